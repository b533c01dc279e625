"""A trial as a scenario file, which the rig can play and a person can follow."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from tactiledata.contract.schema import check_document
from tactiledata.diagnose.next_trial.bench import TrialBench
from tactiledata.diagnose.next_trial.path import FREE_FRAMES
from tactiledata.diagnose.next_trial.trial import Trial

FORMAT = "tactiledata-scenario/1"
Entries = Mapping[str, Mapping[str, Any]]
BACKGROUND = "digit-bg-5"
"""Bundled background for a sensor that names none; pictures are never transferred to it."""


def trial_scenario(
    trial: Trial, bench: TrialBench, sensors: Entries | None = None, indenters: Entries | None = None
) -> dict[str, Any]:
    """Return the scenario document of a trial (``schemas/scenario.json``).

    Parameters
    ----------
    trial : Trial
    bench : TrialBench
        Gives gel, material, force limit and indenters.
    sensors : dict, serial -> entry of the scenario, optional
        The first sensor is used, with the gel of the bench where its entry states none.
    indenters : dict, name -> entry of the scenario, optional
        Entries that replace those of the bench; an indenter that is a mesh must be given here.

    Raises
    ------
    SchemaError
        A sensor or indenter has an entry that no scenario can have.
    """
    # the sensor, the indenters that are used, and how recordings are parted
    serial = next(iter(sensors)) if sensors else bench.touch.sensor or "sensor"
    gel = bench.touch.geometry
    pad = {"outline": list(gel.outline), "thickness": gel.thickness}
    entry = dict(sensors[serial]) if sensors else {"background": BACKGROUND}
    used = dict.fromkeys(touch.indenter for touch in trial.touches)
    recordings: dict[str, Any] = {"group": "sensor", "tare": "log", "pause": trial.pause, "powered": trial.powered}
    if trial.per_recording:
        recordings["trajectories_per_log"] = trial.per_recording
    # the document
    document = {
        "format": FORMAT,
        "title": trial.title,
        "sensors": {serial: {"gel": pad, **entry}},
        "indenters": {name: dict((indenters or {}).get(name) or bench.indenter(name).document) for name in used},
        "material": asdict(bench.material),
        "streams": {"joints": 125, "tcp": 125, "wrench": 100, "arm_wrench": 0},
        "images": {
            "capture": trial.capture,
            "rate": trial.rate,
            "frames_per_step": trial.burst,
            "free_air_frames": FREE_FRAMES,
        },
        "recordings": recordings,
        "trajectories": [
            {
                "name": f"{trial.name}-{number}",
                "sensor": serial,
                "indenter": touch.indenter,
                "position": list(touch.position),
                "force_limit": bench.force_limit,
                "steps": [dict(step) for step in touch.steps],
            }
            for number, touch in enumerate(trial.touches, start=1)
        ],
    }
    check_document(document, "scenario", f"the scenario of trial {trial.name!r}")
    return document
