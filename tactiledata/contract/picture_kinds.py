"""What becomes of a picture that is not 8-bit RGB on its way to one: said, or refused where its meaning would be lost.

Recorded pictures and pictures without contact are held to the same rules: decision 0027.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactiledata.contract.image_bytes import ImageHeader, decode_rgb, read_header, size_fault
from tactiledata.contract.records import Severity
from tactiledata.errors import BrokenLog

USED_BITS = 12
"""Bits of 16 that a picture must use: values below 2 ** 12 leave upper 8 bits below 16 of 255, nearly black."""

ALPHA_LEFT_OUT = "has an alpha channel: it is left out, and colours are read as they are stored"


@dataclass(frozen=True)
class Remark:
    """What is said of one picture: a finding's code and severity, and the sentence's end after the picture's name."""

    code: str
    severity: Severity
    words: str

    @property
    def is_lost(self) -> bool:
        """Whether the picture is not used."""
        return self.severity == "damage"


def remarks_on(header: ImageHeader, payload: bytes) -> list[Remark]:
    """What is said of an encoded picture that is not 8-bit RGB within the limit of size; empty for one that is.

    A picture whose meaning would be lost as 8-bit RGB gives one remark that `is_lost`: four inks, two or five
    channels, or 12 bits in a JPEG, 16-bit grey (a depth map as a rule), 16-bit colours of which only the lower bits
    are used.
    """
    if fault := size_fault(header.height, header.width):
        return [Remark("image-too-large", "damage", f"is not taken: its {fault}; crop it to the gel or scale it down")]
    if refusal := _refusal(header, payload):
        return [Remark("image-encoding", "damage", f"{refusal}; save it as 8-bit RGB")]
    remarks = []
    if header.bits > 8:
        remarks.append(Remark("image-depth", "warning", f"has {header.bits} bits a channel: the upper 8 are read"))
    elif header.bits < 8:
        remarks.append(
            Remark("image-depth", "warning", f"has {header.bits} bits a channel: values are spread over 0 to 255")
        )
    if header.channels < 3:
        remarks.append(Remark("greyscale-image", "warning", "is grey: its values are read as three equal channels"))
    if header.has_alpha:
        remarks.append(Remark("image-alpha", "warning", ALPHA_LEFT_OUT))
    return remarks


def decode_said(payload: bytes, follow_orientation: bool = False) -> tuple[NDArray[np.uint8], list[Remark]]:
    """The picture (H, W, 3), uint8 RGB, of JPEG or PNG bytes, and what is said of one that is not 8-bit RGB as stored.

    Raises
    ------
    BrokenLog
        The bytes do not decode, or their meaning would be lost as 8-bit RGB.
    """
    remarks = remarks_on(read_header(payload), payload)
    for remark in remarks:
        if remark.is_lost:
            raise BrokenLog(f"a picture that {remark.words}", "an 8-bit RGB picture", "Save it as 8-bit RGB.")
    return decode_rgb(payload, follow_orientation), remarks


def _refusal(header: ImageHeader, payload: bytes) -> str:
    if header.encoding == "jpeg":
        if header.channels == 4:
            return "is a JPEG of four inks (CMYK), no RGB picture"
        if header.channels not in (1, 3):
            return f"is a JPEG of {header.channels} channels, where grey has one and RGB three"
        return f"is a JPEG of {header.bits} bits a channel, no 8-bit picture" if header.bits != 8 else ""
    if header.bits == 16 and header.channels < 3:
        return "holds 16-bit grey, no colour picture: 8 bits cannot hold its values"
    if header.bits == 16 and header.is_complete and (largest := _largest_value(payload)) < 2**USED_BITS:
        return f"has 16 bits a channel and no value above {largest}: its upper 8 bits would be a black picture"
    return ""


def _largest_value(payload: bytes) -> int:
    """The largest value of a picture's colours, alpha left out; 2**16 where it does not decode."""
    import cv2

    try:
        flags = cv2.IMREAD_COLOR | cv2.IMREAD_ANYDEPTH
        pixels = cv2.imdecode(np.frombuffer(payload, np.uint8), flags)
    except cv2.error:
        pixels = None
    return 2**16 if pixels is None else int(pixels.max())
