"""Coulomb's limit: by which factor a contact's own pull exceeds it, and how a changed pull is kept within it."""

from __future__ import annotations

import numpy as np

from tactiledata.arrays import RealArray


def beyond_coulomb(pull: RealArray, limit: RealArray) -> RealArray:
    """Return the factor (n,) by which a contact's own pull (n, 2), N, exceeds Coulomb's limit (n,), N; at least 1.

    An indenter that slides with steep flanks is also pushed along the gel by the pressure on them: its pull is a few
    per cent more than friction alone.
    """
    size = np.linalg.norm(pull, axis=1)
    return np.maximum(1.0, np.divide(size, limit, out=np.ones_like(size), where=limit > 0))


def within(pull: RealArray, limit: RealArray) -> RealArray:
    """Return a pull (n, 2), N, shortened to a limit (n,), N, wherever it is more."""
    size = np.linalg.norm(pull, axis=1)
    return pull * np.divide(limit, size, out=np.ones_like(size), where=size > limit)[:, None]
