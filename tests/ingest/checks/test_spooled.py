"""Images come back from a spool as they went in."""

import cv2
import numpy as np
import pytest

from tactiledata.contract.records import Image
from tactiledata.ingest.checks.spooled import SpooledImages
from tactiledata.store.write.spool import Spool

RNG = np.random.default_rng(0)
PIXELS = RNG.integers(0, 256, (8, 6, 3), dtype=np.uint8)
PNG = cv2.imencode(".png", PIXELS[..., ::-1])[1].tobytes()


def image(payload, encoding, camera="digit", size=(8, 6)):
    return Image(camera, payload, encoding, *size, log_ns=1)


def spooled(folder, images):
    with Spool(folder / "spool") as spool:
        for one in images:
            spool.add(one)
        spool.close()
        return SpooledImages(spool.folder, spool.columns())


@pytest.fixture
def mixed(tmp_path):
    other = np.ascontiguousarray(PIXELS[:4])
    return spooled(
        tmp_path,
        [
            image(PNG, "png"),
            image(other.tobytes(), "raw", size=(4, 6)),
            image(b"", "missing"),
            image(PIXELS.tobytes(), "raw"),
            image(b"no picture", "png"),
            image(PNG + b"tail", "png", "other"),
            image(PNG, "png"),
        ],
    )


def test_pictures_come_back(mixed):
    """Encoded and raw ones to the bit, in whatever order they are asked for; what is missing or broken is None."""
    found = mixed.decode(np.array([3, 0, 1, 2, 4, 6]))
    for picture, expected in zip(found, [PIXELS, PIXELS, PIXELS[:4], None, None, PIXELS], strict=True):
        assert (picture is None) == (expected is None)
        if expected is not None:
            np.testing.assert_array_equal(picture, expected)


def test_payloads_are_the_bytes_that_came(mixed):
    """Each payload comes from its own place in its camera's file."""
    assert [mixed.payload(row) for row in (0, 2, 4, 5, 6)] == [
        ("png", PNG),
        ("missing", b""),
        ("png", b"no picture"),
        ("png", PNG + b"tail"),
        ("png", PNG),
    ]


def test_tails_are_the_last_bytes(mixed):
    """The tail is the last bytes of an image, and all of an image that is shorter."""
    assert mixed.tails([5, 0, 4, 6], 12) == [(PNG + b"tail")[-12:], PNG[-12:], b"no picture", PNG[-12:]]
    assert mixed.tails([], 12) == []
