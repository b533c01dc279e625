"""Intervals with the simulation's own errors: wider by what such errors move, and by nothing where there are none."""

import numpy as np
import pytest
from closed_form import NOISE, TRUTH, ClosedFormWorld

from tactiledata.calibrate.bounds import find_bounds
from tactiledata.calibrate.intervals import profile_intervals
from tactiledata.calibrate.least_squares import polish
from tactiledata.calibrate.losses import NormLoss, VectorLoss
from tactiledata.calibrate.search import search
from tactiledata.calibrate.simulation_error import simulation_error
from tactiledata.nuisance import numerical

WIDE = find_bounds("wide")


def fitted(measured):
    """Loss, optimum and statistical ends."""
    world = ClosedFormWorld()
    loss = VectorLoss(world.response("wide"), measured, NOISE, np.full(world.count, 40.0))
    found = WIDE.scaled(polish(loss, WIDE, WIDE.shares(TRUTH)).shares)
    return loss, found, profile_intervals(loss, WIDE, found).ends


@pytest.fixture(scope="module")
def known():
    return fitted(ClosedFormWorld().measured())


@pytest.mark.slow
def test_they_hold_a_truth_whose_force_law_is_off(known):
    """Measured by another law of the force, 1.5 deviations away: the plain interval loses what the wider one holds."""
    loss, found, ends = fitted(numerical.with_law_error(ClosedFormWorld().measured(), 0.09))
    wide = simulation_error(loss, WIDE, found, ends, "finite-strain").ends
    assert (wide[:, 0] <= ends[:, 0]).all()
    assert (wide[:, 1] >= ends[:, 1]).all()
    assert ((wide[:, 0] <= TRUTH) & (wide[:, 1] >= TRUTH)).all()
    assert not ((ends[:, 0] <= TRUTH) & (ends[:, 1] >= TRUTH)).all()


@pytest.mark.slow
def test_they_reach_where_an_error_of_that_size_leads(known):
    """Each optimum of measurements bent within the 95 % is inside."""
    loss, found, ends = known
    told = simulation_error(loss, WIDE, found, ends, "finite-strain")
    for sign in (-1.9, 1.9):
        _, moved, _ = fitted(numerical.with_law_error(loss.measured, sign * told.law))
        assert ((told.ends[:, 0] <= moved) & (told.ends[:, 1] >= moved)).all()
    assert told.ends[0, 1] - found[0] >= 1.96 * told.force * found[0]


def test_an_exact_simulation_widens_nothing(known, monkeypatch):
    """An exact simulation leaves the intervals as they are."""
    loss, found, ends = known
    monkeypatch.setitem(numerical.FORCE_ERROR, "finite-strain", 0.0)
    monkeypatch.setitem(numerical.LAW_ERROR, "finite-strain", 0.0)
    assert simulation_error(loss, WIDE, found, ends, "finite-strain").ends == pytest.approx(ends, rel=1e-5)


def test_the_norm_loss_has_them_too():
    """Errors of the simulation widen intervals by the norm loss, too, that of E by their share of force."""
    world = ClosedFormWorld()
    loss = NormLoss(world.response("wide"), world.measured())
    found = search(loss, WIDE, TRUTH)
    ends = np.stack([found, found], axis=1)
    told = simulation_error(loss, WIDE, found, ends, "finite-strain")
    assert told.ends[0, 1] - found[0] >= 1.96 * told.force * found[0]
    assert (told.ends[:, 1] > found).sum() >= 2
