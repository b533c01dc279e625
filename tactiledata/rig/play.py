"""The touches of one log, played: where the arm is and which wrench the gel exerts, at every moment."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import RealArray, Times
from tactiledata.indenters import make_indenter
from tactiledata.indenters.base import Indenter
from tactiledata.rig.contact.by_layer import touch_layer
from tactiledata.rig.contact.contact import CONTACT_RATE, PlayTouch, RigContact, TouchSetup, deviation_at
from tactiledata.rig.contact.footprint import GelGrid, make_footprint
from tactiledata.rig.hidden.base import EarlierTouch, TouchFacts
from tactiledata.rig.hidden.contact import analytic, touch_hidden
from tactiledata.rig.layer.grid import LayerGrid
from tactiledata.rig.layer.solver import Layer
from tactiledata.rig.motion import motion
from tactiledata.rig.motion.touch import TouchPlan
from tactiledata.rig.scenario.scenario import Gel, Material, Scenario
from tactiledata.transforms import Transform

TRAVEL_SPEED = 0.15
"""Mean speed of the arm between two indenters, m/s."""
TABLE_CORNER = (-0.02, -0.42, 0.12)
"""Position of the first indenter's tip, m, base frame; the others stand in a grid beside it."""
SPACING = 0.05
"""Distance between neighbouring indenters in that grid, m."""
PER_ROW = 4
"""Number of indenters in a row of the grid."""
MOUNTS, OFFSETS = 3, 4
"""Numbers of the random streams of errors of mounting and of positioning."""
TOUCHED = {"pose", "contact", "force"}
"""Values of ``HiddenEffect.ACTS`` with which an effect changes what happens in a touch."""


@dataclass(frozen=True)
class PlayedTrajectory:
    """One trajectory after it was played: its plan, its times and its contact.

    Parameters
    ----------
    touch : TouchPlan
        What the arm was commanded to do.
    start_ns : int
        Start of the trajectory, ns of the host clock.
    lowest : metres
        Height of the turned indenter's first-touching point over its tip; at most 0.
    offset : (3,), metres
        Constant error of arm and mount that adds to the path: x, y, depth. Known to the rig only.
    contact : RigContact
        What the gel does meanwhile.
    mount : int
        Number of times that indenters have been mounted in this log, this one included.
    """

    touch: TouchPlan
    start_ns: int
    lowest: float
    offset: RealArray
    contact: RigContact
    mount: int

    @property
    def path(self) -> motion.Path:
        """Commanded path of the indenter over the gel."""
        return self.contact.path

    @property
    def end_ns(self) -> int:
        """End of the trajectory's half-open interval, ns of the host clock."""
        return self.start_ns + int(np.ceil(self.path.duration * 1e9))

    def true_positions(self, host_ns: Times) -> RealArray:
        """Return the real positions of the indenter over the gel (n, 3): x, y of the tip, depth, metres."""
        seconds = (host_ns - self.start_ns) * 1e-9
        return self.path.at(seconds) + self.offset + deviation_at(self.contact.deviation, seconds)

    def wrench(self, host_ns: Times) -> RealArray:
        """Return the contact wrench (n, 6) on the indenter, gel frame, N and N m, at moments of the host clock."""
        ticks = (host_ns - self.start_ns) * 1e-9 * CONTACT_RATE
        columns = self.contact.wrench.T
        return np.stack([np.interp(ticks, np.arange(len(column)), column) for column in columns], axis=1)

    def surface_at(self, host_ns: int) -> NDArray[np.float32]:
        """Return the height of the gel's surface (n_y, n_x), metres, at one moment of the host clock."""
        return self.contact.surface((host_ns - self.start_ns) * 1e-9)


@dataclass(frozen=True)
class PlayedLog:
    """All trajectories of one log in time, and the motion of the arm between them.

    Parameters
    ----------
    plays : tuple of PlayedTrajectory
        The trajectories, in time.
    poses : tuple of (rotation, Transform)
        For each of them: gel_from_indenter (3, 3), and ``base_from_indenter`` as the log states it.
    tcp_from_gel : Transform
        Mounting of the sensor on the arm.
    start_ns, end_ns : int
        Interval of the log, ns of the host clock.
    """

    plays: tuple[PlayedTrajectory, ...]
    poses: tuple[tuple[RealArray, Transform], ...]
    tcp_from_gel: Transform
    start_ns: int
    end_ns: int

    def tcp(self, host_ns: Times) -> RealArray:
        """Return the commanded poses base_from_tcp (n, 4, 4), metres, at sorted moments (n,) of the host clock."""
        out = np.empty((len(host_ns), 4, 4))
        ends = [self._end_poses(index) for index in range(len(self.plays))]
        edges = np.searchsorted(host_ns, [[play.start_ns, play.end_ns] for play in self.plays])
        # at rest before the first trajectory and after the last one
        out[: edges[0, 0]] = ends[0][0]
        out[edges[-1, 1] :] = ends[-1][1]
        for index, play in enumerate(self.plays):
            first, last = edges[index]
            seconds = (host_ns[first:last] - play.start_ns) * 1e-9
            out[first:last] = self._poses(index, seconds)
            # between two trajectories: up from the table, over and down
            if index + 1 < len(self.plays):
                after = edges[index + 1, 0]
                span = self.plays[index + 1].start_ns - play.end_ns
                share = (host_ns[last:after] - play.end_ns) / span
                if after > last:
                    out[last:after] = motion.transit(ends[index][1], ends[index + 1][0], share)
        return out

    def _poses(self, index: int, seconds: RealArray) -> RealArray:
        """Return the poses base_from_tcp (n, 4, 4) of one trajectory at seconds (n,) from its start."""
        play, (rotation, mounted) = self.plays[index], self.poses[index]
        turned = play.path.turned(seconds) @ rotation
        return motion.base_from_tcp(play.path.at(seconds), turned, play.lowest, mounted, self.tcp_from_gel)

    def _end_poses(self, index: int) -> RealArray:
        """Return the first and the last pose (2, 4, 4) of one trajectory."""
        return self._poses(index, self.plays[index].path.times[[0, -1]])

    def wrench(self, host_ns: Times) -> RealArray:
        """Return the contact wrench (n, 6) on the indenter, gel frame, N and N m; zero between trajectories.

        ``host_ns`` (n,) are sorted moments of the host clock.
        """
        out = np.zeros((len(host_ns), 6))
        for play in self.plays:
            first, last = np.searchsorted(host_ns, [play.start_ns, play.end_ns])
            if last > first:
                out[first:last] = play.wrench(host_ns[first:last])
        return out


SolveContact = Callable[[Gel, TouchSetup, motion.Path | None, RealArray | None], RigContact]
"""Function that plays a touch on a gel, along a path that may be planned already, with a deviation (n, 3), m."""


class RigSetup:
    """The rig of a scenario: its indenters and layers, each made once, and the function that plays touches on it.

    Parameters
    ----------
    scenario : Scenario
        The world to play.
    solve : callable, optional
        Form of contact to use instead of the scenario's own, for example a bank of solved contacts.
    """

    def __init__(self, scenario: Scenario, solve: SolveContact | None = None) -> None:
        self.scenario = scenario
        self._own_solve = solve
        self.indenters: dict[str, Indenter] = {
            name: make_indenter(entry, scenario.folder, f"indenters.{name}")
            for name, entry in scenario.indenters.items()
        }
        self._layers: dict[tuple[Gel, Material], Layer] = {}
        self.mounted = {name: _mounted(index, entry) for index, (name, entry) in enumerate(scenario.indenters.items())}

    def play(
        self,
        touches: Sequence[TouchPlan],
        log_index: int,
        start_ns: int,
        report_played: Callable[[], None] = lambda: None,
    ) -> PlayedLog:
        """Play the touches of one log one after the other and return what happened.

        Parameters
        ----------
        touches : sequence of TouchPlan
            The touches of the log, in order.
        log_index : int
            Place of the log in the scenario; seeds the errors of mounting.
        start_ns : int
            Start of the log, ns of the host clock.
        report_played : callable
            Called after each touch.

        Raises
        ------
        UsageError
            A pose is out of the arm's reach.
        """
        robot, setup = self.scenario.robot, self.scenario.recordings
        rng = np.random.default_rng([self.scenario.seed, MOUNTS, log_index])
        plays: list[PlayedTrajectory] = []
        poses: list[tuple[RealArray, Transform]] = []
        cursor = start_ns + int(0.25e9)
        mount, remount = 0, np.zeros(3)
        earlier_touches: dict[str, list[EarlierTouch]] = {}
        for index, touch in enumerate(touches):
            # mounting an indenter adds an error that lasts until the next one is mounted
            if index == 0 or touches[index - 1].indenter != touch.indenter:
                mount += 1
                remount = rng.normal(0.0, self.scenario.imperfections.remount, 3)
            facts = TouchFacts(
                touch,
                self.scenario,
                (cursor - start_ns) * 1e-9,
                mount,
                log_index,
                self.mounted[touch.indenter],
                earlier_touches.setdefault(touch.sensor, []),
            )
            play = self._play(facts, cursor, remount)
            plays.append(play)
            report_played()
            poses.append((motion.gel_from_indenter_rotation(touch), self.mounted[touch.indenter]))
            # the arm needs time to reach the next indenter
            following = touches[min(index + 1, len(touches) - 1)].indenter
            distance = float(np.linalg.norm(self.mounted[touch.indenter].xyz - self.mounted[following].xyz))
            cursor = play.end_ns + int(max(setup.pause, distance / TRAVEL_SPEED) * 1e9)
        return PlayedLog(tuple(plays), tuple(poses), robot.tcp_from_gel, start_ns, plays[-1].end_ns + int(0.25e9))

    def _play(self, facts: TouchFacts, start_ns: int, remount: RealArray) -> PlayedTrajectory:
        """Return one touch, played with its own error of positioning beside that of the mounting (3,), m."""
        scenario, touch = self.scenario, facts.touch
        gel = scenario.sensors[touch.sensor].gel
        indenter = self.indenters[touch.indenter]
        rng = np.random.default_rng([scenario.seed, OFFSETS, _number(touch.name)])
        offset = remount + rng.normal(0.0, scenario.imperfections.pose_repeatability, 3)
        rotation = motion.gel_from_indenter_rotation(touch)
        footprint = make_footprint(indenter, rotation, touch.position, GelGrid.of(gel))
        images = scenario.images
        plan = partial(
            motion.plan, touch, frames_per_step=images.frames_per_step, free_air_frames=images.free_air_frames
        )
        setup = TouchSetup(touch, indenter, rotation, footprint, offset, gel.thickness, scenario.material, plan)
        # hidden effects change the setup before the contact is solved and the forces after
        solve = self._solve(gel)
        if any(effect.ACTS in TOUCHED for effect in scenario.hidden):
            setup, hidden, earlier = touch_hidden(setup, facts, scenario.hidden, solve)
            facts.earlier_touches.append(earlier)
            return PlayedTrajectory(touch, start_ns, footprint.lowest, setup.offset, hidden, facts.mount)
        return PlayedTrajectory(touch, start_ns, footprint.lowest, offset, solve(setup, None, None), facts.mount)

    def _solve(self, gel: Gel) -> PlayTouch:
        """Return the function that plays touches of a gel: the caller's own, the closed forms or the layer solver."""
        if self._own_solve is not None:
            return partial(self._own_solve, gel)
        return analytic if self.scenario.contact == "analytic" else partial(self._on_layer, gel)

    def _on_layer(
        self, gel: Gel, setup: TouchSetup, path: motion.Path | None, deviation: RealArray | None
    ) -> RigContact:
        """Return a touch played by the layer solver; layers are kept by the gel's real thickness and material."""
        real = replace(gel, thickness=setup.thickness)
        if (real, setup.material) not in self._layers:
            grid = LayerGrid.of(gel.outline, self.scenario.contact_pitch)
            self._layers[real, setup.material] = Layer(grid, setup.thickness, setup.material)
        return touch_layer(setup, self._layers[real, setup.material], path, deviation)


def _number(name: str) -> int:
    """Return a number for a touch's name, to seed random draws by it."""
    return int.from_bytes(name.encode()[:64], "big")


def _mounted(index: int, entry: Mapping[str, Any]) -> Transform:
    """Return base_from_indenter of an indenter: as stated, else in a grid on the table, its tip up."""
    if "base_from_indenter" in entry:
        return Transform.from_document("base", "indenter", entry["base_from_indenter"])
    column, row = index % PER_ROW, index // PER_ROW
    xyz = (TABLE_CORNER[0] + SPACING * column, TABLE_CORNER[1] - SPACING * row, TABLE_CORNER[2])
    # tip up: +z of the indenter, into its body, points down; a little off square, as mounted by hand
    return Transform.from_parts("base", "indenter", xyz, (0.9999, 0.0, 0.0087, 0.0105))
