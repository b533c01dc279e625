"""A camera's lag from planted touches of small grey pictures."""

import re

import numpy as np
import pytest

from tactiledata.contract.take import Reference
from tactiledata.ingest.clocks.lag import (
    LAGS,
    MIN_CORRELATION,
    MIN_PEAK,
    MIN_RATE,
    camera_lag,
    clear_peak,
    lag_in_words,
)
from tests.ingest.made_takes import frames, signal, take, touch

START = 1_700_000_000_000_000_000
MS = 1_000_000
SPAN = 4000
"""ms of a touch, and as much time between two."""


def press(ms):
    """N at some moments (ms) of a touch: up for 1.5 s, down faster."""
    return 10 * np.interp(ms, [500, 2000, 3000], [0, 1, 0], 0, 0) + np.interp(ms, [400, 3200], [0.6, 0.6], 0, 0)


def planted(late=0, touches=1, rate=30, spans=None, curve=press, noise=0.0, **columns):
    """A take whose pictures change with the force, and the pictures by row; images are ``late`` ms late."""
    spans = spans or [SPAN] * touches
    t_frames, rows, seen = [], [], []
    for number, span in enumerate(spans):
        t = np.arange(0, span, 1000 / rate)
        t_frames.append(2 * SPAN * number + t)
        rows += [number] * len(t)
        seen.append(curve(t * SPAN / span - late))
    t_frames, seen = np.concatenate(t_frames), np.concatenate(seen)
    seen = seen + np.random.default_rng(0).normal(0, noise, len(seen))
    t_wrench = np.arange(-1000, 2 * SPAN * len(spans), 5)
    number, into = np.divmod(t_wrench, 2 * SPAN)
    stretched = into * SPAN / np.array(spans)[np.maximum(number, 0)]
    force = np.asarray(curve(stretched)) * (t_wrench >= 0)
    wrench = np.zeros((len(force), 6))
    # the force turns from -y to z while it presses
    turn = np.pi / 2 * np.clip(stretched / SPAN, 0, 1)
    wrench[:, 1], wrench[:, 2], wrench[:, 3] = -force * np.cos(turn), force * np.sin(turn), 99
    count = len(rows)
    own = np.interp(t_frames, t_wrench, force)
    table = frames(
        count, trajectory=rows, t_ns=START + np.rint(t_frames * MS).astype(np.int64), contact_force=own, **columns
    )
    made = take(
        table, [touch(f"t{n}") for n in range(len(spans))],
        {"contact_wrench": signal("contact_wrench", START + t_wrench * MS, wrench)},
        references={"D1": Reference(np.full((8, 6, 3), 100, np.uint8), "a file")},
    )  # fmt: skip
    pictures = np.full((count, 8, 6, 3), 100, np.uint8)
    pictures[:, ::2, ::2] = np.rint(100 + 10 * seen).astype(np.uint8)[:, None, None, None]
    return made, pictures


def said(made, pictures, asked=None):
    def decode(rows):
        if asked is not None:
            asked.append(rows.tolist())
        return [pictures[row] for row in rows]

    found = camera_lag(made, decode)
    assert all((one.code, one.severity) == ("camera-lag", "info") for one in found)
    return [(one.count, one.message) for one in found]


def lag_ms(found):
    [(_, text)] = found
    match = re.search(r"is ([+-]\d+) ms", text)
    return int(match[1]) if match else 0


@pytest.mark.parametrize("late", [-150, -80, 80, 150])
def test_a_planted_lag_comes_back(late):
    """Within 10 ms, which is how far the lags that are tried lie apart; late images have a positive one."""
    assert abs(lag_ms(said(*planted(late))) - late) <= 10


def test_the_rules_of_lags_in_numbers():
    """Lags to 0.3 s in steps of 10 ms; 8 images a second; a correlation of 0.9 and a fall of 0.01."""
    assert (LAGS / MS).tolist() == list(range(-300, 301, 10))
    assert (MIN_RATE, MIN_CORRELATION, MIN_PEAK) == (8.0, 0.9, 0.01)


def test_touches_are_counted_six_at_most():
    """At most six touches are counted, with the spread of their own lags."""
    assert said(*planted(100, touches=2))[0][0] == 2
    assert "the 2 touches judged one by one" in said(*planted(100, touches=2))[0][1]
    asked = []
    assert said(*planted(100, touches=7), asked)[0][0] == 6
    assert len(asked) == 6


def test_the_longest_touches_are_taken():
    """The longest touches come first, with 48 images each from the first to the last."""
    made, pictures = planted(100, spans=[2000] * 3 + [4000, 3000] * 3)
    asked = []
    said(made, pictures, asked)
    rows = made.frames["trajectory"].to_numpy()
    assert [rows[some[0]] for some in asked] == [3, 5, 7, 4, 6, 8]
    force = made.frames["contact_force"].to_numpy()
    assert [len(some) for some in asked] == [48] * 6
    touched = np.flatnonzero((rows == 3) & (force > 0.5))
    assert (asked[0][0], asked[0][-1]) == (touched[0], touched[-1])


def test_without_wrench_images_or_reference_nothing_is_said():
    """Nor where no image decodes, or all have another size."""
    made, pictures = planted(100)
    assert said(take(made.frames, [touch()]), pictures) == []
    assert said(take(frames(0), [touch()], made.signals), pictures) == []
    assert said(take(made.frames, [touch()], made.signals), pictures) == []
    assert camera_lag(made, lambda rows: [None] * len(rows)) == []
    assert said(made, pictures[:, :, :4]) == []


def test_some_images_that_do_not_decode_are_left_out():
    """Fifteen are enough, fourteen are not."""
    made, pictures = planted(100, rate=15)

    def decode(count):
        def decoded(rows):
            kept = np.linspace(0, len(rows) - 1, count).astype(int)
            return [pictures[row] if place in kept else None for place, row in enumerate(rows)]

        return decoded

    evenly = camera_lag(made, lambda rows: [pictures[row] if row % 2 else None for row in rows])
    assert len(evenly) == 1
    rows = []
    camera_lag(made, lambda some: rows.extend(some) or [None] * len(some))
    assert len(rows) > 30
    assert camera_lag(made, decode(14)) == []
    assert len(camera_lag(made, decode(15))) == 1


def test_a_sensor_without_reference_is_passed_over():
    """The touch of another one counts, also where the first is longer."""
    made, pictures = planted(100, spans=[SPAN, 3500])
    count = int((made.frames["trajectory"].to_numpy() == 0).sum())
    sensors = ["D9"] * count + ["D1"] * (made.frames.num_rows - count)
    other, _ = planted(100, spans=[SPAN, 3500], sensor=sensors)
    assert said(made, pictures)[0][0] == 2
    assert said(other, pictures)[0][0] == 1


def curve(best, peak=0.95, low=0.5, **others):
    """A correlation at 61 lags that peaks at one of them; others by their distance, as in before_10."""
    found = np.full(61, low)
    found[best] = peak
    for name, value in others.items():
        side, distance = name.split("_")
        found[best + int(distance) * (1 if side == "after" else -1)] = value
    return found


@pytest.mark.parametrize("side", ["before", "after"])
def test_a_peak_falls_within_a_tenth_of_a_second(side):
    """A peak falls by 0.01 at ten lags on either side; what lies between or farther away does not matter."""
    assert clear_peak(curve(30)) == 30
    assert clear_peak(curve(30, **{f"{side}_10": 0.9399})) == 30
    assert clear_peak(curve(30, **{f"{side}_10": 0.9401})) is None
    assert clear_peak(curve(30, **{f"{side}_9": 0.949, f"{side}_11": 0.949})) == 30


def test_a_peak_is_a_correlation_of_nine_tenths():
    """Just below it there is none; lags that are not known do not count."""
    assert clear_peak(curve(30, 0.9)) == 30
    assert clear_peak(curve(30, 0.8999)) is None
    assert clear_peak(curve(30, before_1=np.nan)) == 30


def test_a_peak_at_the_end_of_the_lags_is_none():
    """Where the last lag that is tried is as good, the lag may be larger."""
    assert clear_peak(curve(0)) is None
    assert clear_peak(curve(60)) is None
    assert clear_peak(curve(5)) == 5
    assert clear_peak(curve(5, before_5=0.949)) is None
    assert clear_peak(curve(55)) == 55
    assert clear_peak(curve(55, after_5=0.949)) is None
    assert clear_peak(np.where(np.arange(61) == 59, 0.949, curve(5, after_10=0.5))) == 5


@pytest.mark.parametrize("noise", [0.0, 3.0])
def test_pictures_that_do_not_follow_the_force_tell_no_lag(noise):
    """A correlation below 0.9 is none."""
    assert bool(said(*planted(100, noise=noise))) == (noise == 0)


def test_a_touch_that_only_loads_tells_no_lag():
    """Every lag makes one a function of the other: the correlation does not fall beside its peak."""
    assert said(*planted(0, curve=lambda ms: 1 + np.clip(np.asarray(ms) / 400, -1, 20))) == []


@pytest.mark.parametrize(("rate", "count"), [(8.0, 1), (7.9, 0)])
def test_images_come_eight_times_a_second(rate, count):
    """Slower ones cannot tell."""
    assert len(said(*planted(200, rate=rate))) == count


def test_images_that_are_missing_or_without_force_do_not_count():
    """Those left of a touch are counted, and what is 0.5 N and less is no touch."""
    made, pictures = planted(100)
    count = made.frames.num_rows
    assert said(planted(100, encoding=["missing"] * count)[0], pictures) == []
    asked = []
    half = planted(100, encoding=["missing", "png"] * (count // 2))[0]
    assert len(said(half, pictures, asked)) == 1
    assert all(row % 2 for row in asked[0])
    assert said(planted(100, curve=lambda ms: press(ms) / 21)[0], pictures) == []


@pytest.mark.parametrize(
    ("lag", "frame", "each", "words"),
    [
        (30, 33.4, [30], "camera lag: none seen (less than 64 ms; frames are 33 ms apart)"),
        (-33.4, 33.4, [30], "camera lag: none seen (less than 67 ms; frames are 33 ms apart)"),
        (33.5, 33.4, [30], "the camera is +34 ms against the force sensor, give or take 33 ms; + means"),
        (10, 1, [0, 30], "less than 25 ms; frames are 1 ms apart; the 2 touches judged one by one spread over 30 ms)"),
        (2e9, 1e9, [7], "the camera is +2000000000 ms against the force sensor, give or take 1000000000 ms;"),
        (1e9, 2e9, [7], "(less than 3000000000 ms; frames are 2000000000 ms apart)"),
        (9e9, 1, [0, 4e9], "give or take 2000000000 ms; + means that images come late; the 2 touches judged one by one "
         "spread over 4000000000 ms. Reported, not applied"),
    ],
)  # fmt: skip
def test_lags_in_words(lag, frame, each, words):
    """Numbers in ms; the doubt is a frame, or half the spread where that is more."""
    assert words in lag_in_words(int(lag * MS), frame * MS, [int(one * MS) for one in each])
