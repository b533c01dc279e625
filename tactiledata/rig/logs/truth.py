"""The truth beside the logs: what only the rig knows, for tests that compare; the toolkit never reads it."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from tactiledata.contract.atomic import write_atomic, write_json_atomic
from tactiledata.rig.hidden.contact import hidden_entries
from tactiledata.rig.logs.reflectance import Optics
from tactiledata.rig.logs.tape import Tape
from tactiledata.rig.play import PlayedLog, PlayedTrajectory

WRENCH = ("fx", "fy", "fz", "tx", "ty", "tz")


def write_truth(tape: Tape, folder: Path) -> None:
    """Write the truth of one log into a folder.

    ``<log>.json`` holds parameters, offsets and times of contact; ``<log>.parquet`` holds the contact at every wrench
    sample and frame, on the host clock.
    """
    played_log: PlayedLog = tape.truth["played_log"]
    scenario = tape.scenario
    write_json_atomic(
        folder / f"{tape.name}.json",
        {
            "material": asdict(scenario.material),
            "contact": {"form": scenario.contact, "pitch": scenario.contact_pitch},
            "imperfections": asdict(scenario.imperfections),
            "clocks": {name: asdict(scenario.clock(name)) for name in ("wrench", "tcp", "joints", "frames")},
            "sensors": {serial: _sensor(tape, serial) for serial in {play.touch.sensor for play in played_log.plays}},
            **({"hidden": hidden_entries(scenario.hidden)} if scenario.hidden else {}),
            "trajectories": {play.touch.name: _trajectory(play) for play in played_log.plays},
        },
    )
    sink = pa.BufferOutputStream()
    pq.write_table(_contacts(tape, played_log), sink, compression="zstd")
    write_atomic(folder / f"{tape.name}.parquet", sink.getvalue().to_pybytes())


def _sensor(tape: Tape, serial: str) -> dict[str, Any]:
    """Return gel and optics of one sensor, those that were drawn included."""
    setup = tape.scenario.sensors[serial]
    return {"gel": asdict(setup.gel), "optics": asdict(Optics.of_unit(serial, tape.scenario.seed, setup.optics))}


def _trajectory(play: PlayedTrajectory) -> dict[str, Any]:
    """Return times, offsets, peak force and phases of one trajectory, on the host clock."""
    seconds = np.arange(0.0, play.path.duration, 1e-4)
    host = play.start_ns + np.rint(seconds * 1e9).astype(np.int64)
    touching = np.flatnonzero(play.true_positions(host)[:, 2] > 0)
    return {
        "start_ns": play.start_ns,
        "end_ns": play.end_ns,
        "onset_ns": int(host[touching[0]]) if len(touching) else None,
        "release_ns": int(host[touching[-1]]) if len(touching) else None,
        "offset": [float(value) for value in play.offset],
        "position": list(play.touch.position),
        "tilt": list(play.touch.tilt),
        "yaw": play.touch.yaw,
        "peak_force": float(np.linalg.norm(play.contact.wrench[:, :3], axis=1).max()),
        "unsettled_steps": play.contact.unsettled,
        "slips": bool(play.contact.slipping.any()),
        "phases": [
            [play.start_ns + int(start * 1e9), play.start_ns + int(end * 1e9), name]
            for start, end, name in play.path.phases
        ],
    }


def _contacts(tape: Tape, played_log: PlayedLog) -> pa.Table:
    """Return the table of contacts: stream, times, trajectory, depth and wrench on the indenter in the gel frame."""
    samples = tape.signals["wrench"]
    frames = np.array([shot.host_ns for shot in tape.shots], dtype=np.int64)
    stamps = np.array([shot.stamp_ns for shot in tape.shots], dtype=np.int64)
    parts = []
    for stream, host, stamp in (("wrench", samples.host_ns, samples.stamp_ns), ("frames", frames, stamps)):
        wrench = played_log.wrench(host)
        names = np.full(len(host), "", dtype=object)
        depth = np.full(len(host), -1.0)
        for play in played_log.plays:
            first, last = np.searchsorted(host, [play.start_ns, play.end_ns])
            names[first:last] = play.touch.name
            depth[first:last] = play.true_positions(host[first:last])[:, 2]
        parts.append(
            pa.table(
                {
                    "stream": pa.array([stream] * len(host), pa.string()),
                    "host_ns": host,
                    "stamp_ns": stamp,
                    "trajectory": pa.array(names, pa.string()),
                    "depth": depth,
                    **{column: wrench[:, place] for place, column in enumerate(WRENCH)},
                }
            )
        )
    return pa.concat_tables(parts)
