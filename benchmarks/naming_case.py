"""Cases for naming missing physics: touches that the rig's layer solver answered, as a store would tell them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from naming_plan import Plan
from naming_zeros import Log, readings_of, weight_since_zero, zeros_of
from numpy.typing import NDArray

from tactiledata.calibrate.touches import ForceReadings, MeasuredTouch
from tactiledata.contract.take import StoredSignal
from tactiledata.diagnose.touches.rest_means import FrameWrenches, means_at_rest, rest_spans
from tactiledata.diagnose.touches.touch_case import BaseFamily, TouchCase, TouchSet
from tactiledata.diagnose.zeros.dead_band import find_dead_band
from tactiledata.diagnose.zeros.inertia import FreeAirMoves, find_inertia
from tactiledata.diagnose.zeros.readings import ForceZeros
from tactiledata.effects.touch.felt_acceleration import felt_accelerations
from tactiledata.effects.touch.imprint import ImprintTable, strongest_imprint
from tactiledata.effects.touch.moved_until import moved_until
from tactiledata.effects.touch.touch import Touch
from tactiledata.gel.contact.history import GelTouch
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.indenters.base.turned import reach_below_tip
from tactiledata.ingest.clocks.align import align, fractions_between
from tactiledata.ingest.forces.contact import contact_wrench
from tactiledata.ingest.forces.tare import SURELY_FREE, component_noise, touch_threshold, touching
from tactiledata.nuisance.noise import noise_at_rest
from tactiledata.rig.bank.bank import BankedContact, ContactBank
from tactiledata.rig.contact.contact import TouchSetup, contact_times
from tactiledata.rig.hidden.base import HiddenEffect
from tactiledata.rig.motion import ur5e
from tactiledata.rig.motion.motion import Path as TouchPath
from tactiledata.rig.play import PlayedTrajectory, RigSetup, SolveContact
from tactiledata.rig.record import BETWEEN_LOGS_NS
from tactiledata.rig.scenario.scenario import Gel, Scenario, load_scenario
from tactiledata.transforms import Transform

Array = NDArray[np.float64]
Times = NDArray[np.int64]

BESIDE = 2e-3
"""m within which an earlier touch counts as one of the same place."""
POSES = 125.0
"""Hz of the stream of poses."""
CLEAR = 1e-4
"""m over the gel, as commanded, from which a frame is free air."""


def play_logs(scenario: Scenario, solve: SolveContact) -> list[Log]:
    """Each unit's touches, in the scenario's order: an indenter may be mounted again."""
    rig_setup = RigSetup(scenario, solve)
    logs = []
    for index, serial in enumerate(scenario.sensors):
        touches = [touch for touch in scenario.trajectories if touch.sensor == serial]
        start_ns = scenario.start_ns + index * BETWEEN_LOGS_NS
        logs.append(Log(rig_setup, index, rig_setup.play(touches, index, start_ns)))
    return logs


def unfelt(gel: Gel, setup: TouchSetup, path: TouchPath | None, missed: Array | None) -> BankedContact:
    """A touch's path without forces."""
    path = path or setup.plan(lambda _: setup.thickness)
    count = len(contact_times(path))
    return BankedContact(path, missed, np.zeros((count, 6)), np.zeros(count, dtype=bool), 0)


def frame_times(play: PlayedTrajectory) -> Times:
    """When frames are taken, ns of the host clock: as the rig does, in the air, and on the way along and out."""
    path = play.path
    moving = [
        (start + end) / 2
        for start, end, here, there in zip(path.times, path.times[1:], path.positions, path.positions[1:], strict=False)
        if here[2] > 0 and (there[2] <= 0 or (here[2] == there[2] and np.linalg.norm(there - here) > 1e-9))
    ]
    seconds = np.unique(np.round([0.2, *path.captures, *moving[-3:], path.duration - 0.2], 6))
    return play.start_ns + np.rint(seconds * 1e9).astype(np.int64)


def told_touches(log: Log, plan: Plan) -> list[Touch]:
    """What a store tells of each touch: poses as commanded, gravity, joints, what the place went through before."""
    performance, scenario = log.performance, log.rig_setup.scenario
    robot = scenario.robot
    gel_from_ft = (robot.tcp_from_gel.inverse() @ robot.tcp_from_ft).matrix
    found: list[Touch] = []
    tables = {name: ImprintTable.of(indenter) for name, indenter in log.rig_setup.indenters.items()}
    for play, mounted in _mounted(log):
        host = frame_times(play)
        tcp = performance.tcp(host)
        base_from_gel = tcp @ robot.tcp_from_gel.matrix
        poses = np.linalg.inv(base_from_gel) @ mounted.matrix
        seconds = (host - performance.start_ns) * 1e-9
        commanded = play.path.at((host - play.start_ns) * 1e-9)[:, 2]
        earlier = [other for other in found if other.sensor == play.touch.sensor]
        touch = Touch(
            seconds=seconds,
            poses=poses,
            indenter=log.rig_setup.indenters[play.touch.indenter],
            material=plan.truth,
            geometry=plan.geometry,
            sensor=play.touch.sensor,
            indenter_name=play.touch.indenter,
            mount=f"{play.touch.indenter} {log.index}.{play.mount}",
            gravity=-9.80665 * base_from_gel[:, 2, :3],
            joints=ur5e.inverse(tcp @ robot.flange_from_tcp.inverse().matrix),
            powered=seconds + scenario.recordings.powered,
            earlier_depth=_as_deep(poses, play.touch.indenter, earlier, tables),
            earlier_contacts=np.full(len(host), float(sum(_is_beside(other, play) for other in earlier))),
            tare=(commanded < -CLEAR) & (seconds < seconds[int(np.argmax(commanded))]),
            **moved_until(seconds, *_way(log, play, mounted)),
            gel_from_sensor=np.tile(gel_from_ft, (len(host), 1, 1)),
            sensor_weight=weight_since_zero(log, host),
        )
        found.append(touch)
    return found


def _mounted(log: Log) -> list[tuple[PlayedTrajectory, Transform]]:
    """Touches of a log, with where their indenter was."""
    performance = log.performance
    return [(play, mounted) for play, (_, mounted) in zip(performance.plays, performance.poses, strict=True)]


def _way(log: Log, play: PlayedTrajectory, mounted: Transform) -> tuple[Array, Array]:
    """Times (m,), s from the log's start, and positions (m, 3), m, of the tip, as the stream of poses has them."""
    host = play.start_ns + np.rint(np.arange(0.0, play.path.duration, 1.0 / POSES) * 1e9).astype(np.int64)
    base_from_gel = log.performance.tcp(host) @ log.rig_setup.scenario.robot.tcp_from_gel.matrix
    places = (np.linalg.inv(base_from_gel) @ mounted.matrix)[:, :3, 3]
    return (host - log.performance.start_ns) * 1e-9, places


def _as_deep(poses: Array, name: str, earlier: Sequence[Touch], tables: Mapping[str, ImprintTable]) -> Array:
    """How deep (n,), m, this indenter would have to press to do what the strongest earlier touch has done there."""
    tips = [one.tips[int(np.argmin(one.tips[:, 2]))] for one in earlier]
    imprints = [float(tables[one.indenter_name].imprint(-tip[2])) for one, tip in zip(earlier, tips, strict=True)]
    pressed = np.array([tip[:2] for tip in tips])
    return tables[name].depth(strongest_imprint(poses[:, :2, 3], pressed, np.array(imprints)))


def _is_beside(other: Touch, play: PlayedTrajectory) -> bool:
    away = other.tips[:, :2] - np.asarray(play.touch.position)
    return bool(np.linalg.norm(away, axis=1).min() < BESIDE)


def to_play(touches: Sequence[Touch]) -> list[MeasuredTouch]:
    """The same for the gel engine."""
    return [
        MeasuredTouch(
            f"{number}", f"{number}", touch.sensor, touch.indenter_name, GelTouch(touch.indenter, touch.poses),
            np.zeros((len(touch), 6)), touch.seconds - touch.seconds[0], 40.0,
        )
        for number, touch in enumerate(touches)
    ]  # fmt: skip


@dataclass(frozen=True)
class Recorded:
    """Contact wrenches at the frames of each touch, averaged where the tip stands and interpolated (n, 6), samples in
    free air before it (m, 6), where all frames lie between two samples (f,), the zeros of all touches, and the
    effects that readings show by themselves.
    """

    at_frames: list[FrameWrenches]
    interpolated: list[Array]
    free: list[Array]
    fractions: Array
    zeros: ForceZeros
    shown: tuple[str, ...] = ()

    @property
    def wrenches(self) -> list[Array]:
        """Wrenches (n, 6) of each touch, averaged where the tip stands."""
        return [one.wrench for one in self.at_frames]


@dataclass(frozen=True)
class Maker:
    """Makes cases of a plan.

    Parameters
    ----------
    plan : Plan
    bank : ContactBank
    touches : list of Touch
        As told, of all logs.
    rows : list of (n,) bool
        Frames of each that are used.
    ways : list of ((m,) s, (m, 3) m)
        Positions of the tip of each at the rate of the stream of poses.
    solve : callable, optional
        The contact of a touch; the bank's where ``None``.
    noise : float
        Factor on noise and quanta of the force sensor.
    """

    plan: Plan
    bank: ContactBank
    touches: list[Touch]
    rows: list[NDArray[np.bool_]]
    ways: list[tuple[Array, Array]]
    solve: SolveContact | None = None
    noise: float = 1.0

    @staticmethod
    def of(plan: Plan, folder: Path) -> Maker:
        """Its touches laid out; nothing is solved."""
        scenario = load_scenario(plan.scenario(0, plan.truth, []))
        logs = play_logs(scenario, unfelt)
        told = [touch for log in logs for touch in told_touches(log, plan)]
        rows = [np.ones(len(touch), dtype=bool) for touch in told]
        ways = [_way(log, *played) for log in logs for played in _mounted(log)]
        return Maker(plan, ContactBank(folder, plan.pitch, logs[0].rig_setup.indenters), told, rows, ways)

    def keeping(self, rows: list[NDArray[np.bool_]]) -> Maker:
        """The same with some of the frames: those that the gel engine could solve."""
        return replace(self, touches=[_part(*pair) for pair in zip(self.touches, rows, strict=True)], rows=rows)

    def recorded(
        self,
        seed: int,
        material: GelMaterial,
        hidden: list[dict[str, Any]],
        more: tuple[HiddenEffect, ...] = (),
        is_exact: bool = False,
    ) -> Recorded:
        """What is recorded of the touches; ``is_exact``: by a force sensor without noise and quanta."""
        scenario = load_scenario(self.plan.scenario(seed, material, hidden))
        scenario = replace(scenario, hidden=(*scenario.hidden, *more))
        kinds, factor = ("force_noise", "torque_noise", "force_quantum", "torque_quantum"), self.noise * (not is_exact)
        noise = {kind: factor * getattr(scenario.imperfections, kind) for kind in kinds}
        scenario = replace(scenario, imperfections=replace(scenario.imperfections, **noise))
        logs = [(log, readings_of(log)) for log in play_logs(scenario, self.solve or self.bank.contact)]
        stored = [touch for log, readings in logs for touch in _as_stored(log, *readings)]
        interpolated = [touch.wrench[rows] for touch, rows in zip(stored, self.rows, strict=True)]
        at_frames = [
            means_at_rest(touch.seconds, wrench, rest_spans(touch.seconds, *way), one.readings)
            for touch, wrench, way, one in zip(self.touches, interpolated, self.ways, stored, strict=True)
        ]
        fractions = np.concatenate([touch.fractions for touch in stored])
        moves = [
            FreeAirMoves(number, one.readings.seconds[: len(one.free)], one.free[:, :3], felt, np.zeros(felt.shape[1]))
            for number, (one, way) in enumerate(zip(stored, self.ways, strict=True))
            for felt in [felt_accelerations(one.readings.seconds[: len(one.free)], *way)]
        ]
        found = find_dead_band([wrench.values for _, (wrench, _) in logs]), find_inertia(moves)
        shown = tuple(str(one.document["effect"]) for one in found if one is not None)
        return Recorded(at_frames, interpolated, [touch.free for touch in stored], fractions, zeros_of(logs), shown)

    def cases(self, recorded: Recorded, base: BaseFamily) -> TouchSet:
        """The trajectories of a case, with their noise as a calibration estimates it."""
        stretches = recorded.free
        steps = np.concatenate([np.diff(touch.seconds) for touch in self.touches])
        noise = noise_at_rest(stretches, max(1, round(100.0 * float(np.median(steps)))), recorded.fractions)
        assert noise is not None
        cases = []
        for number, (touch, way, one, free) in enumerate(
            zip(self.touches, self.ways, recorded.at_frames, recorded.free, strict=True)
        ):
            read = replace(touch, seconds=one.seconds, **moved_until(one.seconds, *way))
            factors = noise.mean_factors(one.readings)
            cases.append(TouchCase(read, one.wrench, noise, _is_clear(read), float(len(free)), f"t{number}", factors))
        return TouchSet(cases, base, self.plan.bounds)


def _part(touch: Touch, rows: NDArray[np.bool_]) -> Touch:
    values = {field.name: getattr(touch, field.name) for field in fields(touch)}
    return Touch(**{key: one[rows] if isinstance(one, np.ndarray) else one for key, one in values.items()})


class StoredTouch(NamedTuple):
    """What a store holds of a touch: wrenches at its frames (n, 6), all readings, those in free air (m, 6), and where
    the frames lie between two readings (f,).
    """

    wrench: Array
    readings: ForceReadings
    free: Array
    fractions: Array


def _as_stored(log: Log, wrench: StoredSignal, tcp: StoredSignal) -> list[StoredTouch]:
    """Readings through what a store does with them: weight off, zero of each touch, gel frame, at the frames."""
    performance = log.performance
    spans = [(play.touch.name, play.start_ns, play.end_ns) for play in performance.plays]
    contact = contact_wrench(log.description, wrench, tcp, spans).signal
    found = []
    for play in performance.plays:
        rows = slice(*np.searchsorted(contact.t_ns, [play.start_ns, play.end_ns]))
        times = frame_times(play)
        fractions = fractions_between(contact.t_ns[rows], times)
        seconds, values = (contact.t_ns[rows] - performance.start_ns) * 1e-9, contact.values[rows]
        readings = ForceReadings(seconds, values)
        found.append(StoredTouch(align(contact, times).values, readings, _before_touch(values), fractions))
    return found


def _is_clear(touch: Touch) -> NDArray[np.bool_]:
    """Frames in free air: the lowest point of the indenter is over the gel."""
    return np.asarray(touch.tips[:, 2] - reach_below_tip(touch.indenter, touch.poses) > CLEAR)


def _before_touch(values: Array) -> Array:
    threshold = touch_threshold(component_noise(values))
    contact = np.flatnonzero(touching(np.linalg.norm(values[:, :3], axis=1), threshold))
    return values[: int(SURELY_FREE * (int(contact[0]) if len(contact) else len(values)))]
