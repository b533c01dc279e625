"""Which candidates become terms: stable under halving the trajectories, and certain against all others."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactiledata.diagnose.candidates import Candidates
from tactiledata.diagnose.projection import Projection, project
from tactiledata.diagnose.residuals import Residuals
from tactiledata.diagnose.sign_flips import p_value, signs
from tactiledata.diagnose.stability import THRESHOLD, false_terms_bound, stable_choices

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

DRAWS = 999
CHUNK = 100
MOST_TERMS = 4
SCREENED = 45
"""Candidates that are kept of each round of screening."""
ROUNDS = 3
AS_GOOD = 0.95
"""Of the best gain in a family: the simplest term that reaches it is taken."""
LEVEL = 0.05
MOST_LOTS = 200
VISIBLE = 1e-3
"""Share of a candidate's norm that parameters must leave of it."""


@dataclass(frozen=True)
class Accepted:
    """A candidate that became a term: its number; the rest as in `tactiledata.diagnose.open_form.Term`."""

    number: int
    inclusion: float
    p: float
    alike: tuple[str, ...]


def choose(residuals: Residuals, candidates: Candidates, seed: int = 0) -> tuple[list[Accepted], float]:
    """The candidates that are stable and certain, and the bound of false ones.

    Raises
    ------
    TactileDataError
        Too few units of exchange.
    """
    residuals.need_units("an open form")
    choices, bound = _stable(residuals, candidates, seed)
    accepted: list[Accepted] = []
    for number, inclusion, alike in choices[:MOST_TERMS]:
        projection = project(residuals.with_fields(candidates.fields([one.number for one in accepted])))
        p = _against_all(projection, candidates, number, seed)
        if p > LEVEL:
            break
        accepted.append(Accepted(number, inclusion, p, alike))
    return accepted, bound


def _stable(
    residuals: Residuals, candidates: Candidates, seed: int
) -> tuple[list[tuple[int, float, tuple[str, ...]]], float]:
    """Candidates with their inclusion and their likes, the strongest first, and the bound of false ones."""
    screened, by_unit = _screen(residuals, candidates)
    if not len(screened):
        return [], 0.0
    projection = project(residuals)
    fields = projection.orthogonal(np.stack([candidates.field(number) for number in screened], axis=2))
    weighed = projection.weigh(fields)
    # more than so many lots to draw from make halves no fairer, and memory grows with them
    lot_of_unit = np.random.default_rng(seed).permutation(residuals.unit_count) % MOST_LOTS
    lot = lot_of_unit[residuals.unit_of_trajectory]
    grams = np.zeros((int(lot.max()) + 1, len(screened), len(screened)))
    for start, count, number in zip(residuals.starts, residuals.counts, lot, strict=True):
        rows = slice(start, start + count)
        grams[number] += fields[rows].reshape(-1, len(screened)).T @ weighed[rows].reshape(-1, len(screened))
    scores = np.zeros((len(grams), len(screened)))
    np.add.at(scores, lot_of_unit, projection.dot(fields, projection.score[:, :, None]))
    families = stable_choices(scores, grams, np.random.default_rng(seed))
    norms = np.maximum(np.einsum("umm->m", grams), 1e-300)
    gains = scores.sum(axis=0) ** 2 / norms
    found = []
    for family in families:
        if family.inclusion < THRESHOLD:
            continue
        good = [place for place in family.members if gains[place] >= AS_GOOD * gains[family.members].max()]
        best = min(good, key=lambda place: (candidates.complexity_of(int(screened[place])), -gains[place]))
        likes = [candidates.full_name(int(screened[place])) for place in family.members if place != best]
        found.append((float(gains[best]), (int(screened[best]), family.inclusion, tuple(likes[:3]))))
    found.sort(key=lambda one: -one[0])
    return [one for _, one in found], false_terms_bound(by_unit)


def _screen(residuals: Residuals, candidates: Candidates) -> tuple[Indices, Array]:
    """Numbers of the candidates that explain most, alone and after the best of each round before; all scores (u, m)."""
    kept: list[int] = []
    bests: list[int] = []
    first = np.zeros((0, 0))
    for _ in range(ROUNDS):
        projection = project(residuals.with_fields(candidates.fields(bests)))
        scores = candidates.scores(projection)
        first = scores.by_unit if not bests else first
        is_visible = (scores.information > VISIBLE * candidates.sizes) & scores.is_testable
        gains = np.where(is_visible, scores.size**2 * scores.information, 0.0)
        order = np.argsort(-gains, kind="stable")[:SCREENED]
        kept += [int(number) for number in order if gains[number] > 0 and number not in kept]
        if not len(order) or gains[order[0]] <= 0:
            break
        bests.append(int(order[0]))
    return np.array(kept, dtype=np.int64), first


def _against_all(projection: Projection, candidates: Candidates, number: int, seed: int) -> float:
    """p-value of one candidate against the largest of all when signs of whole trajectories are thrown anew."""
    scores = candidates.scores(projection)
    is_asked = (scores.information > VISIBLE * candidates.sizes) & scores.is_testable
    if not is_asked[number]:
        return 1.0
    asked = scores.part(is_asked)
    thrown = signs(len(scores.by_unit), DRAWS, seed)
    highest = [np.abs(asked.flipped(thrown[start : start + CHUNK])).max(axis=1) for start in range(0, DRAWS, CHUNK)]
    return p_value(abs(float(scores.statistic[number])), np.concatenate(highest))
