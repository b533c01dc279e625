"""One log's worth of touches, played: where the arm is, what the gel feels, at every moment."""

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
from tactiledata.rig.scenario.scenario import Gel, Scenario
from tactiledata.transforms import Transform

TRAVEL_SPEED = 0.15
"""m/s between indenters."""
TABLE_CORNER = (-0.02, -0.42, 0.12)
"""m, base frame: where the first indenter's tip stands; the others in a grid beside it."""
SPACING = 0.05
PER_ROW = 4
MOUNTS, OFFSETS = 3, 4
"""Numbers of the random streams."""
TOUCHED = {"pose", "contact", "force"}
"""Places where a hidden effect changes what happens in a touch."""


@dataclass(frozen=True)
class PlayedTrajectory:
    """One trajectory, played.

    Parameters
    ----------
    touch : TouchPlan
    start_ns : int
        Of the host clock.
    lowest : metres
        Height of the turned indenter's first-touching point over its tip; at most 0.
    offset : (3,), metres
        What the arm and the mount really add to the path: x, y, depth. Known to the rig only.
    contact : RigContact
        What the gel does.
    mount : int
        How often indenters have been mounted in this log before.
    """

    touch: TouchPlan
    start_ns: int
    lowest: float
    offset: RealArray
    contact: RigContact
    mount: int

    @property
    def path(self) -> motion.Path:
        """As commanded."""
        return self.contact.path

    @property
    def end_ns(self) -> int:
        """End of the half-open interval of the host clock."""
        return self.start_ns + int(np.ceil(self.path.duration * 1e9))

    def true_positions(self, host_ns: Times) -> RealArray:
        """Where the indenter really is over the gel (n, 3): x, y of the tip, depth, metres."""
        seconds = (host_ns - self.start_ns) * 1e-9
        return self.path.at(seconds) + self.offset + deviation_at(self.contact.deviation, seconds)

    def wrench(self, host_ns: Times) -> RealArray:
        """Contact wrench (n, 6) on the indenter, gel frame: N, N m."""
        ticks = (host_ns - self.start_ns) * 1e-9 * CONTACT_RATE
        columns = self.contact.wrench.T
        return np.stack([np.interp(ticks, np.arange(len(column)), column) for column in columns], axis=1)

    def surface_at(self, host_ns: int) -> NDArray[np.float32]:
        """The gel's surface (n_y, n_x), metres, at one moment."""
        return self.contact.surface((host_ns - self.start_ns) * 1e-9)


@dataclass(frozen=True)
class PlayedLog:
    """All trajectories of one log in time, and the ways between them."""

    plays: tuple[PlayedTrajectory, ...]
    poses: tuple[tuple[RealArray, Transform], ...]
    """Per play: gel_from_indenter rotation (3, 3), and the mounted ``base_from_indenter`` as the log states it."""
    tcp_from_gel: Transform
    start_ns: int
    end_ns: int

    def tcp(self, host_ns: Times) -> RealArray:
        """Commanded poses (n, 4, 4) base_from_tcp at sorted moments of the host clock."""
        out = np.empty((len(host_ns), 4, 4))
        ends = [self._end_poses(index) for index in range(len(self.plays))]
        edges = np.searchsorted(host_ns, [[play.start_ns, play.end_ns] for play in self.plays])
        out[: edges[0, 0]] = ends[0][0]
        out[edges[-1, 1] :] = ends[-1][1]
        for index, play in enumerate(self.plays):
            first, last = edges[index]
            seconds = (host_ns[first:last] - play.start_ns) * 1e-9
            out[first:last] = self._poses(index, seconds)
            if index + 1 < len(self.plays):
                after = edges[index + 1, 0]
                span = self.plays[index + 1].start_ns - play.end_ns
                share = (host_ns[last:after] - play.end_ns) / span
                if after > last:
                    out[last:after] = motion.transit(ends[index][1], ends[index + 1][0], share)
        return out

    def _poses(self, index: int, seconds: RealArray) -> RealArray:
        play, (rotation, mounted) = self.plays[index], self.poses[index]
        turned = play.path.turned(seconds) @ rotation
        return motion.base_from_tcp(play.path.at(seconds), turned, play.lowest, mounted, self.tcp_from_gel)

    def _end_poses(self, index: int) -> RealArray:
        return self._poses(index, self.plays[index].path.times[[0, -1]])

    def wrench(self, host_ns: Times) -> RealArray:
        """Contact wrench (n, 6) on the indenter, gel frame, at sorted moments; zero between trajectories."""
        out = np.zeros((len(host_ns), 6))
        for play in self.plays:
            first, last = np.searchsorted(host_ns, [play.start_ns, play.end_ns])
            if last > first:
                out[first:last] = play.wrench(host_ns[first:last])
        return out


SolveContact = Callable[[Gel, TouchSetup, motion.Path | None, RealArray | None], RigContact]
"""A touch of a gel, played along a path that may be planned already, and missed by (n, 3) m."""


class RigSetup:
    """Indenters and footprints of a scenario, each made once.

    Parameters
    ----------
    scenario : Scenario
    solve : callable, optional
        What answers for the contact in place of what the scenario asks for.
    """

    def __init__(self, scenario: Scenario, solve: SolveContact | None = None) -> None:
        self.scenario = scenario
        self._own_solve = solve
        self.indenters: dict[str, Indenter] = {
            name: make_indenter(entry, scenario.folder, f"indenters.{name}")
            for name, entry in scenario.indenters.items()
        }
        self._layers: dict[Gel, Layer] = {}
        self.mounted = {name: _mounted(index, entry) for index, (name, entry) in enumerate(scenario.indenters.items())}

    def play(
        self,
        touches: Sequence[TouchPlan],
        log_index: int,
        start_ns: int,
        played: Callable[[], None] = lambda: None,
    ) -> PlayedLog:
        """The touches one after the other, from ``start_ns`` of the host clock; ``played`` is called after each."""
        robot, setup = self.scenario.robot, self.scenario.recordings
        rng = np.random.default_rng([self.scenario.seed, MOUNTS, log_index])
        plays: list[PlayedTrajectory] = []
        poses: list[tuple[RealArray, Transform]] = []
        cursor = start_ns + int(0.25e9)
        mount, remount = 0, np.zeros(3)
        earlier_touches: dict[str, list[EarlierTouch]] = {}
        for index, touch in enumerate(touches):
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
            played()
            poses.append((motion.gel_from_indenter_rotation(touch), self.mounted[touch.indenter]))
            nearby = touches[min(index + 1, len(touches) - 1)].indenter
            way = float(np.linalg.norm(self.mounted[touch.indenter].xyz - self.mounted[nearby].xyz))
            cursor = play.end_ns + int(max(setup.pause, way / TRAVEL_SPEED) * 1e9)
        return PlayedLog(tuple(plays), tuple(poses), robot.tcp_from_gel, start_ns, plays[-1].end_ns + int(0.25e9))

    def _play(self, facts: TouchFacts, start_ns: int, remount: RealArray) -> PlayedTrajectory:
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
        solve = self._solve(gel)
        if any(effect.ACTS in TOUCHED for effect in scenario.hidden):
            setup, hidden, earlier = touch_hidden(setup, facts, scenario.hidden, solve)
            facts.earlier_touches.append(earlier)
            return PlayedTrajectory(touch, start_ns, footprint.lowest, setup.offset, hidden, facts.mount)
        return PlayedTrajectory(touch, start_ns, footprint.lowest, offset, solve(setup, None, None), facts.mount)

    def _solve(self, gel: Gel) -> PlayTouch:
        if self._own_solve is not None:
            return partial(self._own_solve, gel)
        return analytic if self.scenario.contact == "analytic" else partial(self._on_layer, gel)

    def _on_layer(
        self, gel: Gel, setup: TouchSetup, path: motion.Path | None, deviation: RealArray | None
    ) -> RigContact:
        real = replace(gel, thickness=setup.thickness)
        if real not in self._layers:
            grid = LayerGrid.of(gel.outline, self.scenario.contact_pitch)
            self._layers[real] = Layer(grid, setup.thickness, self.scenario.material)
        return touch_layer(setup, self._layers[real], path, deviation)


def _number(name: str) -> int:
    return int.from_bytes(name.encode()[:64], "big")


def _mounted(index: int, entry: Mapping[str, Any]) -> Transform:
    """Where an indenter stands: as stated, else in a grid on the table, its tip up."""
    if "base_from_indenter" in entry:
        return Transform.from_document("base", "indenter", entry["base_from_indenter"])
    column, row = index % PER_ROW, index // PER_ROW
    xyz = (TABLE_CORNER[0] + SPACING * column, TABLE_CORNER[1] - SPACING * row, TABLE_CORNER[2])
    # tip up: +z of the indenter, into its body, points down; a little off square, as mounted by hand
    return Transform.from_parts("base", "indenter", xyz, (0.9999, 0.0, 0.0087, 0.0105))
