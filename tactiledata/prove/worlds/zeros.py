"""The zeros of the force sensor in the logs of a world: what it reads in free air before each touch."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tactiledata.arrays import Array, RealArray
from tactiledata.contract.take import StoredSignal
from tactiledata.diagnose.zeros.readings import ForceZeros, free_air_readings, pieces_of
from tactiledata.prove.worlds.logs import WorldLog
from tactiledata.rig.motion import ur5e


def zeros_of(logs: Sequence[tuple[WorldLog, StoredSignal, StoredSignal]]) -> ForceZeros:
    """Return pieces of free air before all touches, trajectories numbered through all logs.

    Parameters
    ----------
    logs : sequence of (WorldLog, wrench, poses)
        Logs, each with its readings and its stream of poses.
    """
    pieces: list[tuple[Array, int, int, float, float]] = []
    poses: list[RealArray] = []
    weights: list[Array] = []
    trajectory = 0
    for log, wrench, tcp in logs:
        played = log.played
        load = wrench.values - log.weight(tcp, wrench.t_ns)
        moments = []
        for play in played.plays:
            rows = slice(*np.searchsorted(wrench.t_ns, [play.start_ns, play.end_ns]))
            readings, times = free_air_readings(load[rows], wrench.t_ns[rows])
            for part in pieces_of(len(readings)):
                moments.append(times[part[len(part) // 2]])
                seconds = (moments[-1] - played.start_ns) * 1e-9 + log.rig_setup.scenario.recordings.powered
                zeroed = 1000 * log.index + sum(tare <= moments[-1] for tare in log.tares)
                level = np.asarray(readings[part].mean(axis=0), dtype=np.float64)
                pieces.append((level, trajectory, zeroed, seconds, (play.end_ns - moments[-1]) * 1e-9))
            trajectory += 1
        poses.append(played.tcp(np.array(moments)))
        weights.append(log.weight(tcp, np.array(moments, dtype=np.int64)))
    if not pieces:
        none = np.empty(0, dtype=np.int64)
        return ForceZeros(np.empty((0, 6)), none, none, np.empty((0, 3)), np.empty(0), np.empty(0), None)
    base_from_tcp, robot = np.concatenate(poses), logs[0][0].rig_setup.scenario.robot
    down = -np.einsum("ij,nkj->nik", robot.tcp_from_ft.inverse().rotation, base_from_tcp[:, :3, :3])[:, :, 2]
    joints = np.asarray(ur5e.inverse(base_from_tcp @ robot.flange_from_tcp.inverse().matrix), dtype=float)
    load_, owner, zeroed_, seconds_, remaining = (np.array(column) for column in zip(*pieces, strict=True))
    return ForceZeros(load_, owner, zeroed_, down, seconds_, remaining, joints, np.concatenate(weights))
