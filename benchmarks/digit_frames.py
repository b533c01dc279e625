"""Pictures as a DIGIT gives them: its real backgrounds, a pressed bump under three coloured lights, sensor noise."""

from __future__ import annotations

from collections.abc import Iterator
from importlib import resources

import cv2
import numpy as np
from numpy.typing import NDArray

ROWS, COLUMNS = 320, 240
LIGHTS = np.array([[1.0, 0.0], [-0.5, 0.87], [-0.5, -0.87]])
"""Directions in the image from which the red, green and blue light comes."""

NOISE = 1.5
"""Standard deviation of the sensor noise, grey levels of 255."""


def backgrounds() -> list[NDArray[np.uint8]]:
    """The real DIGIT backgrounds that the package ships, (320, 240, 3) RGB each."""
    folder = resources.files("tactiledata") / "sensors" / "digit_backgrounds"
    pictures = sorted(
        (entry for entry in folder.iterdir() if entry.name.endswith(".jpg")), key=lambda entry: entry.name
    )
    return [cv2.imdecode(np.frombuffer(entry.read_bytes(), np.uint8), cv2.IMREAD_COLOR_RGB) for entry in pictures]


def digit_frames(count: int, seed: int = 0) -> Iterator[NDArray[np.uint8]]:
    """``count`` pictures, (320, 240, 3) uint8 RGB, the same for the same seed."""
    rng = np.random.default_rng(seed)
    scenes = [picture.astype(np.float32) for picture in backgrounds()]
    row, column = np.mgrid[:ROWS, :COLUMNS].astype(np.float32)
    for number in range(count):
        centre = rng.uniform([80, 60], [240, 180])
        width, strength = rng.uniform(12, 40), rng.uniform(10, 70)
        down, right = (row - centre[0]) / width, (column - centre[1]) / width
        slope = np.exp(-(down**2 + right**2)) * strength
        shading = np.stack([slope * (light[0] * down + light[1] * right) for light in LIGHTS], axis=-1)
        noise = rng.standard_normal((ROWS, COLUMNS, 3), dtype=np.float32) * NOISE
        yield np.clip(scenes[number % len(scenes)] + shading + noise, 0, 255).astype(np.uint8)


def encoded(picture: NDArray[np.uint8], extension: str) -> bytes:
    """A picture as JPEG (quality 95) or PNG bytes; ``extension`` is ``".jpg"`` or ``".png"``."""
    options = [cv2.IMWRITE_JPEG_QUALITY, 95] if extension == ".jpg" else []
    return cv2.imencode(extension, cv2.cvtColor(picture, cv2.COLOR_RGB2BGR), options)[1].tobytes()
