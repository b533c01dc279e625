"""Mean, spread, extremes and quantiles of each episode, and of all episodes, as LeRobot normalises by."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

QUANTILES = {"q01": 0.01, "q10": 0.10, "q50": 0.50, "q90": 0.90, "q99": 0.99}
NAMES = ("min", "max", "mean", "std", *QUANTILES)
Statistics = dict[str, Any]
"""Lists of numbers by name, and ``count``, as JSON values."""


def statistics(values: NDArray[Any]) -> Statistics:
    """Return the statistics of rows (n, k); rows with a value that is not finite do not count, zeros where none do."""
    whole = values[np.isfinite(values).all(axis=1)].astype(np.float64)
    count = len(whole)
    if not count:
        return {**{name: [0.0] * values.shape[1] for name in NAMES}, "count": [0]}
    found = {"min": whole.min(axis=0), "max": whole.max(axis=0), "mean": whole.mean(axis=0), "std": whole.std(axis=0)}
    found.update(zip(QUANTILES, np.quantile(whole, list(QUANTILES.values()), axis=0), strict=True))
    return {**{name: found[name].tolist() for name in NAMES}, "count": [count]}


def picture_statistics(pictures: NDArray[np.uint8]) -> Statistics:
    """Return the statistics of pictures (n, H, W, 3) by channel, on the scale 0 to 1; each value is in two brackets.

    Quantiles are read off the counts of the 256 grey levels.
    """
    levels = np.stack([np.bincount(pictures[..., channel].reshape(-1), minlength=256) for channel in range(3)])
    scale = np.arange(256) / 255
    total = levels.sum(axis=1)
    mean = levels @ scale / total
    occurs = levels > 0
    found = {
        "min": scale[occurs.argmax(axis=1)],
        "max": scale[255 - occurs[:, ::-1].argmax(axis=1)],
        "mean": mean,
        "std": np.sqrt(np.maximum(levels @ scale**2 / total - mean**2, 0)),
    }
    reached = np.cumsum(levels, axis=1) / total[:, None]
    for name, quantile in QUANTILES.items():
        found[name] = scale[(reached >= quantile).argmax(axis=1)]
    return {**{name: found[name].reshape(3, 1, 1).tolist() for name in NAMES}, "count": [len(pictures)]}


def combined(episodes: Iterable[Mapping[str, Statistics]]) -> dict[str, Statistics]:
    """Return the statistics of all episodes by feature, from those of each.

    Mean, spread and extremes are exact. Quantiles are the means of the episodes' own, weighted by count, as LeRobot
    itself combines them.
    """
    total: dict[str, dict[str, NDArray[Any]]] = {}
    for episode in episodes:
        for feature, found in episode.items():
            count = int(found["count"][0])
            new = {name: np.asarray(found[name], float) for name in NAMES}
            new["square"] = count * (new["std"] ** 2 + new["mean"] ** 2)
            for name in ("mean", *QUANTILES):
                new[name] = count * new[name]
            new["count"] = np.array([count])
            if feature not in total or not total[feature]["count"][0]:
                total[feature] = new
            elif count:
                total[feature] = _added(total[feature], new)
    return {feature: _finished(found) for feature, found in total.items()}


def _added(held: Mapping[str, NDArray[Any]], new: Mapping[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    """Return two sums together, with the smaller minimum and the larger maximum."""
    added = {name: held[name] + new[name] for name in held}
    return {**added, "min": np.minimum(held["min"], new["min"]), "max": np.maximum(held["max"], new["max"])}


def _finished(found: Mapping[str, NDArray[Any]]) -> Statistics:
    """Return means, spread and quantiles from sums."""
    count = max(int(found["count"][0]), 1)
    means = {name: found[name] / count for name in ("mean", *QUANTILES)}
    spread = np.sqrt(np.maximum(found["square"] / count - means["mean"] ** 2, 0))
    values = {"min": found["min"], "max": found["max"], "std": spread, **means}
    return {**{name: values[name].tolist() for name in NAMES}, "count": found["count"].astype(int).tolist()}
