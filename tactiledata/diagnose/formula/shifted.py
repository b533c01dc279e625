"""Carriers for a length that was counted from a shifted zero: a contact found late makes every depth too small."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import PchipInterpolator

from tactiledata.arrays import Array
from tactiledata.diagnose.formula.candidates import Carrier
from tactiledata.diagnose.formula.open_form import SCALE_OF
from tactiledata.diagnose.residuals.dimensions import find_unit
from tactiledata.diagnose.residuals.residuals import Residuals

FEWEST_PLACES = 5
"""Fewest different values of a covariate in a group from which a slope is read."""
STEP = 0.05
"""Share of a group's range over which a slope is taken: a tangent at a contact says nothing of what comes after."""
SAME = 1e-3
"""Share of a group's range within which values of a covariate count as equal."""
FOLLOWED = 0.99
"""Smallest share of a prediction's variance inside groups that the covariate alone must explain."""


def shift_carriers(residuals: Residuals) -> list[Carrier]:
    """Return a carrier for each quantity and each length whose shift would change the quantity's prediction.

    These are lengths that the prediction follows inside groups. The field is the slope of the prediction over the
    length; a coefficient is a shift in the length's unit.
    """
    listed = []
    for place, parameter in enumerate(residuals.parameters):
        name = parameter.name.removeprefix(SCALE_OF)
        if name == parameter.name or name not in residuals.components:
            continue
        column = residuals.components.index(name)
        predicted = residuals.slopes[:, column, place]
        for covariate, given in residuals.covariates.items():
            unit = find_unit(given.unit)
            if unit is None or unit.exponents != (1.0, *[0.0] * 6):
                continue
            slope = slope_inside(predicted, given.values, residuals)
            if slope is not None:
                field = np.zeros_like(residuals.values)
                field[:, column] = slope
                definition = _slope_definition(name, covariate, given.unit)
                listed.append(Carrier(f"{name} over {covariate}", field, given.unit, covariate, definition))
    return listed


def _slope_definition(of: str, covariate: str, unit: str) -> str:
    return (
        f"slope of predicted {of} over {covariate} is (F({covariate} + h) - F({covariate}))/h, with h {STEP:g} times "
        f"the range of {covariate} in the group, in {unit}, and F the predicted {of} of the group over {covariate}: "
        "a monotone cubic through its rows (PCHIP), straight on beyond the last"
    )


def slope_inside(predicted: Array, values: Array, residuals: Residuals) -> Array | None:
    """Return the slope (n,) of a prediction over a covariate at each row, along a smooth curve through its group.

    Its unit is that of the prediction over that of the covariate. It is 0 in a group with fewer than `FEWEST_PLACES`
    values of the covariate. ``None`` where the covariate alone explains less than `FOLLOWED` of the prediction's
    variance inside groups.

    Parameters
    ----------
    predicted : (n,)
        Predictions, the groups one after another.
    values : (n,)
        The covariate.
    residuals : Residuals
        Gives where each group starts and how many rows it has.
    """
    slope, missed, total = np.zeros_like(predicted), 0.0, 0.0
    for start, count in zip(residuals.starts, residuals.counts, strict=True):
        rows = slice(start, start + count)
        places, means = _merged(values[rows], predicted[rows])
        total += float(((predicted[rows] - predicted[rows].mean()) ** 2).sum())
        if len(places) < FEWEST_PLACES:
            missed += float(((predicted[rows] - predicted[rows].mean()) ** 2).sum())
            continue
        slope[rows] = _secant(values[rows], places, means)
        # cross-validation: every other place is predicted by a curve through its neighbours
        between = PchipInterpolator(places[::2], means[::2])(places[1:-1:2]) - means[1:-1:2]
        missed += float(((predicted[rows] - np.interp(values[rows], places, means)) ** 2).sum())
        missed += float((between**2).sum() / max(len(between), 1) * count)
    return slope if total > 0 and missed <= (1.0 - FOLLOWED) * total else None


def _secant(values: Array, places: Array, means: Array) -> Array:
    """Return the slope of a prediction over a step of `STEP` of the range; the curve goes straight on at its end."""
    step = STEP * float(np.ptp(places))
    curve = PchipInterpolator(places, means)
    end = float(places[-1])
    ahead = curve(np.minimum(values + step, end)) + curve(end, 1) * np.maximum(values + step - end, 0.0)
    rise: Array = (ahead - curve(values)) / step
    return rise


def _merged(values: Array, predicted: Array) -> tuple[Array, Array]:
    """Return the different values of a covariate, ascending, and the mean prediction at each."""
    order = np.argsort(values, kind="stable")
    ascending = values[order]
    is_new = np.diff(ascending, prepend=ascending[0]) > SAME * np.ptp(ascending)
    number = np.cumsum(is_new)
    counts = np.bincount(number)
    return np.bincount(number, ascending) / counts, np.bincount(number, predicted[order]) / counts
