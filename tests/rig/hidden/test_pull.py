"""Pull along the gel with hidden effects: what a solver knows is the solver's, against a closed form and the layer."""

import numpy as np
import pytest
from hidden_worlds import PRESS, contact_of, stated, touch

from tactiledata.rig.hidden.own_springs import OwnSprings
from tactiledata.rig.hidden.pull import LESS, MORE, SolvedPull
from tactiledata.rig.hidden.slider import Loaded, SlidingLaws, relative_limits

MOMENTS = np.arange(500)
WAY = np.interp(MOMENTS, [0, 100, 500], [0.0, 0.0, 1.2e-3])
DEPTH = np.interp(MOMENTS, [0, 100], [0.0, 7e-4])
PATH = np.column_stack([0.6 * WAY, -0.8 * WAY, DEPTH])
NORMAL, STIFFNESS = 4000.0 * DEPTH, 6e6 * DEPTH
AREAS = np.full(len(MOMENTS), 1e-5)
FRICTION = 0.6
AHEAD = {"shear": {"by": [0.0009, 0.0], "settle": 0.1}}
BACK = {"shear": {"by": [-0.0007, 0.0], "settle": 0.1}}


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


def yielding(friction, share=1.0, normal=NORMAL):
    """The pull (n, 2) of a contact that yields from the first on: mu N tanh(k s / mu N), for a straight way of s."""
    limit = np.maximum(friction * normal, 1e-12)
    return (limit * np.tanh(share * STIFFNESS * WAY / limit))[:, None] * [0.6, -0.8]


def solver(pull=yielding):
    return lambda friction: np.column_stack([-pull(friction), NORMAL, np.zeros((len(NORMAL), 3))])


def changed(solve, normal=1.0, stiffness=1.0, friction=None, **laws):
    """The pull (n, 2) of a solver's contact whose normal force, stiffness and friction change by one factor each."""
    solved = SolvedPull(PATH, STIFFNESS, FRICTION, solve)
    factors = [] if friction is None else [lambda slide: friction]
    before, after = Loaded(NORMAL, STIFFNESS), Loaded(normal * NORMAL, stiffness * STIFFNESS)
    own = -solve(FRICTION)[:, :2]
    return solved.changed(PATH[:, :2], AREAS, own, before, after, SlidingLaws(factors, **laws))[0]


def test_no_effect_changes_nothing():
    """Without effects the pull is the solver's own, to the last digits, though no slider pulls so."""
    np.testing.assert_allclose(changed(solver()), yielding(FRICTION), atol=1e-12)


def test_a_softer_gel_pulls_less_by_its_factor():
    """The pull is 0.7 times the solver's, in N, on a gel whose normal force and stiffness are 0.7 times as large."""
    np.testing.assert_allclose(changed(solver(), 0.7, 0.7), 0.7 * yielding(FRICTION), atol=1e-9)


@pytest.mark.parametrize("factor", [LESS, MORE])
def test_a_friction_that_was_solved_is_the_solvers(factor):
    """The pull at 0.6 and 1.6 times the friction, for which the solver is asked, is the solver's within 2 mN."""
    np.testing.assert_allclose(changed(solver(), friction=factor), yielding(factor * FRICTION), atol=2e-3)


@pytest.mark.parametrize(("effects", "expected"), [
    ({"friction": 0.8}, yielding(0.8 * FRICTION)),
    ({"friction": 1.25}, yielding(1.25 * FRICTION)),
    ({"stiffness": 0.7}, yielding(FRICTION, 0.7)),
    ({"normal": 0.85}, yielding(FRICTION, 1.0, 0.85 * NORMAL)),
])  # fmt: skip
def test_between_solved_frictions_the_change_is_near_the_closed_form(effects, expected):
    """A change of the pull by more than 0.05 N (root mean square) is met within a sixth of it."""
    plain = yielding(FRICTION)
    assert rms(expected - plain) > 0.05
    assert rms(changed(solver(), **effects) - expected) < rms(expected - plain) / 6


def test_closed_forms_are_sliders():
    """A contact of one slider pulls with effects as one slider does, within a micronewton."""
    spring = OwnSprings()
    solve = solver(lambda friction: spring.pull(PATH[:, :2], Loaded(NORMAL, STIFFNESS), friction))
    expected = spring.pull(PATH[:, :2], Loaded(0.9 * NORMAL, 0.8 * STIFFNESS), 0.75 * FRICTION)
    np.testing.assert_allclose(changed(solve, 0.9, 0.8, 0.75), expected, atol=1e-6)


def test_limits_of_parts_multiply():
    """One reason alone is even; two have the mean 1 and the variance of a product of independent factors."""
    np.testing.assert_allclose(relative_limits(0.6, 0.0)[[0, -1]], [1 - 0.6 * 11 / 12, 1 + 0.6 * 11 / 12])
    both = relative_limits(0.6, 0.9)
    assert len(both) == 12
    assert both.mean() == pytest.approx(1.0)
    # evenly within 1 - w and 1 + w the variance is w² / 3 (1 - 1 / 144)
    first, second = (w**2 / 3 * (1 - 1 / 144) for w in (0.6, 0.9))
    assert both.var() == pytest.approx((1 + first) * (1 + second) - 1, rel=0.05)


def test_limits_that_vary_more_give_way_earlier():
    """A spread of limits takes pull from a contact that yields already, and hardly any where it sticks."""
    pull, plain = changed(solver(), spreads=[0.8]), yielding(FRICTION)
    less = np.linalg.norm(plain, axis=1) - np.linalg.norm(pull, axis=1)
    assert 0.02 < less.max() < 0.2 * np.linalg.norm(plain, axis=1).max()
    assert np.abs(less[:110]).max() < 0.01
    assert less.min() > -0.01


@pytest.mark.slow
@pytest.mark.parametrize(
    ("indenter", "factor", "most"), [("ball", 0.8, 0.33), ("ball", 1.2, 0.33), ("small", 0.8, 0.33)]
)
def test_a_layers_friction_is_the_layers(indenter, factor, most):
    """A friction that is less or more by a fifth changes the pull of the layer as that of a world that states it."""
    changes = {
        "trajectories": [touch(indenter=indenter, steps=[PRESS, AHEAD, BACK], position=(0.0, 0.0), force_limit=40)],
        "contact": "layer",
        "contact_pitch": 0.001,
    }
    plain = contact_of(**changes)[2]
    stated_so = contact_of(material={"friction": 0.8 * factor}, **changes)[2]
    # along x the factor of an anisotropy is the same all the way
    entry = stated("anisotropy", share=abs(1 - factor), angle=0.0 if factor > 1 else np.pi / 2)
    hidden = contact_of([entry], **changes)[2]
    change = (stated_so - plain)[:, :2]
    assert rms(change) > 0.05
    assert rms((hidden - stated_so)[:, :2]) < most * rms(change)


@pytest.mark.slow
def test_a_contact_that_sticks_knows_no_friction():
    """A flat punch that sticks pulls the same at four fifths of its friction."""
    changes = {
        "trajectories": [touch(indenter="punch", steps=[PRESS, AHEAD, BACK], position=(0.0, 0.0), force_limit=40)],
        "contact": "layer",
        "contact_pitch": 0.001,
    }
    plain = contact_of(**changes)[2]
    hidden = contact_of([stated("anisotropy", share=0.2, angle=np.pi / 2)], **changes)[2]
    assert rms(plain[:, 0]) > 1.0
    assert rms((hidden - plain)[:, :2]) < 0.02
