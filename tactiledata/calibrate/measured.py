"""The touches of a store that a calibration can use, and the reasons why others cannot be used."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tactiledata.arrays import Array
from tactiledata.calibrate.options import CalibrationOptions
from tactiledata.calibrate.touches import ForceReadings, MeasuredTouch
from tactiledata.errors import UnknownName
from tactiledata.gel.contact.history import GelTouch
from tactiledata.gel.flex.model import is_convex
from tactiledata.gel.mesh.pad import PadMesh
from tactiledata.ingest.clocks.align import fractions_between
from tactiledata.ingest.forces.onset import surely_free
from tactiledata.nuisance.noise import WrenchNoise, noise_at_rest, specified_noise
from tactiledata.replay.chosen_frames import chosen_frames
from tactiledata.replay.opened import OpenedStore
from tactiledata.replay.plan import GAP_LIMIT_NS, PlannedTouch
from tactiledata.sensors.robotiq_ft300s import ROBOTIQ_FT300S
from tactiledata.store.check.values import need_sound_values
from tactiledata.store.read.flags import flagged_trajectories

WRENCH = "contact_wrench"
"""Stream of a store that is fitted."""
LEAST_FORCE = 1.0
"""Smallest peak force, N, of a touch that says anything of the gel; the SPLIT paper has the same limit."""
MOST_FRAMES = 24
"""Most frames of one trajectory that are simulated; of a longer one this many are taken, by its path."""


@dataclass(frozen=True)
class Measured:
    """The touches, the mesh and the noise that a store gives to a calibration.

    Parameters
    ----------
    touches : tuple of MeasuredTouch
        The trajectories that were drawn.
    mesh : PadMesh, optional
        Pad of the sensor; ``None`` where no trajectory is usable.
    described : dict
        Dimensions of the pad from which the mesh was made.
    noise : WrenchNoise
        Noise of the contact wrenches, measured at rest, or that of the sensor's data sheet.
    left_out : dict, reason -> number of trajectories
        Why others were not taken.
    """

    touches: tuple[MeasuredTouch, ...]
    mesh: PadMesh | None
    described: Any
    noise: WrenchNoise
    left_out: dict[str, int]


def read_measured(opened: OpenedStore, options: CalibrationOptions) -> Measured:
    """Read as many trajectories of a store as the options ask for, drawn by the seed, indenters in turn.

    Parameters
    ----------
    opened : OpenedStore
        The store, planned with the pads of the options.
    options : CalibrationOptions
        Which trajectories are wanted.

    Raises
    ------
    UnknownName
        A sensor or an indenter that the store does not hold.
    """
    plan = opened.plan
    if options.sensor is not None:
        known = {touch.sensor for touch in plan.touches}
        if options.sensor not in known:
            raise UnknownName("sensor", options.sensor, known)
    known = {touch.indenter for touch in plan.touches}
    for indenter in options.indenters:
        if indenter not in known:
            raise UnknownName("indenter", indenter, known)
    # draw trajectories in turn until there are enough with a contact wrench
    left_out: Counter[str] = Counter()
    usable = _usable(opened, options, left_out)
    reader = _WrenchReader(opened)
    touches: list[MeasuredTouch] = []
    free_air_readings: list[Array] = []
    for planned in drawn_in_turn(usable, options.seed):
        if len(touches) == options.trajectories:
            break
        wrench = reader.wrench(planned)
        if wrench is None:
            left_out["no contact wrench in the gel frame"] += 1
            continue
        readings = reader.readings(planned)
        at_rest, distinct = reader.free_air(planned, readings)
        free_air_readings.append(at_rest)
        touches.append(_measured(opened, planned, wrench, distinct, readings))
    # too little free air to measure the noise: take the data sheet's
    noise = noise_at_rest(free_air_readings, reader.samples_a_frame(touches), reader.fractions()) or stated_noise()
    pad = plan.pads[usable[0].pad] if usable else None
    mesh, described = (pad.mesh, pad.described) if pad else (None, {})
    return Measured(tuple(touches), mesh, described, noise, dict(left_out))


def _usable(opened: OpenedStore, options: CalibrationOptions, left_out: Counter[str]) -> list[PlannedTouch]:
    """Chosen touches on the most frequent pad that can be simulated; the others are counted in ``left_out``."""
    chosen = [
        touch
        for touch in opened.plan.touches
        if options.sensor in (None, touch.sensor) and (not options.indenters or touch.indenter in options.indenters)
    ]
    # one mesh for all: the pad of most of them
    pads = Counter(touch.pad for touch in chosen if touch.obstacle is None)
    pad = pads.most_common(1)[0][0] if pads else -1
    usable, flagged = [], flagged_trajectories(opened.store)
    for touch in chosen:
        peak = opened.by_uid[touch.uid]["peak_force"]
        if touch.uid in flagged:
            left_out["flagged as bad"] += 1
        elif touch.obstacle is not None:
            left_out[touch.reason] += 1
        elif touch.pad != pad:
            left_out["a gel of another shape: calibrate it on its own, with --sensor"] += 1
        elif peak is None or np.isnan(peak):
            left_out["no force: no reading of the force sensor belongs to it"] += 1
        elif not peak >= LEAST_FORCE:
            left_out[f"no force: the sensor felt less than {LEAST_FORCE:g} N"] += 1
        elif options.engine == "mujoco-flex" and touch.solid is not None and not is_convex(touch.solid):
            left_out["an indenter that is not convex, which mujoco-flex cannot press"] += 1
        else:
            usable.append(touch)
    return usable


def drawn_in_turn(touches: Sequence[PlannedTouch], seed: int) -> list[PlannedTouch]:
    """Shuffle touches so that each indenter comes once before any comes a second time."""
    rng = np.random.default_rng(seed)
    shuffled = [touches[place] for place in rng.permutation(len(touches))]
    times_drawn: Counter[str] = Counter()
    ranked = []
    for place, touch in enumerate(shuffled):
        ranked.append((times_drawn[touch.indenter], place, touch))
        times_drawn[touch.indenter] += 1
    return [touch for _, _, touch in sorted(ranked, key=lambda entry: entry[:2])]


def _measured(
    opened: OpenedStore, planned: PlannedTouch, wrench: Array, free_samples: int, readings: ForceReadings | None
) -> MeasuredTouch:
    """Measured touch of a planned one with its contact wrench (frames, 6), thinned to ``MOST_FRAMES``."""
    rows = np.arange(*planned.frames)
    t_ns = opened.frame_t_ns[rows]
    whole = planned.gel_touch(opened.store, 0.0)
    kept = chosen_frames((t_ns - t_ns[0]) / 1e9, whole.poses[:, :3, 3], MOST_FRAMES)
    return MeasuredTouch(
        planned.uid,
        planned.name,
        planned.sensor,
        planned.indenter,
        GelTouch(whole.indenter, whole.poses[kept]),
        wrench[kept],
        (t_ns - t_ns[0])[kept] / 1e9,
        float(free_samples),
        frames=kept,
        readings=readings,
    )


def stated_noise() -> WrenchNoise:
    """Return the noise that the data sheet of the Robotiq FT 300-S states."""
    assert ROBOTIQ_FT300S.force is not None
    return specified_noise(ROBOTIQ_FT300S.force)


class _WrenchReader:
    """Reader of a store's contact wrenches in the gel frame, at frames and at the native rate."""

    def __init__(self, opened: OpenedStore) -> None:
        self._opened, self._store = opened, opened.store
        store = opened.store
        wrenches = [name for name in store.aligned_names if name.partition("@")[0] == WRENCH]
        self._names = [name for name in wrenches if store.meaning("aligned", name).frame == "gel"]
        need_sound_values(store, self._names)
        self._periods: list[float] = []
        self._fractions: list[Array] = []
        self._frame_t_ns = opened.frame_t_ns

    def wrench(self, planned: PlannedTouch) -> Array | None:
        """Contact wrench (n, 6), N and N m, at a touch's frames, NaN where unknown; ``None`` if known at no frame."""
        for name in self._names:
            values, gap_ns = self._store.aligned(name, np.arange(*planned.frames))
            values = np.where((gap_ns > GAP_LIMIT_NS)[:, None], np.nan, values)
            if np.isfinite(values).all(axis=1).any():
                return values
        return None

    def readings(self, planned: PlannedTouch) -> ForceReadings | None:
        """Return the samples at the native rate of a touch, timed from its first frame; ``None`` if there are none."""
        spans = self._opened.by_uid[planned.uid]["spans"]
        name = next((name for name in self._names if name in spans), None)
        if name is None:
            return None
        signal = self._store.signal(name)
        t_ns = signal.t_ns(*spans[name])
        return ForceReadings((t_ns - self._frame_t_ns[planned.frames[0]]) / 1e9, signal.values(*spans[name]))

    def free_air(self, planned: PlannedTouch, readings_of_touch: ForceReadings | None) -> tuple[Array, int]:
        """Return the samples (n, 6) at the native rate before the touch, and how many of them are new readings."""
        if readings_of_touch is None:
            return np.empty((0, 6)), 0
        # the trajectory's known samples, their rate, and where frames lie between them
        is_known = np.isfinite(readings_of_touch.wrench).all(axis=1)
        t_ns = np.rint(readings_of_touch.seconds[is_known] * 1e9).astype(np.int64) + self._frame_t_ns[planned.frames[0]]
        samples = readings_of_touch.wrench[is_known]
        if len(t_ns) > 1:
            self._periods.append(float(np.ptp(t_ns)) / 1e9 / (len(t_ns) - 1))
        self._fractions.append(fractions_between(t_ns, self._frame_t_ns[slice(*planned.frames)]))
        # a sensor that is polled faster than it measures repeats its last reading
        is_new = np.ones(len(samples), dtype=bool)
        is_new[1:] = (np.diff(samples, axis=0) != 0).any(axis=1)
        readings = samples[is_new]
        # stop well before the force first rises above its noise
        distinct = surely_free(readings, t_ns[is_new])
        # repeated samples stay: the frames were interpolated between these, too
        end = int(np.flatnonzero(is_new)[distinct]) if distinct < len(readings) else len(samples)
        return samples[:end], distinct

    def fractions(self) -> Array:
        """Return the position (f,) of each frame of the touches read between its two samples, 0 to 1."""
        return np.concatenate([np.empty(0), *self._fractions])

    def samples_a_frame(self, touches: Sequence[MeasuredTouch]) -> int:
        """Number of samples at the native rate from one frame to the next; at least 1."""
        steps = [step for touch in touches for step in np.diff(touch.seconds)]
        if not steps or not self._periods:
            return 1
        return max(1, round(float(np.median(steps)) / float(np.median(self._periods))))
