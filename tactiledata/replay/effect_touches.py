"""Effects on the trajectories of a store: which act on which, with what gel and indenter, and from which inputs."""

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
from tactiledata.replay.opened import OpenedStore
from tactiledata.replay.plan import NOMINAL, PlannedPad, PlannedTouch, ReplayPlan
from tactiledata.replay.store_facts import StoreFacts
from tactiledata.replay.store_motion import StoreMotion
from tactiledata.store.read.reader import Store

APART = 1e-9
"""Time, s, added per frame, so that frames with one time stamp stay in order."""


@dataclass(frozen=True)
class EffectTouch:
    """Inputs of the effects on one trajectory.

    Parameters
    ----------
    touch : Touch
        Poses, times and covariates of the frames whose pose is known.
    known : (n,) bool
        Mask of these frames among all n of the trajectory.
    settings : tuple of EffectSetting
        Effects that act on the trajectory, in order.
    """

    touch: Touch
    known: NDArray[np.bool_]
    settings: tuple[EffectSetting, ...]


class ReplayEffects:
    """Effects with which a store is replayed, and the plan with the gels and indenters that they imply.

    Parameters
    ----------
    store : Store
        Gives the inputs of effects.
    plan : ReplayPlan
        Plan without effects.
    settings : sequence of EffectSetting
        Effects that are not null, in the order in which they act.

    Attributes
    ----------
    plan : ReplayPlan
        Plan with the gels and indenters that the effects imply.
    varies_gel, stiffens : bool
        Whether any gel differs from the nominal one, and whether any has stiffening terms.

    Raises
    ------
    UsageError
        An effect is restricted to a sensor, an indenter or a mounting that the store does not hold, or an indenter
        cannot be scaled.
    """

    def __init__(self, store: Store, plan: ReplayPlan, settings: Sequence[EffectSetting]) -> None:
        opened = OpenedStore(store, plan)
        self._facts, self._motion = StoreFacts(opened), StoreMotion(opened)
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
        """Sensor, indenter and mounting of a trajectory, to which effects can be restricted."""
        return {
            "sensor": planned.sensor,
            "indenter_name": planned.indenter,
            "mount": self._facts.mount(planned),
        }

    def _acting_on(self, planned: PlannedTouch, settings: Sequence[EffectSetting]) -> tuple[EffectSetting, ...]:
        """Effects whose restrictions a trajectory meets."""
        places = self._places(planned)
        return tuple(
            setting for setting in settings if all(places[name] == value for name, value in setting.where.items())
        )

    def _varied(
        self, planned: PlannedTouch, nominal_pads: Sequence[PlannedPad], pads: list[PlannedPad]
    ) -> PlannedTouch:
        """Trajectory with the gel and the indenter that its effects imply; a new pad is appended to ``pads``."""
        if planned.obstacle is not None:
            return planned
        variant = variant_of(self._acting[planned.uid])
        pad = _varied_pad(nominal_pads[planned.pad], variant)
        keys = [(listed_pad.mesh.digest, listed_pad.law) for listed_pad in pads]
        if (pad.mesh.digest, pad.law) not in keys:
            keys.append((pad.mesh.digest, pad.law))
            pads.append(pad)
        assert planned.solid is not None
        solid = _resized(planned.solid, variant.indenter_scale, planned.indenter)
        return replace(planned, pad=keys.index((pad.mesh.digest, pad.law)), solid=solid)

    def touch(self, planned: PlannedTouch, played: GelTouch, material: GelMaterial) -> EffectTouch | None:
        """Return the inputs of the effects on a trajectory, or ``None`` where none acts or no pose is known.

        Parameters
        ----------
        planned : PlannedTouch
            A trajectory of ``plan``.
        played : GelTouch
            Its poses and indenter.
        material : GelMaterial
            Nominal material of the gel.

        Raises
        ------
        UsageError
            The store lacks what an effect depends on.
        """
        settings = self._acting[planned.uid]
        is_known: NDArray[np.bool_] = np.asarray(np.isfinite(played.poses).all(axis=(1, 2)))
        if not settings or not is_known.any():
            return None
        rows = np.arange(*planned.frames)[is_known]
        poses = played.poses[is_known]
        # read from the store only what these effects depend on
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
        return EffectTouch(touch, is_known, settings)


def variant_of(settings: Iterable[EffectSetting]) -> GelVariant:
    """Return the changes of gel and indenter that effects imply together."""
    variant = GelVariant()
    for setting in settings:
        variant = variant.together_with(setting.member.variant(setting.values))
    return variant


def _varied_pad(pad: PlannedPad, variant: GelVariant) -> PlannedPad:
    """Pad with the mesh warped to a variant's thickness and dome; other changes stay in its law."""
    law = replace(variant, thickness=1.0, dome=0.0, indenter_scale=1.0)
    return replace(pad, mesh=warped(pad.mesh, variant), law=law)


def _resized(solid: Indenter, scale: float, name: str) -> Indenter:
    """Indenter scaled by a factor; refuse a shape that has no sizes."""
    if scale == 1.0:
        return solid
    try:
        return scaled(solid, scale)
    except TypeError as error:
        refused = f"indenter {name!r} cannot be made larger or smaller"
        raise UsageError(refused, "a shape with sizes, or a mesh", "Leave radius_error out.") from error


def _need_places(settings: Sequence[EffectSetting], places: Sequence[dict[str, str]]) -> None:
    """Refuse effects restricted to a sensor, indenter or mounting that the store does not hold."""
    for setting in settings:
        for name, value in setting.where.items():
            present = sorted({place[name] for place in places})
            if value not in present:
                raise UsageError(
                    f"effect {setting.effect!r} acts on {name} {value!r} only, which this store does not hold",
                    f"one of {', '.join(present)}",
                    "The effects come from another store: correct 'where', or remove it.",
                    effect=setting.effect,
                )


def _need_covariates(setting: EffectSetting, touch: Touch, planned: PlannedTouch) -> None:
    """Refuse an effect that depends on a covariate which the trajectory lacks."""
    for need in setting.member.needs:
        if getattr(touch, need) is None:
            raise UsageError(
                f"effect {setting.effect!r} depends on {need!r}, which trajectory {planned.name!r} does not hold",
                f"recordings with {need!r}",
                "Leave the effect out, or restrict it with 'where'.",
                effect=setting.effect,
                covariate=need,
            )
