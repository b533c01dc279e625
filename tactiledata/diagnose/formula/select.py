"""Stability selection: the terms that halves of the trajectories choose again and again by a greedy search.

Meinshausen and Buehlmann 2010, with the complementary pairs of Shah and Samworth 2013. Each half is searched by
orthogonal least squares; terms that are nearly the same field vote together.
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
"""Number of complementary pairs of halves."""
PICKS = 3
"""Terms that each half chooses."""
THRESHOLD = 0.8
"""Smallest share of halves that must choose a family of terms."""
ALIKE = 0.9
"""Absolute cosine above which two terms count as one in these data."""
SINGULAR = 1e-6
"""Smallest share of a term's squared norm that earlier picks must leave of it."""


@dataclass(frozen=True)
class Choice:
    """A family of terms whose fields are nearly the same, and how often halves of the data choose it.

    Parameters
    ----------
    members : (m,)
        Places of the terms, the most often chosen first.
    inclusion : float
        Share of halves that choose any member.
    """

    members: Indices
    inclusion: float


def halves(units: int, rng: np.random.Generator, pairs: int = PAIRS) -> Array:
    """Return masks (2 pairs, u) of random halves and their complements; an odd unit belongs to neither.

    Parameters
    ----------
    units : int
        Number u of units of exchange.
    rng : Generator
    pairs : int
        Number of complementary pairs.
    """
    masks = np.zeros((2 * pairs, units))
    for pair in range(pairs):
        order = rng.permutation(units)
        masks[2 * pair, order[: units // 2]] = 1.0
        masks[2 * pair + 1, order[units // 2 : 2 * (units // 2)]] = 1.0
    return masks


def pursue(scores: Array, grams: Array, picks: int = PICKS) -> Indices:
    """Return which terms (b, picks) orthogonal least squares picks, in b problems of m terms at once.

    Terms are numbered from 0 to m - 1. Each pick is the term that lowers the squared residual most when all picks are
    refitted together; they stand in the order in which they are picked, and of equal terms the one with the smaller
    number is taken. Orthogonal matching pursuit would take the term most correlated with the residual instead. A term
    of whose squared norm the earlier picks leave at most the share ``SINGULAR`` lowers nothing. Where no term lowers
    the squared residual, as where ``picks`` is larger than the number of independent terms, this number and all later
    ones are -1. The scale of a term does not matter.

    Parameters
    ----------
    scores : (b, m)
        Products of the terms with the residual; not changed.
    grams : (b, m, m)
        Products of the terms with one another; not changed.
    picks : int
        Number of terms to pick in each problem.

    Source: Chen, Billings and Luo, Int. J. Control 50 (1989), on orthogonal least squares.
    """
    scores, grams = scores.copy(), grams.copy()
    rows = np.arange(len(scores))
    first = np.einsum("bmm->bm", grams).copy()
    chosen = np.zeros((len(scores), picks), dtype=np.int64)
    for pick in range(picks):
        norms = np.einsum("bmm->bm", grams)
        gains = np.where(norms > SINGULAR * first, scores**2 / np.where(norms > 0, norms, 1.0), 0.0)
        best = gains.argmax(axis=1)
        is_picked = gains[rows, best] > 0
        chosen[:, pick] = np.where(is_picked, best, -1)
        # project the pick out of every term and of the residual; division by infinity leaves them as they are
        column = grams[rows, :, best]
        pivot = np.where(is_picked, column[rows, best], np.inf)
        scores -= column * (scores[rows, best] / pivot)[:, None]
        grams -= column[:, :, None] * column[:, None, :] / pivot[:, None, None]
    return chosen


def stable_choices(by_unit: Array, grams: Array, rng: np.random.Generator) -> list[Choice]:
    """Return families of terms, the most often chosen by halves of the units first.

    In each half `pursue` picks ``PICKS`` terms. A term that any half picks joins the family of a more often picked one
    where the absolute cosine between them exceeds ``ALIKE``; terms that no half picks are in no family.

    Parameters
    ----------
    by_unit : (u, m)
        Contributions of the u units of exchange to the scores of the m terms, their products with the residual.
    grams : (u, m, m)
        Contributions of the units of exchange to the products of the terms with one another.
    rng : Generator
        Draws the halves.
    """
    # votes of all halves
    masks = halves(len(by_unit), rng)
    width = by_unit.shape[1]
    chosen = pursue(masks @ by_unit, (masks @ grams.reshape(len(grams), -1)).reshape(-1, width, width))
    total = grams.sum(axis=0)
    size = np.sqrt(np.maximum(np.diag(total), 1e-300))
    cosines = np.abs(total) / np.outer(size, size)
    votes = np.bincount(chosen[chosen >= 0], minlength=width)
    # a term joins the first family whose most chosen member is nearly the same field
    families: list[list[int]] = []
    for term in np.argsort(-votes, kind="stable"):
        if votes[term] == 0:
            break
        joined = next((family for family in families if cosines[family[0], term] > ALIKE), None)
        if joined is None:
            families.append([int(term)])
        else:
            joined.append(int(term))
    choices = [Choice(np.array(family), float(np.isin(chosen, family).any(axis=1).mean())) for family in families]
    return sorted(choices, key=lambda choice: -choice.inclusion)


def false_terms_bound(by_unit: Array, picks: int = PICKS, threshold: float = THRESHOLD) -> float:
    """Return an upper bound of the expected number of false terms.

    This is ``picks^2 / ((2 threshold - 1) terms)`` of Meinshausen and Buehlmann. As many candidates are nearly the
    same, ``terms`` is the number of directions in which the units' scores vary (their participation ratio).

    Parameters
    ----------
    by_unit : (u, m)
        Contributions of the units of exchange to the scores of all candidates.
    picks : int
        Terms that each half chooses.
    threshold : float
        Smallest share of halves that must choose a term.
    """
    scaled = by_unit / np.maximum(np.linalg.norm(by_unit, axis=0), 1e-300)
    spectrum = np.linalg.eigvalsh(scaled @ scaled.T)
    different = float(spectrum.sum() ** 2 / max(float((spectrum**2).sum()), 1e-300))
    return picks**2 / ((2 * threshold - 1) * max(different, 1.0))


DRAWS = 999
"""Sign flips for the p-value of a term."""
CHUNK = 100
"""Sign flips that are computed at once: limits memory."""
MOST_TERMS = 4
"""Most terms of a formula."""
SCREENED = 45
"""Candidates that are kept of each round of screening."""
ROUNDS = 3
"""Rounds of screening."""
AS_GOOD = 0.95
"""Share of the best gain in a family: the simplest term that reaches it is taken."""
LEVEL = 0.05
"""Largest p-value of a term of a formula."""
MOST_LOTS = 200
"""Most lots into which the units of exchange are pooled: limits memory."""
VISIBLE = 1e-3
"""Smallest share of a candidate's squared norm that a refit of the parameters must leave of it."""


@dataclass(frozen=True)
class Accepted:
    """A candidate that became a term of the formula.

    Parameters
    ----------
    number : int
        The candidate's number.
    inclusion : float
        Share of halves of the units that choose the candidate, or one that is the same in these data.
    p : float
        Its p-value against all candidates together, after the terms before it.
    alike : tuple of str
        Full names of candidates that these data cannot tell from it, at most three.
    """

    number: int
    inclusion: float
    p: float
    alike: tuple[str, ...]


def choose(residuals: Residuals, candidates: Candidates, seed: int = 0) -> tuple[list[Accepted], float]:
    """Return the candidates that become terms, and an upper bound of the expected number of false terms.

    A candidate becomes a term where at least `THRESHOLD` of random halves of the trajectories choose it, or one that
    is nearly the same, and where its p-value against all candidates, after the terms before it, is at most `LEVEL`.
    The first that fails the p-value ends the list, which has `MOST_TERMS` terms at most.

    Parameters
    ----------
    residuals : Residuals
        What the terms are to explain.
    candidates : Candidates
        All terms that may be chosen, of the same residuals.
    seed : int
        Draws halves and sign flips.

    Raises
    ------
    TactileDataError
        Too few units of exchange.
    """
    residuals.need_units("an open form")
    choices, bound = _stable(residuals, candidates, seed)
    accepted: list[Accepted] = []
    for number, inclusion, alike in choices[:MOST_TERMS]:
        projection = project(residuals.with_fields(candidates.fields([term.number for term in accepted])))
        p = _against_all(projection, candidates, number, seed)
        if p > LEVEL:
            break
        accepted.append(Accepted(number, inclusion, p, alike))
    return accepted, bound


def _stable(
    residuals: Residuals, candidates: Candidates, seed: int
) -> tuple[list[tuple[int, float, tuple[str, ...]]], float]:
    """Return stable candidates (number, inclusion, names alike), the strongest first, and the bound of false ones."""
    screened, by_unit = _screen(residuals, candidates)
    if not len(screened):
        return [], 0.0
    # products of the screened candidates with one another and with the residual, by lots of units
    projection = project(residuals)
    fields = projection.orthogonal(np.stack([candidates.field(number) for number in screened], axis=2))
    weighed = projection.weigh(fields)
    # more lots than this make halves no fairer, and memory grows with their number
    lot_of_unit = np.random.default_rng(seed).permutation(residuals.unit_count) % MOST_LOTS
    lot = lot_of_unit[residuals.unit_of_trajectory]
    grams = np.zeros((int(lot.max()) + 1, len(screened), len(screened)))
    for start, count, number in zip(residuals.starts, residuals.counts, lot, strict=True):
        rows = slice(start, start + count)
        grams[number] += fields[rows].reshape(-1, len(screened)).T @ weighed[rows].reshape(-1, len(screened))
    scores = np.zeros((len(grams), len(screened)))
    np.add.at(scores, lot_of_unit, projection.dot(fields, projection.score[:, :, None]))
    families = stable_choices(scores, grams, np.random.default_rng(seed))
    # of each stable family the simplest candidate among those that gain most
    norms = np.maximum(np.einsum("umm->m", grams), 1e-300)
    gains = scores.sum(axis=0) ** 2 / norms
    stable = []
    for family in families:
        if family.inclusion < THRESHOLD:
            continue
        good = [place for place in family.members if gains[place] >= AS_GOOD * gains[family.members].max()]
        best = min(good, key=lambda place: (candidates.complexity_of(int(screened[place])), -gains[place]))
        likes = [candidates.full_name(int(screened[place])) for place in family.members if place != best]
        stable.append((float(gains[best]), (int(screened[best]), family.inclusion, tuple(likes[:3]))))
    stable.sort(key=lambda choice: -choice[0])
    return [choice for _, choice in stable], false_terms_bound(by_unit)


def _screen(residuals: Residuals, candidates: Candidates) -> tuple[Indices, Array]:
    """Return numbers of the candidates that explain most, and the scores (u, m) of all candidates alone.

    Each round asks which candidates explain most after the best candidate of every round before.
    """
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
    """Return the p-value of one candidate against the largest of all candidates under sign flips of whole units."""
    scores = candidates.scores(projection)
    is_visible = (scores.information > VISIBLE * candidates.sizes) & scores.is_testable
    if not is_visible[number]:
        return 1.0
    visible = scores.part(is_visible)
    flips = signs(len(scores.by_unit), DRAWS, seed)
    highest = [np.abs(visible.flipped(flips[start : start + CHUNK])).max(axis=1) for start in range(0, DRAWS, CHUNK)]
    return p_value(abs(float(scores.statistic[number])), np.concatenate(highest))
