"""Pictures of a deformed gel as a DIGIT takes them: three coloured lights, one camera, a real background.

The picture is the real background times the ratio of light that the deformed and the flat gel send back, formed in linear
light. Each light stands beside the gel, so its direction changes over the pad; each colours every channel a little; a
bump throws a soft shadow; the camera is a little off, turned and distorted, and sees the gel from behind.
"""

from __future__ import annotations

import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from tactiledata.rig.footprint import GelGrid

Map = NDArray[np.float32]

HEIGHT, WIDTH = 320, 240
LED_DISTANCE = 0.017
"""m from the gel's centre to a light."""
TERMINATOR = 0.06
"""Width of the soft edge between lit and unlit, in the cosine of the angle of incidence."""
SHADOW_LENGTHS = (6e-4, 1.3e-3)
"""m towards the light at which something in its way is looked for."""
SHADOW = 0.45
"""Share of a light that a shadow takes."""
OCCLUSION = 0.5
"""Share of the ambient light that a fold as deep as it is wide takes."""
BRIGHTEST = 5.0
"""Largest ratio: a camera's shoulder."""


@dataclass(frozen=True)
class Led:
    """A light: where it stands (rad), and its colour as linear RGB."""

    azimuth: float
    elevation: float
    colour: tuple[float, float, float]


@dataclass(frozen=True)
class Optics:
    """One unit's optics; meaning and units in ``schemas/scenario.json``."""

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
        """A unit's optics: what is stated, the rest drawn from the seed and the serial."""
        rng = np.random.default_rng([seed, 2, zlib.crc32(serial.encode())])
        drawn = {
            "leds": tuple(_draw_led(rng, azimuth, channel) for channel, azimuth in enumerate((np.pi, 0.0, np.pi / 2))),
            "gamma": float(rng.uniform(1.9, 2.4)),
            "ambient": float(rng.uniform(0.25, 0.5)),
            "pixel": float(5.9e-5 * rng.uniform(0.97, 1.03)),
            "centre": tuple(float(value) for value in rng.normal(0.0, 2e-4, 2)),
            "turn": float(rng.normal(0.0, 0.015)),
            "distortion": float(rng.uniform(-0.06, -0.01)),
            "mirrored": True,
            "softness": float(rng.uniform(0.9e-4, 1.5e-4)),
            "noise": float(rng.uniform(0.8, 1.4)),
        }
        given = dict(stated)
        if "leds" in given:
            given["leds"] = tuple(Led(led["azimuth"], led["elevation"], tuple(led["colour"])) for led in given["leds"])
        if "centre" in given:
            given["centre"] = tuple(given["centre"])
        return cls(**{**drawn, **given})


def _draw_led(rng: np.random.Generator, azimuth: float, channel: int) -> Led:
    colour = rng.uniform(0.05, 0.2, 3)
    colour[channel] = 1.0
    return Led(
        float(azimuth + rng.normal(0.0, 0.12)),
        float(rng.uniform(0.45, 0.75)),
        (float(colour[0]), float(colour[1]), float(colour[2])),
    )


@dataclass
class Camera:
    """Takes pictures of one unit; what does not change from picture to picture is computed once.

    Parameters
    ----------
    optics : Optics
    background : (320, 240, 3) uint8 RGB
    grid : GelGrid

    ``at_rest`` is the flat surface.
    """

    optics: Optics
    background: NDArray[np.uint8]
    grid: GelGrid
    at_rest: Map = field(init=False, repr=False)
    _mixing: Map = field(init=False, repr=False)
    _pitch: float = field(init=False, repr=False)
    _base: Map = field(init=False, repr=False)
    _lights: list[tuple[Map, Map, Map]] = field(init=False, repr=False)
    _flat: Map = field(init=False, repr=False)
    _maps: tuple[Map, Map] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        self._lights = [self._light_field(led) for led in self.optics.leds]
        self._mixing = np.array([led.colour for led in self.optics.leds], dtype=np.float32)
        self._pitch = float(self.grid.x[1] - self.grid.x[0])
        flat = np.zeros((len(self.grid.y), len(self.grid.x)), np.float32)
        self.at_rest = flat
        self._flat = self._radiance(flat)
        self._maps = self._camera_maps()
        self._base = self.background.astype(np.float32)

    def _light_field(self, led: Led) -> tuple[Map, Map, Map]:
        """Direction to the light times its strength, (n_y, n_x) each along gel x, y and into the gel."""
        x, y = np.meshgrid(self.grid.x.astype(np.float32), self.grid.y.astype(np.float32))
        level = np.cos(led.elevation) * LED_DISTANCE
        to_x = np.cos(led.azimuth) * level - x
        to_y = np.sin(led.azimuth) * level - y
        to_z = np.float32(np.sin(led.elevation) * LED_DISTANCE)
        distance = np.sqrt(to_x**2 + to_y**2 + to_z**2)
        strength = (LED_DISTANCE / distance) ** 2 / distance
        return to_x * strength, to_y * strength, to_z * strength

    def _camera_maps(self) -> tuple[Map, Map]:
        """For each pixel the grid point that it sees, as `cv2.remap` wants it: columns and rows, (320, 240)."""
        optics = self.optics
        u, v = np.meshgrid(np.arange(WIDTH) - (WIDTH - 1) / 2, np.arange(HEIGHT) - (HEIGHT - 1) / 2)
        if not optics.mirrored:
            u = -u
        radius = (u**2 + v**2) / ((WIDTH / 2) ** 2 + (HEIGHT / 2) ** 2)
        bend = 1.0 - optics.distortion * radius
        cos, sin = np.cos(optics.turn), np.sin(optics.turn)
        x = optics.centre[0] + optics.pixel * bend * (cos * u - sin * v)
        y = optics.centre[1] + optics.pixel * bend * (sin * u + cos * v)
        return (
            ((x - self.grid.x[0]) / self._pitch).astype(np.float32),
            ((y - self.grid.y[0]) / self._pitch).astype(np.float32),
        )

    def _radiance(self, height: Map) -> Map:
        """Linear light (n_y, n_x, 3) that the surface sends to the camera, up to the paint's local colour."""
        scale = 1.0 / (8 * self._pitch)
        slope_x = cv2.Sobel(height, cv2.CV_32F, 1, 0, ksize=3, scale=scale)
        slope_y = cv2.Sobel(height, cv2.CV_32F, 0, 1, ksize=3, scale=scale)
        shorter = 1.0 / cv2.sqrt(1.0 + slope_x * slope_x + slope_y * slope_y)
        # the normal towards the camera is (slope_x, slope_y, -1); lights stand on the camera's side, at -z
        total = np.zeros((*height.shape, 3), np.float32)
        total += self._ambient(height)[..., None]
        for led, (to_x, to_y, to_z), colour in zip(self.optics.leds, self._lights, self._mixing, strict=True):
            cosine = (to_x * slope_x + to_y * slope_y + to_z) * shorter
            lit = 0.5 * (cosine + cv2.sqrt(cosine * cosine + np.float32(TERMINATOR**2)))
            lit *= self._shadow(height, led)
            for channel in range(3):
                total[..., channel] += colour[channel] * lit
        return total

    def _ambient(self, height: Map) -> Map:
        """Light from everywhere, less in folds: where the surface lies nearer to the camera than around it, more."""
        small = cv2.resize(height, (height.shape[1] // 4, height.shape[0] // 4), interpolation=cv2.INTER_AREA)
        around = cv2.GaussianBlur(small, (0, 0), 6e-4 / (4 * self._pitch))
        fold = cv2.resize(small - around, (height.shape[1], height.shape[0]), interpolation=cv2.INTER_LINEAR)
        return np.float32(self.optics.ambient) * np.clip(1.0 - OCCLUSION * fold / 2e-4, 0.3, 1.5)

    def _shadow(self, height: Map, led: Led) -> Map:
        """Share of a light that arrives (n_y, n_x): less behind what stands in its way; soft, so on few points."""
        shape = (height.shape[1] // 4, height.shape[0] // 4)
        small = cv2.resize(height, shape, interpolation=cv2.INTER_AREA)
        pitch, rise = 4 * self._pitch, np.tan(led.elevation)
        blocked = np.zeros_like(small)
        for length in SHADOW_LENGTHS:
            shift = (-np.cos(led.azimuth) * length / pitch, -np.sin(led.azimuth) * length / pitch)
            move = np.array([[1, 0, shift[0]], [0, 1, shift[1]]], dtype=np.float32)
            toward = cv2.warpAffine(small, move, shape, flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
            # heights are counted away from the camera, so what stands in the way is lower
            blocked = np.maximum(blocked, (small - toward) - np.float32(0.5 * length * rise))
        share = np.clip(blocked / 1.5e-4, 0.0, 1.0)
        share = cv2.GaussianBlur(share, (0, 0), 1.2)
        return 1.0 - SHADOW * cv2.resize(share, (height.shape[1], height.shape[0]), interpolation=cv2.INTER_LINEAR)

    def picture(self, height: Map, rng: np.random.Generator) -> NDArray[np.uint8]:
        """The picture (320, 240, 3) uint8 RGB of a surface (n_y, n_x), metres, with sensor noise."""
        picture = self._base
        if height.any():
            soft = cv2.GaussianBlur(height, (0, 0), self.optics.softness / self._pitch)
            ratio = np.minimum(self._radiance(soft) / self._flat, BRIGHTEST)
            seen = cv2.remap(ratio, *self._maps, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
            # ratios of linear light become ratios of grey levels by the camera's gamma
            picture = self._base * cv2.pow(seen, 1.0 / self.optics.gamma)
        noise = rng.standard_normal(picture.shape, dtype=np.float32)
        noisy = picture + np.float32(self.optics.noise) * noise
        return np.clip(noisy + 0.5, 0, 255).astype(np.uint8)
