"""Score tests: how much of the plain fit's residual each effect would explain, to first order and without a refit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array, Mask
from tactiledata.diagnose.naming.metric import RandomEffects
from tactiledata.diagnose.naming.signatures import Signature, size_count
from tactiledata.diagnose.naming.strength import Strength
from tactiledata.effects import EFFECTS
from tactiledata.effects.simulate.setting import EffectSetting


@dataclass(frozen=True)
class Screened:
    """One effect with its first-order score, at the shapes at which it explains most.

    Parameters
    ----------
    effect : str
        Name in the catalogue.
    score : float
        Expected fall of twice the negative log-likelihood by the effect, to first order (Lagrange multiplier test).
    evidence : float
        Logarithm of the Bayes factor against the plain simulation to first order: half of the score less the Occam
        penalties of the strengths, under the catalogue's priors, and of the choice among shapes.
    starts : list of tuples of EffectSetting
        Settings from which a refit starts, the most promising shapes first.
    strengths : frozenset of Strength
        Strengths that change anything in these touches.
    """

    effect: str
    score: float
    evidence: float
    starts: list[tuple[EffectSetting, ...]]
    strengths: frozenset[Strength]


MOST_STARTS = 2
"""Number of best shapes of an effect from which a refit starts."""


def screen(metric: RandomEffects, residual: Array, signatures: Sequence[Signature]) -> list[Screened]:
    """Return all effects with their first-order scores, the one with most evidence first.

    Parameters
    ----------
    metric : RandomEffects
        Metric of a fit: scores are orthogonal to what its refit can imitate.
    residual : (N, 6)
        Whitened residual of that fit, `JointFit.residual_at_centre`.
    signatures : sequence of Signature
        Signatures beside what the fit contains, at every shape that is tried.
    """
    # the score of every signature
    by_effect: dict[str, list[tuple[float, float, Signature, Array]]] = {}
    weighed = metric.weigh(residual[:, :, None])[:, :, 0]
    for signature in signatures:
        gradient = np.einsum("nkp,nk->p", signature.field, weighed)
        information = metric.products(signature.field, signature.field)
        strengths, score = _most_likely(gradient, information, signature.one_sided)
        occam = float(np.linalg.slogdet(np.eye(len(gradient)) + information)[1])
        by_effect.setdefault(signature.effect, []).append((score, 0.5 * (score - occam), signature, strengths))
    # the best shapes of every effect
    screened = []
    for name, tried in by_effect.items():
        tried.sort(key=lambda scored: -scored[0])
        best = tried[0]
        starts = [signature.at(strengths) for _, _, signature, strengths in tried[:MOST_STARTS]]
        if size_count(EFFECTS[name]()) > 1:
            # an effect that acts from a threshold on may do nothing at the size that the linearisation suggests
            starts += [
                signature.at(np.where(strengths > 0, signature.step_sizes, 0.0))
                for _, _, signature, strengths in tried[:MOST_STARTS]
            ]
        kept = frozenset(strength for _, _, signature, _ in tried for strength in signature.strengths)
        # the Occam penalty of having chosen the best of several shapes
        evidence = best[1] - float(np.log(len(tried)))
        screened.append(Screened(name, best[0], evidence, starts, kept))
    return sorted(screened, key=lambda effect: -effect.evidence)


def _most_likely(gradient: Array, information: Array, one_sided: Mask) -> tuple[Array, float]:
    """Most likely strengths (p,) in prior standard deviations, and the fall of the cost that they promise.

    A one-sided strength that would be negative is set to 0, and the others are solved for again.

    Parameters
    ----------
    gradient : (p,)
        Products of the signature's fields with the residual.
    information : (p, p)
        Products of the fields with each other.
    one_sided : (p,) bool
        Strengths that cannot be negative.
    """
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
