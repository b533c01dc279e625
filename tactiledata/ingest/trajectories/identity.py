"""Which sensor each image and each trajectory belongs to, by serial."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Container
from dataclasses import replace
from typing import Any

import numpy as np

from tactiledata.contract.description import LogDescription
from tactiledata.contract.records import Finding, Recording, Trajectory
from tactiledata.contract.wording import agreeing, counted, listed
from tactiledata.ingest.trajectories.frames import CapturedFrames

Say = Callable[..., None]

UNKNOWN = "unknown-"
"""How the name of a sensor begins that nobody named; a digest of the recording follows."""


def name_sensors(
    recording: Recording,
    captured: CapturedFrames,
    trajectories: tuple[Trajectory, ...],
    sha256: str,
    say: Say,
) -> tuple[list[str], tuple[Trajectory, ...]]:
    """Return the sensor of each image, in the order of the sink, and the trajectories with their sensors.

    An image's serial comes from the recording, else from the trajectory that it lies in. What stays unknown is called
    ``unknown-<digest>``, so that two recordings of unknown sensors are never taken for one sensor; where several
    cameras of a recording are unknown, the name of the camera is added. A trajectory without a sensor in which several
    sensors recorded becomes one trajectory a sensor.

    Parameters
    ----------
    recording : Recording
        The recording as it was read.
    captured : CapturedFrames
        Its images, with the serials that the recording states.
    trajectories : tuple of Trajectory
        Its trajectories; their sensors may be empty.
    sha256 : str
        Digest of the recording's files, by which unknown sensors are named.
    say : callable
        Called with each finding.
    """
    sensors = list(captured.sensors)
    cameras = captured.images["camera"].to_pylist()
    _fill_from_trajectories(sensors, captured, trajectories)
    _one_camera_per_serial(sensors, cameras, say)
    known = sorted({sensor for sensor in sensors if sensor} | {t.sensor for t in trajectories if t.sensor})
    lost = sum(not sensor for sensor in sensors)
    unknown = _unknown_names({camera for camera, sensor in zip(cameras, sensors, strict=True) if not sensor}, sha256)
    if lost:
        names = " and ".join(repr(name) for name in sorted(unknown.values()))
        text = (
            f"{lost} of {len(sensors)} images do not say which sensor took them; they are filed under {names}. "
            "Name the serial in log.yaml (sensors:) or in a mapping (images: … sensor:)"
        )
        say(Finding("sensor-unknown", "warning", text, count=lost))
    sensors = [sensor or unknown[camera] for camera, sensor in zip(cameras, sensors, strict=True)]
    alone = known[0] if len(known) == 1 and not lost else ""
    named: list[Trajectory] = []
    parted: list[str] = []
    for trajectory in trajectories:
        inside = _sensors_inside(trajectory, captured, sensors) if len(sensors) else [alone]
        if trajectory.sensor or len(inside) < 2:
            named.append(trajectory if trajectory.sensor or not inside else replace(trajectory, sensor=inside[0]))
            continue
        parted.append(trajectory.name)
        taken = {each.name for each in (*trajectories, *named)}
        named += [
            replace(trajectory, name=_free_name(part_name(trajectory.name, sensor), taken), sensor=sensor)
            for sensor in inside
        ]
    if parted:
        text = (
            f"{counted(len(parted), 'trajectory')} {agreeing(len(parted), 'names', 'name')} no sensor and "
            f"{agreeing(len(parted), 'holds', 'hold')} images of several "
            f"({listed(parted, 3)}): each is kept once a sensor, as "
            f"{part_name(parted[0], '<serial>')!r}. Name the sensor of each trajectory if only one was touched"
        )
        say(Finding("trajectory-of-several-sensors", "warning", text, count=len(parted)))
    return sensors, tuple(named)


def _unknown_names(cameras: set[str], sha256: str) -> dict[str, str]:
    """A name for the sensor of each camera that nobody names, the same whenever the recording is read."""
    name = f"{UNKNOWN}{sha256[:8]}"
    return {camera: name if len(cameras) == 1 else f"{name}-{camera}" for camera in cameras}


def _fill_from_trajectories(sensors: list[str], captured: CapturedFrames, trajectories: tuple[Trajectory, ...]) -> None:
    """Images without a serial take that of the trajectory that they name or lie in."""
    by_name = {trajectory.name: trajectory.sensor for trajectory in trajectories}
    blank = np.array([not sensor for sensor in sensors], dtype=bool)
    for row in np.flatnonzero(blank):
        sensors[row] = by_name.get(captured.images["trajectory"][int(row)].as_py(), "")
    for trajectory in trajectories:
        if not trajectory.sensor:
            continue
        inside = (captured.t_ns >= trajectory.start_ns) & (captured.t_ns < trajectory.end_ns)
        for row in np.flatnonzero(inside):
            sensors[row] = sensors[row] or trajectory.sensor


def part_name(trajectory: str, sensor: str) -> str:
    """The name of the part of a trajectory that one of several sensors recorded."""
    return f"{trajectory}-{sensor}"


def _free_name(name: str, taken: Container[str]) -> str:
    """The name, or the first of ``name~2``, ``name~3``… that no other trajectory has."""
    names = itertools.chain([name], (f"{name}~{number}" for number in itertools.count(2)))
    return next(free for free in names if free not in taken)


def _sensors_inside(trajectory: Trajectory, captured: CapturedFrames, sensors: list[str]) -> list[str]:
    """The sensors of the images inside the half-open interval of a trajectory, in the order of the alphabet."""
    inside = (captured.t_ns >= trajectory.start_ns) & (captured.t_ns < trajectory.end_ns)
    return sorted({sensors[row] for row in np.flatnonzero(inside)})


def _one_camera_per_serial(sensors: list[str], cameras: list[str], say: Say) -> None:
    owners: dict[str, set[str]] = {}
    for sensor, camera in zip(sensors, cameras, strict=True):
        if sensor:
            owners.setdefault(sensor, set()).add(camera)
    for sensor, names in sorted(owners.items()):
        if len(names) > 1:
            text = (
                f"the cameras {', '.join(sorted(names))} say that they are the one sensor {sensor!r}; one is wrong. "
                "Name the right serials in a mapping (images: … sensor:)"
            )
            say(Finding("serial-shared", "damage", text, sorted(names)[0], count=len(names)))


def sensor_facts(description: LogDescription, serials: list[str]) -> dict[str, dict[str, Any]]:
    """What the recording says of each sensor, without the path of its background."""
    return {
        serial: {
            key: value
            for key, value in description.sensors.get(serial, {}).items()
            if key not in {"background", "power_on_ns"}
        }
        for serial in serials
        if serial
    }
