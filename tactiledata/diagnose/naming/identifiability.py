"""What can be found at all: how much of an effect a plain calibration hides, and which effects look alike; no data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.naming.metric import RandomEffects, cosines
from tactiledata.diagnose.naming.signatures import Signature, effect_signatures, nuisance, playable
from tactiledata.diagnose.naming.strength import Strength
from tactiledata.diagnose.naming.thresholds import DEFAULT_THRESHOLDS
from tactiledata.diagnose.touches.touch_case import TouchSet
from tactiledata.diagnose.touches.whitened import NumericalErrors, WhitenedTouches
from tactiledata.gel.elasticity.material import GelMaterial

VISIBLE = DEFAULT_THRESHOLDS.visible
"""Signal over noise, after all that a refit imitates, from which an effect can be claimed."""


@dataclass(frozen=True)
class Identifiability:
    """Of each strength of each effect, k of them, at the default of its shapes or the most visible of their grid.

    Parameters
    ----------
    numbers : k of them
    concealment : (k,)
        Share of what the effect changes, squared, that E, nu, mu, offsets, zeros and numerical errors imitate: 0 shows
        in full, 1 is hidden.
    confusability : (k, k)
        Cosines of what is left of them: at 1 no data of this kind tell two apart.
    reach : (k,)
        Signal over noise in these trajectories, after concealment, at the end of the plausible range.
    not_told : tuple of str
        Effects that depend on what the touches do not tell.
    without_trace : tuple of str
        Effects that change nothing in these trajectories.
    """

    numbers: tuple[Strength, ...]
    concealment: Array
    confusability: Array
    reach: Array
    not_told: tuple[str, ...]
    without_trace: tuple[str, ...] = ()

    @property
    def effects(self) -> tuple[str, ...]:
        """Of each number."""
        return tuple(one.effect for one in self.numbers)

    @property
    def strengths(self) -> tuple[str, ...]:
        """In words: ``"x of ball3"`` where the effect is another one for each."""
        return tuple(one.label for one in self.numbers)

    @property
    def ends(self) -> Array:
        """Ends (k,) of the plausible ranges, the farther ones, without sign."""
        return np.array([abs(one.end) for one in self.numbers])

    @property
    def shows_from(self) -> Array:
        """Sizes (k,) of the strengths from which a signal can be claimed, to first order; infinite where none can."""
        return np.divide(self.ends * VISIBLE, self.reach, out=np.full(len(self.reach), np.inf), where=self.reach > 0)

    @property
    def undetectable(self) -> tuple[str, ...]:
        """Effects that could be as strong as they ever are and not be claimed in these trajectories."""
        seen = {name for name, reach in zip(self.effects, self.reach, strict=True) if reach >= VISIBLE}
        return (*(name for name in dict.fromkeys(self.effects) if name not in seen), *self.without_trace)

    @property
    def undetectable_numbers(self) -> tuple[Strength, ...]:
        """Strengths, of effects that would be seen, that could be as large as ever and not be claimed anywhere.

        Where an effect is another one for each place, that of the first.
        """
        unseen = set(self.undetectable)
        most: dict[tuple[str, str], float] = {}
        first: dict[tuple[str, str], Strength] = {}
        for one, reach in zip(self.numbers, self.reach, strict=True):
            key = one.effect, one.name
            first.setdefault(key, one)
            most[key] = max(most.get(key, 0.0), float(reach))
        return tuple(first[key] for key, reach in most.items() if reach < VISIBLE and key[0] not in unseen)

    def look_alikes(self, least: float = 0.95) -> list[tuple[str, str, float]]:
        """Pairs of different effects that can be seen and whose cosine is at least so large, the nearest first."""
        found: dict[tuple[str, str], float] = {}
        for i, first in enumerate(self.effects):
            for j, second in enumerate(self.effects[:i]):
                size = abs(float(self.confusability[i, j]))
                if first != second and min(self.reach[i], self.reach[j]) >= VISIBLE and size >= least:
                    found[second, first] = max(size, found.get((second, first), 0.0))
        return sorted(((*pair, size) for pair, size in found.items()), key=lambda one: -one[2])

    @property
    def document(self) -> list[dict[str, object]]:
        """One entry a strength, ready for JSON."""
        return [
            {
                "effect": effect,
                "strength": strength,
                "concealment": float(hidden),
                "reach": float(reach),
                "shows_from": float(least) if np.isfinite(least) else None,
            }
            for effect, strength, hidden, reach, least in zip(
                self.effects, self.strengths, self.concealment, self.reach, self.shows_from, strict=True
            )
        ]


def identifiability(
    cases: TouchSet, material: GelMaterial, effects: Sequence[str] | None = None, errors: NumericalErrors | None = None
) -> Identifiability:
    """What trajectories as these could tell of effects, before any of them is measured.

    Parameters
    ----------
    cases : TouchSet
        Their measured wrenches only weigh the frames; those of a simulation, or zeros, serve as well.
    material : GelMaterial
    effects : names; all of the catalogue where ``None``

    Raises
    ------
    TactileDataError
        Too few trajectories.
    """
    cases.need_cases()
    white = WhitenedTouches.of(cases, errors)
    names, not_told = playable(white, effects)
    signatures = effect_signatures(white, material, names)
    return identifiability_of(nuisance(white, material), signatures, tuple(not_told), names)


def identifiability_of(
    metric: RandomEffects,
    signatures: Sequence[Signature],
    not_told: tuple[str, ...] = (),
    asked: Sequence[str] = (),
) -> Identifiability:
    """The same from signatures that are known already, of all effects that were ``asked`` for and left anything."""
    left_any = {one.effect for one in signatures}
    best: dict[Strength, tuple[float, float, Array]] = {}
    for one in signatures:
        left = np.einsum("nkp,nkp->p", one.field, metric.weigh(one.field))
        whole = np.einsum("nkp,nkp->p", one.field, one.field)
        for place, strength in enumerate(one.strengths):
            reach = float(np.sqrt(max(left[place], 0.0))) * abs(strength.end) / float(one.scales[place])
            hidden = 1.0 - float(np.clip(left[place] / whole[place], 0.0, 1.0))
            if strength not in best or reach > best[strength][0]:
                best[strength] = reach, hidden, one.field[:, :, place]
    fields = [field for _, _, field in best.values()]
    alike = cosines(metric, fields) if fields else np.zeros((0, 0))
    return Identifiability(
        tuple(best),
        np.array([hidden for _, hidden, _ in best.values()]),
        alike,
        np.array([reach for reach, _, _ in best.values()]),
        not_told,
        tuple(name for name in asked if name not in left_any),
    )
