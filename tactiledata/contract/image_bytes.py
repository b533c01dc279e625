"""What JPEG and PNG bytes say of themselves, and the one way in which they are decoded, within one limit.

All readers (formats, ingest, the store, sensors' backgrounds) decode here, so that all give the same RGB and none
decodes a picture that would fill the memory.
"""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactiledata.contract.lfs_pointer import refuse_pointer_bytes
from tactiledata.contract.records import Encoding
from tactiledata.errors import BrokenLog

IMAGE_SUFFIXES = frozenset({".jpg", ".jpeg", ".png"})
"""File endings, lower case, of images whose bytes are kept as they came."""

MAX_SIDE = 32_767
"""Pixels. The frames table keeps heights and widths as 16-bit integers."""

MAX_DECODED_PIXELS = 2**24
"""Pixels (4096 x 4096, 48 MiB of RGB) above which no image is decoded: a few bytes must not fill the memory. Cameras of
tactile sensors give at most half of it."""

PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"
PNG_CHANNELS = {0: 1, 2: 3, 3: 3, 4: 2, 6: 4}
PNG_PALETTE = 3
JPEG_FRAMES = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
JPEG_ALONE = frozenset({0x01, *range(0xD0, 0xD8)})
JPEG_SCAN, JPEG_END, JPEG_END_MARK = 0xDA, 0xD9, b"\xff\xd9"


@dataclass(frozen=True)
class ImageHeader:
    """What an encoded image says of itself.

    Parameters
    ----------
    encoding : "jpeg" or "png"
    height, width : int
        Pixels as stored; an orientation in the metadata is not followed.
    channels : int
        1 grey, 2 grey with transparency, 3 colour, 4 colour with transparency (PNG) or four inks (JPEG).
    bits : int
        Of one channel.
    has_alpha : bool
        Whether it states transparency, by a channel or by a list of transparent colours.
    is_complete : bool
        Whether the bytes reach their end mark. A file that was cut has a good header and does not.
    """

    encoding: Encoding
    height: int
    width: int
    channels: int
    bits: int
    has_alpha: bool
    is_complete: bool


def read_header(payload: bytes) -> ImageHeader:
    """The header of JPEG or PNG bytes.

    Raises
    ------
    BrokenLog
        Neither JPEG nor PNG, cut before the size is stated, of an impossible size, or a PNG with a chunk that does not
        fit its CRC-32. It is a ``ValueError``.
    """
    if payload.startswith(PNG_SIGNATURE):
        header = _png(payload)
    elif payload.startswith(b"\xff\xd8"):
        header = _jpeg(payload)
    else:
        refuse_pointer_bytes(payload, "the image")
        start = payload[:8].hex(" ") or "nothing"
        raise _broken(f"bytes that start with {start} are neither JPEG nor PNG")
    if not (0 < header.height <= MAX_SIDE and 0 < header.width <= MAX_SIDE):
        limits = f"a side has 1 to {MAX_SIDE} pixels"
        raise _broken(f"a {header.encoding} image of {header.height} rows x {header.width} columns, where {limits}")
    return header


def probe(payload: bytes) -> tuple[Encoding, int, int]:
    r"""Encoding, height and width of JPEG or PNG bytes.

    Raises
    ------
    BrokenLog
        As `read_header`.

    Examples
    --------
    >>> probe(b"\x89PNG\r\n\x1a\n" + b"\0\0\0\x0dIHDR" + b"\0\0\0\xf0" + b"\0\0\1\x40" + b"\x08\x02")
    ('png', 320, 240)
    """
    header = read_header(payload)
    return header.encoding, header.height, header.width


def size_fault(height: int, width: int) -> str:
    """Why an image of this size (pixels) is not decoded, with the limit; empty where it is within the limit."""
    if height * width <= MAX_DECODED_PIXELS:
        return ""
    return (
        f"{height} rows x {width} columns are {height * width / 1e6:.1f} million pixels, "
        f"and at most {MAX_DECODED_PIXELS / 1e6:.1f} million are decoded"
    )


def decode_rgb(payload: bytes, follow_orientation: bool = False) -> NDArray[np.uint8]:
    """The picture (H, W, 3), uint8 RGB, of JPEG or PNG bytes; turned as its metadata say only where asked.

    Raises
    ------
    BrokenLog
        The bytes do not decode, or to more than ``MAX_DECODED_PIXELS``; then no pixel was decoded.
    """
    import cv2

    header = read_header(payload)
    if fault := size_fault(header.height, header.width):
        raise BrokenLog(
            f"a {header.encoding} image whose {fault}",
            f"an image of at most {MAX_DECODED_PIXELS} pixels",
            "Crop it to the gel or scale it down.",
        )
    flags = cv2.IMREAD_COLOR_RGB | (0 if follow_orientation else cv2.IMREAD_IGNORE_ORIENTATION)
    try:
        picture = cv2.imdecode(np.frombuffer(payload, np.uint8), flags)
    except cv2.error:
        picture = None
    if picture is None:
        raise _broken(f"a {header.encoding} image of {header.height} x {header.width} that does not decode")
    return np.ascontiguousarray(picture, dtype=np.uint8)


def _broken(found: str) -> BrokenLog:
    return BrokenLog(
        found, f"a whole JPEG or PNG image of at most {MAX_SIDE} pixels a side", "Copy the file again from its origin."
    )


def _png(payload: bytes) -> ImageHeader:
    if len(payload) < 26 or payload[12:16] != b"IHDR":
        raise _broken(f"a PNG of {len(payload)} bytes that ends before its size is stated")
    width, height, bits, colour = struct.unpack_from(">IIBB", payload, 16)
    if colour not in PNG_CHANNELS:
        raise _broken(f"a PNG with colour type {colour}")
    bits = 8 if colour == PNG_PALETTE else bits
    has_list, is_complete = _png_chunks(payload)
    has_alpha = PNG_CHANNELS[colour] in (2, 4) or has_list
    return ImageHeader("png", height, width, PNG_CHANNELS[colour], bits, has_alpha, is_complete)


def _png_chunks(payload: bytes) -> tuple[bool, bool]:
    """Whether a PNG lists transparent colours (chunk tRNS), and whether it reaches its end mark.

    Raises
    ------
    BrokenLog
        A chunk does not fit its CRC-32. A flip in a chunk's name makes a part of the picture one that decoders pass
        over, so no chunk that does not fit is taken for a mere remark.
    """
    place, has_list = len(PNG_SIGNATURE), False
    while place + 12 <= len(payload):
        length, kind = int.from_bytes(payload[place : place + 4], "big"), payload[place + 4 : place + 8]
        end = place + 8 + length
        crc = payload[end : end + 4]
        if len(crc) < 4:
            break
        if zlib.crc32(payload[place + 4 : end]) != int.from_bytes(crc, "big"):
            raise _broken(f"a PNG whose chunk at byte {place} does not fit its CRC-32")
        if kind == b"IEND":
            return has_list, True
        has_list |= kind == b"tRNS"
        place = end + 4
    return has_list, False


def _jpeg(payload: bytes) -> ImageHeader:
    """Walk the segments to the frame header, then to the scan."""
    place, frame = 2, None
    while place + 4 <= len(payload):
        if payload[place] != 0xFF:
            break
        marker = payload[place + 1]
        if marker == 0xFF or marker in JPEG_ALONE:  # fill byte, or a mark without content
            place += 1 if marker == 0xFF else 2
            continue
        if marker in (JPEG_SCAN, JPEG_END):
            break
        length = int.from_bytes(payload[place + 2 : place + 4], "big")
        if marker in JPEG_FRAMES and place + 10 <= len(payload):
            frame = struct.unpack_from(">BHHB", payload, place + 4)
        place += 2 + length
    if frame is None:
        raise _broken(f"a JPEG of {len(payload)} bytes that ends or breaks before its size is stated")
    bits, height, width, channels = frame
    # inside a scan every FF is stuffed, so the end mark found there is the end
    is_complete = payload.find(JPEG_END_MARK, place) >= 0
    return ImageHeader("jpeg", height, width, channels, bits, False, is_complete)
