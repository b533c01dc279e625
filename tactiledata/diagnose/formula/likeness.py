"""Cosines of a field with the signatures of known effects, beyond what a refit of shared parameters can imitate."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.residuals.projection import ProjectedResiduals

NEAR = 0.9
"""Smallest absolute cosine at which a field behaves like a known effect."""


@dataclass(frozen=True)
class Likeness:
    """A known effect and the cosine of the angle between its signature and the field."""

    name: str
    cosine: float

    @property
    def is_near(self) -> bool:
        """Whether the field behaves like the effect."""
        return abs(self.cosine) > NEAR


def likenesses(projection: ProjectedResiduals, field: Array, signatures: Mapping[str, Array]) -> tuple[Likeness, ...]:
    """Return the cosines of a field with known signatures, the largest absolute cosine first.

    Parameters
    ----------
    projection : ProjectedResiduals
        Gives the metric, and the shared parameters that are projected out of the field and of the signatures.
    field : (n, k)
        Whitened change of the simulation.
    signatures : dict, name -> (n, k)
        Whitened changes by known effects.
    """
    if not signatures:
        return ()
    names = list(signatures)
    both = projection.orthogonal(np.stack([field, *(signatures[name] for name in names)], axis=2))
    together = np.einsum("nka,nkb->ab", both, projection.weigh(both), optimize=True)
    size = np.sqrt(np.maximum(np.diag(together), 1e-300))
    cosines = together[0, 1:] / (size[0] * size[1:])
    listed = [Likeness(name, float(cosine)) for name, cosine in zip(names, cosines, strict=True)]
    return tuple(sorted(listed, key=lambda likeness: -abs(likeness.cosine)))
