"""What the residual of the vector loss consists of, row by row."""

import numpy as np
import pytest
from closed_form import NOISE, TRUTH, ClosedFormWorld

from tactiledata.calibrate.losses import VectorLoss


@pytest.mark.parametrize(("prior", "shape_error"), [(4e-5, 0.02), (4e-5, 0.0), (0.0, 0.02), (0.0, 0.0)])
def test_offsets_and_factors_stand_over_their_priors(prior, shape_error):
    """After six rows a frame come offsets over their prior, then each factor's distance from 1 over its own."""
    world = ClosedFormWorld(count=6)
    shapes = np.array([0, 1, 0, 1, 0, 1])
    measured = world.measured(offsets=3e-5) * np.repeat(np.where(shapes == 0, 1.03, 0.98), 14)[:, None]
    loss = VectorLoss(world.response(), measured, NOISE, np.full(6, 40.0), prior, shapes, shape_error)
    rest = loss.residual(TRUTH)[measured.size :]
    offsets, factors = loss.offsets(TRUTH), loss.factors(TRUTH)
    assert len(rest) == 6 + (2 if shape_error else 0)
    np.testing.assert_allclose(rest[:6], offsets / prior if prior else np.zeros(6))
    np.testing.assert_allclose(rest[6:], (factors - 1) / shape_error if shape_error else [])
    assert prior == 0 or np.abs(rest[:6]).max() > 0.1
    assert shape_error == 0 or np.abs(factors - 1).min() > 0.001
    assert len(loss.owner()) == measured.size + len(rest)


def test_a_row_is_what_was_measured_less_the_factor_times_what_was_simulated():
    """Indenters that press 20 % too strongly and 15 % too weakly leave noise alone once their factors are fitted."""
    world = ClosedFormWorld(count=6)
    shapes = np.array([0, 1, 0, 1, 0, 1])
    measured = world.measured() * np.repeat(np.where(shapes == 0, 1.2, 0.85), 14)[:, None]
    with_factors = VectorLoss(world.response(), measured, NOISE, np.full(6, 40.0), 0.0, shapes, 0.3)
    without = VectorLoss(world.response(), measured, NOISE, np.full(6, 40.0), 0.0, shapes, 0.0)
    np.testing.assert_allclose(with_factors.factors(TRUTH), [1.2, 0.85], atol=0.02)
    rows = measured.size
    assert np.mean(np.square(with_factors.residual(TRUTH)[:rows])) < 1.3
    assert np.mean(np.square(without.residual(TRUTH)[:rows])) > 2.0


def test_each_row_of_the_residual_belongs_to_a_trajectory():
    """A frame has six rows, a trajectory one for its offset, and each factor one of its indenter's first trajectory."""
    world = ClosedFormWorld(count=4)
    shapes = np.array([0, 1, 0, 1])
    loss = VectorLoss(world.response(), world.measured(), NOISE, np.full(4, 40.0), 4e-5, shapes, 0.02)
    frames = np.repeat(np.arange(4), 14 * 6)
    np.testing.assert_array_equal(loss.owner(), [*frames, 0, 1, 2, 3, 0, 1])
    plain = VectorLoss(world.response(), world.measured(), NOISE, np.full(4, 40.0), 4e-5, shapes, 0.0)
    np.testing.assert_array_equal(plain.owner(), [*frames, 0, 1, 2, 3])
