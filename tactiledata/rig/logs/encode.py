"""Pictures as the bytes that a driver sends."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from tactiledata.rig.scenario.scenario import Images

SUFFIX = {"jpeg": "jpg", "png": "png", "raw": "png"}
"""Ending of an image file by encoding; a folder log has no raw images and keeps them as PNG."""


def turned(picture: NDArray[np.uint8], images: Images) -> NDArray[np.uint8]:
    """The picture with rows and columns as the driver delivers them."""
    return np.ascontiguousarray(np.rot90(picture)) if images.swapped_size else picture


def encoded(picture: NDArray[np.uint8], encoding: str, quality: int) -> bytes:
    """JPEG or PNG bytes of an RGB picture."""
    bgr = cv2.cvtColor(picture, cv2.COLOR_RGB2BGR)
    if encoding == "jpeg":
        return cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, quality])[1].tobytes()
    return cv2.imencode(".png", bgr, [cv2.IMWRITE_PNG_COMPRESSION, 3])[1].tobytes()


def raw_bytes(picture: NDArray[np.uint8], channels: str) -> bytes:
    """Bytes of a raw image with the channels in the stated order."""
    return (picture if channels == "rgb8" else picture[..., ::-1]).tobytes()
