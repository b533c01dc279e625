"""Cosines of a field with the signatures of known effects, beyond what a refit of shared parameters can imitate."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.residuals.projection import ProjectedResiduals
from tactiledata.diagnose.residuals.scores import cosines_of

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
        Its metric is the inverse covariance with the trajectories' own parameters marginalised. Its shared parameters
        are projected out of the field and of the signatures; the cosine is 0 where they imitate a signature.
    field : (n, k)
        Whitened change of the simulation.
    signatures : dict, name -> (n, k)
        Whitened changes by known effects.
    """
    if not signatures:
        return ()
    names = list(signatures)
    stacked = np.stack([field, *(signatures[name] for name in names)], axis=2)
    both = projection.orthogonal(stacked)
    together = np.einsum("nka,nkb->ab", both, projection.weigh(both), optimize=True)
    cosines = cosines_of(together, (stacked**2).sum(axis=(0, 1)))[0, 1:]
    listed = [Likeness(name, float(cosine)) for name, cosine in zip(names, cosines, strict=True)]
    return tuple(sorted(listed, key=lambda likeness: -abs(likeness.cosine)))
