"""A network reads planted touches, and nothing where there is nothing to read."""

import numpy as np
import pytest

from split_models.tables import touch_head
from split_models.tables.touch_head import SIZE, explained, learned_head, small_pictures
from tactiledata.errors import UsageError


def spots(count, seed):
    """Pictures (count, 80, 60, 3) of a spot; its place, px of a small picture, and its strength, grey levels."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:80, :60]
    values = np.stack([rng.uniform(20, 40, count), rng.uniform(25, 55, count), rng.uniform(20, 120, count)], axis=1)
    gap = (x - values[:, 0, None, None]) ** 2 + (y - values[:, 1, None, None]) ** 2
    pictures = 80 + values[:, 2, None, None, None] * np.exp(-gap / 60)[..., None] * (1.0, 0.6, 0.2)
    return np.clip(pictures + rng.normal(0, 1, pictures.shape), 0, 255).astype(np.uint8), values


@pytest.fixture
def quick(monkeypatch):
    """A training of two epochs."""
    monkeypatch.setattr(touch_head, "EPOCHS", 2)


@pytest.mark.slow
def test_planted_touches_are_read():
    """Place and strength of unseen spots are read; with values of other pictures nothing is (negative control)."""
    pictures, values = spots(192, seed=1)
    unseen, true = spots(48, seed=2)
    small = small_pictures(pictures)
    assert small.shape[1:] == (*SIZE, 3)
    read = learned_head(small, values).read(small_pictures(unseen))
    assert all(explained(read[:, column], true[:, column]) > 0.8 for column in range(3))
    mixed = learned_head(small, np.random.default_rng(0).permutation(values)).read(small_pictures(unseen))
    assert all(explained(mixed[:, column], true[:, column]) < 0.3 for column in range(3))


def test_the_same_seed_reads_the_same(quick):
    """Learning is repeated to the bit, and another seed is another network."""
    pictures, values = spots(40, seed=3)
    small = small_pictures(pictures)
    one, same, other = (learned_head(small, values, seed).read(small) for seed in (0, 0, 1))
    np.testing.assert_array_equal(one, same)
    assert np.abs(one - other).max() > 0


def test_explained_has_its_marks():
    """1 for the truth, 0 for its mean, below 0 for what is worse, and no number where nothing varies."""
    true = np.array([1.0, 2.0, 4.0])
    assert explained(true, true) == 1.0
    assert explained(np.full(3, true.mean()), true) == pytest.approx(0.0)
    assert explained(-true, true) < 0
    assert np.isnan(explained(true, np.ones(3)))


def test_too_few_pictures_are_refused():
    """Fewer than a batch, or other numbers of values than pictures."""
    small = np.zeros((31, *SIZE, 3), np.float32)
    with pytest.raises(UsageError, match="31 pictures"):
        learned_head(small, np.zeros((31, 6)))
    with pytest.raises(UsageError, match="with 40 rows"):
        learned_head(np.zeros((64, *SIZE, 3), np.float32), np.zeros((40, 6)))
