"""What the trajectories' own parameters follow: contact offsets that go with the place, the indenter or the time.

A parameter that each trajectory has for itself takes a mismatch up that differs from trajectory to trajectory: under a
surface that is no plane contact offsets go with the distance from the middle, under a badly mounted indenter with its
name, and nothing is left of either in the residual. Where they follow nothing, any trajectory might have had the value
of any other: values are exchanged, the largest correlation over all covariates is the statistic (Westfall and Young
1993).
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
"""Share of a covariate's variance that must lie between units of exchange: others tell of frames, not of units."""


@dataclass(frozen=True)
class _Fact:
    """A covariate or a level of a label, as one number (u,) of each unit of exchange."""

    name: str
    at: str
    values: Array
    where: str


def own_drifts(projection: ProjectedResiduals, seed: int = 0, draws: int = DRAWS) -> tuple[Drift, ...]:
    """Every pair of own parameter and covariate or level, the most certain first.

    Raises
    ------
    TactileDataError
        Too few units of exchange.
    """
    residuals = projection.residuals
    residuals.need_units("what own parameters follow")
    facts = list(_facts(residuals, in_contact(residuals)))
    values = own_values(projection)
    if not facts or not values:
        return ()
    told = np.column_stack([about_mean(one.values) for one in facts])
    exchanged = _exchanged(residuals.unit_count, draws, seed)
    observed, drawn = [], []
    for own in values.values():
        alone = about_mean(own)
        observed.append(np.abs(told.T @ alone))
        drawn.append(np.abs(alone[exchanged] @ told))
    p_values = family_wise(np.concatenate(observed), np.concatenate(drawn, axis=1))
    alike = look_alikes(residuals)
    pairs = [(name, fact) for name in values for fact in facts]
    found = [
        _drift(residuals, name, values[name], fact, float(p), alike.get(fact.name, ()))
        for (name, fact), p in zip(pairs, p_values, strict=True)
    ]
    return tuple(sorted(found, key=lambda one: (one.p, -abs(one.statistic))))


def own_values(projection: ProjectedResiduals) -> dict[str, Array]:
    """Most likely values (u,) of the own parameters that are asked, in the mean of each unit of exchange.

    Under its prior N(0, v) a parameter with sensitivities s stands at ``v sᵀ V⁻¹ r`` for a residual r of covariance V.
    """
    residuals = projection.residuals
    count = np.bincount(residuals.unit_of_trajectory, minlength=residuals.unit_count)
    values = {}
    for place, one in enumerate(residuals.parameters):
        if one.own_deviation is not None and np.isfinite(one.own_deviation) and one.is_tested:
            told = residuals.by_unit(np.einsum("nk,nk->n", residuals.slopes[:, :, place], projection.score))
            values[one.name] = one.own_deviation**2 * told / count
    return values


def _facts(residuals: Residuals, touched: NDArray[np.bool_]) -> Iterator[_Fact]:
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
    (parameter,) = (one for one in residuals.parameters if one.name == name)
    told = fact.values - fact.values.mean()
    size = float(told @ own) / float(told @ told)
    left = own - own.mean() - size * told
    freedom = len(own) - 2
    error = float(np.sqrt(left @ left / freedom / (told @ told)))
    moved = Change(parameter, size, float(student.ppf(0.975, freedom)) * error)
    words = f"each trajectory's own {moved.words} {fact.where} ({p_words(p)})"
    words += alike_words(fact.name, same)
    return Drift(name, fact.name, size / max(error, 1e-300), p, fact.at, moved, words, same)


def _exchanged(units: int, draws: int, seed: int) -> NDArray[np.int64]:
    """Orders (draws, u) of the units."""
    rng = np.random.default_rng(seed)
    return rng.permuted(np.tile(np.arange(units), (draws, 1)), axis=1)
