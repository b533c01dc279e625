"""The signature of each effect: the whitened change of the wrenches over one prior standard deviation of a strength."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array, Mask
from tactiledata.calibrate.bounds import Bounds, find_bounds
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
"""Step of the finite differences over a trajectory's contact offset, in metres."""
SHARE = 0.5
"""Step of the finite differences over a strength, in standard deviations of its prior."""
PARTS = (1.0, 0.25, 0.05)
"""Shares of that step that are tried in turn: soft springs may find no balance with the gel at the whole step."""
FAINT = 1e-6
"""Root mean square of a signature, in units of the noise, below which the strength counts as changing nothing."""
POISSON_RATIO = "nu"
"""Symbol of Poisson's ratio."""
MATERIAL = ("E", POISSON_RATIO, "mu")
"""Symbols of Young's modulus, Poisson's ratio and the friction coefficient, the first entries of a model's vector."""


@dataclass(frozen=True)
class Signature:
    """What an effect changes about its null, at one choice of its shape parameters.

    Parameters
    ----------
    effect : str
        Name in the catalogue.
    shapes : dict, parameter -> value
        Values of the shape parameters.
    strengths : tuple of p Strength
        Those that change anything in these touches.
    scales : (p,)
        Standard deviations of their priors, in the parameters' units.
    one_sided : (p,) bool
        Whether a strength cannot be negative.
    step_sizes : (p,)
        Size of the finite difference, in standard deviations.
    field : (N, 6, p)
        Whitened change over one standard deviation of each strength.
    """

    effect: str
    shapes: dict[str, float]
    strengths: tuple[Strength, ...]
    scales: Array
    one_sided: Mask
    step_sizes: Array
    field: Array

    @property
    def label(self) -> str:
        """Effect and shapes, for tables: ``"relaxation time=3"``."""
        return " ".join([self.effect, *(f"{name}={value:g}" for name, value in self.shapes.items())])

    def at(self, strengths: Array) -> tuple[EffectSetting, ...]:
        """Return the effect with strengths (p,) in standard deviations, clipped to their bounds: a setting a place."""
        values: dict[str, dict[str, float]] = {}
        for strength, size, scale in zip(self.strengths, strengths, self.scales, strict=True):
            value = float(np.clip(size * scale, *strength.parameter.bounds))
            values.setdefault(strength.place, {})[strength.name] = value
        return tuple(set_at(self.effect, {**self.shapes, **at_place}, place) for place, at_place in values.items())


def shape_grids(effect: Effect) -> Iterator[dict[str, float]]:
    """Yield every combination of grid values of an effect's shape parameters, which a screen tries.

    A shape with fewer than two grid values is left out and keeps its default; where none is left, the only combination
    is an empty dict. Values are in the parameters' units.
    """
    shapes = [parameter for parameter in effect.parameters if parameter.null is None and len(parameter.grid) > 1]
    for values in itertools.product(*(shape.grid for shape in shapes)):
        yield dict(zip((shape.name for shape in shapes), values, strict=True))


def strengths_of(effect: Effect) -> tuple[Parameter, ...]:
    """Return the strengths of an effect: its parameters with a null value, at which the effect is absent.

    Its other parameters are shapes, such as a time constant: they say in which form the effect acts.
    """
    return tuple(parameter for parameter in effect.parameters if parameter.null is not None)


def size_count(effect: Effect) -> int:
    """Return at how many sizes a signature is taken: several for an effect that acts from a threshold on, else one."""
    return max(1, *(len(parameter.grid) for parameter in strengths_of(effect)))


def deviation_of(parameter: Parameter) -> float:
    """Return a strength's prior standard deviation, in its unit: as declared, or a quarter of its plausible range."""
    return parameter.deviation or (parameter.plausible[1] - parameter.plausible[0]) / 4.0


def playable(whitened: WhitenedTouches, names: Iterable[str] | None = None) -> tuple[list[str], list[str]]:
    """Return the names of the effects that can be tried in these touches, and of those that cannot.

    An effect can be tried where every touch states what the effect needs (`Effect.needs`), such as joint angles. Both
    lists have the order of the candidates.

    Parameters
    ----------
    whitened : WhitenedTouches
        Trajectories.
    names : iterable of str, optional
        Names of candidate effects; all of the catalogue where ``None``.
    """
    candidates = list(EFFECTS) if names is None else list(names)
    touches = [case.touch for case in whitened.touch_set.touches]
    has_covariates = [
        all(getattr(touch, need) is not None for need in EFFECTS[name].needs for touch in touches)
        for name in candidates
    ]
    return (
        [name for name, has_all in zip(candidates, has_covariates, strict=True) if has_all],
        [name for name, has_all in zip(candidates, has_covariates, strict=True) if not has_all],
    )


def effect_signatures(
    whitened: WhitenedTouches,
    material: GelMaterial,
    names: Iterable[str],
    settings: Sequence[EffectSetting] = (),
    offsets: Array | None = None,
) -> list[Signature]:
    """Return signatures of effects beside effects that are set already: one for each choice of shapes and sizes.

    Strengths that change nothing in these touches are left out, and so are effects without any other.

    Parameters
    ----------
    whitened : WhitenedTouches
        Trajectories.
    material : GelMaterial
        Material of the gel in the simulation.
    names : iterable of str
        Names of effects.
    settings : sequence of EffectSetting
        Effects that are set already.
    offsets : (t,) m, optional
        Contact offset of each trajectory. It matters where a contact is about to slide or a limit is about to act.
    """
    before = whitened.touch_set.played(material, settings, offsets)
    signatures = []
    for name in names:
        member: Effect = EFFECTS[name]()
        known: dict[tuple[object, ...], Array] = {}
        for shapes, size_number in itertools.product(shape_grids(member), range(size_count(member))):
            # the field of every strength at every place, each played once
            fields, kept = [], []
            for place in places_of(whitened, member):
                for parameter in strengths_of(member):
                    share = _step_size(parameter, size_number)
                    key = (*shapes.values(), place, parameter.name, share)
                    if key not in known:
                        # only an effect that acts from a threshold on is taken at several sizes
                        values = {**shapes, parameter.name: share * deviation_of(parameter)}
                        settings_there = [*settings, set_at(name, values, place)]
                        changed = _playable_change(whitened, material, settings_there, parameter.name, offsets, before)
                        known[key] = whitened.whiten(changed) / share
                    field = known[key]
                    if np.linalg.norm(field) > FAINT * np.sqrt(field.size):
                        fields.append(field)
                        kept.append(Strength(name, parameter.name, place))
            if kept:
                signatures.append(
                    Signature(
                        name,
                        shapes,
                        tuple(kept),
                        np.array([deviation_of(strength.parameter) for strength in kept]),
                        np.array([strength.parameter.bounds[0] >= 0.0 for strength in kept]),
                        np.array([_step_size(strength.parameter, size_number) for strength in kept]),
                        np.stack(fields, axis=2),
                    )
                )
    return signatures


def _step_size(parameter: Parameter, size_number: int) -> float:
    """Size of the finite difference over a strength, in standard deviations of its prior."""
    return parameter.grid[size_number] / deviation_of(parameter) if parameter.grid else SHARE


def places_of(whitened: WhitenedTouches, effect: Effect) -> tuple[str, ...]:
    """Return the places where an effect has strengths of its own; one empty name where the touches share them.

    They are shared as well where some touch does not name its place.
    """
    if not effect.varies_by:
        return ("",)
    names = {getattr(case.touch, effect.varies_by) for case in whitened.touch_set.touches}
    return tuple(sorted(names)) if all(names) else ("",)


def _playable_change(
    whitened: WhitenedTouches,
    material: GelMaterial,
    settings: list[EffectSetting],
    strength: str,
    offsets: Array | None,
    before: Played,
) -> Array:
    """Change of the wrench (N, 6), in N and N m, by the last setting.

    Where gel and springs find no balance at the whole strength, it is scaled up from a smaller one; 0 where they find
    none at all, as an effect that cannot be played is no candidate.

    Parameters
    ----------
    settings : list of EffectSetting
        All effects, the one in question last.
    strength : str
        Parameter of the last setting that is made smaller.
    offsets : (t,) m, optional
        Contact offset of each trajectory.
    before : Played
        The trajectories without the last setting.
    """
    last = settings[-1]
    for part in PARTS:
        values = {**last.values, strength: part * last.values[strength]}
        smaller = EffectSetting(last.effect, values, last.where)
        try:
            return _change(whitened, material, [*settings[:-1], smaller], offsets, before) / part
        except UsageError:
            continue
    return np.zeros_like(before.wrench)


def _change(
    whitened: WhitenedTouches,
    material: GelMaterial,
    settings: list[EffectSetting],
    offsets: Array | None,
    before: Played,
) -> Array:
    """Change of the wrench (N, 6) by the last setting; without contact offsets where there is no balance with them."""
    last = settings[-1]
    try:
        return whitened.touch_set.simulate_where(last, before, material, settings, offsets).wrench - before.wrench
    except UsageError:
        if offsets is None:
            raise
        without = whitened.touch_set.played(material, settings[:-1])
        return whitened.touch_set.simulate_where(last, without, material, settings).wrench - without.wrench


def material_steps(bounds: Bounds) -> Array:
    """Return the steps (3,) of the finite differences over ln E, nu and mu."""
    return np.array([1e-2, 0.02 * float(bounds.span[1]), 0.01])


def material_fields(
    whitened: WhitenedTouches,
    material: GelMaterial,
    settings: Sequence[EffectSetting],
    offsets: Array | None,
    before: Played,
    errors: Array,
) -> Array:
    """Return the whitened change (N, 6, 3) over ln E, nu and mu.

    Parameters
    ----------
    whitened : WhitenedTouches
        Trajectories.
    material : GelMaterial
        Material about which the differences are taken.
    settings : sequence of EffectSetting
        Effects in the simulation.
    offsets : (t,) m, optional
        Contact offset of each trajectory.
    before : Played
        The trajectories as played with all of these.
    errors : (e,)
        Errors of the simulation, which are shares of the wrenches; empty where there are none.
    """
    bounds = find_bounds("wide")
    erred = whitened.erred(before, errors)
    steps = material_steps(bounds)
    here = np.array([np.log(material.youngs_modulus), material.poisson_ratio, material.friction])
    fields = []
    for entry, step in enumerate(steps):
        # nu stays below its upper bound, near which the gel is incompressible
        inward = -step if here[1] + step > bounds.high[1] and entry == 1 else step
        there = here.copy()
        there[entry] += inward
        moved = GelMaterial(float(np.exp(there[0])), float(there[1]), float(there[2]))
        changed = whitened.erred(whitened.touch_set.simulate(moved, settings, offsets, before), errors)
        fields.append(whitened.whiten(changed - erred) / inward)
    return np.stack(fields, axis=2)


def own_field(
    whitened: WhitenedTouches,
    material: GelMaterial,
    settings: Sequence[EffectSetting],
    offsets: Array,
    before: Played,
    errors: Array,
) -> Array:
    """Return the whitened change (N, 6) over one prior standard deviation of each trajectory's contact offset.

    Parameters
    ----------
    whitened : WhitenedTouches
        Trajectories.
    material : GelMaterial
        Material of the gel.
    settings : sequence of EffectSetting
        Effects in the simulation.
    offsets : (t,) m
        Contact offsets about which the difference is taken.
    before : Played
        The trajectories as played with all of these.
    errors : (e,)
        Errors of the simulation; empty where there are none.
    """
    moved = whitened.touch_set.simulate(material, settings, offsets + OWN_STEP, before)
    return whitened.whiten(whitened.erred(moved, errors) - whitened.erred(before, errors)) * (PRIOR / OWN_STEP)


def material_precision() -> Array:
    """Return the inverse variances (3,) of the priors of ln E, nu and mu; 0 for ln E and mu, which have no prior.

    The prior standard deviation of nu is half the width of its bounds.
    """
    half = 0.5 * float(find_bounds("wide").span[1])
    return np.array([0.0, half**-2, 0.0])
