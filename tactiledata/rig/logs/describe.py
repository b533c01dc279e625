"""The description of a log (``schemas/log.json``), without anything that only the rig knows."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from tactiledata import __version__
from tactiledata.contract.description import LOG_FORMAT, LogDescription
from tactiledata.rig.logs.ros2_messages import FRAMES
from tactiledata.rig.play import PlayedLog, PlayedTrajectory, RigSetup
from tactiledata.rig.scenario.scenario import Scenario, SensorSetup

DECIMALS = 12
"""Decimal places of numbers in descriptions: a picometre, which drops rounding errors of arithmetic."""


def describe(
    rig_setup: RigSetup, played_log: PlayedLog, serials: Sequence[str], tares: Sequence[int]
) -> dict[str, Any]:
    """Return the description of one log, checked against its schema.

    Parameters
    ----------
    rig_setup : RigSetup
        The scenario and its indenters.
    played_log : PlayedLog
        The log, which decides the indenters that are described.
    serials : sequence of str
        Sensors of the log.
    tares : sequence of int
        Moments at which the force sensor was set to zero, ns of the host clock.
    """
    scenario = rig_setup.scenario
    robot = scenario.robot
    used = dict.fromkeys(play.touch.indenter for play in played_log.plays)
    document = {
        "format": LOG_FORMAT,
        **({"title": scenario.title} if scenario.title else {}),
        "sensors": {
            serial: _sensor(scenario.sensors[serial], played_log.start_ns - int(scenario.recordings.powered * 1e9))
            for serial in serials
        },
        "indenters": {name: _indenter(rig_setup, name) for name in used},
        "robot": {
            "model": "ur5e",
            "tcp_from_gel": _rounded(robot.tcp_from_gel.document()),
            "tcp_from_ft": _rounded(robot.tcp_from_ft.document()),
            "tool": {"mass": robot.tool_mass, "centre_of_gravity": list(robot.centre_of_gravity)},
        },
        "wrench": {
            "model": "robotiq_ft300s",
            "frame": FRAMES["wrench"],
            "sign": scenario.recordings.sign,
            "gravity": "included",
            "tare_ns": list(tares),
        },
        "clocks": _clocks(scenario),
        "recorded_by": {"tool": "tactiledata rig", "version": __version__, "contact": "simulated"},
    }
    LogDescription.checked(document, "the rig's description")
    return document


def _sensor(setup: SensorSetup, power_on_ns: int) -> dict[str, Any]:
    """Return the description of one sensor, as its data sheet and its operator would state it."""
    gel = setup.gel
    return {
        "model": "digit",
        "background": f"backgrounds/{setup.serial}.png",
        **({} if setup.shore_00 is None else {"shore_00": setup.shore_00}),
        "gel": {
            "outline": list(gel.outline),
            "thickness": gel.thickness,
            "edge_thickness": gel.thickness,
            "sides": "free",
            "backing": "bonded",
        },
        "power_on_ns": [power_on_ns],
    }


def _indenter(rig_setup: RigSetup, name: str) -> dict[str, Any]:
    """Return the description of one indenter: its shape, or its mesh file, and where it stands."""
    entry = rig_setup.scenario.indenters[name]
    solid = dict(rig_setup.indenters[name].document)
    if "mesh" in entry:
        solid = {"mesh": f"indenters/{name}.stl", "unit": entry["unit"]}
    return {**solid, "base_from_indenter": _rounded(rig_setup.mounted[name].document())}


def _clocks(scenario: Scenario) -> dict[str, Any]:
    """Return the offsets of the streams' clocks as far as they are known."""
    clocks = {}
    for stream in ("wrench", "tcp", "joints", "frames"):
        setup = scenario.clock(stream)
        clocks[stream] = {"offset_ns": setup.offset_ns if setup.known else 0, "known": setup.known}
    return clocks


def _rounded(document: dict[str, list[float]]) -> dict[str, list[float]]:
    """Return a document's numbers, rounded, with no negative zero."""
    return {key: [round(value, DECIMALS) + 0.0 for value in values] for key, values in document.items()}


def trajectory_rows(played_log: PlayedLog) -> Iterator[dict[str, Any]]:
    """Yield the rows of trajectories.csv; the free columns hold what an operator knows: commands, not outcomes."""
    for play in played_log.plays:
        yield {
            "trajectory": play.touch.name,
            "start_ns": play.start_ns,
            "end_ns": play.end_ns,
            "sensor": play.touch.sensor,
            "indenter": play.touch.indenter,
            **_commands(play),
        }


def _commands(play: PlayedTrajectory) -> dict[str, Any]:
    """Return the free columns of a trajectory: depth, shear, speed and step time as commanded."""
    press = next((step for step in play.touch.steps if step.kind == "press"), None)
    shear = next((step for step in play.touch.steps if step.kind == "shear"), None)
    by = (0.0, 0.0) if shear is None else shear.by
    return {
        "touch": play.touch.group or play.touch.name,
        "step_time_s": 0.0 if press is None else round(press.step / press.speed + press.settle, 6),
        "speed_m_s": 0.0 if press is None else round(press.speed, 9),
        "commanded_depth_m": round(float(play.path.positions[:, 2].max()), 9),
        "commanded_shear_x_m": round(by[0], 9),
        "commanded_shear_y_m": round(by[1], 9),
        "mount": play.mount,
    }
