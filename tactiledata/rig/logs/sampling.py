"""The recording of a played log by the instruments: streams with noise, clocks and losses, and pictures."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import RealArray
from tactiledata.contract.image_bytes import decode_rgb
from tactiledata.contract.paths import path_inside
from tactiledata.errors import BrokenLog, SchemaError
from tactiledata.rig.contact.footprint import GelGrid
from tactiledata.rig.hidden.sensing import hidden_loads, reported_readings, reported_stamps, sensed_loads
from tactiledata.rig.logs import imperfections
from tactiledata.rig.logs.describe import describe, trajectory_rows
from tactiledata.rig.logs.reflectance import HEIGHT, WIDTH, Camera, Optics
from tactiledata.rig.logs.tape import Samples, Shot, Tape
from tactiledata.rig.motion import ur5e
from tactiledata.rig.play import PlayedLog, PlayedTrajectory, RigSetup
from tactiledata.rig.scenario.scenario import Scenario
from tactiledata.sensors.backgrounds import load_background
from tactiledata.transforms import matrix_poses, move_wrench

GRAVITY = 9.81
"""Acceleration of gravity, m/s², along -z of the base frame."""
TARE_DELAY_NS = 100_000_000
"""Time from the start of a log or a trajectory until the force sensor is set to zero, ns."""
ARM_NOISE = 4.0
"""Noise of the arm's own force sensor relative to the force sensor's."""
SAMPLING, PICTURES = 6, 7
"""Numbers of the random streams of the instruments and of the pictures."""


def sample(rig_setup: RigSetup, name: str, index: int, played_log: PlayedLog) -> Tape:
    """Return the tape of one log.

    Parameters
    ----------
    rig_setup : RigSetup
        The scenario and its indenters.
    name : str
        Name of the log's file or folder, without ending.
    index : int
        Place of the log in the scenario; seeds what the instruments draw.
    played_log : PlayedLog
        What happened.
    """
    # streams of numbers; the order of the draws decides the bytes of the log
    scenario = rig_setup.scenario
    rng = np.random.default_rng([scenario.seed, SAMPLING, index])
    tares = tare_times(scenario, played_log)
    signals = {
        "tcp": _tcp(scenario, played_log, rng),
        "wrench": wrench_samples(scenario, played_log, index, tares, rng),
    }
    if scenario.streams.joints > 0:
        signals["joints"] = _joints(scenario, played_log, rng)
    if scenario.streams.arm_wrench > 0:
        signals["arm_wrench"] = _arm_wrench(scenario, played_log, rng)
    # pictures
    serials = list(dict.fromkeys(play.touch.sensor for play in played_log.plays))
    backgrounds = {serial: background_of(scenario, serial) for serial in serials}
    shots = _shots(scenario, played_log, backgrounds, index, rng)
    names_trajectories = scenario.recordings.name_trajectories
    # meshes of the indenters that took part
    files = {
        f"indenters/{key}.stl": path_inside(scenario.folder, entry["mesh"], f"indenters.{key}.mesh")
        for key, entry in scenario.indenters.items()
        if "mesh" in entry and any(play.touch.indenter == key for play in played_log.plays)
    }
    return Tape(
        name=name,
        index=index,
        scenario=scenario,
        description=describe(rig_setup, played_log, serials, tares),
        trajectories=tuple(trajectory_rows(played_log)) if names_trajectories else (),
        signals=signals,
        shots=tuple(shots),
        backgrounds={f"backgrounds/{serial}.png": picture for serial, picture in backgrounds.items()},
        files=files,
        truth={"played_log": played_log},
    )


def _tcp(scenario: Scenario, played_log: PlayedLog, rng: np.random.Generator) -> Samples:
    """Return the poses of the tool (n, 7) over a whole log, with noise of position."""
    clock = scenario.clock("tcp")
    host = _times(played_log, scenario.streams.tcp, clock.jitter, rng)
    poses = matrix_poses(played_log.tcp(host))
    poses[:, :3] += rng.normal(0.0, scenario.imperfections.tcp_noise, (len(host), 3))
    return Samples(host, imperfections.stream_stamps(host, clock), poses)


def _joints(scenario: Scenario, played_log: PlayedLog, rng: np.random.Generator) -> Samples:
    """Return the joint angles (n, 6), rad, over a whole log."""
    clock = scenario.clock("joints")
    host = _times(played_log, scenario.streams.joints, clock.jitter, rng)
    base_from_flange = played_log.tcp(host) @ scenario.robot.flange_from_tcp.inverse().matrix
    return Samples(host, imperfections.stream_stamps(host, clock), ur5e.inverse(base_from_flange))


def _times(played_log: PlayedLog, rate: float, jitter: float, rng: np.random.Generator) -> NDArray[np.int64]:
    """Return the moments of sampling (n,), ns of the host clock, over a whole log."""
    return imperfections.sampling_times(played_log.start_ns, played_log.end_ns, rate, jitter, rng)


def tare_times(scenario: Scenario, played_log: PlayedLog) -> list[int]:
    """Return the moments at which the force sensor is set to zero, ns of the host clock.

    They lie ``TARE_DELAY_NS`` after the start of the log where the scenario's ``recordings.tare`` is "log", after the
    start of each trajectory where it is "trajectory"; there are none otherwise.
    """
    setup = scenario.recordings.tare
    if setup == "log":
        return [played_log.start_ns + TARE_DELAY_NS]
    if setup == "trajectory":
        return [play.start_ns + TARE_DELAY_NS for play in played_log.plays]
    return []


def load_on_ft(scenario: Scenario, played_log: PlayedLog, host_ns: NDArray[np.int64]) -> RealArray:
    """Return the load (n, 6), N and N m, on the tool side, in the force sensor's frame: contact, weight, hidden loads.

    Parameters
    ----------
    scenario : Scenario
        Mounting of the sensors, mass of the tool, hidden effects.
    played_log : PlayedLog
        What happened.
    host_ns : (n,), ns
        Sorted moments of the host clock.
    """
    robot = scenario.robot
    ft_from_tcp = robot.tcp_from_ft.inverse().matrix
    on_gel = -played_log.wrench(host_ns)
    contact = move_wrench(on_gel, ft_from_tcp @ robot.tcp_from_gel.matrix)
    down = played_log.tcp(host_ns)[:, 2, :3] * (-robot.tool_mass * GRAVITY)
    weight = np.concatenate([down, np.cross(np.asarray(robot.centre_of_gravity), down)], axis=1)
    return contact + move_wrench(weight, ft_from_tcp) + hidden_loads(scenario, played_log, host_ns)


def wrench_samples(
    scenario: Scenario, played_log: PlayedLog, index: int, tares: list[int], rng: np.random.Generator
) -> Samples:
    """Return the readings of the force sensor (n, 6), N and N m, in its own frame, over a whole log.

    Parameters
    ----------
    scenario : Scenario
        Imperfections, streams, clocks and hidden effects.
    played_log : PlayedLog
        What happened.
    index : int
        Place of the log in the scenario; seeds hidden effects.
    tares : list of int
        Moments at which the sensor is set to zero, ns of the host clock.
    rng : Generator
        Draws noise, bias and losses.
    """
    # loads at the samples and at the moments of taring
    setup, streams, clock = scenario.imperfections, scenario.streams, scenario.clock("wrench")
    host = _times(played_log, streams.wrench, clock.jitter, rng)
    seconds = (host - played_log.start_ns) * 1e-9
    moments = np.concatenate([host, np.asarray(tares, dtype=np.int64)])
    order = np.argsort(moments, kind="stable")
    loads = np.empty((len(moments), 6))
    load = partial(load_on_ft, scenario, played_log)
    loads[order] = sensed_loads(scenario, played_log, index, load, moments[order])
    loads += imperfections.bias_over_time((moments - played_log.start_ns) * 1e-9, setup, rng)
    # from each taring on, the load at that moment is the zero
    reading: RealArray = loads[: len(host)].copy()
    for tare_ns, zero in zip(tares, loads[len(host) :], strict=True):
        reading[host >= tare_ns] = loads[: len(host)][host >= tare_ns] - zero
    # noise, quanta, repeated and lost samples
    scale = np.array([*[setup.force_noise] * 3, *[setup.torque_noise] * 3])
    reading += imperfections.coloured_noise(len(host), scale, streams.wrench, setup, rng)
    reading = reported_readings(scenario.hidden, imperfections.quantised(reading, setup))
    reading = imperfections.held(reading, seconds, streams.wrench_effective)
    if scenario.recordings.sign == "reaction":
        reading = -reading
    reading[imperfections.chosen(len(host), setup.nan_wrench, rng)] = np.nan
    stamps = reported_stamps(scenario.hidden, "wrench", imperfections.stream_stamps(host, clock), seconds)
    return Samples(host, stamps, reading)


def _arm_wrench(scenario: Scenario, played_log: PlayedLog, rng: np.random.Generator) -> Samples:
    """Return the readings (n, 6), N and N m, of the arm's own wrist sensor: a decoy for readers of the log.

    It measures the same load at the flange, with more noise, and is never set to zero.
    """
    setup = scenario.imperfections
    host = _times(played_log, scenario.streams.arm_wrench, 0.0, rng)
    at_flange = move_wrench(
        load_on_ft(scenario, played_log, host), (scenario.robot.flange_from_tcp @ scenario.robot.tcp_from_ft).matrix
    )
    at_flange += imperfections.bias_over_time((host - played_log.start_ns) * 1e-9, setup, rng)
    scale = ARM_NOISE * np.array([*[setup.force_noise] * 3, *[setup.torque_noise] * 3])
    noise = imperfections.coloured_noise(len(host), scale, scenario.streams.arm_wrench, setup, rng)
    return Samples(host, imperfections.stream_stamps(host, scenario.clock("joints")), at_flange + noise)


def _shots(
    scenario: Scenario,
    played_log: PlayedLog,
    backgrounds: dict[str, NDArray[np.uint8]],
    index: int,
    rng: np.random.Generator,
) -> list[Shot]:
    """Return the captured moments of one log, in time; pictures are drawn when they are written."""
    cameras = {
        serial: Camera(
            Optics.of_unit(serial, scenario.seed, scenario.sensors[serial].optics),
            background,
            GelGrid.of(scenario.sensors[serial].gel),
        )
        for serial, background in backgrounds.items()
    }
    clock = scenario.clock("frames")
    moments = sorted(_capture_moments(scenario, played_log, clock.jitter, rng), key=lambda moment: moment[0])
    dropped = imperfections.chosen(len(moments), scenario.imperfections.dropped_frames, rng)
    shots = []
    for number, ((host_ns, serial, play), lost) in enumerate(zip(moments, dropped, strict=True)):
        inside = play is not None and scenario.recordings.name_trajectories
        shots.append(
            Shot(
                host_ns,
                host_ns - clock.offset_ns,
                serial,
                play.touch.name if inside and play is not None else "",
                bool(lost),
                partial(_draw, cameras[serial], play, host_ns, [scenario.seed, PICTURES, index, number]),
            )
        )
    return shots


def _draw(camera: Camera, play: PlayedTrajectory | None, host_ns: int, seed: list[int]) -> NDArray[np.uint8]:
    """Return the picture (320, 240, 3), uint8 RGB, of a touch at a moment, or without contact."""
    rng = np.random.default_rng(seed)
    if play is None:
        return camera.picture(camera.at_rest, rng)
    return camera.picture(play.surface_at(host_ns), rng)


def _capture_moments(
    scenario: Scenario, played_log: PlayedLog, jitter: float, rng: np.random.Generator
) -> list[tuple[int, str, PlayedTrajectory | None]]:
    """Return moments of pictures, ns of the host clock, with sensor and touch; videos run over the whole log."""
    setup = scenario.images
    moments: list[tuple[int, str, PlayedTrajectory | None]] = []
    if setup.capture in ("step", "both"):
        for play in played_log.plays:
            late = np.abs(rng.normal(0.0, jitter, len(play.path.captures))) if jitter else 0.0
            host = play.start_ns + np.rint((play.path.captures - late) * 1e9).astype(np.int64)
            moments.extend((int(moment), play.touch.sensor, play) for moment in np.unique(host))
    if setup.capture in ("video", "both"):
        for serial in dict.fromkeys(play.touch.sensor for play in played_log.plays):
            host = _times(played_log, setup.rate, jitter, rng)
            for moment in host.tolist():
                moments.append((moment, serial, _touching(played_log, serial, moment)))
    return moments


def _touching(played_log: PlayedLog, serial: str, moment: int) -> PlayedTrajectory | None:
    """Return the trajectory on a sensor at a moment, ns of the host clock; None for none."""
    for play in played_log.plays:
        if play.start_ns <= moment < play.end_ns:
            return play if play.touch.sensor == serial else None
    return None


def background_of(scenario: Scenario, serial: str) -> NDArray[np.uint8]:
    """Return the real picture (320, 240, 3), uint8 RGB, of a sensor without contact.

    Parameters
    ----------
    scenario : Scenario
        Its ``sensors.<serial>.background`` names a file, relative to the scenario's folder, or a bundled picture.
    serial : str
        Serial number of the sensor.

    Raises
    ------
    MissingFile
        The name is neither a bundled background nor a file.
    SchemaError
        The file is no image, or an image of another size.
    """
    name = scenario.sensors[serial].background
    path = path_inside(scenario.folder, name, f"sensors.{serial}.background")
    if not path.is_file():
        return load_background(name)
    try:
        picture: Any = decode_rgb(path.read_bytes(), follow_orientation=True)
    except BrokenLog:
        picture = None
    if picture is None or picture.shape != (HEIGHT, WIDTH, 3):
        shape = "no image" if picture is None else f"an image of {picture.shape[0]} rows x {picture.shape[1]} columns"
        raise SchemaError(
            f"the background {path} of sensor {serial} is {shape}",
            f"an image of {HEIGHT} rows x {WIDTH} columns, as a DIGIT takes it",
            "Name another file, or one of the bundled backgrounds.",
            path=f"$.sensors.{serial}.background",
        )
    return picture
