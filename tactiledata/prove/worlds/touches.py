"""What the logs of a world say of each touch: poses as commanded, gravity, joints, what the place went through before.

Nothing here depends on forces or on what a world hides: it follows from the plan alone.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import Any

import numpy as np

from tactiledata.arrays import Array, Mask, Times
from tactiledata.calibrate.touches import MeasuredTouch
from tactiledata.effects.touch.imprint import ImprintTable, strongest_imprint
from tactiledata.effects.touch.moved_until import moved_until
from tactiledata.effects.touch.touch import Touch
from tactiledata.gel.contact.history import GelTouch
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.indenters.base.turned import reach_below_tip
from tactiledata.prove.worlds.logs import POSES, WorldLog
from tactiledata.rig.motion import ur5e
from tactiledata.rig.play import PlayedTrajectory
from tactiledata.sensors.base import GelGeometry
from tactiledata.transforms import Transform

BESIDE = 2e-3
"""Distance, m, within which an earlier touch counts as one of the same place."""
CLEAR = 1e-4
"""Height, m, over the gel, as commanded, from which a frame is free air."""
Way = tuple[Array, Array]
"""Times (m,), s from the log's start, and positions (m, 3), m, of the tip, as the stream of poses has them."""


def frame_times(play: PlayedTrajectory) -> Times:
    """Return when frames are taken, ns of the host clock: as the rig does, in the air, and on the way along and out."""
    path = play.path
    moving = [
        (start + end) / 2
        for start, end, here, there in zip(path.times, path.times[1:], path.positions, path.positions[1:], strict=False)
        if here[2] > 0 and (there[2] <= 0 or (here[2] == there[2] and np.linalg.norm(there - here) > 1e-9))
    ]
    seconds = np.unique(np.round([0.2, *path.captures, *moving[-3:], path.duration - 0.2], 6))
    return play.start_ns + np.rint(seconds * 1e9).astype(np.int64)


def told_touches(log: WorldLog, material: GelMaterial, geometry: GelGeometry) -> list[Touch]:
    """Return what a store would tell of each touch of a log.

    Parameters
    ----------
    log : WorldLog
        The touches as they were played; forces are not looked at.
    material : GelMaterial
        Material where a fit starts.
    geometry : GelGeometry
        Shape of the gel as the log describes it.
    """
    played, scenario = log.played, log.rig_setup.scenario
    robot = scenario.robot
    gel_from_ft = (robot.tcp_from_gel.inverse() @ robot.tcp_from_ft).matrix
    found: list[Touch] = []
    tables = {name: ImprintTable.of(indenter) for name, indenter in log.rig_setup.indenters.items()}
    for play, mounted in log.mounted:
        host = frame_times(play)
        tcp = played.tcp(host)
        base_from_gel = tcp @ robot.tcp_from_gel.matrix
        poses = np.linalg.inv(base_from_gel) @ mounted.matrix
        seconds = np.asarray((host - played.start_ns) * 1e-9, dtype=float)
        commanded = play.path.at((host - play.start_ns) * 1e-9)[:, 2]
        earlier = [other for other in found if other.sensor == play.touch.sensor]
        touch = Touch(
            seconds=seconds,
            poses=poses,
            indenter=log.rig_setup.indenters[play.touch.indenter],
            material=material,
            geometry=geometry,
            sensor=play.touch.sensor,
            indenter_name=play.touch.indenter,
            mount=f"{play.touch.indenter} {log.index}.{play.mount}",
            gravity=-9.80665 * base_from_gel[:, 2, :3],
            joints=np.asarray(ur5e.inverse(tcp @ robot.flange_from_tcp.inverse().matrix), dtype=float),
            powered=seconds + scenario.recordings.powered,
            earlier_depth=_as_deep(poses, play.touch.indenter, earlier, tables),
            earlier_contacts=np.full(len(host), float(sum(_is_beside(other, play) for other in earlier))),
            tare=(commanded < -CLEAR) & (seconds < seconds[int(np.argmax(commanded))]),
            **motion_until(seconds, way_of(log, play, mounted)),
            gel_from_sensor=np.tile(gel_from_ft, (len(host), 1, 1)),
            sensor_weight=log.weight_since_zero(host),
        )
        found.append(touch)
    return found


def way_of(log: WorldLog, play: PlayedTrajectory, mounted: Transform) -> Way:
    """Return the way of a touch's tip; see `Way`.

    Parameters
    ----------
    log : WorldLog
        The log that the touch is part of.
    play : PlayedTrajectory
        The touch.
    mounted : Transform
        ``base_from_indenter`` as the log states it.
    """
    host = play.start_ns + np.rint(np.arange(0.0, play.path.duration, 1.0 / POSES) * 1e9).astype(np.int64)
    base_from_gel = log.played.tcp(host) @ log.rig_setup.scenario.robot.tcp_from_gel.matrix
    places = (np.linalg.inv(base_from_gel) @ mounted.matrix)[:, :3, 3]
    return np.asarray((host - log.played.start_ns) * 1e-9, dtype=float), places


def motion_until(seconds: Array, way: Way) -> dict[str, Any]:
    """Return how a tip has moved until each of n moments, as fields of a `Touch`."""
    return dict(moved_until(seconds, *way))


def is_clear(touch: Touch) -> Mask:
    """Return the frames (n,) in free air: the lowest point of the indenter is over the gel."""
    return np.asarray(touch.tips[:, 2] - reach_below_tip(touch.indenter, touch.poses) > CLEAR)


def part_of(touch: Touch, rows: Mask) -> Touch:
    """Return a touch with some (n,) of its frames."""
    values = {field.name: getattr(touch, field.name) for field in fields(touch)}
    parts: dict[str, Any] = {key: one[rows] if isinstance(one, np.ndarray) else one for key, one in values.items()}
    return Touch(**parts)


def to_play(touches: Sequence[Touch]) -> list[MeasuredTouch]:
    """Return touches as the gel engine takes them, without forces."""
    return [
        MeasuredTouch(
            f"{number}", f"{number}", touch.sensor, touch.indenter_name, GelTouch(touch.indenter, touch.poses),
            np.zeros((len(touch), 6)), touch.seconds - touch.seconds[0], 40.0,
        )
        for number, touch in enumerate(touches)
    ]  # fmt: skip


def _as_deep(poses: Array, name: str, earlier: Sequence[Touch], tables: Mapping[str, ImprintTable]) -> Array:
    """Return how deep (n,), m, this indenter would have to press to do what the strongest earlier touch did there."""
    tips = [one.tips[int(np.argmin(one.tips[:, 2]))] for one in earlier]
    imprints = [float(tables[one.indenter_name].imprint(-tip[2])) for one, tip in zip(earlier, tips, strict=True)]
    pressed = np.array([tip[:2] for tip in tips])
    return tables[name].depth(strongest_imprint(poses[:, :2, 3], pressed, np.array(imprints)))


def _is_beside(other: Touch, play: PlayedTrajectory) -> bool:
    """Return whether an earlier touch came near the place of another."""
    away = other.tips[:, :2] - np.asarray(play.touch.position)
    return bool(np.linalg.norm(away, axis=1).min() < BESIDE)
