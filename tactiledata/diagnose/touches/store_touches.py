"""The trajectories of a store that a diagnosis can use, with covariates and all plays of the gel that effects need."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tactiledata.arrays import Array, Mask
from tactiledata.calibrate.bounds import find_bounds
from tactiledata.calibrate.gent import youngs_modulus_of_shore_a
from tactiledata.calibrate.measured import Measured, read_measured
from tactiledata.calibrate.options import CalibrationOptions
from tactiledata.calibrate.plays.estimated_plays import Estimates
from tactiledata.calibrate.touches import MeasuredTouch
from tactiledata.compute import make_scheduler
from tactiledata.compute.base import Scheduler
from tactiledata.contract.progress import Progress, no_progress
from tactiledata.contract.wording import all_left_out
from tactiledata.diagnose.touches.grid_answer import TouchPlays
from tactiledata.diagnose.touches.play_grid import play_touches
from tactiledata.diagnose.touches.played_response import PlayedFamily
from tactiledata.diagnose.touches.rest_means import FrameWrenches, means_at_rest, rest_spans
from tactiledata.diagnose.touches.touch_case import FEWEST_CASES, FEWEST_FRAMES, TouchCase, TouchSet
from tactiledata.diagnose.touches.variant_plays import design_variants, variants_of
from tactiledata.effects import EFFECTS
from tactiledata.effects.touch.moved_until import moved_until
from tactiledata.effects.touch.response import GelVariant
from tactiledata.effects.touch.touch import Touch
from tactiledata.errors import TactileDataError
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.nuisance.noise import WrenchNoise
from tactiledata.replay.opened import OpenedStore
from tactiledata.replay.plan import PlannedTouch
from tactiledata.replay.store_facts import StoreFacts
from tactiledata.replay.store_motion import StoreMotion
from tactiledata.sensors.base import GelGeometry

FREE_AIR = 1e-4
"""Height in metres above the gel beyond which a tip touches nothing, whatever the contact offset."""


@dataclass(frozen=True)
class FrameUse:
    """How many frames of the measured trajectories take part in a diagnosis, and how much of the force.

    Parameters
    ----------
    lost : int
        Frames that take no part: without pose or wrench, or not solved at the middle of the grid.
    force_lost : float
        Share of the squared measured force that is in these frames.
    estimated : int
        Frames that take part and were interpolated at some parameters of the gel, because it was not solved there.
    averaged : int
        Frames that take part and whose wrench is a mean of readings, because the indenter stands.
    """

    lost: int
    force_lost: float
    estimated: int
    averaged: int = 0

    @staticmethod
    def of(measured: Sequence[MeasuredTouch], cases: Sequence[TouchCase], plays: Sequence[TouchPlays]) -> FrameUse:
        """Return the use of the frames of measured trajectories.

        Parameters
        ----------
        measured : sequence of MeasuredTouch
            Trajectories with all of their frames.
        cases : sequence of TouchCase
            Trajectories that take part, with the frames that do.
        plays : sequence of TouchPlays
            Their plays, of the same frames.
        """

        def squares(wrenches: Sequence[Array]) -> float:
            """Sum of the squared forces, N^2."""
            return float(sum((np.nan_to_num(wrench[:, :3]) ** 2).sum() for wrench in wrenches))

        lost = sum(len(touch.seconds) for touch in measured) - sum(len(case.touch) for case in cases)
        whole, used = squares([touch.wrench for touch in measured]), squares([case.measured for case in cases])
        estimated = sum(int(part.estimated.sum()) for part in plays if part.estimated is not None)
        averaged = sum(int((case.noise_factors < 1).sum()) for case in cases)
        return FrameUse(lost, 1.0 - used / whole if whole > 0 else 0.0, estimated, averaged)


@dataclass(frozen=True)
class StoreTouches:
    """Everything that a diagnosis takes from a store.

    Parameters
    ----------
    touch_set : TouchSet
        Usable trajectories, and the simulation that plays them.
    start : GelMaterial
        Material from which fits start.
    effects : tuple of str
        Effects that can be simulated in these trajectories.
    not_played : dict, effect -> reason
        Effects that cannot be simulated.
    left_out : dict, reason -> number of trajectories
        Trajectories that are not used.
    frames : FrameUse
        Which frames of the measured trajectories take part.
    geometry : GelGeometry
        Geometry of the gel.
    uids : tuple of str
        Unique identifiers of the used trajectories, in order.
    plays : sequence of TouchPlays
        Plays of the used trajectories, in order.
    """

    touch_set: TouchSet
    start: GelMaterial
    effects: tuple[str, ...]
    not_played: dict[str, str]
    left_out: dict[str, int]
    frames: FrameUse
    geometry: GelGeometry
    uids: tuple[str, ...]
    plays: Sequence[TouchPlays]


def store_touches(
    opened: OpenedStore,
    options: CalibrationOptions,
    progress: Progress = no_progress,
    full: Collection[GelVariant] = (),
    only: Collection[str] | None = None,
    estimates: Estimates = "learned",
    runner: Scheduler | None = None,
) -> StoreTouches:
    """Return the chosen trajectories of a store, played by the gel.

    Parameters
    ----------
    opened : OpenedStore
        Recordings, planned with the pads of the options.
    options : CalibrationOptions
        Which trajectories are drawn, and how the gel plays them.
    progress : Progress
        Called with how many plays of touches are finished, how many there are, and what was played last.
    full : collection of GelVariant
        Variants of the gel that are played at finite strain even where they could be estimated.
    only : collection of str, optional
        Unique identifiers of the drawn trajectories that are taken; all by default.
    estimates : "learned", "rough" or "none"
        How plays at finite strain are estimated, see `play_touches`.
    runner : Scheduler, optional
        Where touches are played; that of the options where ``None``.

    Raises
    ------
    TactileDataError
        Too few trajectories can be used; the message counts the reasons.
    """
    # measured trajectories
    measured = read_measured(opened, options)
    if only is not None:
        measured = replace(measured, touches=tuple(touch for touch in measured.touches if touch.uid in only))
    if measured.mesh is None or len(measured.touches) < FEWEST_CASES:
        raise too_few(len(measured.touches), measured.left_out)
    planned = {touch.uid: touch for touch in opened.plan.touches}
    geometry = opened.plan.pads[planned[measured.touches[0].uid].pad].geometry
    box = find_bounds(options.bounds)
    # plays; variants of the gel exist at finite strain only
    variants = variants_of(EFFECTS) if options.fidelity == "finite-strain" else ()
    plays = play_touches(
        measured.mesh, options.fidelity, measured.touches, box,
        runner or make_scheduler(options.workers, options.scheduler), progress, variants,
        estimates=estimates, full=full,
    )  # fmt: skip
    start = GelMaterial(*box.inside(np.array([youngs_modulus_of_shore_a(options.shore_a), 0.475, 0.7])).tolist())
    # trajectories with covariates; those without usable frames are left out
    make = _CaseMaker(measured, StoreFacts(opened), StoreMotion(opened), start, geometry)
    left_out = Counter(measured.left_out)
    cases, kept, uids = [], [], []
    for touch, played in zip(measured.touches, plays, strict=True):
        case, part = make.case(touch, planned[touch.uid], played)
        if len(case.touch) < FEWEST_FRAMES or not part.level.any():
            left_out["fewer than 3 frames that are known and that the gel could be pressed to, or no contact"] += 1
            continue
        cases.append(case)
        kept.append(part)
        uids.append(touch.uid)
    if len(cases) < FEWEST_CASES:
        raise too_few(len(cases), dict(left_out))
    # the simulation
    not_played = _not_played(kept[0], options)
    effects = tuple(name for name in EFFECTS if name not in not_played)
    family = PlayedFamily([case.touch for case in cases], kept)
    frames = FrameUse.of(measured.touches, cases, kept)
    # an effect may move E far: if E were held at a durometer's bound, errors of the simulation would absorb what is
    # missing
    touch_set = TouchSet(cases, family, box.with_free_modulus)
    return StoreTouches(
        touch_set, start, effects, not_played, dict(left_out), frames, geometry=geometry, uids=tuple(uids), plays=kept
    )


def too_few(count: int, left_out: dict[str, int]) -> TactileDataError:
    """Return the error of a store with too few usable trajectories: their number, and why the others are left out."""
    reasons = all_left_out(left_out)
    return TactileDataError(
        f"{count} trajectories can be diagnosed{f' ({reasons})' if reasons else ''}",
        f"at least {FEWEST_CASES}, with poses, a known indenter and a contact wrench in the gel frame: whole "
        "trajectories are held out, never frames",
        "Record more of them; docs/calibration.md, What a recording must hold.",
        left_out=left_out,
    )


def _not_played(plays: TouchPlays, options: CalibrationOptions) -> dict[str, str]:
    """Return the effects that need variants which were not played, with the reason."""
    why = (
        "the gel solver failed with this effect in more than 10 % of the frames"
        if options.fidelity == "finite-strain"
        else "the gel plays this effect at --fidelity finite-strain only"
    )
    return {
        name: why
        for name in EFFECTS
        if any(variant not in plays.variants for variant in design_variants(EFFECTS[name]()))
    }


@dataclass(frozen=True)
class _CaseMaker:
    """Builds trajectories with their covariates.

    Parameters
    ----------
    measured : Measured
        Measured trajectories and their noise.
    facts : StoreFacts
        Mounts, gravity, joints, power-on times and earlier contacts.
    motion : StoreMotion
        What is known of the tip's motion between frames.
    material : GelMaterial
        Any material: each fit replaces it by its own.
    geometry : GelGeometry
        Geometry of the gel.
    """

    measured: Measured
    facts: StoreFacts
    motion: StoreMotion
    material: GelMaterial
    geometry: GelGeometry

    def case(self, touch: MeasuredTouch, planned: PlannedTouch, plays: TouchPlays) -> tuple[TouchCase, TouchPlays]:
        """Return a trajectory and its plays, both of the frames with pose and wrench that the gel could be pressed to.

        Parameters
        ----------
        touch : MeasuredTouch
            Measured poses and wrenches.
        planned : PlannedTouch
            Where the trajectory stands in the store.
        plays : TouchPlays
            Plays of all of its frames.
        """
        # frames that are known, later than the frame before
        rows = np.arange(*planned.frames)[slice(None) if touch.frames is None else touch.frames]
        known = plays.known & np.isfinite(touch.wrench).all(axis=1)
        known[1:] &= np.diff(touch.seconds) > 0
        part, rows, poses = plays.part(known), rows[known], touch.touch.poses[known]
        # means of readings where the indenter stands
        places = self.motion.places(planned)
        at_frames = _wrenches(touch, known, places)
        motion: dict[str, Any] = {} if places is None else moved_until(at_frames.seconds, *places)
        # covariates
        height = part.height - poses[:, 2, 3]
        earlier = self.facts.earlier(planned, poses[:, :2, 3], rows) if len(rows) else (None, None)
        at = Touch(
            at_frames.seconds,
            poses,
            touch.touch.indenter,
            self.material,
            self.geometry,
            sensor=touch.sensor,
            indenter_name=touch.indenter,
            mount=self.facts.mount(planned),
            gravity=self.facts.gravity(planned, rows),
            joints=self.facts.joints(rows),
            powered=self.facts.powered(planned, rows) if len(rows) else None,
            earlier_depth=earlier[0],
            earlier_contacts=earlier[1],
            **motion,
            **self.motion.sensor(planned, len(rows)),
        )
        case = TouchCase(
            at, at_frames.wrench, self.noise, height < -FREE_AIR, touch.free_samples, touch.name,
            self.noise.mean_factors(at_frames.readings),
        )  # fmt: skip
        return case, part

    @property
    def noise(self) -> WrenchNoise:
        """Noise of a wrench at one frame."""
        return self.measured.noise


def _wrenches(touch: MeasuredTouch, known: Mask, places: tuple[Array, Array] | None) -> FrameWrenches:
    """Wrenches of the known frames (n,) of a touch, averaged where the indenter stands.

    ``places`` are times, s, and positions, m, of the tip.
    """
    frames, wrench = touch.seconds[known], touch.wrench[known]
    if places is None or touch.readings is None:
        return FrameWrenches(frames, wrench, np.zeros(len(frames), dtype=np.int64))
    return means_at_rest(frames, wrench, rest_spans(frames, *places), touch.readings)
