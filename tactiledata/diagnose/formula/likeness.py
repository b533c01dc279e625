"""Which known effect a field resembles, once everything that a refit can imitate is taken off both."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.residuals.projection import ProjectedResiduals

NEAR = 0.9


@dataclass(frozen=True)
class Likeness:
    """A known signature and the cosine of its angle to the field."""

    name: str
    cosine: float

    @property
    def is_near(self) -> bool:
        """Whether the field behaves like it."""
        return abs(self.cosine) > NEAR


def likenesses(projection: ProjectedResiduals, field: Array, signatures: Mapping[str, Array]) -> tuple[Likeness, ...]:
    """Cosines of a field (n, k) with signatures (n, k) in the whitened metric, the nearest first."""
    if not signatures:
        return ()
    names = list(signatures)
    both = projection.orthogonal(np.stack([field, *(signatures[name] for name in names)], axis=2))
    together = np.einsum("nka,nkb->ab", both, projection.weigh(both), optimize=True)
    size = np.sqrt(np.maximum(np.diag(together), 1e-300))
    cosines = together[0, 1:] / (size[0] * size[1:])
    found = [Likeness(name, float(cosine)) for name, cosine in zip(names, cosines, strict=True)]
    return tuple(sorted(found, key=lambda one: -abs(one.cosine)))
