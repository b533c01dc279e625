"""The logs of a world: a sensor's touches in time, and the readings of the force sensor meanwhile."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from tactiledata.arrays import Array, RealArray, Times
from tactiledata.contract.description import LogDescription
from tactiledata.contract.records import Stamps
from tactiledata.contract.take import StoredSignal
from tactiledata.ingest.forces.gravity import tool_weight
from tactiledata.rig.bank.bank import BankedContact
from tactiledata.rig.contact.contact import TouchSetup, contact_times
from tactiledata.rig.logs.describe import describe
from tactiledata.rig.logs.sampling import SAMPLING, tare_times, wrench_samples
from tactiledata.rig.motion.motion import Path
from tactiledata.rig.play import PlayedLog, PlayedTrajectory, RigSetup, SolveContact
from tactiledata.rig.record import BETWEEN_LOGS_NS
from tactiledata.rig.scenario.scenario import Gel, Scenario
from tactiledata.transforms import Transform, matrix_poses
from tactiledata.units import SIGNAL_COLUMNS, signal_units

POSES = 125.0
"""Rate, Hz, of the stream of poses."""
AROUND_NS = 2_000_000_000
"""Time, ns, before and after a log for which poses are known: stamps of another clock may lie there."""


@dataclass(frozen=True)
class LogReadings:
    """The readings of the force sensor over a whole log, as they are recorded.

    Parameters
    ----------
    t_ns : (n,), ns
        Stamps.
    values : (n, 6), N and N m
        Readings in the sensor's frame.
    """

    t_ns: Times
    values: Array


@dataclass(frozen=True)
class WorldLog:
    """One sensor's touches in time, and what the log says of itself.

    Parameters
    ----------
    rig_setup : RigSetup
        The scenario and its indenters.
    index : int
        Place of the log in the scenario.
    played : PlayedLog
        What happened.
    """

    rig_setup: RigSetup
    index: int
    played: PlayedLog

    @property
    def tares(self) -> list[int]:
        """Moments at which the force sensor is set to zero, ns of the host clock."""
        return tare_times(self.rig_setup.scenario, self.played)

    @cached_property
    def description(self) -> LogDescription:
        """The log's description, as it would stand in the log."""
        serials = list(dict.fromkeys(play.touch.sensor for play in self.played.plays))
        return LogDescription.checked(describe(self.rig_setup, self.played, serials, self.tares), "the rig")

    @property
    def mounted(self) -> list[tuple[PlayedTrajectory, Transform]]:
        """Touches of the log, each with ``base_from_indenter`` as the log states it."""
        return [(play, mounted) for play, (_, mounted) in zip(self.played.plays, self.played.poses, strict=True)]

    def readings(self, noise: float = 1.0) -> LogReadings:
        """Return what the force sensor reads over the whole log.

        Parameters
        ----------
        noise : float
            Factor on noise and quanta of the force sensor.
        """
        scenario = self.rig_setup.scenario
        kinds = ("force_noise", "torque_noise", "force_quantum", "torque_quantum")
        sizes = {kind: noise * getattr(scenario.imperfections, kind) for kind in kinds}
        scenario = replace(scenario, imperfections=replace(scenario.imperfections, **sizes))
        chance = np.random.default_rng([scenario.seed, SAMPLING, self.index])
        samples = wrench_samples(scenario, self.played, self.index, self.tares, chance)
        return LogReadings(samples.stamp_ns, np.asarray(samples.values))

    @cached_property
    def poses(self) -> StoredSignal:
        """The stream of poses: where the arm was told to be, which no hidden effect changes."""
        step = round(1e9 / POSES)
        host = np.arange(self.played.start_ns - AROUND_NS, self.played.end_ns + AROUND_NS, step, dtype=np.int64)
        return stored_signal("tcp", host, matrix_poses(self.played.tcp(host)), "base")

    def weight(self, poses: StoredSignal, t_ns: Times) -> Array:
        """Return the tool's stated weight (n, 6), N and N m, as a load on the force sensor at moments (n,), ns."""
        weight = tool_weight(self.description, poses, t_ns)
        assert weight is not None
        return weight

    def weight_since_zero(self, t_ns: Times) -> Array:
        """Return by how much the tool's weight (n, 6) on the sensor differs from that at its zero, N and N m."""
        moments = np.concatenate([self.tares[:1], t_ns])
        poses = stored_signal("tcp", moments, matrix_poses(self.played.tcp(moments)), "base")
        weight = self.weight(poses, moments)
        since: Array = weight[1:] - weight[0]
        return since


def play_logs(scenario: Scenario, solve: SolveContact) -> list[WorldLog]:
    """Return each sensor's touches, in the scenario's order: an indenter may be mounted again."""
    rig_setup = RigSetup(scenario, solve)
    logs = []
    for index, serial in enumerate(scenario.sensors):
        touches = [touch for touch in scenario.trajectories if touch.sensor == serial]
        start_ns = scenario.start_ns + index * BETWEEN_LOGS_NS
        logs.append(WorldLog(rig_setup, index, rig_setup.play(touches, index, start_ns)))
    return logs


def unfelt(gel: Gel, setup: TouchSetup, path: Path | None = None, missed: RealArray | None = None) -> BankedContact:
    """Return a touch's path without forces; a `SolveContact` for plans whose touches are laid out only.

    Parameters
    ----------
    gel : Gel
        Not used.
    setup : TouchSetup
        The touch.
    path : Path, optional
        The path where it is planned already.
    missed : (n, 3), m, optional
        See `RigContact.deviation`.
    """
    path = path or setup.plan(lambda _: setup.thickness)
    count = len(contact_times(path))
    return BankedContact(path, missed, np.zeros((count, 6)), np.zeros(count, dtype=bool), 0)


def stored_signal(name: str, t_ns: Times, values: Array, frame: str) -> StoredSignal:
    """Return a signal as a store holds it.

    Parameters
    ----------
    name : str
        Name of the stream, which decides columns and units.
    t_ns : (n,), ns
        Times.
    values : (n, c)
        Values in SI units.
    frame : str
        Frame of the values.
    """
    columns = SIGNAL_COLUMNS[name]
    return StoredSignal(t_ns, np.asarray(values), columns, signal_units(columns), frame, Stamps(t_ns))
