"""Terms that halves of the trajectories choose again and again: stability selection over greedy pursuit.

Meinshausen and Buehlmann 2010, with the complementary pairs of Shah and Samworth 2013. Each half is searched by
orthogonal matching pursuit; terms that are nearly the same field vote together.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

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
