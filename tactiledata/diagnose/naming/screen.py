"""Score tests: how much of the residual each effect would explain, without a refit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import Array
from tactiledata.diagnose.naming.metric import RandomEffects
from tactiledata.diagnose.naming.signatures import Signature, looks
from tactiledata.diagnose.naming.strength import Strength
from tactiledata.effects import EFFECTS
from tactiledata.effects.simulate.setting import EffectSetting


@dataclass(frozen=True)
class Screened:
    """One effect, at the shapes at which it explains most.

    Parameters
    ----------
    effect : str
    score : float
        LM: the fall of twice the negative log-likelihood that its strengths promise, to first order.
    evidence : float
        Logarithm of the Bayes factor against nothing, with the catalogue's priors; to first order.
    starts : list of tuples of EffectSetting
        From which to refit, the most promising shapes first.
    strengths : those that leave anything
    """

    effect: str
    score: float
    evidence: float
    starts: list[tuple[EffectSetting, ...]]
    strengths: frozenset[Strength]


MOST_STARTS = 2


def screen(metric: RandomEffects, residual: Array, signatures: Sequence[Signature]) -> list[Screened]:
    """All effects, the most promising first.

    Parameters
    ----------
    metric : RandomEffects
        What a refit of the plain simulation takes: scores are orthogonal to it.
    residual : (N, 6), whitened
    signatures : at the null
    """
    by_effect: dict[str, list[tuple[float, float, Signature, Array]]] = {}
    weighed = metric.weigh(residual[:, :, None])[:, :, 0]
    for one in signatures:
        gradient = np.einsum("nkp,nk->p", one.field, weighed)
        information = metric.products(one.field, one.field)
        strengths, score = _most_likely(gradient, information, one.one_sided)
        occam = float(np.linalg.slogdet(np.eye(len(gradient)) + information)[1])
        by_effect.setdefault(one.effect, []).append((score, 0.5 * (score - occam), one, strengths))
    found = []
    for name, tried in by_effect.items():
        tried.sort(key=lambda each: -each[0])
        best = tried[0]
        starts = [one.at(strengths) for _, _, one, strengths in tried[:MOST_STARTS]]
        if looks(EFFECTS[name]()) > 1:
            # what acts from a threshold on may do nothing at the size that a straight line promises
            starts += [one.at(np.where(sizes > 0, one.looked_at, 0.0)) for _, _, one, sizes in tried[:MOST_STARTS]]
        kept = frozenset(strength for _, _, one, _ in tried for strength in one.strengths)
        # the best of several shapes is chosen: that choice is paid for
        paid = best[1] - float(np.log(len(tried)))
        found.append(Screened(name, best[0], paid, starts, kept))
    return sorted(found, key=lambda one: -one.evidence)


def _most_likely(gradient: Array, information: Array, one_sided: NDArray[np.bool_]) -> tuple[Array, float]:
    """Strengths (p,) in standard deviations of their priors, none negative that cannot be, and what they explain."""
    active = np.ones(len(gradient), dtype=bool)
    strengths = np.zeros(len(gradient))
    while active.any():
        inner = information[np.ix_(active, active)] + np.eye(int(active.sum()))
        strengths = np.zeros(len(gradient))
        strengths[active] = np.linalg.solve(inner, gradient[active])
        wrong = one_sided & (strengths < 0)
        if not wrong.any():
            break
        active &= ~wrong
    strengths[~active] = 0.0
    return strengths, float(strengths @ gradient)
