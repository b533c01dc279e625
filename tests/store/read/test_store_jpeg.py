"""The quick way to decode a JPEG gives the pixels of the slow one, and hands on what it does not know."""

from pathlib import Path

import cv2
import numpy as np

from tactiledata.contract.image_bytes import decode_rgb
from tactiledata.store.read.scaled_pictures import decode_jpeg_into

BACKGROUNDS = sorted((Path(__file__).parents[3] / "tactiledata" / "sensors" / "digit_backgrounds").glob("*.jpg"))


def test_both_decoders_agree_to_the_bit():
    """Both decoders agree on 18 real DIGIT pictures, and on grey and otherwise sampled JPEG files."""
    files = [path.read_bytes() for path in BACKGROUNDS]
    picture = decode_rgb(files[0])
    for sampling in (cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444, cv2.IMWRITE_JPEG_SAMPLING_FACTOR_420):
        settings = [cv2.IMWRITE_JPEG_SAMPLING_FACTOR, sampling, cv2.IMWRITE_JPEG_QUALITY, 90]
        files.append(cv2.imencode(".jpg", picture, settings)[1].tobytes())
    files.append(cv2.imencode(".jpg", picture[..., 0])[1].tobytes())
    assert len(files) == 21
    for content in files:
        target = np.zeros((320, 240, 3), np.uint8)
        assert decode_jpeg_into(content, target)
        assert (target == decode_rgb(content)).all()


def test_other_sizes_and_other_files_are_handed_on():
    """A picture of another size, a cut file and a PNG file are not taken."""
    content = BACKGROUNDS[0].read_bytes()
    picture = decode_rgb(content)
    assert not decode_jpeg_into(content, np.zeros((160, 120, 3), np.uint8))
    assert not decode_jpeg_into(content, np.zeros((320, 480, 3), np.uint8))
    assert not decode_jpeg_into(content[:-2000], np.zeros((320, 240, 3), np.uint8))
    assert not decode_jpeg_into(cv2.imencode(".png", picture)[1].tobytes(), np.zeros((320, 240, 3), np.uint8))
