"""Parameters that are no constants: what drifts with depth, rate, load, time, place or indenter.

A calibration that has absorbed an effect leaves parameters that would take other values in other parts of the data. The
score of a parameter, summed over frames above a value of a covariate or along it, tells so without a refit (Nyblom
1989; Hansen 1992; Zeileis and Hornik 2007); the largest over all values is its statistic. Whole trajectories are the
units: their signs are thrown anew (Cameron, Gelbach and Miller 2008), the same throw for all pairs of parameter and
covariate, whose maximum controls the error of the whole family (Westfall and Young 1993).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.stats import rankdata

from tactiledata.arrays import Array
from tactiledata.diagnose.residuals.instruments import cuts, levels, slope, steps
from tactiledata.diagnose.residuals.projection import ProjectedResiduals
from tactiledata.diagnose.residuals.residuals import Residuals, joined_names
from tactiledata.diagnose.residuals.scores import Contributions, contributions
from tactiledata.diagnose.residuals.sign_flips import DRAWS, family_wise, signs
from tactiledata.diagnose.residuals.slopes import Change, change, over
from tactiledata.diagnose.residuals.wording import p_words, quantity

ALIKE = 0.9
"""Rank correlation from which on two covariates tell the same story."""
ALL_ALONG = "all along"
TRAJECTORIES_A_LEVEL = 3
"""At least, for a label to be one: names of single trajectories decide everything."""


@dataclass(frozen=True)
class Drift:
    """One pair of parameter and covariate.

    Parameters
    ----------
    parameter, covariate : str
    statistic : float
        Largest of the studentised scores over the slope and all cuts, or over all levels.
    p : float
        For all pairs together.
    at : str
        Where the score is largest: a value of the covariate, "all along" for a slope, or a level of the label.
    change : Change
        Between the 5 % and 95 % quantiles of the covariate, or at the level against all others.
    words : str
    alike : names of covariates that cannot be told from this one in these data
    """

    parameter: str
    covariate: str
    statistic: float
    p: float
    at: str
    change: Change
    words: str
    alike: tuple[str, ...]


@dataclass(frozen=True)
class _Pair:
    place: int
    covariate: str
    found: Contributions
    at: tuple[str, ...]
    is_label: bool


def parameter_drifts(
    projection: ProjectedResiduals, seed: int = 0, draws: int = DRAWS, tested: int | None = None
) -> tuple[Drift, ...]:
    """Every pair of shared parameter and covariate or label, the strongest first.

    Parameters
    ----------
    tested : int, optional
        Only the first so many of the shared parameters.

    Raises
    ------
    TactileDataError
        Too few units of exchange.
    """
    residuals = projection.residuals
    residuals.need_units("tests of drifting parameters")
    pairs = _pairs(projection, tested)
    if not pairs:
        return ()
    thrown = signs(residuals.unit_count, draws, seed)
    observed = np.array([np.abs(pair.found.statistic).max() for pair in pairs])
    drawn = np.stack([np.abs(pair.found.flipped(thrown)).max(axis=1) for pair in pairs], axis=1)
    p_values = family_wise(observed, drawn)
    alike = look_alikes(residuals)
    drifts = [
        _drift(projection, pair, float(statistic), float(p), alike)
        for pair, statistic, p in zip(pairs, observed, p_values, strict=True)
    ]
    # the studentised score saturates where all trajectories agree; how sharply the change is known does not
    return tuple(sorted(drifts, key=lambda drift: (drift.p, -drift.change.sharpness)))


def _pairs(projection: ProjectedResiduals, tested: int | None) -> list[_Pair]:
    residuals, pairs = projection.residuals, []
    for place in range(len(residuals.tested))[:tested]:
        weights = projection.information(place)
        for name, covariate in residuals.covariates.items():
            places = cuts(covariate.values, weights)
            if len(places):
                instruments = np.column_stack([steps(covariate.values, places), slope(covariate.values, weights)[0]])
                found = contributions(projection, place, instruments)
                at = (*(f"{cut:.6g}" for cut in places), ALL_ALONG)
                pairs.append(_Pair(place, name, found, at, False))
        for name, texts in residuals.labels.items():
            names, instruments = levels(texts)
            if names:
                pairs.append(_Pair(place, name, contributions(projection, place, instruments), tuple(names), True))
    return [pair for pair in pairs if pair.found.is_testable.any()]


def _drift(
    projection: ProjectedResiduals, pair: _Pair, statistic: float, p: float, alike: Mapping[str, tuple[str, ...]]
) -> Drift:
    residuals = projection.residuals
    parameter = residuals.parameters[residuals.shared[pair.place]].name
    at = pair.at[int(np.abs(pair.found.statistic).argmax())]
    if pair.is_label:
        moved = change(projection, pair.place, (residuals.labels[pair.covariate] == at).astype(np.float64))
        where = f"at {pair.covariate} {at}, against all others"
    else:
        covariate = residuals.covariates[pair.covariate]
        instrument, low, high = slope(covariate.values, projection.information(pair.place))
        moved = change(projection, pair.place, instrument[:, 0])
        where = over(pair.covariate, low, high, covariate.unit)
    said = f"{moved.words} {where}"
    if at != ALL_ALONG and not pair.is_label and moved.sharpness <= 1.0:
        # the score is large at a cut, and the slope is not told from none: no number of it is news
        said = f"{parameter} differs below and above {pair.covariate} {quantity(float(at), covariate.unit)}"
        said += ", without a steady trend"
    words = f"{said} ({p_words(p)})"
    same = alike[pair.covariate]
    words += alike_words(pair.covariate, same)
    return Drift(parameter, pair.covariate, statistic, p, at, moved, words, same)


def alike_words(name: str, same: tuple[str, ...]) -> str:
    """What a sentence on a covariate or label ends with where others tell the same story; empty where none does."""
    return f"; in these data {name} cannot be told from {joined_names(same)}" if same else ""


def look_alikes(residuals: Residuals) -> dict[str, tuple[str, ...]]:
    """For each covariate and label those that tell the same story.

    Covariates whose ranks go together, or against one another; and a label that alone decides a covariate, as where
    indenters were mounted one after the other.
    """
    ranks = {name: about_mean(rankdata(one.values)) for name, one in residuals.covariates.items()}
    alike: dict[str, list[str]] = {name: [] for name in (*residuals.covariates, *residuals.labels)}
    for first, second in combinations(ranks, 2):
        if abs(float(ranks[first] @ ranks[second])) > ALIKE:
            alike[first].append(second)
            alike[second].append(first)
    for label, texts in residuals.labels.items():
        names, level = np.unique(texts, return_inverse=True)
        if not 2 <= len(names) <= len(residuals.starts) // TRAJECTORIES_A_LEVEL:
            continue
        counts = np.bincount(level)
        for name, one in ranks.items():
            decided = float((np.bincount(level, weights=one) ** 2 / counts).sum())
            if decided > ALIKE**2:
                alike[label].append(name)
                alike[name].append(label)
    return {name: tuple(others) for name, others in alike.items()}


def about_mean(values: Array) -> Array:
    """Values (n,) about their mean, of unit length."""
    centred = values - values.mean()
    return centred / max(float(np.linalg.norm(centred)), 1e-300)
