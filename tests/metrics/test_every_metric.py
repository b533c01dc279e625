"""What every metric keeps: best on itself, worse the more is wrong, a value a sample, no value without pixels."""

import numpy as np
import pytest

from tactiledata.errors import UsageError
from tactiledata.metrics import METRICS

PAIRS = {"images", "meshes", "forces"}
SCORES = [
    pytest.param(METRICS[name], score, id=f"{name}.{score.name}")
    for name in METRICS
    if METRICS[name].takes in PAIRS
    for score in METRICS[name].scores.values()
]


def samples(takes, rng):
    """Four samples of what a metric takes."""
    if takes == "images":
        return rng.integers(60, 190, (4, 24, 20, 3)).astype(np.uint8)
    return rng.normal(0, 1e-3, (4, 30, 3)) if takes == "meshes" else rng.normal(0, 4, (4, 3))


def corrupted(batch, strength):
    """The batch with the same noise, ever stronger."""
    noise = np.random.default_rng(1).normal(0, 1, batch.shape)
    if batch.dtype == np.uint8:
        return np.clip(batch + 20 * strength * noise, 0, 255).astype(np.uint8)
    return batch * (1 + 0.3 * strength * np.abs(noise))


@pytest.mark.parametrize(("member", "score"), SCORES)
def test_best_on_itself_and_worse_with_every_step(member, score):
    """A sample against itself has the best value; growing noise gives ever worse ones, for every sample."""
    batch = samples(member.takes, np.random.default_rng(0))
    assert score(batch, batch) == pytest.approx(score.best)
    values = np.array([score(corrupted(batch, strength), batch) for strength in (0, 0.2, 0.6, 1.5)])
    assert values.shape == (4, 4)
    steps = np.diff(values, axis=0)
    assert (steps < 0).all() if score.better == "higher" else (steps > 0).all()


@pytest.mark.parametrize(("member", "score"), SCORES)
def test_a_sample_is_judged_alone(member, score):
    """A value does not depend on the other samples of the batch."""
    batch = samples(member.takes, np.random.default_rng(2))
    other = corrupted(batch, 0.5)
    one_by_one = np.concatenate([score(other[row : row + 1], batch[row : row + 1]) for row in range(4)])
    np.testing.assert_allclose(score(other, batch), one_by_one)


@pytest.mark.parametrize(("member", "score"), SCORES)
def test_what_does_not_go_together_is_refused(member, score):
    """Batches of other shapes, and NaN where there may be one, are refused in words."""
    batch = samples(member.takes, np.random.default_rng(3))
    with pytest.raises(UsageError):
        score(batch[:3], batch)
    if batch.dtype != np.uint8:
        batch = batch.copy()
        batch[2, 0] = np.nan
        with pytest.raises(UsageError, match="sample 2"):
            score(batch, batch)
