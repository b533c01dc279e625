"""How alike two effects are once everything is taken off that a refit of the plain simulation imitates."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tactiledata.diagnose.random_effects import RandomEffects

Array = NDArray[np.float64]


def cosines(metric: RandomEffects, fields: Sequence[Array]) -> Array:
    """Cosines (k, k) of fields (N, 6) in the metric; 0 where nothing of one is left."""
    stacked = np.stack(fields, axis=2)
    together = metric.products(stacked, stacked)
    size = np.sqrt(np.maximum(np.diag(together), 1e-300))
    return np.clip(together / np.outer(size, size), -1.0, 1.0)


def best_imitation(metric: RandomEffects, field: Array, others: Array) -> float:
    """Cosine of a field (N, 6) with the nearest of all that fields (N, 6, p) can make together."""
    inner = metric.products(others, others)
    toward = metric.products(others, field[:, :, None])[:, 0]
    size = float(metric.products(field[:, :, None], field[:, :, None])[0, 0])
    if not size > 0:
        return 0.0
    scale = np.sqrt(np.maximum(np.diag(inner), 1e-300))
    strengths = np.linalg.pinv(inner / np.outer(scale, scale), rcond=1e-8, hermitian=True) @ (toward / scale)
    return float(np.sqrt(np.clip(strengths @ (toward / scale) / size, 0.0, 1.0)))
