"""A zero is never taken in contact without a word: where free air was lost, or the zero moved inside a touch."""

import numpy as np
import pytest
from copied_trees import copy_tree
from few_examples import few
from hypothesis import example, given
from hypothesis import strategies as st

from tactiledata.ingest.forces.tare import find_zero
from tactiledata.ingest.pipeline import ingest
from tactiledata.store.read.reader import Store

START = 1_700_000_000_000_000_000
RATE, TOUCH_SECONDS, NOISE = 100, 8.0, 0.05
WITHIN = 0.2
"""N: noise, and drift within a touch."""


class Touches:
    """Touches of 8 s one after another: 1 s of air, a press of ``peak`` N for 3 s, then air; a zero that drifts."""

    def __init__(self, seed, count, peak, drift=0.01, zero=2.0):
        rng = np.random.default_rng(seed)
        seconds = np.arange(int(count * TOUCH_SECONDS * RATE)) / RATE
        self.into = seconds % TOUCH_SECONDS
        self.touch = (seconds // TOUCH_SECONDS).astype(int)
        shape = np.clip((self.into - 1.0) / 0.5, 0, 1) * np.clip((4.5 - self.into) / 0.5, 0, 1)
        self.truth = shape * peak * (1 + 0.1 * self.touch)
        self.t_ns = START + (seconds * 1e9).astype(np.int64)
        self.load = rng.normal(0, NOISE, (len(seconds), 6)) * [1, 1, 1, 0.02, 0.02, 0.02]
        self.load += zero + drift * seconds[:, None]
        self.load[:, 2] += self.truth
        starts = START + (np.arange(count) * TOUCH_SECONDS * 1e9).astype(np.int64)
        self.spans = [(f"t{n}", int(start), int(start + 7e9)) for n, start in enumerate(starts)]

    def answer(self, lost=None, tares=()):
        """N: the worst mean error of a touch's force at rest; and the findings by code."""
        kept = np.ones(len(self.t_ns), dtype=bool) if lost is None else ~lost
        zero = find_zero(self.t_ns[kept], self.load[kept], self.spans, list(tares))
        off = (self.load[kept] - zero.bias)[:, 2] - self.truth[kept]
        rest = (self.into[kept] > 1.6) & (self.into[kept] < 3.9)
        worst = max(
            abs(np.nanmean(off[rest & (self.touch[kept] == n)]))
            for n in range(len(self.spans))
            if (rest & (self.touch[kept] == n)).any()
        )
        return worst, {finding.code: finding for finding in zero.findings}


@few(60)
@example(0, 3, 1.9, [0], 2.0, False)
@given(
    st.integers(0, 10**6),
    st.integers(2, 6),
    st.floats(0.8, 4.5),
    st.lists(st.integers(0, 5), min_size=1, max_size=3),
    st.floats(1.2, 3.0),
    st.booleans(),
)
def test_a_touch_whose_free_air_was_lost_takes_no_zero_in_contact(seed, count, peak, numbers, until, is_nan):
    """Rows are missing (or have no pose) from before a touch until it presses: its force is right, or it is named."""
    world = Touches(seed, count, peak)
    named = sorted({number % count for number in numbers})[: count - 1]
    lost = np.isin(world.touch, named) & (world.into < until)
    if is_nan:
        world.load[lost] = np.nan
        lost = None
    worst, said = world.answer(lost)
    assert worst < WITHIN + 0.1 * count
    assert said["no-free-air"].count == len(named)
    assert all(f"t{number}" in said["no-free-air"].message for number in named)


@given(st.integers(0, 10**6), st.integers(1, 6), st.floats(0.8, 6.0), st.floats(0.0, 0.8), st.floats(-0.01, 0.01))
def test_free_air_of_which_a_part_was_lost_still_counts(seed, count, peak, until, drift):
    """Negative control: while some free air is left before a touch, it is its zero, and nothing is said."""
    world = Touches(seed, count, peak, drift)
    worst, said = world.answer(world.into < until)
    assert worst < WITHIN
    assert not {"no-free-air", "zero-moved"} & set(said)


@pytest.mark.parametrize("peak", [1.0, 1.9, 4.0])
def test_a_trajectory_that_is_named_too_late_begins_in_contact(peak):
    """Nothing was lost, but the interval of the third touch begins while it presses: the zero is its neighbours'."""
    world = Touches(1, 5, peak)
    name, start, end = world.spans[2]
    world.spans[2] = (name, start + 2 * 10**9, end)
    worst, said = world.answer()
    assert worst < WITHIN
    assert said["no-free-air"].count == 1


@pytest.mark.parametrize("step", [0.8, -2.0])
def test_an_unstated_tare_inside_a_touch_is_said(step):
    """The zero jumps while something presses: the trajectory is named. Stated, it is an info, and forces are right."""
    world = Touches(2, 4, 5.0)
    jump = (world.touch == 1) & (world.into >= 2.5)
    moment = int(world.t_ns[jump][0])
    world.load[world.t_ns >= moment] += step
    _, said = world.answer()
    assert said["zero-moved"].severity == "warning"
    assert said["zero-moved"].count == 1
    assert "t1" in said["zero-moved"].message


def test_an_unstated_tare_between_touches_is_no_matter():
    """Negative control: each touch has its own zero, so a jump in the pause moves no force; nor does a drift."""
    world = Touches(3, 4, 5.0, drift=0.03)
    world.load[(world.touch > 1) | ((world.touch == 1) & (world.into > 7.2)), 2] += 3.0
    worst, said = world.answer()
    assert worst < WITHIN
    assert not {"no-free-air", "zero-moved"} & set(said)


@pytest.mark.parametrize("first", [2, 3, 4])
@pytest.mark.parametrize("step", [8.0, -8.0])
def test_an_unstated_tare_of_many_newtons_between_touches(first, step):
    """However far the zero jumps: two touches on either side that come back to where they began were in free air."""
    world = Touches(3, 6, 5.0)
    world.load[world.touch >= first, 2] += step
    worst, said = world.answer()
    assert worst < WITHIN
    assert "no-free-air" not in said
    assert said["zero-drift"].count == 6


def test_an_unstated_tare_under_load_leaves_the_touches_before_it():
    """Set to zero while the third of six touches presses: those before it keep the zero that they were read with."""
    world = Touches(2, 6, 8.0)
    jump = (world.touch == 2) & (world.into >= 2.5)
    world.load[world.t_ns >= int(world.t_ns[jump][0]), 2] += 8.0
    zero = find_zero(world.t_ns, world.load, world.spans, [])
    off = (world.load - zero.bias)[:, 2] - world.truth
    for number in (0, 1, 3, 4, 5):
        assert abs(np.mean(off[(world.touch == number) & (world.into < 7)])) < WITHIN, number
    said = {finding.code: finding for finding in zero.findings}
    assert "t2" in said["zero-moved"].message
    assert "no-free-air" not in said


def test_one_touch_far_off_is_not_believed():
    """Alone at another level it may be one long press: it takes the zero of its neighbours, and is named."""
    world = Touches(3, 6, 5.0)
    world.load[world.touch == 5, 2] += 8.0
    _, said = world.answer()
    assert said["no-free-air"].count == 1


@pytest.mark.slow
@pytest.mark.parametrize("touch", [0, 1])
def test_a_log_that_lost_the_air_before_a_touch_names_it(touch, tiny_folders, tmp_path):
    """Rows of wrench.csv are missing until the touch presses: the trajectory is named, and no other."""
    log = copy_tree(tiny_folders[0], tmp_path / "log")
    plain = ingest([tiny_folders[0]], tmp_path / "plain.zarr").sources[0]
    codes = {finding.code for finding in plain.findings}
    assert not codes & {"no-free-air", "zero-moved", "sign-reversed", "tare-elsewhere", "tare-not-seen"}
    store = Store.open(tmp_path / "plain.zarr")
    frames = store.frames(["trajectory", "t_ns", "contact_force"]).to_pydict()
    pressed = [t for n, t, force in zip(*frames.values(), strict=True) if n == touch and force > 1.0]
    row = store.trajectories().to_pylist()[touch]
    head, *rows = (log / "wrench.csv").read_text().splitlines()
    kept = [text for text in rows if not row["start_ns"] - 10**9 < int(text.split(",")[0]) < pressed[0] - 10**6]
    (log / "wrench.csv").write_text("\n".join([head, *kept]) + "\n")
    [source] = ingest([log], tmp_path / "ds.zarr").sources
    [said] = [finding for finding in source.findings if finding.code == "no-free-air"]
    assert said.count == 1
    assert row["trajectory"] in said.message
