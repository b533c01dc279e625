"""A trial as a scenario file, that the rig can play and a person can follow."""

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
"""A bundled one, where nobody names the sensor's own; none that pictures are transferred to."""


def trial_scenario(
    trial: Trial, bench: TrialBench, sensors: Entries | None = None, indenters: Entries | None = None
) -> dict[str, Any]:
    """The document, fit for ``schemas/scenario.json``.

    Parameters
    ----------
    sensors : serial -> entry of the scenario, optional
        The first is used, with the gel of the bench where it states none.
    indenters : name -> entry of the scenario, optional
        In place of those of the bench, by name; a mesh must be given here.

    Raises
    ------
    SchemaError
        An entry that no scenario can have.
    """
    serial = next(iter(sensors)) if sensors else bench.touch.sensor or "sensor"
    gel = bench.touch.geometry
    pad = {"outline": list(gel.outline), "thickness": gel.thickness}
    entry = dict(sensors[serial]) if sensors else {"background": BACKGROUND}
    used = dict.fromkeys(one.indenter for one in trial.touches)
    recordings: dict[str, Any] = {"group": "sensor", "tare": "log", "pause": trial.pause, "powered": trial.powered}
    if trial.per_recording:
        recordings["trajectories_per_log"] = trial.per_recording
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
                "indenter": one.indenter,
                "position": list(one.position),
                "force_limit": bench.force_limit,
                "steps": [dict(step) for step in one.steps],
            }
            for number, one in enumerate(trial.touches, start=1)
        ],
    }
    check_document(document, "scenario", f"the scenario of trial {trial.name!r}")
    return document
