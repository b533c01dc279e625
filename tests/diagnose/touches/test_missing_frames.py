"""Frames that a play lacks are estimated from other loads and from the middle play: closed forms of two gels."""

import numpy as np
import pytest

from tactiledata.calibrate.plays.kept_plays import Play
from tactiledata.diagnose.touches.missing_frames import NEIGHBOURS, complete, solved
from tactiledata.gel.contact.history import FrameStatus

FRAMES = 40
TOLERANCE = 0.01
"""Largest error of an estimated force or torque, as a share of the largest one of the play."""
DEPTHS = 1e-3 * np.sin(np.linspace(-0.3, np.pi + 0.3, FRAMES))
"""A press and its withdrawal, m; negative in free air."""
SLIDE = 1e-3 * np.linspace(0.0, 1.0, FRAMES)


def press(depths=DEPTHS, stiffness=1.0, exponent=1.5, friction=0.5, centre=0.0, spot=1.0, spin=2e-4):
    """A play of a ball that presses and slides: a power law of the depth, Coulomb's shear, a centre that wanders.

    The wrench is that of a force at the centre of pressure, at the height of the tip, and of a spin about the normal.
    """
    depth = np.maximum(depths, 0.0)
    load = 0.01 * stiffness * (depth / 1e-3) ** exponent
    force = np.column_stack([-friction * load, 0.3 * friction * load * np.sin(3e3 * SLIDE), load])
    places = np.column_stack([SLIDE - centre * depth / 1e-3, 0.5 * SLIDE + 0.5 * centre * depth / 1e-3, -depths])
    torque = np.cross(places, force)
    torque[:, 2] += spin * friction * load
    area = spot * 2e-5 * depth / 1e-3
    status = np.where(depth > 0, FrameStatus.SOLVED, FrameStatus.NO_CONTACT).astype(np.int8)
    return Play(np.hstack([force, torque]), status, area)


def other(depths=DEPTHS):
    """The same touch of a gel that is stiffer the deeper it is pressed, with more friction and another centre."""
    return press(depths, 1.2, 1.6, 0.6, 1e-4, 1.1)


def without(play, frames, status=FrameStatus.NOT_CONVERGED):
    """The play with some frames not solved."""
    wrench, states, area = play.wrench.copy(), play.status.copy(), play.area.copy()
    wrench[frames], states[frames], area[frames] = np.nan, status, 0.0
    return Play(wrench, states, area)


def error(found, truth):
    """Largest errors of force and torque, and of the area, as shares of the largest ones."""
    size = np.repeat([np.abs(truth.wrench[:, :3]).max(), np.abs(truth.wrench[:, 3:]).max()], 3)
    return np.abs((found.wrench - truth.wrench) / size).max(), np.abs(found.area - truth.area).max() / truth.area.max()


def one(play, middle, depths=DEPTHS):
    """The completed play of one touch."""
    (found,) = complete([play], [middle], [-depths])
    return found


@pytest.mark.slow
@pytest.mark.parametrize("lost", [[12], [18, 19, 20, 21], [9, 15, 16, 25, 30]], ids=["one", "the deepest", "some"])
def test_lost_frames_are_recovered(lost):
    """Within the stated tolerance; by the middle play alone they would be off by five times that and more."""
    truth, middle = other(), press()
    found = one(without(truth, lost), middle)
    assert max(error(found, truth)) < TOLERANCE
    assert solved(found).all()
    kept = np.setdiff1d(np.arange(FRAMES), lost)
    assert np.array_equal(found.wrench[kept], truth.wrench[kept])
    assert np.array_equal(found.area[kept], truth.area[kept])
    # the factors are needed: what the middle play has is far from it
    plain = Play(truth.wrench.copy(), truth.status, truth.area.copy())
    plain.wrench[lost], plain.area[lost] = middle.wrench[lost], middle.area[lost]
    assert max(error(plain, truth)) > 5 * TOLERANCE


def test_beyond_the_loads_that_are_known_factors_are_those_of_the_last_one():
    """A play that lacks its upper half gets there the middle play's load times its last known factor."""
    truth, middle = other(), press()
    lost = np.flatnonzero(middle.wrench[:, 2] > 0.5 * middle.wrench[:, 2].max())
    found = one(without(truth, lost), middle)
    known = np.setdiff1d(np.flatnonzero(middle.wrench[:, 2] > 0), lost)
    last = known[np.argmax(middle.wrench[known, 2])]
    factor = truth.wrench[last, 2] / middle.wrench[last, 2]
    assert found.wrench[lost, 2] == pytest.approx(factor * middle.wrench[lost, 2])


def test_a_factor_that_is_the_same_at_all_loads_is_exact():
    """A gel with another modulus has the middle play's wrench times one number, at every frame."""
    middle = press()
    stiffer = Play(1.3 * middle.wrench, middle.status, middle.area)
    lost = np.arange(5, 35, 3)
    assert max(error(one(without(stiffer, lost), middle), stiffer)) < 1e-9


def test_without_shear_none_is_made_up():
    """A middle play without shear gives no factor of shear; that of the load stands for it."""
    truth, middle = press(stiffness=1.2, friction=1e-3), press(friction=1e-3)
    found = one(without(truth, [10, 20]), middle)
    assert np.isfinite(found.wrench).all()
    assert max(error(found, truth)) < TOLERANCE


def test_what_the_middle_does_not_know_stays_unknown():
    """There is nothing that an estimate could follow; a frame that the play itself has solved stays solved."""
    truth = other()
    middle = without(press(), [12, 13], FrameStatus.TOO_DEEP)
    found = one(without(truth, [12, 20]), middle)
    assert found.status[12] == FrameStatus.NOT_CONVERGED
    assert np.isnan(found.wrench[12]).all()
    assert np.array_equal(found.wrench[13], truth.wrench[13])
    assert found.status[20] == FrameStatus.SOLVED


def test_no_contact_stays_no_contact():
    """A frame in free air that a play has not solved has no force, no area, and the status that says so."""
    truth, middle = other(), press()
    air = np.flatnonzero(DEPTHS < 0)
    found = one(without(truth, air[:2]), middle)
    assert (found.status[air] == FrameStatus.NO_CONTACT).all()
    assert not found.wrench[air].any()
    assert not found.area[air].any()


def test_plays_without_a_gap_are_returned_as_they_are():
    """Plays without a gap are returned as they are, also beside another touch that has one, and are never changed."""
    whole, broken, middle = other(), without(other(), [10]), press()
    assert one(whole, middle) is whole
    first, second = complete([whole, broken], [middle, middle], [-DEPTHS, -DEPTHS])
    assert first is whole
    assert second is not broken
    assert broken.status[10] == FrameStatus.NOT_CONVERGED
    assert np.isnan(broken.wrench[10]).all()


def test_a_touch_of_which_no_frame_is_solved_takes_the_factors_of_other_touches():
    """Its loads are the middle ones, times the median of the factors at the loads of another touch that are next."""
    shallow = 0.6 * DEPTHS
    middles = [press(), press(shallow)]
    truths = [other(), other(shallow)]
    lost = np.flatnonzero(shallow > 0)
    found = complete([truths[0], without(truths[1], lost)], middles, [-DEPTHS, -shallow])[1]
    assert solved(found).all()
    loads = [middle.wrench[:, 2] for middle in middles]
    factors = truths[0].wrench[:, 2][loads[0] > 0] / loads[0][loads[0] > 0]
    for frame in lost:
        next_in_load = np.argsort(np.abs(loads[0][loads[0] > 0] - loads[1][frame]))[:NEIGHBOURS]
        expected = np.median(factors[next_in_load]) * loads[1][frame]
        assert found.wrench[frame, 2] == pytest.approx(expected)
    # load and shear come within some per cent of the truth, the middle play only within a quarter
    assert error(found, truths[1])[0] < 0.05
    assert error(Play(middles[1].wrench, found.status, found.area), truths[1])[0] > 0.15


def test_one_odd_frame_of_another_touch_changes_nothing():
    """The median of the neighbours does not follow a frame that was solved badly."""
    shallow = 0.6 * DEPTHS
    middles = [press(), press(shallow)]
    truths = [other(), other(shallow)]
    lost = np.flatnonzero(shallow > 0)
    odd = Play(truths[0].wrench.copy(), truths[0].status, truths[0].area)
    odd.wrench[11] *= 50.0
    found = complete([odd, without(truths[1], lost)], middles, [-DEPTHS, -shallow])[1]
    assert error(found, truths[1])[0] < 0.05


def test_a_play_without_any_contact_that_is_solved_stays_as_it_is():
    """Neither this touch nor another one says how it differs from the middle play."""
    lost = np.flatnonzero(DEPTHS > 0)
    broken = [without(other(), lost), without(other(), lost)]
    found = complete(broken, [press(), press()], [-DEPTHS, -DEPTHS])
    assert all(one is given for one, given in zip(found, broken, strict=True))
