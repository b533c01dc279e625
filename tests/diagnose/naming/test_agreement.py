"""Whether trajectories agree on a change: planted shares."""

import numpy as np
import pytest

from tactiledata.diagnose.naming.agreement import agreement
from tactiledata.diagnose.naming.metric import RandomEffects

TRAJECTORIES, FRAMES = 20, 6


def plain_metric():
    """Noise alone: nothing is refitted."""
    count = TRAJECTORIES * FRAMES
    starts = np.arange(TRAJECTORIES) * FRAMES
    return RandomEffects(np.zeros((count, 6)), np.zeros((count, 6, 0)), np.zeros(0), starts)


def change_of(chance):
    """Trajectories that can tell very different amounts."""
    size = np.repeat(chance.lognormal(0.0, 1.0, TRAJECTORIES), FRAMES)[:, None]
    return size * chance.normal(size=(TRAJECTORIES * FRAMES, 6))


@pytest.mark.parametrize("share", [0.0, 0.4, 1.0])
def test_a_planted_share_is_found_within_its_error(share):
    """200 worlds: the mean is the share, and the scatter over worlds is the stated error."""
    found = []
    for seed in range(200):
        chance = np.random.default_rng(seed)
        change = change_of(chance)
        found.append(agreement(plain_metric(), change, share * change + chance.normal(size=change.shape)))
    z = np.array([(one.share - share) / one.error for one in found])
    assert abs(z.mean()) < 4 / np.sqrt(200)
    assert z.std() == pytest.approx(1.0, abs=0.25)


def test_the_unit_of_a_change_does_not_matter():
    """Twice the change is there by half, as certainly; one that is nothing says nothing."""
    chance = np.random.default_rng(5)
    change, metric = change_of(chance), plain_metric()
    residual = change + chance.normal(size=change.shape)
    once, twice = agreement(metric, change, residual), agreement(metric, 2.0 * change, residual)
    assert twice.share == pytest.approx(once.share / 2)
    assert twice.standard_errors == pytest.approx(once.standard_errors)
    assert agreement(metric, 0.0 * change, residual).standard_errors == 0.0


def test_how_much_touches_tell_is_no_disagreement():
    """Trajectories that tell different amounts make gains scatter; what they agree on is as certain as before."""
    chance = np.random.default_rng(6)
    change, metric = change_of(chance), plain_metric()
    residual = change + 0.1 * chance.normal(size=change.shape)
    gains = 0.5 * (residual**2 - (residual - change) ** 2).sum(axis=1).reshape(TRAJECTORIES, FRAMES).sum(axis=1)
    of_gains = gains.sum() / (np.sqrt(TRAJECTORIES) * gains.std(ddof=1))
    assert agreement(metric, change, residual).standard_errors > 5 * of_gains
