"""Springs that are fitted to a contact: planted ones are found again, and standing moments change nothing."""

import numpy as np
import pytest

from tactiledata.rig.hidden.own_springs import OwnSprings, Pulled, own_springs
from tactiledata.rig.hidden.slider import Loaded

MOMENTS = np.arange(600)
WAY = np.interp(MOMENTS, [0, 50, 250, 350, 550], [0.0, 0.0, 8e-4, 8e-4, 2e-4])
PATH = np.column_stack([0.6 * WAY, -0.8 * WAY, np.interp(MOMENTS, [0, 50], [0.0, 7e-4])])
NORMAL = np.interp(MOMENTS, [0, 50], [0.0, 3.0])
STIFFNESS = np.interp(MOMENTS, [0, 50], [0.0, 5e3])
LOADED = Loaded(NORMAL, STIFFNESS)


@pytest.mark.parametrize(("factor", "spread"), [(0.9, 0.4), (1.15, 0.7), (1.2, 0.3), (1.3, 0.4), (1.0, 0.0)])
def test_planted_ones_are_found(factor, spread):
    """Stiffness and spread of planted springs are found within 0.05; without pull, the usual springs are returned."""
    pull = OwnSprings(factor, spread).pull(PATH[:, :2], LOADED, 0.6)
    assert own_springs(PATH, STIFFNESS, [Pulled(0.6, NORMAL, pull)]) == pytest.approx((factor, spread), abs=0.05)
    assert own_springs(PATH, STIFFNESS, [Pulled(0.6, NORMAL, 0.0 * pull)]) == OwnSprings()


def test_moments_at_rest_are_passed_over():
    """Every moment told three times pulls as once."""
    springs = OwnSprings(0.9, 0.5)
    once = springs.pull(PATH[:, :2], LOADED, 0.6)
    path, normal, stiffness = (np.repeat(one, 3, axis=0) for one in (PATH[:, :2], NORMAL, STIFFNESS))
    thrice = springs.pull(path, Loaded(normal, stiffness), 0.6)
    np.testing.assert_allclose(thrice[::3], once, rtol=1e-12)
