"""Whether trajectories agree on a change: planted shares."""

import numpy as np
import pytest

from tactiledata.diagnose.naming.agreement import agreement, strength_trend
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


def trend_of(seed, growth, by_indenter=0.0):
    """The trend found where a strength grows linearly by so much to the end of a session, and differs by indenter."""
    chance = np.random.default_rng(seed)
    change = change_of(chance)
    seconds = np.sort(chance.uniform(100.0, 2000.0, TRAJECTORIES))
    time = (2 * seconds - seconds[0] - seconds[-1]) / (seconds[-1] - seconds[0])
    indenter = np.arange(TRAJECTORIES) * 4 // TRAJECTORIES
    share = np.repeat(growth * time + by_indenter * indenter, FRAMES)[:, None]
    noisy = share * change + chance.normal(size=change.shape)
    return strength_trend(plain_metric(), change, noisy, seconds, indenter)


@pytest.mark.slow
@pytest.mark.parametrize("growth", [0.0, 0.3, -0.5])
def test_a_planted_trend_is_found_within_its_error(growth):
    """200 worlds in which indenters follow one another: what differs by indenter is no trend."""
    found = [trend_of(seed, growth, by_indenter) for seed in range(200) for by_indenter in (0.0, 2.0)]
    z = np.array([(one.share - growth) / one.error for one in found])
    assert abs(z.mean()) < 4 / np.sqrt(200)
    assert 0.7 < z.std() < 1.35


def test_without_time_there_is_no_trend():
    """Trajectories at one time say nothing about it."""
    change, indenter = change_of(np.random.default_rng(3)), np.zeros(TRAJECTORIES, dtype=int)
    assert strength_trend(plain_metric(), change, change, np.full(TRAJECTORIES, 7.0), indenter) is None
