"""A locator of one's own: a component that differs between the first and the second half of each trajectory."""

from dataclasses import dataclass

import numpy as np

from tactiledata.diagnose.locate.base import Locator
from tactiledata.diagnose.residuals.sign_flips import family_wise, signs


@dataclass(frozen=True)
class LateFrames:
    """A component and how certain its difference is."""

    component: str
    p: float
    words: str


def find(given):
    """One finding for each component, the most certain first; ``None`` for trajectories of one frame."""
    residuals = given.residuals
    if min(residuals.counts) < 2:
        return None
    # +1 in the second half of each trajectory, -1 in the first; the sum of each unit flips its sign by chance alone
    place = np.concatenate([np.arange(count) / count for count in residuals.counts])
    halves = np.where(place < 0.5, -1.0, 1.0)[:, None]
    sums = residuals.by_unit(halves * given.projection.score)
    scale = np.sqrt(np.square(sums).sum(axis=0))
    observed = np.abs(sums.sum(axis=0)) / scale
    drawn = np.abs(signs(len(sums), given.draws, given.seed + 20) @ sums) / scale
    listed = [
        LateFrames(name, float(p), f"{name} differs between the halves of a trajectory")
        for name, p in zip(residuals.components, family_wise(observed, drawn), strict=True)
    ]
    return sorted(listed, key=lambda finding: finding.p)


LOCATOR = Locator("halves of trajectories", find, lambda finding: {"component": finding.component})
