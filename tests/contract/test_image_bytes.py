"""Headers of image bytes, read without decoding."""

from __future__ import annotations

import zlib

import cv2
import numpy as np
import pytest

from tactiledata.contract.image_bytes import decode_rgb, probe, read_header, size_fault
from tactiledata.errors import BrokenLog


def picture(height: int = 32, width: int = 24, channels: int = 3) -> np.ndarray:
    rng = np.random.default_rng(5)
    shape = (height, width, channels) if channels > 1 else (height, width)
    return rng.integers(0, 256, shape, dtype=np.uint8)


def encoded(suffix: str, image: np.ndarray, *options: int) -> bytes:
    done, payload = cv2.imencode(suffix, image, list(options))
    assert done
    return payload.tobytes()


@pytest.mark.parametrize("suffix", [".png", ".jpg"])
@pytest.mark.parametrize(
    ("height", "width", "channels"), [(1, 1, 3), (32, 24, 3), (24, 32, 3), (17, 300, 1), (8, 8, 4)]
)
def test_size_is_that_of_the_decoded_picture(suffix, height, width, channels):
    """The header gives the size, the channels and the completeness of what a decoder returns."""
    if suffix == ".jpg" and channels == 4:
        channels = 3
    payload = encoded(suffix, picture(height, width, channels))
    header = read_header(payload)
    assert (header.height, header.width, header.channels, header.bits) == (height, width, channels, 8)
    assert header.is_complete
    assert probe(payload) == ({".png": "png", ".jpg": "jpeg"}[suffix], height, width)
    assert decode_rgb(payload).shape == (height, width, 3)


def test_progressive_jpeg_and_deep_png():
    """Progressive JPEG frames and 16-bit PNG are understood."""
    progressive = encoded(".jpg", picture(), cv2.IMWRITE_JPEG_PROGRESSIVE, 1)
    assert probe(progressive) == ("jpeg", 32, 24)
    assert read_header(progressive).is_complete
    assert read_header(encoded(".png", picture().astype(np.uint16) * 257)).bits == 16


def test_rgb_order():
    """A red picture decodes to red first."""
    red = np.zeros((8, 8, 3), np.uint8)
    red[..., 2] = 200  # OpenCV writes BGR
    assert decode_rgb(encoded(".png", red))[0, 0].tolist() == [200, 0, 0]


@pytest.mark.parametrize("suffix", [".png", ".jpg"])
def test_every_cut_is_noticed(suffix):
    """No cut of a file passes as complete: either the header is refused or the image is said to be incomplete."""
    payload = encoded(suffix, picture())
    for length in range(len(payload) - 1):
        try:
            assert not read_header(payload[:length]).is_complete, length
        except BrokenLog:
            continue


def test_every_flipped_bit_of_a_png_is_noticed():
    """A PNG with one flipped bit behind its signature is refused or incomplete; without a flip it is whole."""
    whole = encoded(".png", picture(8, 6))
    note = b"tEXta note"
    payload = whole[:33] + (6).to_bytes(4, "big") + note + zlib.crc32(note).to_bytes(4, "big") + whole[33:]
    assert read_header(payload).is_complete
    for place in range(8, len(payload)):
        for bit in range(8):
            flipped = bytearray(payload)
            flipped[place] ^= 1 << bit
            try:
                assert not read_header(bytes(flipped)).is_complete, (place, bit)
            except BrokenLog:
                continue


def test_padding_after_the_end_is_complete():
    """Zero bytes after the end mark, as cameras append them, do not make an image incomplete."""
    for suffix in (".png", ".jpg"):
        assert read_header(encoded(suffix, picture()) + bytes(100)).is_complete


def test_thumbnail_does_not_stand_for_the_image():
    """An end mark inside a metadata segment (a thumbnail) does not make a cut JPEG complete."""
    payload = encoded(".jpg", picture())
    thumbnail = b"\xff\xe1" + (2 + 8).to_bytes(2, "big") + b"Exif\xff\xd9\0\0"
    cut = payload[:2] + thumbnail + payload[2:-40]
    assert probe(cut) == ("jpeg", 32, 24)
    assert not read_header(cut).is_complete


@pytest.mark.parametrize(
    "payload",
    [b"", b"\xff", b"\xff\xd8", b"GIF89a", b"%PDF", b"\x89PNG\r\n\x1a\n", bytes(100), b"\xff\xd8" + bytes(100),
     b"\xff\xd8\xff\xc0\x00\x11\x08\x00\x00\x00\x08\x03" + bytes(30)],
)  # fmt: skip
def test_other_bytes_are_refused(payload):
    """Bytes that state no size are a ValueError that says what they are."""
    with pytest.raises(ValueError, match="expected a whole JPEG or PNG"):
        probe(payload)


def test_random_bytes_never_break_the_parser():
    """Whatever follows a signature, the parser answers or refuses, and ends."""
    rng = np.random.default_rng(11)
    for start in (b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff"):
        for _ in range(500):
            try:
                read_header(start + rng.bytes(60))
            except BrokenLog:
                continue


@pytest.mark.parametrize(("payload", "start"), [(b"", "nothing"), (b"GIF89a\x01\x00\x02", "47 49 46 38 39 61 01 00")])
def test_bytes_of_another_kind_are_refused_by_their_first_eight(payload, start):
    """The message shows the first eight bytes, or says that there are none."""
    with pytest.raises(BrokenLog, match=f"bytes that start with {start} are neither JPEG nor PNG"):
        read_header(payload)


def test_the_limit_of_a_decoded_size_is_said_in_millions_of_pixels():
    """2^24 pixels are decoded; one column more is refused with both numbers."""
    assert size_fault(4096, 4096) == ""
    said = "4096 rows x 4097 columns are 16.8 million pixels, and at most 16.8 million are decoded"
    assert size_fault(4096, 4097) == said
    assert size_fault(30000, 30000).startswith("30000 rows x 30000 columns are 900.0 million pixels")


@pytest.mark.parametrize("lost", [1, 2, 3, 4, 11, 12])
def test_a_png_without_the_last_bytes_of_its_end_mark_is_cut(lost):
    """The end mark has 12 bytes: length, name and CRC; one byte less, and the picture is not complete."""
    payload = encoded(".png", picture())
    assert read_header(payload).is_complete
    assert read_header(payload + b"\0").is_complete
    assert not read_header(payload[:-lost]).is_complete


@pytest.mark.parametrize("size", [0, 8, 25])
def test_a_png_that_ends_before_its_size_is_refused(size):
    """26 bytes hold signature, length, name, size, bits and colours; the message says how many there are."""
    payload = encoded(".png", picture(7, 9))
    assert (read_header(payload[:26]).height, read_header(payload[:26]).width) == (7, 9)
    with pytest.raises(BrokenLog):
        read_header(payload[:size])


@pytest.mark.parametrize("mark", [b"\xff\x01", b"\xff\xd0", b"\xff\xd7", b"\xff", b"\xff\xff"])
def test_marks_without_content_and_fill_bytes_are_passed_over(mark):
    """Marks that may stand before the frame header of a JPEG (ITU-T T.81, B.1.1) do not hide its size."""
    payload = encoded(".jpg", picture(7, 9))
    header = read_header(payload[:2] + mark + payload[2:])
    assert (header.height, header.width, header.is_complete) == (7, 9, True)
