"""Pictures of a store as JPEG or PNG bytes that every reader decodes to the pixels that the store gives."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import PictureArray
from tactiledata.contract.image_bytes import PNG_PALETTE, decode_rgb, read_header
from tactiledata.errors import StoreError

PNG_LEVEL = 3
"""Compression of PNG files made here; more costs three times the time for a few percent."""
ORIENTED = (b"Exif\0\0", b"eXIf")
"""Marks of metadata that may state an orientation, which the store leaves alone and other readers follow."""
COLOUR_TYPE_AT = 25
"""Place of a PNG's colour type: a number in a table of colours is no colour to every reader."""
METADATA_BYTES = 2**17
"""Bytes at the start of a file among which the marks are looked for."""


def encoded_picture(payload: bytes, is_raw: bool, height: int, width: int) -> tuple[bytes, str, bool]:
    """Return bytes, their kind (``jpeg`` or ``png``), and whether they are those of the store.

    JPEG and PNG files of 8-bit RGB stay as they came. Raw frames become PNG, and so do files that readers understand
    in different ways: grey or indexed ones, those with alpha, with 16 bits, or with an orientation in their metadata.

    Parameters
    ----------
    payload : bytes
        As the store keeps it.
    is_raw : bool
        Whether it is RGB pixels, not a JPEG or PNG file.
    height, width : int
        Pixels.
    """
    if is_raw:
        pixels: NDArray[np.uint8] = np.frombuffer(payload, np.uint8).reshape(height, width, 3)
        return png_bytes(pixels), "png", False
    header = read_header(payload)
    is_indexed = header.encoding == "png" and payload[COLOUR_TYPE_AT] == PNG_PALETTE
    is_plain = header.channels == 3 and header.bits == 8 and not header.has_alpha and not is_indexed
    if is_plain and not any(mark in payload[:METADATA_BYTES] for mark in ORIENTED):
        return payload, header.encoding, True
    return png_bytes(decode_rgb(payload)), "png", False


def png_bytes(picture: PictureArray) -> bytes:
    """Return a picture (H, W, 3), uint8 RGB, as a PNG file, without loss."""
    done, content = cv2.imencode(".png", picture[:, :, ::-1], [cv2.IMWRITE_PNG_COMPRESSION, PNG_LEVEL])
    if not done:
        raise StoreError(f"a picture of {picture.shape[0]} x {picture.shape[1]} cannot be written as PNG")
    return content.tobytes()
