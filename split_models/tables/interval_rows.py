"""Rows of the force table for intervals: how often they hold the truth, and how wide they are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from split_models.tables.force_intervals import LEVEL, CalibratedEnsemble, floor_of, least_trajectories

AXES = ("fx", "fy", "fz")


def interval_rows(
    part: str,
    heads: Mapping[str, Sequence[Any]],
    forces: Mapping[str, Any],
    true: NDArray[np.floating],
    trajectories: Any,
    calibration: tuple[Mapping[str, Any], Any, Any],
) -> list[dict[str, Any]]:
    """A row for each input with two or more heads; no rows where too few trajectories can be calibrated on.

    Parameters
    ----------
    part : str
        Part of the split, for the title.
    heads : dict
        Networks by input.
    forces : dict of (h, n, 3) N
        Forces of the part's frames from each network, by input.
    true : (n, 3) N
        Measured forces.
    trajectories : (n,) str
        Trajectory of each frame.
    calibration : (forces, true, trajectories)
        The same three of frames that no network learned from.
    """
    known, known_true, known_trajectories = calibration
    if len(set(known_trajectories)) < least_trajectories(LEVEL):
        return []
    rows = []
    for name, networks in heads.items():
        if len(networks) < 2:
            continue
        ensemble = CalibratedEnsemble.fitted(known[name], known_true, known_trajectories, floor_of(networks))
        _, intervals = ensemble.intervals(forces[name])
        is_held = (intervals[..., 0] <= true) & (true <= intervals[..., 1])
        held, width = _of_trajectories(is_held, trajectories), np.diff(intervals, axis=-1)[..., 0].mean(axis=0)
        counts = {"frames": len(true), "trajectories": len(set(trajectories))}
        scores = {
            f"{axis} held": {"value": float(share), "unit": "", "better": "higher", **counts}
            for axis, share in zip(AXES, held, strict=True)
        }
        scores |= {
            f"width of {axis}": {"value": float(mean_width), "unit": "N", "better": "lower", **counts}
            for axis, mean_width in zip(AXES, width, strict=True)
        }
        rows.append({"part": f"{part}, intervals of {LEVEL:.0%}", "method": name, "scores": scores})
    return rows


def _of_trajectories(is_held: NDArray[np.bool_], trajectories: Any) -> NDArray[np.float64]:
    """Share (3,) of frames whose intervals hold the truth; every trajectory has the same weight."""
    names = np.asarray(trajectories, dtype=str)
    return np.mean([is_held[names == name].mean(axis=0) for name in np.unique(names)], axis=0)
