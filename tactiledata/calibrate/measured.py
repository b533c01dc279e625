"""The touches of a store that a calibration can use, and the reasons why others cannot."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import Array
from tactiledata.calibrate.options import CalibrationOptions
from tactiledata.calibrate.touches import MeasuredTouch
from tactiledata.errors import UnknownName
from tactiledata.gel.contact.history import GelTouch
from tactiledata.gel.flex.model import is_convex
from tactiledata.gel.mesh.pad import PadMesh
from tactiledata.ingest.clocks.align import fractions_between
from tactiledata.ingest.forces.tare import SURELY_FREE, component_noise, touch_threshold, touching
from tactiledata.nuisance.noise import WrenchNoise, noise_at_rest, specified_noise
from tactiledata.replay.plan import GAP_LIMIT_NS, PlannedTouch, ReplayPlan, plan_replay
from tactiledata.sensors.robotiq_ft300s import ROBOTIQ_FT300S
from tactiledata.store.check.values import need_sound_values
from tactiledata.store.read.reader import Store

WRENCH = "contact_wrench"
LEAST_FORCE = 1.0
"""N: a touch that the sensor felt less says nothing of the gel (the SPLIT paper's lower limit, too)."""
MOST_FRAMES = 24
"""Of one trajectory that are played; of more, so many are taken at even distances."""


@dataclass(frozen=True)
class Measured:
    """What a store gives to a calibration.

    Parameters
    ----------
    touches : tuple of MeasuredTouch
    mesh : PadMesh
    described : what the mesh was made of
    noise : WrenchNoise
    left_out : dict, reason -> number of trajectories
    """

    touches: tuple[MeasuredTouch, ...]
    mesh: PadMesh | None
    described: Any
    noise: WrenchNoise
    left_out: dict[str, int]


def read_measured(store: Store, options: CalibrationOptions) -> Measured:
    """So many trajectories of a store as the options ask for, drawn by the seed, indenters in turn.

    Raises
    ------
    UnknownName
        A sensor or an indenter that the store does not hold.
    """
    plan = plan_replay(store, options.pads, options.indenter_folder)
    if options.sensor is not None:
        known = {touch.sensor for touch in plan.touches}
        if options.sensor not in known:
            raise UnknownName("sensor", options.sensor, known)
    known = {touch.indenter for touch in plan.touches}
    for indenter in options.indenters:
        if indenter not in known:
            raise UnknownName("indenter", indenter, known)
    left_out: Counter[str] = Counter()
    usable = _usable(store, plan, options, left_out)
    reader = _WrenchReader(store)
    touches: list[MeasuredTouch] = []
    stretches: list[Array] = []
    for planned in drawn_in_turn(usable, options.seed):
        if len(touches) == options.trajectories:
            break
        wrench = reader.wrench(planned)
        if wrench is None:
            left_out["no contact wrench in the gel frame"] += 1
            continue
        readings, distinct = reader.free_air(planned)
        stretches.append(readings)
        touches.append(_measured(store, planned, wrench, distinct))
    noise = noise_at_rest(stretches, reader.samples_a_frame(touches), reader.fractions()) or _stated_noise()
    pad = plan.pads[usable[0].pad] if usable else None
    mesh, described = (pad.mesh, pad.described) if pad else (None, {})
    return Measured(tuple(touches), mesh, described, noise, dict(left_out))


def _usable(store: Store, plan: ReplayPlan, options: CalibrationOptions, left_out: Counter[str]) -> list[PlannedTouch]:
    peaks = dict(zip(*(store.trajectories(["uid", "peak_force"])[name].to_pylist() for name in ("uid", "peak_force")),
                     strict=True))  # fmt: skip
    wanted = [
        touch
        for touch in plan.touches
        if options.sensor in (None, touch.sensor) and (not options.indenters or touch.indenter in options.indenters)
    ]
    pads = Counter(touch.pad for touch in wanted if touch.obstacle is None)
    pad = pads.most_common(1)[0][0] if pads else -1
    usable = []
    for touch in wanted:
        peak = peaks.get(touch.uid)
        if touch.obstacle is not None:
            left_out[touch.reason] += 1
        elif touch.pad != pad:
            left_out["a gel of another shape: calibrate it on its own, with --sensor"] += 1
        elif peak is None or not peak >= LEAST_FORCE:
            left_out[f"no force: the sensor felt less than {LEAST_FORCE:g} N"] += 1
        elif options.engine == "mujoco-flex" and touch.solid is not None and not is_convex(touch.solid):
            left_out["an indenter that is not convex, which mujoco-flex cannot press"] += 1
        else:
            usable.append(touch)
    return usable


def drawn_in_turn(touches: Sequence[PlannedTouch], seed: int) -> list[PlannedTouch]:
    """All touches in an order of chance, one of each indenter before the second of any."""
    chance = np.random.default_rng(seed)
    shuffled = [touches[place] for place in chance.permutation(len(touches))]
    turn: Counter[str] = Counter()
    ranked = []
    for place, touch in enumerate(shuffled):
        ranked.append((turn[touch.indenter], place, touch))
        turn[touch.indenter] += 1
    return [touch for _, _, touch in sorted(ranked, key=lambda entry: entry[:2])]


def _measured(store: Store, planned: PlannedTouch, wrench: Array, free_samples: int) -> MeasuredTouch:
    rows = np.arange(*planned.frames)
    t_ns = np.asarray(store.frames(["t_ns"])["t_ns"])[rows]
    kept = kept_rows(len(rows))
    whole = planned.gel_touch(store, 0.0)
    return MeasuredTouch(
        planned.uid,
        planned.name,
        planned.sensor,
        planned.indenter,
        GelTouch(whole.indenter, whole.poses[kept]),
        wrench[kept],
        (t_ns - t_ns[0])[kept] / 1e9,
        float(free_samples),
    )


def kept_rows(count: int) -> NDArray[np.int64]:
    """Which of a trajectory's frames are played: all, or ``MOST_FRAMES`` at even distances."""
    if count <= MOST_FRAMES:
        return np.arange(count)
    return np.unique(np.linspace(0, count - 1, MOST_FRAMES).astype(np.int64))


def _stated_noise() -> WrenchNoise:
    assert ROBOTIQ_FT300S.force is not None
    return specified_noise(ROBOTIQ_FT300S.force)


class _WrenchReader:
    """Contact wrenches of a store, at frames and at their native rate."""

    def __init__(self, store: Store) -> None:
        self._store = store
        named = [name for name in store.aligned_names if name.partition("@")[0] == WRENCH]
        self._names = [name for name in named if store.meaning("aligned", name).frame == "gel"]
        need_sound_values(store, self._names)
        table = store.trajectories(["uid", "signal_rows"])
        self._spans = {
            uid: json.loads(spans)
            for uid, spans in zip(table["uid"].to_pylist(), table["signal_rows"].to_pylist(), strict=True)
        }
        self._periods: list[float] = []
        self._fractions: list[Array] = []
        self._frame_t_ns = np.asarray(store.frames(["t_ns"])["t_ns"])

    def wrench(self, planned: PlannedTouch) -> Array | None:
        """At the frames (n, 6), NaN where not known; ``None`` where nowhere."""
        for name in self._names:
            values, gap_ns = self._store.aligned(name, np.arange(*planned.frames))
            values = np.where((gap_ns > GAP_LIMIT_NS)[:, None], np.nan, values)
            if np.isfinite(values).all(axis=1).any():
                return values
        return None

    def free_air(self, planned: PlannedTouch) -> tuple[Array, int]:
        """Return the samples (n, 6) at the native rate before the touch, and how many of them are new readings."""
        spans = self._spans[planned.uid]
        name = next((name for name in self._names if name in spans), None)
        if name is None:
            return np.empty((0, 6)), 0
        signal = self._store.signal(name)
        start, stop = spans[name]
        samples = signal.values(start, stop)
        is_known = np.isfinite(samples).all(axis=1)
        t_ns, samples = signal.t_ns(start, stop)[is_known], samples[is_known]
        if len(t_ns) > 1:
            self._periods.append(float(np.ptp(t_ns)) / 1e9 / (len(t_ns) - 1))
        self._fractions.append(fractions_between(t_ns, self._frame_t_ns[slice(*planned.frames)]))
        is_new = np.ones(len(samples), dtype=bool)
        is_new[1:] = (np.diff(samples, axis=0) != 0).any(axis=1)
        readings = samples[is_new]
        threshold = touch_threshold(component_noise(readings))
        contact = np.flatnonzero(touching(np.linalg.norm(readings[:, :3], axis=1), threshold))
        first = int(contact[0]) if len(contact) else len(readings)
        distinct = int(SURELY_FREE * first)
        # repeated samples stay: the frames were interpolated between these, too
        end = int(np.flatnonzero(is_new)[distinct]) if distinct < len(readings) else len(samples)
        return samples[:end], distinct

    def fractions(self) -> Array:
        """Return where the frames (f,) of the touches that were read lie between two samples, 0 to 1."""
        return np.concatenate([np.empty(0), *self._fractions])

    def samples_a_frame(self, touches: Sequence[MeasuredTouch]) -> int:
        """Samples at the native rate from one frame to the next."""
        steps = [step for touch in touches for step in np.diff(touch.seconds)]
        if not steps or not self._periods:
            return 1
        return max(1, round(float(np.median(steps)) / float(np.median(self._periods))))
