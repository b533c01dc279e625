"""Encoding of pictures into the bytes that a camera's driver sends."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from tactiledata.rig.scenario.scenario import Images

SUFFIX = {"jpeg": "jpg", "png": "png", "raw": "png"}
"""Ending of an image file by encoding; a folder log has no raw images and keeps them as PNG."""


def turned(picture: NDArray[np.uint8], images: Images) -> NDArray[np.uint8]:
    """Return a picture with rows and columns as the driver delivers them: turned where the scenario asks for it."""
    return np.ascontiguousarray(np.rot90(picture)) if images.swapped_size else picture


def encoded(picture: NDArray[np.uint8], encoding: str, quality: int) -> bytes:
    """Return the JPEG or PNG bytes of a picture.

    Parameters
    ----------
    picture : (h, w, 3) uint8 RGB
    encoding : "jpeg" or "png"
    quality : int
        Quality of JPEG, 1 to 100; without influence on PNG.
    """
    bgr = cv2.cvtColor(picture, cv2.COLOR_RGB2BGR)
    if encoding == "jpeg":
        return cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, quality])[1].tobytes()
    return cv2.imencode(".png", bgr, [cv2.IMWRITE_PNG_COMPRESSION, 3])[1].tobytes()


def raw_bytes(picture: NDArray[np.uint8], channels: str) -> bytes:
    """Return the bytes of a raw RGB image with the channels in the stated order, ``rgb8`` or ``bgr8``."""
    return (picture if channels == "rgb8" else picture[..., ::-1]).tobytes()
