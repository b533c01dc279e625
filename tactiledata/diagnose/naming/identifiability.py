"""Which effects trajectories could show at all: what a calibration hides, and which effects look alike.

Measured forces are not needed. All numbers are linearised about the plain simulation, and therefore too small for
limits and dead bands, which have no influence up to a threshold.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.naming.metric import RandomEffects, cosines
from tactiledata.diagnose.naming.signatures import (
    Signature,
    effect_signatures,
    material_fields,
    material_precision,
    own_field,
    playable,
)
from tactiledata.diagnose.naming.strength import Strength
from tactiledata.diagnose.naming.thresholds import DEFAULT_THRESHOLDS, DecisionThresholds
from tactiledata.diagnose.touches.simulation_errors import NumericalErrors
from tactiledata.diagnose.touches.touch_case import TouchSet
from tactiledata.diagnose.touches.whitened import WhitenedTouches
from tactiledata.gel.elasticity.material import GelMaterial


@dataclass(frozen=True)
class Identifiability:
    """What trajectories can show of k strengths of effects, each at its default shapes or the most visible of its grid.

    Parameters
    ----------
    numbers : tuple of k Strength
        The strengths that change anything.
    concealment : (k,)
        Share of the squared change that E, nu, mu, contact offsets, zeros and errors of the simulation can imitate: 0
        is fully visible, 1 is hidden.
    confusability : (k, k)
        Cosines of what is left of the changes: at 1, no data of this kind can tell two strengths apart.
    reach : (k,)
        Signal-to-noise ratio in these trajectories, after concealment, at the far end of the plausible range.
    visible : (k,)
        Signal-to-noise ratio, in the same sense as ``reach``, from which the effect of each strength can be claimed.
    thresholds : DecisionThresholds
        The thresholds for these trajectories.
    not_told : tuple of str
        Effects that depend on covariates which the touches do not have.
    without_trace : tuple of str
        Effects that change nothing in these trajectories.
    """

    numbers: tuple[Strength, ...]
    concealment: Array
    confusability: Array
    reach: Array
    visible: Array
    not_told: tuple[str, ...]
    without_trace: tuple[str, ...] = ()

    @property
    def effects(self) -> tuple[str, ...]:
        """Effect of each strength."""
        return tuple(strength.effect for strength in self.numbers)

    @property
    def strengths(self) -> tuple[str, ...]:
        """Each strength in words: ``"x of ball3"`` where the effect has numbers of its own for each place."""
        return tuple(strength.label for strength in self.numbers)

    @property
    def ends(self) -> Array:
        """Absolute values (k,) of the far ends of the plausible ranges, in the parameters' units."""
        return np.array([abs(strength.end) for strength in self.numbers])

    @property
    def shows_from(self) -> Array:
        """Sizes (k,) from which a strength can be claimed, in the parameters' units; infinite where none can."""
        return np.divide(
            self.ends * self.visible, self.reach, out=np.full(len(self.reach), np.inf), where=self.reach > 0
        )

    @property
    def undetectable(self) -> tuple[str, ...]:
        """Effects that could not be claimed in these trajectories at any plausible strength."""
        seen = {name for name, is_seen in zip(self.effects, self.reach >= self.visible, strict=True) if is_seen}
        return (*(name for name in dict.fromkeys(self.effects) if name not in seen), *self.without_trace)

    @property
    def undetectable_numbers(self) -> tuple[Strength, ...]:
        """Strengths of detectable effects that could not be claimed by themselves at any plausible size, at any place.

        Of a strength with several places, the first one stands for all.
        """
        unseen = set(self.undetectable)
        is_seen: dict[tuple[str, str], bool] = {}
        first: dict[tuple[str, str], Strength] = {}
        for strength, reaches in zip(self.numbers, self.reach >= self.visible, strict=True):
            key = strength.effect, strength.name
            first.setdefault(key, strength)
            is_seen[key] = is_seen.get(key, False) or bool(reaches)
        return tuple(first[key] for key, seen in is_seen.items() if not seen and key[0] not in unseen)

    def look_alikes(self, least: float = 0.95) -> list[tuple[str, str, float]]:
        """Return pairs of detectable effects with their largest absolute cosine, at least ``least``, largest first."""
        pairs: dict[tuple[str, str], float] = {}
        for i, first in enumerate(self.effects):
            for j, second in enumerate(self.effects[:i]):
                size = abs(float(self.confusability[i, j]))
                are_seen = self.reach[i] >= self.visible[i] and self.reach[j] >= self.visible[j]
                if first != second and are_seen and size >= least:
                    pairs[second, first] = max(size, pairs.get((second, first), 0.0))
        return sorted(((*pair, size) for pair, size in pairs.items()), key=lambda alike: -alike[2])

    @property
    def document(self) -> list[dict[str, object]]:
        """One entry for each strength, ready for JSON."""
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
    touch_set: TouchSet,
    material: GelMaterial,
    effects: Sequence[str] | None = None,
    errors: NumericalErrors | None = None,
) -> Identifiability:
    """Return what trajectories such as these could show of effects, before any of them is measured.

    Parameters
    ----------
    touch_set : TouchSet
        Trajectories, and the simulation without effects. Measured wrenches determine the weights of the frames only:
        simulated ones, or zeros, can stand in their place.
    material : GelMaterial
        Material of the gel.
    effects : sequence of str, optional
        Names of effects; all of the catalogue where ``None``.
    errors : NumericalErrors, optional
        Standard deviations of the simulation's own errors; the defaults where ``None``.

    Raises
    ------
    TactileDataError
        Too few trajectories, or too few frames in one of them.
    """
    touch_set.need_touches()
    whitened = WhitenedTouches.of(touch_set, errors)
    names, not_told = playable(whitened, effects)
    signatures = effect_signatures(whitened, material, names)
    thresholds = DEFAULT_THRESHOLDS.for_data(len(whitened.starts), whitened.precision)
    return identifiability_of(nuisance(whitened, material), signatures, thresholds, tuple(not_told), names)


def identifiability_of(
    metric: RandomEffects,
    signatures: Sequence[Signature],
    thresholds: DecisionThresholds,
    not_told: tuple[str, ...] = (),
    names: Sequence[str] = (),
) -> Identifiability:
    """Return what trajectories could show of effects, from signatures that are known already.

    Parameters
    ----------
    metric : RandomEffects
        Metric of the plain simulation.
    signatures : sequence of Signature
        Of each strength, the shapes with the largest reach are kept.
    thresholds : DecisionThresholds
        The thresholds for these trajectories.
    not_told : tuple of str
        Effects that depend on covariates which the touches do not have.
    names : sequence of str
        All effects that were tried: those without a signature change nothing.
    """
    with_signature = {signature.effect for signature in signatures}
    best: dict[Strength, tuple[float, float, Array]] = {}
    for signature in signatures:
        left = np.einsum("nkp,nkp->p", signature.field, metric.weigh(signature.field))
        whole = np.einsum("nkp,nkp->p", signature.field, signature.field)
        for index, strength in enumerate(signature.strengths):
            reach = float(np.sqrt(max(left[index], 0.0))) * abs(strength.end) / float(signature.scales[index])
            hidden = 1.0 - float(np.clip(left[index] / whole[index], 0.0, 1.0))
            if strength not in best or reach > best[strength][0]:
                best[strength] = reach, hidden, signature.field[:, :, index]
    fields = [field for _, _, field in best.values()]
    alike = cosines(metric, fields) if fields else np.zeros((0, 0))
    return Identifiability(
        tuple(best),
        np.array([hidden for _, hidden, _ in best.values()]),
        alike,
        np.array([reach for reach, _, _ in best.values()]),
        np.array([thresholds.visible(strength.effect) for strength in best]),
        not_told,
        tuple(name for name in names if name not in with_signature),
    )


def nuisance(whitened: WhitenedTouches, material: GelMaterial) -> RandomEffects:
    """Return the metric of the plain simulation at a material: what a refit or its errors imitate counts as 0."""
    before = whitened.touch_set.played(material, [])
    none = np.zeros(0)
    own = own_field(whitened, material, [], np.zeros(len(whitened.starts)), before, none)
    errors = whitened.simulation_error_fields(material)
    shared = np.concatenate([material_fields(whitened, material, [], None, before, none), errors], axis=2)
    precision = np.concatenate([material_precision(), np.ones(errors.shape[2])])
    return RandomEffects(own, shared, precision, whitened.starts)
