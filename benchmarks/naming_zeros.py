"""What a log of the rig says in free air: the zeros of its force sensor, as a store would tell them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactiledata.contract.description import LogDescription
from tactiledata.contract.records import Stamps
from tactiledata.contract.take import StoredSignal
from tactiledata.diagnose.zeros.readings import ForceZeros, free_air_readings, pieces_of
from tactiledata.ingest.forces.gravity import tool_weight
from tactiledata.rig.logs.describe import describe
from tactiledata.rig.logs.sampling import SAMPLING, tare_times, wrench_samples
from tactiledata.rig.motion import ur5e
from tactiledata.rig.play import PlayedLog, RigSetup
from tactiledata.transforms import matrix_poses
from tactiledata.units import SIGNAL_COLUMNS, signal_units

Array = NDArray[np.float64]
Times = NDArray[np.int64]


@dataclass(frozen=True)
class Log:
    """One unit's touches in time, and what the log says of itself."""

    rig_setup: RigSetup
    index: int
    performance: PlayedLog

    @property
    def tares(self) -> list[int]:
        """When the force sensor is set to zero, ns."""
        return tare_times(self.rig_setup.scenario, self.performance)

    @property
    def description(self) -> LogDescription:
        """As the log would state it."""
        serials = list(dict.fromkeys(play.touch.sensor for play in self.performance.plays))
        return LogDescription.checked(describe(self.rig_setup, self.performance, serials, self.tares), "the rig")


def readings_of(log: Log) -> tuple[StoredSignal, StoredSignal]:
    """Wrenches and poses of a whole log, as they are stored."""
    scenario, performance = log.rig_setup.scenario, log.performance
    chance = np.random.default_rng([scenario.seed, SAMPLING, log.index])
    samples = wrench_samples(scenario, performance, log.index, log.tares, chance)
    poses = matrix_poses(performance.tcp(samples.host_ns))
    return _stored("wrench", samples.stamp_ns, samples.values, "ft"), _stored("tcp", samples.host_ns, poses, "base")


def _stored(name: str, t_ns: Times, values: Array, frame: str) -> StoredSignal:
    columns = SIGNAL_COLUMNS[name]
    return StoredSignal(t_ns, np.asarray(values), columns, signal_units(columns), frame, Stamps(t_ns))


def zeros_of(logs: Sequence[tuple[Log, tuple[StoredSignal, StoredSignal]]]) -> ForceZeros:
    """Pieces of free air before all touches, trajectories numbered through all logs."""
    pieces: list[tuple[Array, int, int, float]] = []
    poses: list[Array] = []
    trajectory = 0
    for log, (wrench, tcp) in logs:
        performance = log.performance
        load = wrench.values - weight_of(log, tcp, wrench.t_ns)
        moments = []
        for play in performance.plays:
            rows = slice(*np.searchsorted(wrench.t_ns, [play.start_ns, play.end_ns]))
            readings, times = free_air_readings(load[rows], wrench.t_ns[rows])
            for part in pieces_of(len(readings)):
                moments.append(times[part[len(part) // 2]])
                seconds = (moments[-1] - performance.start_ns) * 1e-9 + log.rig_setup.scenario.recordings.powered
                zeroed = 1000 * log.index + sum(tare <= moments[-1] for tare in log.tares)
                pieces.append((readings[part].mean(axis=0), trajectory, zeroed, seconds))
            trajectory += 1
        poses.append(performance.tcp(np.array(moments)))
    if not pieces:
        none = np.empty(0, dtype=np.int64)
        return ForceZeros(np.empty((0, 6)), none, none, np.empty((0, 3)), np.empty(0), None)
    base_from_tcp, robot = np.concatenate(poses), logs[0][0].rig_setup.scenario.robot
    down = -np.einsum("ij,nkj->nik", robot.tcp_from_ft.inverse().rotation, base_from_tcp[:, :3, :3])[:, :, 2]
    joints = ur5e.inverse(base_from_tcp @ robot.flange_from_tcp.inverse().matrix)
    load_, owner, zeroed_, seconds_ = (np.array(column) for column in zip(*pieces, strict=True))
    return ForceZeros(load_, owner, zeroed_, down, seconds_, joints)


def weight_of(log: Log, tcp: StoredSignal, t_ns: Times) -> Array:
    """The tool's stated weight (n, 6) as a load on the force sensor."""
    weight = tool_weight(log.description, tcp, t_ns)
    assert weight is not None
    return weight


def weight_since_zero(log: Log, t_ns: Times) -> Array:
    """Of it, what the sensor reads (n, 6) in its frame: what changed since its zero, once for the log."""
    performance = log.performance
    moments = np.concatenate([log.tares[:1], t_ns])
    tcp = _stored("tcp", moments, matrix_poses(performance.tcp(moments)), "base")
    weight = weight_of(log, tcp, moments)
    since: Array = weight[1:] - weight[0]
    return since
