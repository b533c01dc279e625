"""How far a contact's pull goes beyond Coulomb's limit."""

from __future__ import annotations

import numpy as np

from tactiledata.arrays import RealArray


def beyond_coulomb(pull: RealArray, limit: RealArray) -> RealArray:
    """By what factor a contact's own pull (n, 2) exceeds Coulomb's limit (n,); 1 where it does not.

    What slides on flanks is pushed along the gel by the pressure on them, too: a few per cent more than friction alone.
    """
    size = np.linalg.norm(pull, axis=1)
    return np.maximum(1.0, np.divide(size, limit, out=np.ones_like(size), where=limit > 0))
