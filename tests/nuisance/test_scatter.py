"""What a simulation scatters from frame to frame."""

import numpy as np

from tactiledata.nuisance.numerical import scatter_covariance


def test_scatter_is_that_of_forces_at_their_places():
    """The covariance is that of drawn forces, of the torques of their places, and of a centre that moves."""
    chance = np.random.default_rng(3)
    deviations, places = np.array([[0.2, 0.2, 0.05]]), np.array([[0.002, -0.003, -0.001]])
    found = scatter_covariance(deviations, np.array([3e-4]), places)[0]
    drawn = deviations * chance.normal(size=(200_000, 3))
    torques = np.cross(places, drawn) + 3e-4 * chance.normal(size=drawn.shape)
    sample = np.cov(np.hstack([drawn, torques]).T)
    size = np.sqrt(np.diag(found))
    assert np.abs((sample - found) / np.outer(size, size)).max() < 0.02
