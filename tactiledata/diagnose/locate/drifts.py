"""Parameters that are not constant: they drift with depth, rate, load, time, place or indenter.

Where a calibration has absorbed an effect, parameters would take different values in different parts of the data. A
score test shows this without a refit: the parameter's score is summed over the frames above a value of a covariate, or
weighted by the covariate (Nyblom 1989; Hansen 1992; Zeileis and Hornik 2007). The statistic is the largest over all
values. Its p-value comes from random signs of whole trajectories (Cameron, Gelbach and Miller 2008), the same for all
pairs of parameter and covariate, so that the maximum controls the family-wise error (Westfall and Young 1993).
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
"""Rank correlation above which two covariates count as collinear."""
ALL_ALONG = "all along"
"""Value of `Drift.at` for a slope over the whole range of a covariate."""
TRAJECTORIES_A_LEVEL = 3
"""Fewest trajectories for each level of a label that is checked for collinearity: a label with a level for each
trajectory would determine every covariate."""


@dataclass(frozen=True)
class Drift:
    """The change of one parameter along one covariate or label, with its p-value.

    Parameters
    ----------
    parameter, covariate : str
        Names of the parameter and of the covariate or label.
    statistic : float
        Largest studentised score over the slope and all steps of a covariate, or over all levels of a label.
    p : float
        Family-wise p-value over all pairs.
    at : str
        Where the score is largest: a value of the covariate, "all along" for a slope, or a level of the label.
    change : Change
        Change between the 5 % and 95 % quantiles of the covariate, or at the level against all others.
    words : str
        The change as a clause.
    alike : tuple of str
        Covariates and labels that are collinear with this one in these data.
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
    """A parameter (by its index in `Residuals.shared`) and a covariate or label, with the scores of all instruments.

    ``at`` names the place of each instrument, as in `Drift.at`.
    """

    place: int
    covariate: str
    scores: Contributions
    at: tuple[str, ...]
    is_label: bool


def parameter_drifts(
    projection: ProjectedResiduals, seed: int = 0, draws: int = DRAWS, tested: int | None = None
) -> tuple[Drift, ...]:
    """Return the drift of every tested parameter along every covariate and label, the strongest first.

    Parameters
    ----------
    projection : ProjectedResiduals
        Residuals after the refit.
    seed : int
        Random seed of the sign flips.
    draws : int
        Number of sign flips.
    tested : int, optional
        Number of tested parameters that are considered, from the first one on; ``None``: all.

    Raises
    ------
    TactileDataError
        There are too few units of exchange.
    """
    residuals = projection.residuals
    residuals.need_units("tests of drifting parameters")
    pairs = _pairs(projection, tested)
    if not pairs:
        return ()
    flips = signs(residuals.unit_count, draws, seed)
    observed = np.array([np.abs(pair.scores.statistic).max() for pair in pairs])
    drawn = np.stack([np.abs(pair.scores.flipped(flips)).max(axis=1) for pair in pairs], axis=1)
    p_values = family_wise(observed, drawn)
    alike = look_alikes(residuals)
    drifts = [
        _drift(projection, pair, float(statistic), float(p), alike)
        for pair, statistic, p in zip(pairs, observed, p_values, strict=True)
    ]
    # the studentised score saturates where all trajectories agree; how sharply the change is known does not
    return tuple(sorted(drifts, key=lambda drift: (drift.p, -drift.change.sharpness)))


def _pairs(projection: ProjectedResiduals, tested: int | None) -> list[_Pair]:
    """Return all pairs of parameter and covariate or label with at least one testable instrument."""
    residuals, pairs = projection.residuals, []
    for place in range(len(residuals.tested))[:tested]:
        weights = projection.information(place)
        for name, covariate in residuals.covariates.items():
            places = cuts(covariate.values, weights)
            if len(places):
                instruments = np.column_stack([steps(covariate.values, places), slope(covariate.values, weights)[0]])
                scores = contributions(projection, place, instruments)
                at = (*(f"{cut:.6g}" for cut in places), ALL_ALONG)
                pairs.append(_Pair(place, name, scores, at, False))
        for name, texts in residuals.labels.items():
            names, instruments = levels(texts)
            if names:
                pairs.append(_Pair(place, name, contributions(projection, place, instruments), tuple(names), True))
    return [pair for pair in pairs if pair.scores.is_testable.any()]


def _drift(
    projection: ProjectedResiduals, pair: _Pair, statistic: float, p: float, alike: Mapping[str, tuple[str, ...]]
) -> Drift:
    """Return the drift of one pair, with its refitted change and its clause.

    Parameters
    ----------
    projection : ProjectedResiduals
        Residuals after the refit.
    pair : _Pair
        Parameter and covariate or label, with their scores.
    statistic : float
        Largest absolute statistic of the pair.
    p : float
        Family-wise p-value.
    alike : dict, name -> names
        Collinear covariates and labels, as from `look_alikes`.
    """
    residuals = projection.residuals
    parameter = residuals.parameters[residuals.shared[pair.place]].name
    at = pair.at[int(np.abs(pair.scores.statistic).argmax())]
    # size of the change: at a level against the others, or over the range of the covariate
    if pair.is_label:
        shift = change(projection, pair.place, (residuals.labels[pair.covariate] == at).astype(np.float64))
        where = f"at {pair.covariate} {at}, against all others"
    else:
        covariate = residuals.covariates[pair.covariate]
        instrument, low, high = slope(covariate.values, projection.information(pair.place))
        shift = change(projection, pair.place, instrument[:, 0])
        where = over(pair.covariate, low, high, covariate.unit)
    clause = f"{shift.words} {where}"
    if at != ALL_ALONG and not pair.is_label and shift.sharpness <= 1.0:
        # the score is large at a step, but the interval of the slope includes 0: its number would mislead
        clause = f"{parameter} differs below and above {pair.covariate} {quantity(float(at), covariate.unit)}"
        clause += ", without a steady trend"
    words = f"{clause} ({p_words(p)})"
    same = alike[pair.covariate]
    words += alike_words(pair.covariate, same)
    return Drift(parameter, pair.covariate, statistic, p, at, shift, words, same)


def alike_words(name: str, same: tuple[str, ...]) -> str:
    """Return the end of a sentence, which names the collinear ones of a covariate or label; empty without any."""
    return f"; these data cannot separate {name} from {joined_names(same)}" if same else ""


def look_alikes(residuals: Residuals) -> dict[str, tuple[str, ...]]:
    """Return, for each covariate and label, the names of those that are collinear with it in these data.

    Two covariates are collinear where their rank correlation exceeds `ALIKE` in absolute value. A label and a covariate
    are, where the label explains the covariate's ranks as well: for example time, where indenters were mounted one
    after the other.
    """
    # pairs of covariates
    ranks = {name: about_mean(rankdata(covariate.values)) for name, covariate in residuals.covariates.items()}
    alike: dict[str, list[str]] = {name: [] for name in (*residuals.covariates, *residuals.labels)}
    for first, second in combinations(ranks, 2):
        if abs(float(ranks[first] @ ranks[second])) > ALIKE:
            alike[first].append(second)
            alike[second].append(first)
    # pairs of a label and a covariate: share of the ranks' variance that lies between levels
    for label, texts in residuals.labels.items():
        names, level = np.unique(texts, return_inverse=True)
        if not 2 <= len(names) <= len(residuals.starts) // TRAJECTORIES_A_LEVEL:
            continue
        counts = np.bincount(level)
        for name, covariate_ranks in ranks.items():
            explained = float((np.bincount(level, weights=covariate_ranks) ** 2 / counts).sum())
            if explained > ALIKE**2:
                alike[label].append(name)
                alike[name].append(label)
    return {name: tuple(others) for name, others in alike.items()}


def about_mean(values: Array) -> Array:
    """Return values (n,) minus their mean, scaled to unit length; all 0 where they are constant."""
    centred = values - values.mean()
    return centred / max(float(np.linalg.norm(centred)), 1e-300)
