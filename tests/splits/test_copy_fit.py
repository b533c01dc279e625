"""When the brightness of a possible copy is fitted more finely, and when that fit ends."""

import numpy as np
import pytest

from tactiledata.splits import copies
from tactiledata.splits.copies import Portrait, compare_images

PICTURE = np.random.default_rng(0).integers(60, 180, (64, 64, 3)).astype(np.uint8)


@pytest.mark.parametrize(
    ("gain", "offset", "is_fitted"),
    [
        (1.0, 0.0, False),
        (1.0, 0.29, False),
        (1.0, 0.31, True),
        (1.0, -0.31, True),
        (1.002, 0.0, False),  # 0.256 grey levels at mid grey
        (1.003, 0.0, True),  # 0.384
        (0.997, 0.0, True),
        (1.001, 0.1, False),  # 0.128 + 0.1
        (1.002, 0.2, True),  # 0.256 + 0.2
        (0.998, -0.2, True),
    ],
)
def test_a_change_of_brightness_below_rounding_is_not_fitted(gain, offset, is_fitted, monkeypatch):
    """Only where gain and offset together move mid grey by 0.3 levels or more is the fine fit made."""
    monkeypatch.setattr(copies, "brightness_fit", lambda *_: (gain, offset))
    monkeypatch.setattr(copies, "_left", lambda *_: 2.0)  # about what the noise of 2 levels leaves: undecided
    monkeypatch.setattr(copies, "_finest", lambda *_: 0.5)
    found = compare_images(Portrait(PICTURE), Portrait(PICTURE), 2.0)
    assert found.left == (0.5 if is_fitted else 2.0)


@pytest.mark.parametrize(("improvement", "trials"), [(1.0, 9), (0.95, 9), (0.85, 27)])
def test_a_fit_that_does_not_help_ends(improvement, trials, monkeypatch):
    """A round of nine trials that leaves more than nine tenths of what was left is the last of three."""
    made = []

    def left(*_):
        made.append(1)
        return 2.0 * improvement ** (1 + (len(made) - 1) // 9)

    monkeypatch.setattr(copies, "_left", left)
    found = copies._finest(Portrait(PICTURE), Portrait(PICTURE), (2.0, 1.0, 0.0), 0)
    assert len(made) == trials
    assert found == pytest.approx(2.0 * improvement ** (trials // 9))
