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


@pytest.mark.parametrize(("left", "expected", "ratio"), [(0.05, 0.001, 0.0), (0.07, 0.1, 0.7), (0.06, 1e-9, 0.0)])
def test_what_rounding_leaves_is_no_difference(left, expected, ratio):
    """Up to 0.06 grey levels two images are the same whatever their noise."""
    assert copies.Comparison(left, expected).ratio == pytest.approx(ratio)


@pytest.mark.parametrize(("offset", "is_judged"), [(7.0, True), (8.0, False)])
def test_pictures_that_compression_cannot_part_so_far_are_not_judged(offset, is_judged, monkeypatch):
    """The limit is 4 grey levels and twice the noise: with 1.75 it is 7.5."""
    monkeypatch.setattr(copies, "brightness_fit", lambda *_: (1.0, offset))
    monkeypatch.setattr(copies, "_left", lambda *_: 2.0)
    monkeypatch.setattr(copies, "_finest", lambda *_: 2.0)
    assert np.isfinite(compare_images(Portrait(PICTURE), Portrait(PICTURE), 1.75).left) == is_judged


@pytest.mark.parametrize(("left", "is_fitted"), [(3.0, True), (5.0, False)])
def test_what_is_far_from_a_copy_is_not_fitted_more_finely(left, is_fitted, monkeypatch):
    """Noise of 2 levels leaves 1.9 of luma: 3 is 1.6 times as much, 5 is 2.6 times, beyond twice."""
    monkeypatch.setattr(copies, "brightness_fit", lambda *_: (1.0, 3.0))
    monkeypatch.setattr(copies, "_left", lambda *_: left)
    monkeypatch.setattr(copies, "_finest", lambda *_: 2.5)
    assert compare_images(Portrait(PICTURE), Portrait(PICTURE), 2.0).left == (2.5 if is_fitted else left)


def test_a_copy_is_tried_as_it_is_and_with_the_fitted_brightness(monkeypatch):
    """A copy is tried unchanged (gain 1, offset 0) and as fitted, without compression here."""
    tried = set()
    monkeypatch.setattr(copies, "brightness_fit", lambda *_: (1.01, 2.0))
    monkeypatch.setattr(copies, "_left", lambda _, __, *trial: tried.add(trial) or 99.0)
    compare_images(Portrait(PICTURE), Portrait(PICTURE), 2.0)
    assert {trial[:2] for trial in tried} == {(1.0, 0.0), (1.01, 2.0)}


def test_three_rounds_of_ever_finer_steps(monkeypatch):
    """Gains differ by 0.002, 0.001, 0.0005 about the best so far, offsets by a hundred times that; the middle stays."""
    made = []

    def left(_, __, gain, offset, ___):
        made.append((gain, offset))
        return 2.0 * 0.8 ** (1 + (len(made) - 1) // 9)

    monkeypatch.setattr(copies, "_left", left)
    copies._finest(Portrait(PICTURE), Portrait(PICTURE), (2.0, 1.0, 0.0), 0)
    middle = float(PICTURE.mean())
    centre = (1.0, 0.0)
    for number, step in enumerate((0.002, 0.001, 0.0005)):
        trials = made[9 * number : 9 * number + 9]
        expected = [
            (centre[0] + turn, centre[1] - turn * middle + shift)
            for turn in (-step, 0.0, step)
            for shift in (-100 * step, 0.0, 100 * step)
        ]
        np.testing.assert_allclose(trials, expected, rtol=0, atol=1e-9)
        centre = min(trials)  # all trials of a round leave as much, so that the smallest pair counts


def test_colours_far_off_a_first_line_have_no_say_in_the_second():
    """Two fits, outliers of the first left out of the second; a third would leave out more."""
    rng = np.random.default_rng(3)
    original = rng.uniform(20, 200, 2000)
    other = 1.05 * original + 4 + rng.normal(0, 1.0, 2000)
    other[:200] = np.clip(other[:200] + rng.uniform(5, 40, 200), 0, 240)
    one, two = original.astype(np.float32), other.astype(np.float32)

    def rounds(count):
        keep = (np.minimum(one, two) > 12) & (np.maximum(one, two) < 243)
        for _ in range(count):
            gain, offset = np.polyfit(one[keep], two[keep], 1)
            off = np.abs(two - (gain * one + offset))
            keep &= off <= 3 * np.median(off[keep]) + 0.01
        return gain, offset

    found = copies.brightness_fit(one, two)
    assert found == pytest.approx(rounds(2), abs=1e-9)
    assert all(found != pytest.approx(rounds(count), abs=1e-4) for count in (1, 3))


def test_every_third_pixel_tells_the_brightness():
    """Of 64 x 64 pixels, 22 x 22 of three colours are used."""
    assert Portrait(PICTURE).smooth.shape == (22 * 22 * 3,)


def test_noise_is_what_a_blur_of_a_pixel_and_a_half_leaves():
    """White noise of 1: luma has 0.668 of it, blurring takes 5.5 % of that away, and 1.6 times as much is 1.011."""
    rng = np.random.default_rng(4)
    one, two = (np.rint(120 + 4 * rng.normal(size=(320, 240, 3))).astype(np.uint8) for _ in range(2))
    kept = np.sqrt(1 - 2 / (2 * np.pi * 1.5**2) + 1 / (4 * np.pi * 1.5**2))
    luma = np.sqrt(0.299**2 + 0.587**2 + 0.114**2)
    assert copies.noise_between(one, two) == pytest.approx(1.6 * kept * luma * 4, rel=0.015)


@pytest.mark.parametrize(("quality", "is_found"), [(49, False), (50, True), (96, True), (97, False)])
def test_qualities_of_50_to_96_are_recovered(quality, is_found):
    """One beyond either end is not named."""
    rng = np.random.default_rng(5)
    rows, columns = np.mgrid[:192, :144]
    smooth = 120 + 60 * np.sin(rows / 9) * np.cos(columns / 7) + 5 * rng.normal(size=(192, 144))
    picture = np.repeat(np.clip(smooth, 0, 255)[..., None], 3, axis=2).astype(np.uint8)
    portrait = Portrait(copies.compress(picture, quality))
    assert (portrait.quality == quality) == is_found
