"""What the residual of the vector loss consists of, row by row."""

import numpy as np
import pytest
from closed_form import NOISE, TRUTH, ClosedFormWorld

from tactiledata.calibrate.losses import VectorLoss


@pytest.mark.parametrize(("prior", "shape_error"), [(4e-5, 0.02), (4e-5, 0.0), (0.0, 0.02), (0.0, 0.0)])
def test_offsets_and_factors_stand_over_their_priors(prior, shape_error):
    """Behind six rows a frame: offsets over their prior, then each factor's distance from 1 over its own, if any."""
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
