"""Intervals of forces hold the truth as often as they say, on planted worlds whose frames come in touches."""

import numpy as np
import pytest
import torch

from split_models.networks.force_head import ForceHead
from split_models.tables.force_intervals import CalibratedEnsemble, ForceIntervals, group_quantile, least_trajectories
from split_models.tables.interval_rows import interval_rows
from tactiledata.errors import UsageError


def world(rng, touches, frames=20):
    """Two heads' forces of touches that each have an error of their own; some touches are harder than others."""
    difficulty = np.repeat(np.exp(rng.normal(0, 0.7, (touches, 1))), frames, axis=0)
    error = np.repeat(rng.normal(size=(touches, 3)), frames, axis=0) + 0.3 * rng.normal(size=(touches * frames, 3))
    true = rng.normal(size=(touches * frames, 3))
    disagreement = difficulty * rng.normal(size=(2, touches * frames, 3))
    return true + difficulty * error + 0.3 * disagreement, true, np.repeat(np.arange(touches), frames)


def test_new_touches_are_held_as_promised():
    """90 % over many worlds of 30 touches; frames taken as if each were a touch promise too much."""
    rng = np.random.default_rng(0)
    held, naive = [], []
    for _ in range(150):
        found, true, names = world(rng, 30)
        new, new_true, _ = world(rng, 20)
        for kept, groups in ((held, names), (naive, np.arange(len(true)))):
            ensemble = CalibratedEnsemble.fitted(found, true, groups, 0.05 * np.ones(3))
            _, intervals = ensemble.intervals(new)
            kept.append(((intervals[..., 0] <= new_true) & (new_true <= intervals[..., 1])).mean())
    assert 0.9 <= np.mean(held) < 0.95
    assert np.mean(naive) < np.mean(held) - 0.01


def test_the_quantile_gives_every_trajectory_the_same_weight():
    """A closed form: nine touches of one frame and one of a thousand; the next one has the weight of one touch."""
    scores = np.concatenate([np.arange(1.0, 10.0), np.full(1000, 0.5)])
    groups = np.concatenate([np.arange(9), np.full(1000, 9)])
    assert group_quantile(scores, groups, 1 / 11) == 0.5
    assert group_quantile(scores, groups, 5 / 11) == 4.0
    assert group_quantile(scores, groups, 10 / 11) == 9.0
    assert group_quantile(scores, groups, 0.95) == np.inf
    assert least_trajectories(0.9) == 9
    assert np.isfinite(group_quantile(np.ones(9), np.arange(9), 0.9))
    assert np.isinf(group_quantile(np.ones(8), np.arange(8), 0.9))


def heads(count):
    torch.manual_seed(0)
    return [ForceHead(4, (16,), (), (0.0, 0.0, 5.0), (1.0, 1.0, 3.0)) for _ in range(count)]


def test_heads_give_forces_with_intervals():
    """Wider where heads disagree; the middle is their mean; too few heads or trajectories are said."""
    torch.manual_seed(1)
    given, true = torch.randn(200, 4), np.random.default_rng(0).normal(size=(200, 3))
    names = np.repeat([f"t{number}" for number in range(20)], 10)
    sure = ForceIntervals.fitted(heads(5), given, true, names)
    forces, intervals = sure.predict(torch.cat([given[:1], 30 * given[:1]]))
    assert forces.shape == (2, 3)
    assert intervals.shape == (2, 3, 2)
    assert np.allclose(intervals.mean(axis=-1), forces)
    near, far = np.diff(intervals, axis=-1)[..., 0]
    assert (far > 2 * near).all()
    with pytest.raises(UsageError, match="1 head"):
        ForceIntervals.fitted(heads(1), given, true, names)
    with pytest.raises(UsageError, match="8 trajectories to calibrate intervals of 90%"):
        ForceIntervals.fitted(heads(5), given[:80], true[:80], names[:80])


def test_rows_of_the_table():
    """A row for each input with several heads, coverage and widths; none where the calibration is too small."""
    rng = np.random.default_rng(0)
    (found, true, names), (new, new_true, new_names) = world(rng, 30), world(rng, 40)
    networks = {"mesh": heads(2), "raw_mesh": heads(1)}
    given = {"mesh": new, "raw_mesh": new[:1]}
    calibration = ({"mesh": found, "raw_mesh": found[:1]}, true, names)
    (row,) = interval_rows("test", networks, given, new_true, new_names, calibration)
    assert (row["part"], row["method"]) == ("test, intervals of 90%", "mesh")
    assert list(row["scores"]) == ["fx held", "fy held", "fz held", "width of fx", "width of fy", "width of fz"]
    assert row["scores"]["fx held"]["value"] > 0.75
    few = names < 8
    assert (
        interval_rows("test", networks, given, new_true, new_names, ({"mesh": found[:, few]}, true[few], names[few]))
        == []
    )
