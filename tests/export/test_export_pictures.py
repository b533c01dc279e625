"""Pictures that go out are the store's bytes, or decode to the store's pixels in every reader."""

import io

import cv2
import numpy as np
import PIL.Image
import PIL.ImageOps
import pytest

from tactiledata.contract.image_bytes import decode_rgb
from tactiledata.export.pictures import encoded_picture, png_bytes


def drawn(mode="RGB", **options):
    """A picture and its file, by Pillow, which is not what writes them in the store."""
    rng = np.random.default_rng(1)
    pixels = rng.integers(0, 256, (8, 6, 3)).astype(np.uint8)
    buffer = io.BytesIO()
    PIL.Image.fromarray(pixels).convert(mode).save(buffer, **options)
    return pixels, buffer.getvalue()


def as_others_read(content):
    """What `datasets`, and LeRobot with it, makes of a file: turned by its metadata."""
    return np.asarray(PIL.ImageOps.exif_transpose(PIL.Image.open(io.BytesIO(content))))


@pytest.mark.parametrize("form", ["PNG", "JPEG"])
def test_plain_files_stay_as_they_came(form):
    """8-bit RGB files keep every byte."""
    _, content = drawn(format=form)
    assert encoded_picture(content, False, 8, 6) == (content, form.lower(), True)


@pytest.mark.parametrize(
    "options",
    [{"mode": "L", "format": "PNG"}, {"mode": "L", "format": "JPEG"}, {"mode": "RGBA", "format": "PNG"},
     {"mode": "P", "format": "PNG"}],
)  # fmt: skip
def test_files_that_readers_read_in_different_ways_become_png(options):
    """Grey, transparent and indexed files come out as PNG of the pixels that the store gives."""
    _, content = drawn(**options)
    made, kind, is_unchanged = encoded_picture(content, False, 8, 6)
    assert (kind, is_unchanged) == ("png", False)
    assert np.array_equal(as_others_read(made), decode_rgb(content))


def test_an_orientation_is_not_followed_by_anyone():
    """A JPEG that says it lies on its side is given out as the store reads it: upright for every reader."""
    exif = PIL.Image.Exif()
    exif[0x0112] = 6
    _, content = drawn(format="JPEG", exif=exif, quality=95)
    assert as_others_read(content).shape == (6, 8, 3)
    made, kind, _ = encoded_picture(content, False, 8, 6)
    assert kind == "png"
    assert np.array_equal(as_others_read(made), decode_rgb(content))


def test_raw_frames_become_png_without_loss():
    """Pixels that were kept as pixels come back from the PNG, red where red was."""
    pixels = np.zeros((4, 5, 3), np.uint8)
    pixels[..., 0] = 200
    made, kind, is_unchanged = encoded_picture(pixels.tobytes(), True, 4, 5)
    assert (kind, is_unchanged) == ("png", False)
    assert np.array_equal(as_others_read(made), pixels)
    assert png_bytes(pixels) == made
    assert cv2.imdecode(np.frombuffer(made, np.uint8), cv2.IMREAD_COLOR_RGB)[0, 0].tolist() == [200, 0, 0]
