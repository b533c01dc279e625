"""Shear where friction, depth or path are not those of a play: against planted springs, Mindlin's contact and laws."""

import numpy as np
import pytest
from few_examples import few
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import PchipInterpolator

from tactiledata.diagnose.touches.between_plays import CubicsOverFriction, Parabola, PressedContact, ShearBetweenPlays
from tactiledata.diagnose.touches.sliders import Sliders

NODES = np.array([0.4, 0.6, 0.85])
STEP = 5e-5
OUT, BACK = 20, 24
WAY = np.concatenate([np.linspace(0, 12e-4, OUT), np.linspace(12e-4, 1e-4, BACK + 1)[1:]])
PATH = np.column_stack([0.6 * WAY, -0.8 * WAY])
FRAMES = len(WAY)
STILL, NOWHERE = np.zeros(FRAMES), np.zeros((FRAMES, 2))
PLANTED = Sliders(1.0, 0.4)


def pressed(load, deeper=0.0):
    """A round contact of 5 mm² on 4 mm of gel, whose load over E, m², grows by a share for each metre of depth."""
    area = np.where(load > 0, 5e-6, 0.0)
    rest = np.zeros(FRAMES)
    return PressedContact(Parabola(load, deeper * load, rest), Parabola(area, rest, rest), 0.475, 4e-3)


LOAD = np.linspace(3.0, 4.0, FRAMES) * 1e-6
CONTACT = pressed(LOAD)


class Touch:
    """A contact that is springs with sliders, played at the nodes, and told between them."""

    def __init__(self, sliders=PLANTED, path=PATH, contact=CONTACT):
        self.sliders, self.path, self.contact = sliders, path, contact
        self.load = contact.load.level
        shear = np.array([self.true(np.full(FRAMES, friction)) for friction in NODES])
        self.between = ShearBetweenPlays.of(NODES, STEP, path, contact, shear)
        self.played = CubicsOverFriction(NODES, PchipInterpolator(NODES, shear).c)

    def true(self, frictions, offset=STILL, shift=NOWHERE):
        """Shear of the planted springs on the indenter."""
        stiffness, load = self.contact.at(offset)
        return -self.sliders.pull(self.path + shift, stiffness, frictions * load)

    def told(self, frictions, shift=NOWHERE):
        """Shear without an offset, from plays at the nodes."""
        own = self.played.at(frictions)
        return own + self.between.missed(frictions, STILL, shift, own, self.load)


@few(40)
@given(st.lists(st.floats(0.0, 1.6), min_size=4, max_size=4), st.floats(0.0, 0.9), st.floats(0.7, 1.4))
def test_planted_springs_are_told_at_any_friction(corners, spread, factor):
    """Within 1 % of the largest limit, whatever friction each frame has, beyond the plays and with earlier frames."""
    touch = Touch(Sliders(factor, spread))
    frictions = np.interp(np.arange(FRAMES), np.linspace(0, FRAMES - 1, 4), corners)
    assert np.abs(touch.told(frictions) - touch.true(frictions)).max() < 0.01 * 1.6 * LOAD.max()


@few(20)
@given(st.lists(st.floats(-3e-4, 3e-4), min_size=8, max_size=8), st.floats(0.45, 0.8))
def test_a_way_that_differs_from_frame_to_frame_is_told(corners, friction):
    """Within 1 % of the limit, at any friction."""
    touch = Touch()
    places = np.linspace(0, FRAMES - 1, 4)
    shift = np.column_stack([np.interp(np.arange(FRAMES), places, half) for half in (corners[:4], corners[4:])])
    frictions = np.full(FRAMES, friction)
    found, true = touch.told(frictions, shift), touch.true(frictions, STILL, shift)
    assert np.abs(found - true).max() < 0.01 * friction * LOAD.max()


def test_a_depth_that_changes_is_told():
    """A contact pressed twice as hard from its middle on pulls as the springs do, and not as if always so pressed."""
    touch = Touch(contact=pressed(np.full(FRAMES, 3e-6), deeper=1.0 / STEP))
    offset = np.where(np.arange(FRAMES) < OUT, 0.0, STEP)
    frictions = np.full(FRAMES, 0.6)
    true = touch.true(frictions, offset)
    always = touch.true(frictions, np.full(FRAMES, STEP))
    own = np.where((offset > 0)[:, None], always, touch.true(frictions))
    load = touch.contact.at(offset)[1]
    found = own + touch.between.missed(frictions, offset, NOWHERE, own, load)
    assert np.abs(own - true).max() > 0.3 * 0.6 * 3e-6
    assert found == pytest.approx(true, abs=0.01 * 0.6 * 3e-6)


@few(20)
@given(st.integers(0, 10_000))
def test_plays_stand(seed):
    """The springs add no shear at a friction and offset that were played, even if no springs can fit that play."""
    touch = Touch()
    noise = np.random.default_rng(seed).normal(0, 2e-7, (3, FRAMES, 2))
    shear = np.array([touch.true(np.full(FRAMES, friction)) for friction in NODES]) + noise
    between = ShearBetweenPlays.of(NODES, STEP, PATH, CONTACT, shear)
    for friction, expected in zip(NODES, shear, strict=True):
        for offset in (-STEP, 0.0, STEP):
            missed = between.missed(
                np.full(FRAMES, friction), np.full(FRAMES, offset), np.full((FRAMES, 2), 1e-4), expected, LOAD
            )
            assert missed == pytest.approx(0.0, abs=1e-16)


def mindlin(way, friction):
    """Shear of two balls, Mindlin 1949: k x at first, the limit from x = 3 mu N / (2 k) on."""
    stiffness = CONTACT.at(STILL)[0][0]
    return friction * 3e-6 * (1 - np.maximum(1 - stiffness * way / (1.5 * friction * 3e-6), 0.0) ** 1.5)


def there_and_back(friction):
    """Out until all slides, then back: Masing's rule, twice as wide and twice as high; along x."""
    there = mindlin(WAY[:OUT], friction)
    back = there[-1] - 2 * mindlin((WAY[OUT - 1] - WAY[OUT:]) / 2, friction)
    return -np.column_stack([np.concatenate([there, back]), np.zeros(FRAMES)])


@pytest.mark.parametrize(("friction", "most"), [(0.1, 0.06), (0.25, 0.07), (0.5, 0.05), (0.7, 0.04), (1.1, 0.05)])
def test_mindlins_contact_is_told_at_other_frictions(friction, most):
    """Springs are no Mindlin contact: from its plays it is told within a share of the limit, better than without."""
    path = np.column_stack([WAY, np.zeros(FRAMES)])
    shear = np.array([there_and_back(played_at) for played_at in NODES])
    contact = pressed(np.full(FRAMES, 3e-6))
    between = ShearBetweenPlays.of(NODES, STEP, path, contact, shear)
    frictions = np.full(FRAMES, friction)
    without = CubicsOverFriction(NODES, PchipInterpolator(NODES, shear).c).at(frictions)
    told = without + between.missed(frictions, STILL, NOWHERE, without, contact.load.level)
    true = there_and_back(friction)
    error, usual = (np.abs(one - true).max() / (3e-6 * friction) for one in (told, without))
    assert error < most
    assert error < 0.8 * usual


def test_a_limit_that_grows_at_rest_pulls_nothing():
    """What stands keeps its pull, however strong its hold grows; what falls below the pull lets it slip."""
    still = np.concatenate([WAY[:OUT], np.full(BACK, WAY[OUT - 1])])
    touch = Touch(path=np.column_stack([still, np.zeros(FRAMES)]), contact=pressed(np.full(FRAMES, 3e-6)))
    for later, expected in ((0.95, 0.5), (0.3, 0.3)):
        found = touch.told(np.where(np.arange(FRAMES) < OUT, 0.5, later))
        assert found[OUT:, 0] == pytest.approx(-expected * 3e-6, rel=0.01)


def test_air_forgets_and_has_no_shear():
    """After a frame without load, frames before it do not matter; in that frame nothing is missed."""
    load = LOAD.copy()
    load[OUT] = 0.0
    touch = Touch(contact=pressed(load))
    frictions = np.full(FRAMES, 0.6)
    frictions[:OUT] = 0.5
    own = touch.played.at(frictions)
    # a frame that no play pressed has no springs, whatever is asked of it
    missed = touch.between.missed(frictions, STILL, NOWHERE, own, np.full(FRAMES, 3e-6))
    assert np.abs(missed[:OUT]).max() > 1e-8
    assert not missed[OUT].any()
    assert missed[OUT + 1 :] == pytest.approx(0.0, abs=1e-14)
    # nor has one that is pressed no more
    gone = touch.between.missed(frictions, STILL, NOWHERE, own, np.where(np.arange(FRAMES) < 5, 0.0, load))
    assert not gone[:5].any()


def test_what_is_missed_is_in_proportion_to_the_load():
    """A contact whose material gives twice the force misses twice as much."""
    touch = Touch()
    frictions = np.full(FRAMES, 1.2)
    own = touch.played.at(frictions)
    once, twice = (touch.between.missed(frictions, STILL, NOWHERE, own, factor * LOAD) for factor in (1.0, 2.0))
    assert np.abs(once).max() > 1e-7
    assert twice == pytest.approx(2.0 * once)


@few(40)
@given(st.lists(st.floats(0.05, 1.3), min_size=FRAMES, max_size=FRAMES), st.integers(0, FRAMES - 1))
def test_it_depends_continuously_on_friction(frictions, row):
    """A friction that differs by 1e-7 in one frame changes no shear by more than 1e-4 of the load."""
    nudged = np.array(frictions)
    nudged[row] += 1e-7
    touch = Touch()
    assert np.abs(touch.told(nudged) - touch.told(np.array(frictions))).max() < 1e-4 * LOAD.max()


def test_columns_are_given_back():
    """Cubics over friction give back the plays, and beyond the outer frictions those of the outermost."""
    touch = Touch()
    for friction in NODES:
        frictions = np.full(FRAMES, friction)
        assert np.allclose(touch.played.at(frictions), touch.true(frictions))
    assert np.array_equal(touch.played.at(np.full(FRAMES, 0.1)), touch.played.at(np.full(FRAMES, 0.4)))


def test_a_spring_in_series_shares_the_way():
    """A sticking contact of stiffness k N/m on a stem of c m/N pulls as one spring of stiffness k / (1 + c k)."""
    path = np.column_stack([np.linspace(0.0, 1e-4, FRAMES), np.zeros(FRAMES)])
    touch = Touch(Sliders(), path, pressed(np.full(FRAMES, 1e-3)))
    stiffness = touch.contact.at(STILL)[0][0]
    yielding = 0.5 / stiffness
    force = -stiffness * path / (1 + yielding * stiffness)
    assert touch.told(np.full(FRAMES, 0.6), yielding * force) == pytest.approx(force, rel=1e-9, abs=1e-12)


def test_a_shift_that_stays_changes_nothing():
    """A constant shift changes no shear."""
    touch = Touch()
    frictions = np.full(FRAMES, 0.7)
    assert touch.told(frictions, np.full((FRAMES, 2), 3e-4)) == pytest.approx(touch.told(frictions), abs=1e-15)
