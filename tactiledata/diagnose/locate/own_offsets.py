"""What the trajectories' own parameters follow: contact offsets that depend on the place, the indenter or the time.

A parameter that each trajectory has for itself absorbs any mismatch that differs between trajectories, so that nothing
of it remains in the residual. On a curved surface contact offsets depend on the distance from the centre, with a badly
mounted indenter on its name. If the values follow nothing, they can be permuted among trajectories; the statistic is
the largest correlation over all covariates (Westfall and Young 1993).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student

from tactiledata.arrays import Array
from tactiledata.diagnose.locate.drifts import ALL_ALONG, Drift, about_mean, alike_words, look_alikes
from tactiledata.diagnose.locate.free_air import in_contact
from tactiledata.diagnose.residuals.instruments import levels, slope
from tactiledata.diagnose.residuals.projection import ProjectedResiduals
from tactiledata.diagnose.residuals.residuals import Residuals
from tactiledata.diagnose.residuals.scores import FEWEST_EFFECTIVE
from tactiledata.diagnose.residuals.sign_flips import DRAWS, family_wise
from tactiledata.diagnose.residuals.slopes import Change, over
from tactiledata.diagnose.residuals.wording import p_words

BETWEEN = 0.8
"""Least share of a covariate's variance between units of exchange: a covariate with less varies within trajectories."""


@dataclass(frozen=True)
class _Fact:
    """A covariate or a level of a label, as one number for each unit of exchange.

    Parameters
    ----------
    name : str
        Name of the covariate or label.
    at : str
        ``"all along"`` for a covariate, else the level.
    values : (u,)
        Mean of the instrument over the frames in contact of each unit.
    where : str
        Phrase for sentences, such as ``"between x 1 mm and 5 mm"``.
    """

    name: str
    at: str
    values: Array
    where: str


def own_drifts(projection: ProjectedResiduals, seed: int = 0, draws: int = DRAWS) -> tuple[Drift, ...]:
    """Return the dependence of every own parameter on every covariate and level of a label, the most certain first.

    Parameters
    ----------
    projection : ProjectedResiduals
        Residuals after the refit, with own parameters marginalised.
    seed : int
        Random seed of the permutations.
    draws : int
        Number of permutations.

    Raises
    ------
    TactileDataError
        There are too few units of exchange.
    """
    residuals = projection.residuals
    residuals.need_units("what own parameters follow")
    facts = list(_facts(residuals, in_contact(residuals)))
    values = own_values(projection)
    if not facts or not values:
        return ()
    # correlation of each own parameter with each fact, also after permutations that all pairs share
    fact_columns = np.column_stack([about_mean(fact.values) for fact in facts])
    orders = _exchanged(residuals.unit_count, draws, seed)
    observed, drawn = [], []
    for own in values.values():
        centred = about_mean(own)
        observed.append(np.abs(fact_columns.T @ centred))
        drawn.append(np.abs(centred[orders] @ fact_columns))
    p_values = family_wise(np.concatenate(observed), np.concatenate(drawn, axis=1))
    alike = look_alikes(residuals)
    pairs = [(name, fact) for name in values for fact in facts]
    drifts = [
        _drift(residuals, name, values[name], fact, float(p), alike.get(fact.name, ()))
        for (name, fact), p in zip(pairs, p_values, strict=True)
    ]
    return tuple(sorted(drifts, key=lambda drift: (drift.p, -abs(drift.statistic))))


def own_values(projection: ProjectedResiduals) -> dict[str, Array]:
    """Return the most likely values (u,) of the tested own parameters, by name: means over each unit's trajectories.

    With the prior N(0, v) and sensitivities s, the most likely value of a parameter is ``v sᵀ V⁻¹ r`` for a residual r
    with covariance V. Shared parameters are refitted under their priors.
    """
    residuals, score = projection.residuals, projection.score_with_priors
    count = np.bincount(residuals.unit_of_trajectory, minlength=residuals.unit_count)
    values = {}
    for place, parameter in enumerate(residuals.parameters):
        if parameter.own_deviation is not None and np.isfinite(parameter.own_deviation) and parameter.is_tested:
            products = residuals.by_unit(np.einsum("nk,nk->n", residuals.slopes[:, :, place], score))
            values[parameter.name] = parameter.own_deviation**2 * products / count
    return values


def _facts(residuals: Residuals, touched: NDArray[np.bool_]) -> Iterator[_Fact]:
    """Return covariates that vary mainly between units, and levels that whole units have; ``touched`` is contact."""
    weights = touched.astype(float)
    frames = np.maximum(residuals.by_unit(weights), 1.0)
    unit = residuals.unit_of_trajectory[residuals.trajectory]
    for name, covariate in residuals.covariates.items():
        instrument, low, high = slope(covariate.values, weights)
        means = residuals.by_unit(instrument[:, 0] * weights) / frames
        inside = float(((instrument[:, 0] - means[unit])[touched] ** 2).mean())
        if float(instrument[touched].var()) > 0 and inside <= (1.0 - BETWEEN) * float(instrument[touched].var()):
            yield _Fact(name, ALL_ALONG, means, over(name, low, high, covariate.unit))
    for name, texts in residuals.labels.items():
        kept, instruments = levels(texts)
        for level, column in zip(kept, instruments.T, strict=True):
            means = residuals.by_unit(column * weights) / frames
            is_of_units = bool(np.isin(means, (0.0, 1.0)).all())
            if is_of_units and FEWEST_EFFECTIVE <= means.sum() <= len(means) - FEWEST_EFFECTIVE:
                yield _Fact(name, level, means, f"at {name} {level}, against all others")


def _drift(residuals: Residuals, name: str, own: Array, fact: _Fact, p: float, same: tuple[str, ...]) -> Drift:
    """Return the least-squares slope of an own parameter over a fact, as a drift with its clause.

    Parameters
    ----------
    residuals : Residuals
        Holds the parameter with its unit.
    name : str
        Name of the parameter.
    own : (u,)
        Value of the parameter for each unit of exchange.
    fact : _Fact
        What the values may follow.
    p : float
        Family-wise p-value.
    same : tuple of str
        Covariates and labels that are collinear with the fact.
    """
    (parameter,) = (parameter for parameter in residuals.parameters if parameter.name == name)
    centred = fact.values - fact.values.mean()
    size = float(centred @ own) / float(centred @ centred)
    left = own - own.mean() - size * centred
    freedom = len(own) - 2
    error = float(np.sqrt(left @ left / freedom / (centred @ centred)))
    moved = Change(parameter, size, float(student.ppf(0.975, freedom)) * error)
    words = f"each trajectory's own {moved.words} {fact.where} ({p_words(p)})"
    words += alike_words(fact.name, same)
    return Drift(name, fact.name, size / max(error, 1e-300), p, fact.at, moved, words, same)


def _exchanged(units: int, draws: int, seed: int) -> NDArray[np.int64]:
    """Return random permutations (draws, u) of the units of exchange."""
    rng = np.random.default_rng(seed)
    return rng.permuted(np.tile(np.arange(units), (draws, 1)), axis=1)
