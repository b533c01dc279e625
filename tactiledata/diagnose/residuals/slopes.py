"""The change of a parameter over a covariate, with a 95 % interval from the scatter between whole trajectories."""

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
    """A change of a parameter, with its 95 % interval.

    Parameters
    ----------
    parameter : ResidualParameter
        What changes.
    value, half_width : float
        In the parameter's unit; the 95 % interval is value ± half_width.
    """

    parameter: ResidualParameter
    value: float
    half_width: float

    @property
    def is_relative(self) -> bool:
        """Whether the change is reported as a share of the parameter's value: that is known and not 0."""
        return bool(np.isfinite(self.parameter.value) and self.parameter.value != 0)

    @property
    def sharpness(self) -> float:
        """Absolute change over the half width of its interval; 0 where the half width is 0."""
        return abs(self.value) / self.half_width if self.half_width > 0 else 0.0

    @property
    def words(self) -> str:
        """A clause such as ``"E falls by 11 ± 2 %"``.

        It has no number where the interval exceeds the value of E, or where E would have to fall below 0.
        """
        name = self.parameter.name
        if self._is_uncertain:
            return f"{name} changes by an amount that these data do not determine"
        if self.is_relative and self.value <= -abs(self.parameter.value):
            return f"{name} falls by more than all of its value"
        return signed_change(name, *self._displayed)

    @property
    def offset_words(self) -> str:
        """A clause such as ``"E is 11 ± 2 % too high"``, for a change that holds in all frames."""
        if self._is_uncertain:
            return f"{self.parameter.name} is off by an amount that these data do not determine"
        value, half_width, unit = self._displayed
        return f"{self.parameter.name} is {with_interval(abs(value), half_width, unit)} {TOO[value > 0]}"

    @property
    def _is_uncertain(self) -> bool:
        """Whether the interval is finite and wider than the parameter's value."""
        return self.is_relative and abs(self.parameter.value) < self.half_width < np.inf

    @property
    def _displayed(self) -> tuple[float, float, str]:
        """Value, half width and unit for a sentence: in per cent of the parameter's value where it is known."""
        if self.is_relative:
            share = 100.0 / abs(self.parameter.value)
            return self.value * share, self.half_width * share, "%"
        return self.value, self.half_width, self.parameter.unit


def change(projection: ProjectedResiduals, place: int, instrument: Array) -> Change:
    """Return the change of a shared parameter along an instrument, with all other parameters refitted.

    The variance is the sandwich estimate over units of exchange, at the fit that includes the change.

    Parameters
    ----------
    projection : ProjectedResiduals
        Residuals of n frames after the refit.
    place : int
        Index of the parameter in `Residuals.shared`.
    instrument : (n,)
        By how much the parameter changes in each frame, per unit of change.
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
    """Return the shift of each shared parameter in the linear refit, with intervals from the scatter between units.

    The list is in the order of `Residuals.shared`.
    """
    residuals, inverse = projection.residuals, projection.inverse
    moved, grams = projection.score_by_unit @ inverse, projection.information_by_unit
    shares = np.einsum("pq,uqr,rp->up", inverse, grams, inverse, optimize=True) / np.maximum(np.diag(inverse), 1e-300)
    return [
        Change(residuals.parameters[place], float(projection.refit[k]), _half_width(moved[:, k], shares[:, k]))
        for k, place in enumerate(residuals.shared)
    ]


def _half_width(misfit: Array, shares: Array) -> float:
    """Return the half width of a 95 % interval from each unit's shift (u,) and its share of the information (u,).

    A unit with much of the information pulls the fit towards itself: its shift is scaled up by the leverage.
    """
    widened = misfit / (1.0 - np.clip(shares, 0.0, 0.9))
    effective = 1.0 / max(float((shares**2).sum()), 1.0 / len(shares))
    return float(student.ppf(0.975, max(effective - 1.0, 1.0))) * float(np.sqrt((widened**2).sum()))


def over(name: str, low: float, high: float, unit: str) -> str:
    """Return a phrase such as ``"between depth 0.2 mm and 1.1 mm"``.

    Parameters
    ----------
    name : str
        Name of the covariate.
    low, high : float
        Ends of the range, in ``unit``.
    unit : str
        Unit of the covariate.
    """
    return f"between {name} {quantity(low, unit)} and {quantity(high, unit)}"
