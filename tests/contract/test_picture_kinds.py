"""What is said of pictures that are not 8-bit RGB, kind by kind, and which of them are not used."""

import struct

import cv2
import numpy as np
import pytest

from tactiledata.contract.image_bytes import ImageHeader, decode_rgb, read_header
from tactiledata.contract.picture_kinds import ALPHA_LEFT_OUT, Remark, decode_said, remarks_on
from tactiledata.errors import BrokenLog

DEEP = "has 16 bits a channel: the upper 8 are read"
GREY = "is grey: its values are read as three equal channels"


def encoded(suffix, image):
    done, payload = cv2.imencode(suffix, image)
    assert done
    return payload.tobytes()


def flat(value, channels=3, dtype=np.uint16):
    """A picture of 4 x 6 pixels of one value; an alpha channel is opaque."""
    picture = np.full((4, 6, channels), value, dtype)
    if channels == 4:
        picture[..., 3] = np.iinfo(dtype).max
    return picture


def said(encoding="png", height=4, width=6, channels=3, bits=8, has_alpha=False):
    """The codes and words of the remarks on a header whose bytes do not matter."""
    header = ImageHeader(encoding, height, width, channels, bits, has_alpha, is_complete=False)
    return [(remark.code, remark.words) for remark in remarks_on(header, b"")]


@pytest.mark.parametrize("encoding", ["png", "jpeg"])
def test_eight_bit_rgb_needs_no_remark(encoding):
    """Neither a PNG nor a JPEG of three channels with 8 bits each is remarked on."""
    assert said(encoding) == []


@pytest.mark.parametrize("bits", [1, 2, 4])
def test_few_bits_are_spread(bits):
    """A PNG of 1, 2 or 4 bits is grey, too: both are said."""
    spread = f"has {bits} bits a channel: values are spread over 0 to 255"
    assert said(channels=1, bits=bits) == [("image-depth", spread), ("greyscale-image", GREY)]


@pytest.mark.parametrize(
    ("channels", "has_alpha", "codes"),
    [
        (1, False, ["greyscale-image"]),
        (1, True, ["greyscale-image", "image-alpha"]),
        (2, True, ["greyscale-image", "image-alpha"]),
        (3, True, ["image-alpha"]),
        (4, True, ["image-alpha"]),
    ],
)
def test_grey_and_transparency_are_said_one_by_one(channels, has_alpha, codes):
    """One or two channels are grey; transparency is said of any number of channels."""
    assert [code for code, _ in said(channels=channels, has_alpha=has_alpha)] == codes


@pytest.mark.parametrize(
    ("header", "words"),
    [
        ({"encoding": "jpeg", "channels": 4}, "is a JPEG of four inks (CMYK), no RGB picture; save it as 8-bit RGB"),
        ({"encoding": "jpeg", "channels": 5}, "is a JPEG of 5 channels, where grey has one and RGB three; save it"),
        ({"encoding": "jpeg", "channels": 2}, "is a JPEG of 2 channels, where grey has one and RGB three; save it"),
        ({"encoding": "jpeg", "bits": 12}, "is a JPEG of 12 bits a channel, no 8-bit picture; save it as 8-bit RGB"),
        ({"encoding": "jpeg", "bits": 7}, "is a JPEG of 7 bits a channel, no 8-bit picture; save it as 8-bit RGB"),
        ({"channels": 1, "bits": 16}, "holds 16-bit grey, no colour picture: 8 bits cannot hold its values"),
        ({"channels": 2, "bits": 16}, "holds 16-bit grey, no colour picture: 8 bits cannot hold its values"),
        ({"height": 4097, "width": 4096}, "is not taken: its 4097 rows x 4096 columns are 16.8 million pixels"),
    ],
)
def test_what_would_lose_its_meaning_is_one_remark(header, words):
    """Inks, deep JPEGs, 16-bit grey and too large pictures are refused, and nothing else is said of them."""
    ((code, found),) = said(**header)
    assert code == ("image-too-large" if "height" in header else "image-encoding")
    assert found.startswith(words)


@pytest.mark.parametrize("channels", [3, 4])
@pytest.mark.parametrize(("largest", "is_lost"), [(1, True), (4095, True), (4096, False), (65535, False)])
def test_sixteen_bits_of_which_only_the_lower_are_used(largest, is_lost, channels):
    """Up to 4095, twelve bits, the upper eight bits would be black; alpha, which is white, does not count."""
    payload = encoded(".png", flat(largest, channels))
    first = remarks_on(read_header(payload), payload)[0]
    assert first.is_lost == is_lost
    black = f"has 16 bits a channel and no value above {largest}: its upper 8 bits would be a black picture"
    assert first.words == (f"{black}; save it as 8-bit RGB" if is_lost else DEEP)


def test_a_deep_picture_that_is_cut_or_does_not_decode_is_not_called_black():
    """What cannot be decoded is not refused for its values: other checks say that it is broken."""
    payload = encoded(".png", flat(7))
    cut = payload[:-12]
    assert [remark.words for remark in remarks_on(read_header(cut), cut)] == [DEEP]
    header = ImageHeader("png", 4, 6, 3, 16, False, is_complete=True)
    assert [remark.words for remark in remarks_on(header, b"no picture")] == [DEEP]
    assert [remark.words for remark in remarks_on(header, b"")] == [DEEP]


def test_damage_alone_is_lost():
    """A warning leaves the picture in use, damage does not."""
    assert Remark("x", "damage", "").is_lost
    assert not Remark("x", "warning", "").is_lost


def test_a_picture_is_decoded_with_what_is_said_of_it():
    """Sixteen bits with transparency are decoded to their upper eight, with two remarks; a lost one is refused."""
    picture, remarks = decode_said(encoded(".png", flat(200 * 257, 4)))
    assert picture.shape == (4, 6, 3)
    assert (picture == 200).all()
    assert [remark.words for remark in remarks] == [DEEP, ALPHA_LEFT_OUT]
    with pytest.raises(BrokenLog, match="a picture that has 16 bits a channel and no value above 9"):
        decode_said(encoded(".png", flat(9)))


def test_an_orientation_is_followed_only_where_asked():
    """A JPEG of 16 x 32 whose metadata turn it by a right angle is 16 x 32 as stored and 32 x 16 as turned."""
    stored = encoded(".jpg", np.zeros((16, 32, 3), np.uint8))
    # one entry of TIFF: orientation (0x112), a short, 6: a quarter turn
    tiff = b"MM\0\x2a" + struct.pack(">IHHHIHHI", 8, 1, 0x112, 3, 1, 6, 0, 0)
    segment = b"Exif\0\0" + tiff
    turned = stored[:2] + b"\xff\xe1" + struct.pack(">H", len(segment) + 2) + segment + stored[2:]
    for decode in (decode_rgb, lambda *given: decode_said(*given)[0]):
        assert decode(turned).shape == (16, 32, 3)
        assert decode(turned, False).shape == (16, 32, 3)
        assert decode(turned, True).shape == (32, 16, 3)
