"""HeldOutRefits without some trajectories: one step from the fit to all, as far as it holds."""

import dataclasses

import numpy as np
import pytest
from tied_worlds import START, recorded

from tactiledata.diagnose.naming.held_out import HeldOutRefits, held_out
from tactiledata.diagnose.naming.joint_fit import joint_fit, least_cost, plain_fit
from tactiledata.diagnose.naming.linearise import Linearised
from tactiledata.diagnose.touches.whitened import WhitenedTouches


@pytest.fixture(scope="module")
def world():
    """Touches that lack no effect, and the plain fit to them."""
    white = WhitenedTouches.of(recorded(touches=8, slide=1e-3))
    return white, plain_fit(white, START)


def marked(white, *numbers):
    """Trajectories of these numbers (t,)."""
    return np.isin(np.arange(len(white.starts)), numbers)


def cost_of(white, out, model):
    """Cost of the trajectories not marked in ``out``, their contact offsets fitted, the model's numbers held."""
    others = model.at(model.vector, model.offsets[~out])
    return least_cost(white.part(~out), others, range(len(model.vector)), rounds=8)


@pytest.mark.parametrize("number", [0, 5])
def test_one_step_goes_most_of_the_way_to_a_whole_refit(world, number):
    """Without one trajectory, one step lowers the cost of the others by most of what a whole refit does."""
    white, fit = world
    out = marked(white, number)
    moved, _ = HeldOutRefits.of(white, fit).without(out)
    start = fit.model.at(fit.model.vector, fit.model.offsets[~out])
    least = joint_fit(white.part(~out), start, rounds=30).cost
    before, after = cost_of(white, out, fit.model), cost_of(white, out, moved)
    assert before - after > 0.7 * (before - least) > 0


def test_the_residual_is_that_of_the_moved_numbers(world):
    """The residual that comes with a refit is what its numbers leave when all touches are simulated anew."""
    white, fit = world
    moved, residual = HeldOutRefits.of(white, fit).without(marked(white, 2))
    assert np.allclose(residual, Linearised(white, frozenset()).evaluate(moved).residual)


@pytest.mark.parametrize("times", [3.0, 30.0, 1e4])
def test_a_step_that_goes_too_far_is_halved(world, times):
    """However far the first step goes, the trajectories that are fitted do not get worse by it."""
    white, fit = world
    out = marked(white, 1, 4)
    right = HeldOutRefits.of(white, fit)
    wrong = dataclasses.replace(right, grams=right.grams / times, gradients=right.gradients + 1.0)
    before = cost_of(white, out, fit.model)
    whole = fit.model.at(fit.model.vector + wrong._change_without(out), fit.model.offsets)
    assert cost_of(white, out, whole) > before + 10.0
    assert cost_of(white, out, wrong.without(out)[0]) < before + 1.0


def test_held_out_costs_do_not_run_away(world, monkeypatch):
    """Gradients that are a thousand times too large raise the cost of held-out trajectories by less than a half."""
    white, fit = world
    right = held_out(white, fit)
    refits = HeldOutRefits.of(white, fit)
    wrong = dataclasses.replace(refits, gradients=1e3 * refits.gradients)
    monkeypatch.setattr(HeldOutRefits, "of", staticmethod(lambda *_: wrong))
    found = held_out(white, fit)
    assert found.by_trajectory.sum() < 1.5 * right.by_trajectory.sum()
    assert found.by_indenter.sum() < 1.5 * right.by_indenter.sum()
