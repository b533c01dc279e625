"""Terms that halves of the trajectories choose again and again: stability selection over greedy pursuit.

Meinshausen and Buehlmann 2010, with the complementary pairs of Shah and Samworth 2013. Each half is searched by
orthogonal matching pursuit; terms that are nearly the same field vote together.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array, Indices
from tactiledata.diagnose.formula.candidates import Candidates
from tactiledata.diagnose.residuals.projection import ProjectedResiduals, project
from tactiledata.diagnose.residuals.residuals import Residuals
from tactiledata.diagnose.residuals.sign_flips import p_value, signs

PAIRS = 50
PICKS = 3
"""Terms that each half chooses."""
THRESHOLD = 0.8
ALIKE = 0.9
"""Cosine from which on two terms are one in these data."""
SINGULAR = 1e-6


@dataclass(frozen=True)
class Choice:
    """A family of terms that are nearly the same field.

    Parameters
    ----------
    members : (m,)
        The most often chosen first.
    inclusion : float
        Share of halves that choose any of them.
    """

    members: Indices
    inclusion: float


def halves(units: int, rng: np.random.Generator, pairs: int = PAIRS) -> Array:
    """Masks (2 pairs, u) of halves and their complements."""
    masks = np.zeros((2 * pairs, units))
    for pair in range(pairs):
        order = rng.permutation(units)
        masks[2 * pair, order[: units // 2]] = 1.0
        masks[2 * pair + 1, order[units // 2 : 2 * (units // 2)]] = 1.0
    return masks


def pursue(scores: Array, grams: Array, picks: int = PICKS) -> Indices:
    """What orthogonal matching pursuit picks (b, picks) in b problems of m terms at once.

    Parameters
    ----------
    scores : (b, m)
        Products of the terms with the residual.
    grams : (b, m, m)
        Products of the terms with one another.
    """
    scores, grams = scores.copy(), grams.copy()
    rows = np.arange(len(scores))
    first = np.einsum("bmm->bm", grams).copy()
    chosen = np.zeros((len(scores), picks), dtype=np.int64)
    for pick in range(picks):
        norms = np.einsum("bmm->bm", grams)
        gains = np.where(norms > SINGULAR * first, scores**2 / np.where(norms > 0, norms, 1.0), 0.0)
        best = gains.argmax(axis=1)
        chosen[:, pick] = best
        # what is left of every term and of the residual once the pick has had its share
        column = grams[rows, :, best]
        pivot = np.maximum(column[rows, best], 1e-300)
        scores -= column * (scores[rows, best] / pivot)[:, None]
        grams -= column[:, :, None] * column[:, None, :] / pivot[:, None, None]
    return chosen


def stable_choices(by_unit: Array, grams: Array, rng: np.random.Generator) -> list[Choice]:
    """Families of terms and how often halves of the units choose them, the most often chosen first.

    Parameters
    ----------
    by_unit : (u, m)
        Contributions of the units of exchange to the scores.
    grams : (u, m, m)
        And to the products of the terms with one another.
    """
    masks = halves(len(by_unit), rng)
    width = by_unit.shape[1]
    chosen = pursue(masks @ by_unit, (masks @ grams.reshape(len(grams), -1)).reshape(-1, width, width))
    total = grams.sum(axis=0)
    size = np.sqrt(np.maximum(np.diag(total), 1e-300))
    cosines = np.abs(total) / np.outer(size, size)
    votes = np.bincount(chosen.ravel(), minlength=width)
    families: list[list[int]] = []
    for term in np.argsort(-votes, kind="stable"):
        if votes[term] == 0:
            break
        home = next((family for family in families if cosines[family[0], term] > ALIKE), None)
        if home is None:
            families.append([int(term)])
        else:
            home.append(int(term))
    choices = [Choice(np.array(family), float(np.isin(chosen, family).any(axis=1).mean())) for family in families]
    return sorted(choices, key=lambda one: -one.inclusion)


def false_terms_bound(by_unit: Array, picks: int = PICKS, threshold: float = THRESHOLD) -> float:
    """Upper bound of the expected number of false terms, counted over as many terms as are really different.

    Meinshausen and Buehlmann's ``picks^2 / ((2 threshold - 1) terms)``; the number of different terms is that of
    directions in which the units' scores vary (their participation ratio).
    """
    scaled = by_unit / np.maximum(np.linalg.norm(by_unit, axis=0), 1e-300)
    spectrum = np.linalg.eigvalsh(scaled @ scaled.T)
    different = float(spectrum.sum() ** 2 / max(float((spectrum**2).sum()), 1e-300))
    return picks**2 / ((2 * threshold - 1) * max(different, 1.0))


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
    """A candidate that became a term: its number; the rest as in `tactiledata.diagnose.formula.open_form.Term`."""

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


def _against_all(projection: ProjectedResiduals, candidates: Candidates, number: int, seed: int) -> float:
    """p-value of one candidate against the largest of all when signs of whole trajectories are thrown anew."""
    scores = candidates.scores(projection)
    is_asked = (scores.information > VISIBLE * candidates.sizes) & scores.is_testable
    if not is_asked[number]:
        return 1.0
    asked = scores.part(is_asked)
    thrown = signs(len(scores.by_unit), DRAWS, seed)
    highest = [np.abs(asked.flipped(thrown[start : start + CHUNK])).max(axis=1) for start in range(0, DRAWS, CHUNK)]
    return p_value(abs(float(scores.statistic[number])), np.concatenate(highest))
