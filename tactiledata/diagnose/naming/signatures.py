"""What each effect would leave in the data: the whitened change of the wrench over one standard deviation of it."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import Array
from tactiledata.calibrate.bounds import Bounds, find_bounds
from tactiledata.diagnose.naming.metric import RandomEffects
from tactiledata.diagnose.naming.strength import Strength, set_at
from tactiledata.diagnose.touches.touch_case import Played
from tactiledata.diagnose.touches.whitened import WhitenedTouches
from tactiledata.effects import EFFECTS
from tactiledata.effects.base import Effect
from tactiledata.effects.parameter import Parameter
from tactiledata.effects.simulate.setting import EffectSetting
from tactiledata.errors import UsageError
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.nuisance.offsets import PRIOR

OWN_STEP = 2e-5
"""m, of the differences over a trajectory's offset."""
SHARE = 0.5
"""Of a strength's standard deviation, of the differences over it."""
PARTS = (1.0, 0.25, 0.05)
"""Of that, where springs as soft as the whole find no balance with the gel."""
FAINT = 1e-6
"""Norm of a signature per standard deviation, in noise: less is nothing."""
MATERIAL = ("E", "nu", "mu")


@dataclass(frozen=True)
class Signature:
    """An effect at its null, at one choice of its shapes.

    Parameters
    ----------
    effect : str
    shapes : dict, parameter -> value
    strengths : the p that leave anything
    scales : (p,)
        Standard deviations of their priors.
    one_sided : (p,) bool
        Whether a strength cannot be negative.
    looked_at : (p,)
        Standard deviations at which the change was taken.
    field : (N, 6, p)
        Whitened change over one standard deviation.
    """

    effect: str
    shapes: dict[str, float]
    strengths: tuple[Strength, ...]
    scales: Array
    one_sided: NDArray[np.bool_]
    looked_at: Array
    field: Array

    @property
    def label(self) -> str:
        """For tables: ``"relaxation time=3"``."""
        return " ".join([self.effect, *(f"{name}={value:g}" for name, value in self.shapes.items())])

    def at(self, strengths: Array) -> tuple[EffectSetting, ...]:
        """The effect with strengths (p,) in standard deviations, inside their bounds: a setting for each place."""
        values: dict[str, dict[str, float]] = {}
        for one, strength, scale in zip(self.strengths, strengths, self.scales, strict=True):
            value = float(np.clip(strength * scale, *one.parameter.bounds))
            values.setdefault(one.place, {})[one.name] = value
        return tuple(set_at(self.effect, {**self.shapes, **found}, place) for place, found in values.items())


def shape_grids(effect: Effect) -> Iterator[dict[str, float]]:
    """Every combination of the values of its shapes that a screen tries."""
    tried = [one for one in effect.parameters if one.null is None and len(one.grid) > 1]
    for values in itertools.product(*(one.grid for one in tried)):
        yield dict(zip((one.name for one in tried), values, strict=True))


def strengths_of(effect: Effect) -> tuple[Parameter, ...]:
    """Parameters that make it strong."""
    return tuple(one for one in effect.parameters if one.null is not None)


def looks(effect: Effect) -> int:
    """At how many sizes its signature is taken: several where it acts from a threshold on."""
    return max(1, *(len(one.grid) for one in strengths_of(effect)))


def deviation_of(parameter: Parameter) -> float:
    """Standard deviation of a strength's prior."""
    return parameter.deviation or (parameter.plausible[1] - parameter.plausible[0]) / 4.0


def playable(cases: WhitenedTouches, names: Iterable[str] | None = None) -> tuple[list[str], list[str]]:
    """Names of effects that the touches tell enough for, and of those that they do not.

    Parameters
    ----------
    names : of candidates; all of the catalogue where ``None``
    """
    asked = list(EFFECTS) if names is None else list(names)
    touches = [case.touch for case in cases.touch_set.touches]
    told = [
        all(getattr(touch, need) is not None for need in EFFECTS[name].needs for touch in touches) for name in asked
    ]
    return (
        [name for name, is_told in zip(asked, told, strict=True) if is_told],
        [name for name, is_told in zip(asked, told, strict=True) if not is_told],
    )


def effect_signatures(
    cases: WhitenedTouches,
    material: GelMaterial,
    names: Iterable[str],
    settings: Sequence[EffectSetting] = (),
    offsets: Array | None = None,
) -> list[Signature]:
    """Signatures of effects beside others that are set already.

    Strengths that leave nothing in these touches are left out, and effects without any.

    Parameters
    ----------
    offsets : (t,) m
        Of the trajectories: what slides, and what is beyond a limit, depends on them.
    """
    before = cases.touch_set.played(material, settings, offsets)
    found = []
    for name in names:
        member: Effect = EFFECTS[name]()
        known: dict[tuple[object, ...], Array] = {}
        for shapes, look in itertools.product(shape_grids(member), range(looks(member))):
            fields, kept = [], []
            for place in places_of(cases, member):
                for parameter in strengths_of(member):
                    share = _looked_at(parameter, look)
                    key = (*shapes.values(), place, parameter.name, share)
                    if key not in known:
                        # only what acts from a threshold on is looked at in several sizes
                        values = {**shapes, parameter.name: share * deviation_of(parameter)}
                        settings_there = [*settings, set_at(name, values, place)]
                        changed = _playable_change(cases, material, settings_there, parameter.name, offsets, before)
                        known[key] = cases.whiten(changed) / share
                    field = known[key]
                    if np.linalg.norm(field) > FAINT * np.sqrt(field.size):
                        fields.append(field)
                        kept.append(Strength(name, parameter.name, place))
            if kept:
                found.append(
                    Signature(
                        name,
                        shapes,
                        tuple(kept),
                        np.array([deviation_of(one.parameter) for one in kept]),
                        np.array([one.parameter.bounds[0] >= 0.0 for one in kept]),
                        np.array([_looked_at(one.parameter, look) for one in kept]),
                        np.stack(fields, axis=2),
                    )
                )
    return found


def _looked_at(parameter: Parameter, look: int) -> float:
    """In standard deviations."""
    return parameter.grid[look] / deviation_of(parameter) if parameter.grid else SHARE


def places_of(cases: WhitenedTouches, effect: Effect) -> tuple[str, ...]:
    """Where an effect has strengths of its own: one empty name where it is the same everywhere."""
    if not effect.varies_by:
        return ("",)
    names = {getattr(case.touch, effect.varies_by) for case in cases.touch_set.touches}
    return tuple(sorted(names)) if all(names) else ("",)


def _playable_change(
    cases: WhitenedTouches,
    material: GelMaterial,
    settings: list[EffectSetting],
    strength: str,
    offsets: Array | None,
    before: Played,
) -> Array:
    """What the last setting changes (N, 6), in proportion from a smaller strength where gel and springs find no balance
    at the whole; nothing where they find none at all, as what cannot be played is no candidate.
    """
    last = settings[-1]
    for part in PARTS:
        values = {**last.values, strength: part * last.values[strength]}
        smaller = EffectSetting(last.effect, values, last.where)
        try:
            return _change(cases, material, [*settings[:-1], smaller], offsets, before) / part
        except UsageError:
            continue
    return np.zeros_like(before.wrench)


def _change(
    cases: WhitenedTouches, material: GelMaterial, settings: list[EffectSetting], offsets: Array | None, before: Played
) -> Array:
    """What the last setting changes (N, 6); without offsets where, with them, gel and springs find no balance."""
    last = settings[-1]
    try:
        return cases.touch_set.play_where(last, before, material, settings, offsets) - before.wrench
    except UsageError:
        if offsets is None:
            raise
        without = cases.touch_set.played(material, settings[:-1])
        return cases.touch_set.play_where(last, without, material, settings) - without.wrench


def material_steps(bounds: Bounds) -> Array:
    """Steps of ln E, nu and mu for differences."""
    return np.array([1e-2, 0.02 * float(bounds.span[1]), 0.01])


def material_fields(
    cases: WhitenedTouches,
    material: GelMaterial,
    settings: Sequence[EffectSetting],
    offsets: Array | None,
    before: Played,
) -> Array:
    """Whitened change (N, 6, 3) over ln E, nu and mu."""
    bounds = find_bounds("wide")
    steps = material_steps(bounds)
    here = np.array([np.log(material.youngs_modulus), material.poisson_ratio, material.friction])
    fields = []
    for place, step in enumerate(steps):
        inward = -step if here[1] + step > bounds.high[1] and place == 1 else step
        there = here.copy()
        there[place] += inward
        moved = GelMaterial(float(np.exp(there[0])), float(there[1]), float(there[2]))
        changed = cases.touch_set.play(moved, settings, offsets, before) - before.wrench
        fields.append(cases.whiten(changed) / inward)
    return np.stack(fields, axis=2)


def own_field(
    cases: WhitenedTouches, material: GelMaterial, settings: Sequence[EffectSetting], offsets: Array, before: Played
) -> Array:
    """Whitened change (N, 6) over one standard deviation of each trajectory's offset."""
    moved = cases.touch_set.play(material, settings, offsets + OWN_STEP, before)
    return cases.whiten(moved - before.wrench) * (PRIOR / OWN_STEP)


def material_precision() -> Array:
    """Precision (3,) of the priors of ln E, nu and mu: nu is known to lie within its bounds, the others may be any."""
    half = 0.5 * float(find_bounds("wide").span[1])
    return np.array([0.0, half**-2, 0.0])


def nuisance(cases: WhitenedTouches, material: GelMaterial) -> RandomEffects:
    """What a refit of the plain simulation and its numerical errors could imitate."""
    before = cases.touch_set.played(material, [])
    own = own_field(cases, material, [], np.zeros(len(cases.starts)), before)
    errors = cases.simulation_error_fields(material)
    shared = np.concatenate([material_fields(cases, material, [], None, before), errors], axis=2)
    precision = np.concatenate([material_precision(), np.ones(errors.shape[2])])
    return RandomEffects(own, shared, precision, cases.starts)
