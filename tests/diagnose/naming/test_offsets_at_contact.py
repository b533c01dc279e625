"""A joint fit whose contact offsets decide whether a touch touches at all."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest
from tied_worlds import START, recorded

from tactiledata.diagnose.naming import joint_fit as module
from tactiledata.diagnose.naming.joint_fit import STILL, joint_fit
from tactiledata.diagnose.naming.linearise import Linearised
from tactiledata.diagnose.naming.parameters import joint_model
from tactiledata.diagnose.touches.touch_case import TouchSet
from tactiledata.diagnose.touches.whitened import WhitenedTouches
from tactiledata.nuisance.offsets import PRIOR

OFFSETS = 1e-4 * np.array([1.0, -1.0, 1.0, 0.8, -0.8, 1.0, -1.0, 0.9, -0.9, 0.7])
"""How much deeper than recorded each touch is, m: some begin in a frame that the record has above the gel."""
MOVED = 2.0
"""Factor on the recorded depths: from shallow touches, a first contact is a large part."""


@pytest.fixture(scope="module")
def shifted():
    """Whitened touches that are deeper or less deep than recorded, and fit(offsets) from offsets of the start."""
    plain = recorded(slide=1e-3)
    for case in plain.touches:
        case.touch.poses[:, 2, 3] /= MOVED
    wrench = plain.play(START, [], OFFSETS)
    rows = np.split(wrench, np.cumsum(plain.counts)[:-1])
    noise = np.random.default_rng(1).normal(size=wrench.shape)
    drawn = np.split(noise, np.cumsum(plain.counts)[:-1])
    cases = [
        dataclasses.replace(case, measured=part + 0.1 * one * case.noise.deviations)
        for case, part, one in zip(plain.touches, rows, drawn, strict=True)
    ]
    white = WhitenedTouches.of(TouchSet(cases, plain.base))

    def fit(offsets):
        model = joint_model(START, [], len(white.starts), len(white.simulation_errors))
        return joint_fit(white, model.at(model.vector, offsets))

    return white, fit


def test_offsets_cross_first_contact(shifted):
    """In the world of this test some frames touch only as deep as they are, and others only as recorded."""
    white, _ = shifted
    recorded_load, load = (white.touch_set.play(START, [], offsets)[:, 2] for offsets in (0 * OFFSETS, OFFSETS))
    assert ((recorded_load == 0) & (load > 0)).sum() >= 5
    assert ((recorded_load > 0) & (load == 0)).sum() >= 5


def test_a_fit_from_no_offsets_ends_no_worse_than_one_from_the_truth(shifted):
    """Its cost is higher by no more than the fall at which a fit ends, and its offsets are those of the world.

    Within half a standard deviation of their prior, which draws them towards 0.
    """
    _, fit = shifted
    found, best = fit(0 * OFFSETS), fit(OFFSETS)
    assert found.cost <= best.cost + 2 * STILL
    # what all offsets have in common may be material instead
    apart = (found.model.offsets - found.model.offsets.mean()) - (OFFSETS - OFFSETS.mean())
    assert np.abs(apart).max() < 0.5 * PRIOR


def test_no_step_raises_the_cost(shifted, monkeypatch):
    """Every model about which a fit linearises costs no more than the one before, whatever the offsets did."""
    costs, slopes = [], Linearised.slopes
    monkeypatch.setattr(
        Linearised, "slopes", lambda self, model, state: costs.append(state.cost) or slopes(self, model, state)
    )
    _, fit = shifted
    fit(-OFFSETS)
    assert len(costs) > 2
    assert (np.diff(costs) <= 0).all()


def test_the_costs_of_trajectories_are_their_part_of_the_whole(shifted):
    """The costs that decide which offset moves less add up, with the priors of shared numbers, to the whole cost."""
    white, fit = shifted
    found = fit(OFFSETS)
    work = Linearised(white, frozenset())
    state = work.evaluate(found.model)
    shared = work.precision(found.model) @ (found.model.vector - work.centre(found.model)) ** 2
    assert work.costs(found.model, state.residual).sum() + shared == pytest.approx(state.cost)
    np.testing.assert_allclose(work.costs(found.model, state.residual), found.cost_by_trajectory)


@dataclasses.dataclass(frozen=True)
class Offsets:
    """A model of nothing but offsets."""

    offsets: np.ndarray
    vector: np.ndarray = dataclasses.field(default_factory=lambda: np.zeros(0))

    def at(self, vector, offsets):
        """The model with other numbers."""
        return Offsets(offsets, vector)


class Parabolas:
    """Trajectories whose costs are squares of the distance to 1, and steps that do not see how steep they are."""

    def __init__(self, ahead):
        self.ahead, self.dampings = np.asarray(ahead, dtype=float), []

    def costs(self, model, residual):
        return (model.offsets - 1.0) ** 2

    def evaluate_or_none(self, model):
        costs = self.costs(model, None)
        return SimpleNamespace(cost=float(costs.sum()), residual=model.offsets)

    def step(self, model, state, slopes, damping):
        self.dampings.append(damping)
        return Offsets(self.ahead / (1.0 + damping)), 1.0


def test_an_offset_that_made_its_trajectory_worse_is_halved_and_the_others_keep_their_step():
    """It goes back halfway until the cost has fallen; the damping of the whole step does not rise."""
    work, start = Parabolas([10.0, 1.0, 0.5]), Offsets(np.zeros(3))
    state = work.evaluate_or_none(start)
    model, after, damping = module._better(work, start, state, None, 1e-9)
    assert model.offsets == pytest.approx([2.5, 1.0, 0.5])
    assert after.cost < state.cost
    assert work.dampings == [1e-9]
    assert damping <= 1e-6


def test_a_step_that_halving_does_not_save_is_shortened():
    """A part of the step is taken before the damping rises."""
    far, start = Parabolas([100.0, 1.0, 0.5]), Offsets(np.zeros(3))
    state = far.evaluate_or_none(start)
    model, after, damping = module._better(far, start, state, None, 1e-3)
    assert far.dampings == [damping] == [1e-3]
    assert after.cost <= state.cost
    assert model.offsets[0] < 3.0


def test_a_step_of_which_no_part_helps_is_damped():
    """Offsets that go far too far come back by damping; where no step helps, the fit ends."""
    far, start = Parabolas([3000.0, 1.0, 0.5]), Offsets(np.zeros(3))
    state = far.evaluate_or_none(start)
    _, after, _ = module._better(far, start, state, None, 1e-3)
    assert len(far.dampings) > 1
    assert after.cost <= state.cost
    assert module._better(Parabolas([-3.0, -3.0, -3.0]), start, state, None, 1e-3) is None
