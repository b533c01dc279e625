"""By how much a parameter changes over a covariate, with an interval that whole trajectories vouch for."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import t as student

from tactiledata.arrays import Array
from tactiledata.diagnose.residuals.projection import ProjectedResiduals
from tactiledata.diagnose.residuals.residuals import ResidualParameter
from tactiledata.diagnose.residuals.scores import IMITATED
from tactiledata.diagnose.residuals.wording import TOO, quantity, signed_change, with_interval


@dataclass(frozen=True)
class Change:
    """A change of a parameter.

    Parameters
    ----------
    parameter : ResidualParameter
    value, half_width : float
        In the parameter's unit; the 95 % interval is value ± half_width.
    """

    parameter: ResidualParameter
    value: float
    half_width: float

    @property
    def is_relative(self) -> bool:
        """Whether it is said as a share of the parameter's value."""
        return bool(np.isfinite(self.parameter.value) and self.parameter.value != 0)

    @property
    def sharpness(self) -> float:
        """The change over the half width of its interval."""
        return abs(self.value) / self.half_width if self.half_width > 0 else 0.0

    @property
    def words(self) -> str:
        """``"E falls by 11 ± 2 %"``; no number where it is not known to the parameter's own size."""
        if self._is_untold:
            return f"{self.parameter.name} changes by more than its own size, which these data cannot tell"
        return signed_change(self.parameter.name, *self._told)

    @property
    def standing(self) -> str:
        """Of a change that holds everywhere, ``"E is 11 ± 2 % too high"``."""
        if self._is_untold:
            return f"{self.parameter.name} cannot be told from these data"
        value, half_width, unit = self._told
        return f"{self.parameter.name} is {with_interval(abs(value), half_width, unit)} {TOO[value > 0]}"

    @property
    def _is_untold(self) -> bool:
        return self.is_relative and abs(self.parameter.value) < self.half_width < np.inf

    @property
    def _told(self) -> tuple[float, float, str]:
        if self.is_relative:
            share = 100.0 / abs(self.parameter.value)
            return self.value * share, self.half_width * share, "%"
        return self.value, self.half_width, self.parameter.unit


def change(projection: ProjectedResiduals, place: int, instrument: Array) -> Change:
    """The change of a shared parameter along an instrument (n,), all other parameters refitted with it.

    Its variance is the sandwich of the units of exchange at the fit that includes the change.
    """
    alone = (projection.directions[:, :, place] * instrument[:, None])[:, :, None]
    field = projection.orthogonal(alone)
    weighed = projection.weigh(field)
    scores = projection.dot(weighed, projection.left[:, :, None])[:, 0]
    information = projection.dot(field, weighed)[:, 0]
    total = float(information.sum())
    parameter = projection.residuals.parameters[projection.residuals.shared[place]]
    if total <= IMITATED * float((alone**2).sum()):
        return Change(parameter, 0.0, float("inf"))
    value = float(scores.sum()) / total
    misfit = (scores - value * information) / total
    return Change(parameter, value, _half_width(misfit, information / total))


def refitted(projection: ProjectedResiduals) -> list[Change]:
    """By how much a linear refit moves each shared parameter, with intervals from what the units disagree on."""
    residuals, inverse = projection.residuals, projection.inverse
    moved = residuals.by_unit(np.einsum("nkp,nk->np", projection.directions, projection.score)) @ inverse
    grams = residuals.by_unit(np.einsum("nkp,nkq->npq", projection.directions, projection.weighed))
    shares = np.einsum("pq,uqr,rp->up", inverse, grams, inverse, optimize=True) / np.maximum(np.diag(inverse), 1e-300)
    return [
        Change(residuals.parameters[place], float(projection.refit[k]), _half_width(moved[:, k], shares[:, k]))
        for k, place in enumerate(residuals.shared)
    ]


def _half_width(misfit: Array, shares: Array) -> float:
    """Half of a 95 % interval from what each unit (u,) moves the value by, and its share of the information.

    A unit that carries much of the information pulls the fit towards itself: its misfit is scaled up for that.
    """
    widened = misfit / (1.0 - np.clip(shares, 0.0, 0.9))
    effective = 1.0 / max(float((shares**2).sum()), 1.0 / len(shares))
    return float(student.ppf(0.975, max(effective - 1.0, 1.0))) * float(np.sqrt((widened**2).sum()))


def over(name: str, low: float, high: float, unit: str) -> str:
    """``"between depth 0.2 mm and 1.1 mm"``."""
    return f"between {name} {quantity(low, unit)} and {quantity(high, unit)}"
