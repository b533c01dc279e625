"""Black box and surface: they explain what is there on trajectories that they have not seen, and no noise."""

import numpy as np
import pytest
from planted import planted

from tactiledata.diagnose.formula.surface import LABEL, empirical
from tactiledata.diagnose.residuals.ceiling import black_box
from tactiledata.diagnose.residuals.projection import project


def bump(world):
    """A shape that no short formula has."""
    depth, speed = world.covariates["depth"].values, np.log10(world.covariates["speed"].values)
    values = np.zeros_like(world.values)
    values[:, 0] = 6.0 * np.exp(-0.5 * (((depth - 0.6) / 0.2) ** 2 + (speed / 0.4) ** 2))
    return values


@pytest.mark.slow
def test_the_ceiling_is_high_where_structure_is():
    """Trees explain a third of the squares or more, and nothing of noise."""
    with_bump = black_box(project(planted(1, 60, plant=bump)))
    assert with_bump.explained > 0.2
    assert black_box(project(planted(1, 60))).explained < 0.05


@pytest.mark.slow
def test_the_ceiling_is_deterministic():
    """The same seed gives the same trees."""
    projection = project(planted(2, 16, 8))
    np.testing.assert_array_equal(black_box(projection, 1).predicted, black_box(projection, 1).predicted)


@pytest.mark.slow
def test_the_surface_is_labelled_and_does_not_extrapolate():
    """It takes a part of the squares, says that it explains nothing, and is NaN outside what was seen."""
    world = planted(1, 60, plant=bump)
    found = empirical(project(world), ("depth", "speed"))
    assert found is not None
    assert found.explained > 0.1
    assert LABEL in found.words
    low, high = found.low, found.high
    predicted = found.predict(np.array([(low + high) / 2, high * 1.01, low - 0.01]))
    assert np.isfinite(predicted[0]).all()
    assert np.isnan(predicted[1:]).all()


@pytest.mark.slow
def test_the_surface_of_noise_is_flat():
    """Nothing is taken from trajectories that were held out."""
    found = empirical(project(planted(3, 60, random_effects=False)), ("depth", "speed"))
    assert found is not None
    assert found.explained < 0.03
