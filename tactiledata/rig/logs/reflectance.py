"""Pictures of a deformed gel as a DIGIT takes them: three coloured lights, one camera, a real background.

The picture is the real background times the ratio of light that the deformed and the flat gel reflect, computed in
linear light. Each light stands beside the gel, so that its direction changes over the pad, and adds to every channel; a
bump casts a soft shadow; the camera is displaced, turned and distorted a little, and sees the gel from behind.
"""

from __future__ import annotations

import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from tactiledata.rig.contact.footprint import GelGrid

Map = NDArray[Any]
"""A float32 map; OpenCV's annotations do not state the type."""

HEIGHT, WIDTH = 320, 240
"""Size of a DIGIT's picture, rows and columns."""
LED_DISTANCE = 0.017
"""Distance from the gel's centre to a light, m."""
TERMINATOR = 0.06
"""Width of the soft edge between lit and unlit, in the cosine of the angle of incidence."""
SHADOW_LENGTHS = (6e-4, 1.3e-3)
"""Distances towards the light, m, at which an obstacle is looked for."""
SHADOW = 0.45
"""Share of a light that a full shadow takes."""
OCCLUSION = 0.5
"""Share of the ambient light that a deep fold takes."""
SHADOW_DEPTH = 1.5e-4
"""Height of an obstacle above the ray to the light, m, that gives a full shadow."""
FOLD_WIDTH, FOLD_DEPTH = 6e-4, 2e-4
"""Length scale of a fold and the depth of a full fold, m."""
BRIGHTEST = 5.0
"""Largest ratio of light, since a camera saturates."""
RIM = 12
"""Width of the rim of the grid around what the camera sees, in points."""


@dataclass(frozen=True)
class Led:
    """A light: its azimuth and elevation (rad), and its colour as linear RGB."""

    azimuth: float
    elevation: float
    colour: tuple[float, float, float]


@dataclass(frozen=True)
class Optics:
    """The optics of one unit; meaning and units in ``schemas/scenario.json``."""

    leds: tuple[Led, Led, Led]
    gamma: float
    ambient: float
    pixel: float
    centre: tuple[float, float]
    turn: float
    distortion: float
    mirrored: bool
    softness: float
    noise: float

    @classmethod
    def of_unit(cls, serial: str, seed: int, stated: Mapping[str, Any]) -> Optics:
        """Return the optics of a unit: stated values, and the others drawn from the seed and the serial.

        Parameters
        ----------
        serial : str
            Name of the unit.
        seed : int
            Seed of the scenario.
        stated : dict
            Values that the scenario states.
        """
        rng = np.random.default_rng([seed, 2, zlib.crc32(serial.encode())])
        drawn = {
            "leds": tuple(_draw_led(rng, azimuth, channel) for channel, azimuth in enumerate((np.pi, 0.0, np.pi / 2))),
            "gamma": float(rng.uniform(1.9, 2.4)),
            "ambient": float(rng.uniform(0.12, 0.3)),
            "pixel": float(5.9e-5 * rng.uniform(0.97, 1.03)),
            "centre": tuple(float(value) for value in rng.normal(0.0, 2e-4, 2)),
            "turn": float(rng.normal(0.0, 0.015)),
            "distortion": float(rng.uniform(-0.06, -0.01)),
            "mirrored": True,
            "softness": float(rng.uniform(0.9e-4, 1.5e-4)),
            "noise": float(rng.uniform(0.8, 1.4)),
        }
        # stated values win
        given = dict(stated)
        if "leds" in given:
            given["leds"] = tuple(Led(led["azimuth"], led["elevation"], tuple(led["colour"])) for led in given["leds"])
        if "centre" in given:
            given["centre"] = tuple(given["centre"])
        return cls(**{**drawn, **given})


def _draw_led(rng: np.random.Generator, azimuth: float, channel: int) -> Led:
    """Return a light near an azimuth, rad, that shines mostly in one channel."""
    colour = rng.uniform(0.05, 0.2, 3)
    colour[channel] = 1.0
    return Led(
        float(azimuth + rng.normal(0.0, 0.12)),
        float(rng.uniform(0.3, 0.55)),
        (float(colour[0]), float(colour[1]), float(colour[2])),
    )


@cache
def normal_deviates() -> Map:
    """Return normal deviates (4096,) by rank, so that the noise of a picture is 230,000 look-ups."""
    return ndtri((np.arange(4096) + 0.5) / 4096).astype(np.float32)


class Camera:
    """Camera of one unit; what is the same for every picture is computed once.

    Parameters
    ----------
    optics : Optics
        The unit's optics.
    background : (320, 240, 3) uint8 RGB
        Picture without contact.
    grid : GelGrid
        Grid of the surfaces that are shown.
    """

    def __init__(self, optics: Optics, background: NDArray[np.uint8], grid: GelGrid) -> None:
        self.optics = optics
        self._pitch = float(grid.x[1] - grid.x[0])
        columns, rows = _seen_points(optics)
        columns, rows = (columns - grid.x[0]) / self._pitch, (rows - grid.y[0]) / self._pitch
        # only the part of the pad that the camera sees is ever shaded
        self._window = (_span(rows, len(grid.y)), _span(columns, len(grid.x)))
        self._maps = (
            (columns - self._window[1].start).astype(np.float32),
            (rows - self._window[0].start).astype(np.float32),
        )
        x, y = grid.x[self._window[1]].astype(np.float32), grid.y[self._window[0]].astype(np.float32)
        self._lights = [_light_field(led, *np.meshgrid(x, y)) for led in optics.leds]
        self._mixing = np.array([led.colour for led in optics.leds], dtype=np.float32).T
        self.at_rest: Map = np.zeros((len(grid.y), len(grid.x)), np.float32)
        self._flat = 1.0 / self._radiance(np.zeros((len(y), len(x)), np.float32))
        self._base = background.astype(np.float32)

    def _radiance(self, height: Map) -> Map:
        """Return the linear light (rows, columns, 3) of a surface (rows, columns), m, up to the paint's colour."""
        scale = 1.0 / (8 * self._pitch)
        slope_x = cv2.Sobel(height, cv2.CV_32F, 1, 0, ksize=3, scale=scale)
        slope_y = cv2.Sobel(height, cv2.CV_32F, 0, 1, ksize=3, scale=scale)
        shorter = 1.0 / np.sqrt(1.0 + slope_x * slope_x + slope_y * slope_y)
        small = cv2.resize(height, (height.shape[1] // 4, height.shape[0] // 4), interpolation=cv2.INTER_AREA)
        arriving = []
        # the normal towards the camera is (slope_x, slope_y, -1); lights stand on the camera's side, at -z
        for led, (to_x, to_y, to_z) in zip(self.optics.leds, self._lights, strict=True):
            cosine = (to_x * slope_x + to_y * slope_y + to_z) * shorter
            lit = 0.5 * (cosine + np.sqrt(cosine * cosine + np.float32(TERMINATOR**2)))
            arriving.append(lit * _enlarged(self._unshadowed(small, led), height.shape))
        ambient = _enlarged(self._ambient(small), height.shape)
        return cv2.transform(cv2.merge(arriving), self._mixing) + ambient[..., None]

    def _ambient(self, small: Map) -> Map:
        """Return the ambient light (rows, columns): less in folds, more where the surface is nearer to the camera."""
        fold = small - cv2.GaussianBlur(small, (0, 0), FOLD_WIDTH / (4 * self._pitch))
        return np.float32(self.optics.ambient) * np.clip(1.0 - OCCLUSION * fold / np.float32(FOLD_DEPTH), 0.3, 1.5)

    def _unshadowed(self, small: Map, led: Led) -> Map:
        """Return the share (rows, columns) of a light that arrives; few points suffice, since shadows are soft."""
        pitch, rise = 4 * self._pitch, np.tan(led.elevation)
        blocked = np.zeros_like(small)
        for length in SHADOW_LENGTHS:
            shift = (-np.cos(led.azimuth) * length / pitch, -np.sin(led.azimuth) * length / pitch)
            move = np.array([[1, 0, shift[0]], [0, 1, shift[1]]], dtype=np.float32)
            toward = cv2.warpAffine(
                small, move, small.shape[::-1], flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
            )
            # heights are counted away from the camera, so what stands in the way is lower
            blocked = np.maximum(blocked, (small - toward) - np.float32(0.5 * length * rise))
        return 1.0 - SHADOW * cv2.GaussianBlur(np.clip(blocked / SHADOW_DEPTH, 0.0, 1.0), (0, 0), 1.2)

    def picture(self, height: Map, rng: np.random.Generator) -> NDArray[np.uint8]:
        """Return the picture (320, 240, 3), uint8 RGB, of a surface (n_y, n_x), metres, with the camera's noise."""
        picture = self._base
        seen = height[self._window]
        if seen.any():
            soft = cv2.GaussianBlur(seen, (0, 0), self.optics.softness / self._pitch)
            ratio = np.minimum(self._radiance(soft) * self._flat, BRIGHTEST)
            # ratios of linear light become ratios of grey levels by the camera's gamma
            ratio = cv2.pow(ratio, 1.0 / self.optics.gamma)
            picture = self._base * cv2.remap(ratio, *self._maps, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        deviates = normal_deviates()
        noise = deviates[rng.integers(0, len(deviates), picture.shape, dtype=np.uint16)]
        noisy: Any = cv2.add(picture, np.float32(self.optics.noise) * noise, dtype=cv2.CV_8U)
        return noisy


def _seen_points(optics: Optics) -> tuple[Map, Map]:
    """Return the places x and y (320, 240) on the gel, metres, that each pixel sees."""
    u, v = np.meshgrid(np.arange(WIDTH) - (WIDTH - 1) / 2, np.arange(HEIGHT) - (HEIGHT - 1) / 2)
    if not optics.mirrored:
        u = -u
    radius = (u**2 + v**2) / ((WIDTH / 2) ** 2 + (HEIGHT / 2) ** 2)
    bend = 1.0 - optics.distortion * radius
    cos, sin = np.cos(optics.turn), np.sin(optics.turn)
    x = optics.centre[0] + optics.pixel * bend * (cos * u - sin * v)
    y = optics.centre[1] + optics.pixel * bend * (sin * u + cos * v)
    return x, y


def _span(places: Map, size: int) -> slice:
    """Return the part of a grid's axis that holds all places, in points, with a rim for blurs."""
    return slice(max(int(places.min()) - RIM, 0), min(int(places.max()) + RIM + 2, size))


def _light_field(led: Led, x: Map, y: Map) -> tuple[Map, Map, Map]:
    """Return the direction to a light times its strength at gel points x, y, m: along gel x, y and into the gel."""
    level = np.cos(led.elevation) * LED_DISTANCE
    to_x = np.float32(np.cos(led.azimuth) * level) - x
    to_y = np.float32(np.sin(led.azimuth) * level) - y
    to_z = np.float32(np.sin(led.elevation) * LED_DISTANCE)
    distance = np.sqrt(to_x**2 + to_y**2 + to_z**2)
    strength = (np.float32(LED_DISTANCE) / distance) ** 2 / distance
    return to_x * strength, to_y * strength, to_z * strength


def _enlarged(small: Map, shape: tuple[int, ...]) -> Map:
    """Return a map, interpolated to a larger shape."""
    return cv2.resize(small, (shape[1], shape[0]), interpolation=cv2.INTER_LINEAR)
