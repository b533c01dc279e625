"""Effects on the trajectories of a store: which act on which, on what gel, and all that they depend on."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tactiledata.effects.simulate.setting import EffectSetting
from tactiledata.effects.touch.gel_variants import warped
from tactiledata.effects.touch.response import GelVariant
from tactiledata.effects.touch.touch import Touch
from tactiledata.errors import UsageError
from tactiledata.gel.contact.history import GelTouch
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.indenters.base import Indenter
from tactiledata.indenters.scaled import scaled
from tactiledata.replay.plan import NOMINAL, PlannedPad, PlannedTouch, ReplayPlan
from tactiledata.replay.store_facts import StoreFacts
from tactiledata.replay.store_motion import StoreMotion
from tactiledata.store.read.reader import Store

APART = 1e-9
"""s: frames of one moment are told apart by so much."""


@dataclass(frozen=True)
class EffectTouch:
    """A trajectory as effects see it.

    Parameters
    ----------
    touch : Touch
        Of the frames whose pose is known.
    known : (n,) bool
        Which of the trajectory's frames these are.
    settings : tuple of EffectSetting
        Those that act on it, in order.
    """

    touch: Touch
    known: NDArray[np.bool_]
    settings: tuple[EffectSetting, ...]


class ReplayEffects:
    """Effects that a store is replayed with.

    Parameters
    ----------
    store : Store
    plan : ReplayPlan
        Without effects.
    settings : sequence of EffectSetting
        None of them null, in order.

    Attributes
    ----------
    plan : ReplayPlan
        With the gels and indenters that they stand for.
    varies_gel, stiffens : bool
        Whether any gel is another than the nominal one; whether its law is.

    Raises
    ------
    UsageError
        One is restricted to a sensor, an indenter or a mounting that the store does not hold, or an indenter cannot be
        made larger.
    """

    def __init__(self, store: Store, plan: ReplayPlan, settings: Sequence[EffectSetting]) -> None:
        self._facts = StoreFacts(store, plan.touches)
        self._motion = StoreMotion(store)
        self._plain = {touch.uid: touch for touch in plan.touches}
        _need_places(settings, [self._places(touch) for touch in plan.touches])
        self._acting = {touch.uid: self._acting_on(touch, settings) for touch in plan.touches}
        pads: list[PlannedPad] = []
        touches = tuple(self._varied(touch, plan.pads, pads) for touch in plan.touches)
        self.plan = ReplayPlan(touches, tuple(pads))
        nominal = {pad.mesh.digest for pad in plan.pads}
        self.varies_gel = any(pad.mesh.digest not in nominal or pad.law != NOMINAL for pad in pads)
        self.stiffens = any(pad.law.c20 or pad.law.c30 for pad in pads)

    def _places(self, planned: PlannedTouch) -> dict[str, str]:
        return {
            "sensor": planned.sensor,
            "indenter_name": planned.indenter,
            "mount": self._facts.mount(planned),
        }

    def _acting_on(self, planned: PlannedTouch, settings: Sequence[EffectSetting]) -> tuple[EffectSetting, ...]:
        places = self._places(planned)
        return tuple(one for one in settings if all(places[name] == wanted for name, wanted in one.where.items()))

    def _varied(self, planned: PlannedTouch, known: Sequence[PlannedPad], pads: list[PlannedPad]) -> PlannedTouch:
        """The trajectory with the gel and the indenter that effects stand for; new pads are appended."""
        if planned.obstacle is not None:
            return planned
        variant = variant_of(self._acting[planned.uid])
        pad = _varied_pad(known[planned.pad], variant)
        keys = [(one.mesh.digest, one.law) for one in pads]
        if (pad.mesh.digest, pad.law) not in keys:
            keys.append((pad.mesh.digest, pad.law))
            pads.append(pad)
        assert planned.solid is not None
        solid = _resized(planned.solid, variant.indenter_scale, planned.indenter)
        return replace(planned, pad=keys.index((pad.mesh.digest, pad.law)), solid=solid)

    def touch(self, planned: PlannedTouch, played: GelTouch, material: GelMaterial) -> EffectTouch | None:
        """What effects see of one of the plan's trajectories; ``None`` where none acts, or no pose is known."""
        settings = self._acting[planned.uid]
        known: NDArray[np.bool_] = np.asarray(np.isfinite(played.poses).all(axis=(1, 2)))
        if not settings or not known.any():
            return None
        rows = np.arange(*planned.frames)[known]
        poses = played.poses[known]
        needs = {need for setting in settings for need in setting.member.needs}
        depth, contacts = (
            self._facts.earlier(self._plain[planned.uid], poses[:, :2, 3], rows)
            if needs & {"earlier_depth", "earlier_contacts"}
            else (None, None)
        )
        touch = Touch(
            np.maximum.accumulate(self._facts.seconds(rows)) + APART * np.arange(len(rows)),
            poses,
            played.indenter,
            material,
            self.plan.pads[planned.pad].geometry,
            planned.sensor,
            planned.indenter,
            self._facts.mount(planned),
            gravity=self._facts.gravity(planned, rows) if "gravity" in needs else None,
            joints=self._facts.joints(rows) if "joints" in needs else None,
            powered=self._facts.powered(planned, rows) if "powered" in needs else None,
            earlier_depth=depth,
            earlier_contacts=contacts,
            **self._motion.facts(planned, rows),
        )
        for setting in settings:
            _need_covariates(setting, touch, planned)
        return EffectTouch(touch, known, settings)


def variant_of(settings: Iterable[EffectSetting]) -> GelVariant:
    """The gel and the indenter that effects stand for."""
    variant = GelVariant()
    for setting in settings:
        variant = variant.together_with(setting.member.variant(setting.values))
    return variant


def _varied_pad(pad: PlannedPad, variant: GelVariant) -> PlannedPad:
    law = replace(variant, thickness=1.0, dome=0.0, indenter_scale=1.0)
    return replace(pad, mesh=warped(pad.mesh, variant), law=law)


def _resized(solid: Indenter, scale: float, name: str) -> Indenter:
    if scale == 1.0:
        return solid
    try:
        return scaled(solid, scale)
    except TypeError as error:
        found = f"indenter {name!r} cannot be made larger or smaller"
        raise UsageError(found, "a shape with sizes, or a mesh", "Leave radius_error out.") from error


def _need_places(settings: Sequence[EffectSetting], places: Sequence[dict[str, str]]) -> None:
    for setting in settings:
        for name, wanted in setting.where.items():
            held = sorted({place[name] for place in places})
            if wanted not in held:
                raise UsageError(
                    f"effect {setting.effect!r} acts on {name} {wanted!r} only, which this store does not hold",
                    f"one of {', '.join(held)}",
                    "These effects were found in another store: correct 'where', or take it out.",
                    effect=setting.effect,
                )


def _need_covariates(setting: EffectSetting, touch: Touch, planned: PlannedTouch) -> None:
    for need in setting.member.needs:
        if getattr(touch, need) is None:
            raise UsageError(
                f"effect {setting.effect!r} depends on {need!r}, which trajectory {planned.name!r} does not tell",
                f"recordings with {need!r}",
                "Leave the effect out, or restrict it with 'where'.",
                effect=setting.effect,
                covariate=need,
            )
