"""What a recording states, against what can be: names that nobody knows, and numbers in another unit than SI.

Nothing is changed: the recording is kept as it says, and a finding names what to look at.
"""

from __future__ import annotations

import difflib
from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np

from tactiledata.contract.description import PLACEHOLDER, LogDescription
from tactiledata.contract.paths import path_inside
from tactiledata.contract.records import Finding, Recording
from tactiledata.errors import TactileDataError, UnsafeContent
from tactiledata.indenters import INDENTERS, make_indenter
from tactiledata.sensors import SENSORS
from tactiledata.units import SIGNAL_COLUMNS

UNDESCRIBED_MODELS = frozenset({"biotac", "camera", "gelsight", "gelsight_mini", "unknown"})
"""Models that corpora hold and the toolkit does not describe."""

OTHER_WORDS = {
    "ball": "sphere",
    "cube": "box",
    "cylinder": "cylinder_flat or cylinder_side",
    "plus": "cross",
    "square": "box",
    "wedge": "edge",
}
"""What people call shapes, and what they are called here."""

DERIVED = "contact_wrench"
"""The signal that has the times of another one, and no clock."""
FRAMES = "frames"
"""What images are called among the clocks of a description."""
LARGEST_GEL = 0.1
"""m. No gel is longer or thicker; larger numbers are millimetres."""
SMALLEST_GEL = 1e-4
FARTHEST = {"tcp_from_gel": 1.5, "tcp_from_ft": 1.5, "base_from_indenter": 5.0, "robot.tool.centre_of_gravity": 1.5}
"""m. Beyond this a stated distance is in millimetres."""
HEAVIEST_TOOL = 30.0
"""kg. More than any arm of these carries; a larger number is grams."""
UNTURNED = (0.0, 0.0, 0.0, 1.0)
"""A quaternion that turns nothing."""
UNIT_TOLERANCE = 1e-3
"""Deviation of a stated quaternion's length from 1 that rounding explains."""


def description_findings(description: LogDescription) -> list[Finding]:
    """What is implausible about what a recording says of itself."""
    found = [
        Finding("stated-implausible", "warning", f"{place} is {value}: {why}")
        for place, value, why in _implausible_numbers(description)
    ]
    for name, entry in description.indenters.items():
        found.extend(_indenter_findings(name, entry))
    for serial, facts in description.sensors.items():
        found.extend(_model_findings(serial, str(facts.get("model", ""))))
    left = [name for names in (description.sensors, description.indenters) for name in names if _is_placeholder(name)]
    if left:
        text = f"{', '.join(left)}: a placeholder of a draft was not replaced by the real name"
        found.append(Finding("placeholder-left", "warning", text, count=len(left)))
    return found


def unused_units(recording: Recording) -> list[Finding]:
    """Return a finding on units that a description states for tables of a folder log, where the recording is none.

    Parameters
    ----------
    recording : Recording
        As a format read it; a folder log's description states no units any more.
    """
    stated = recording.description.units
    if not stated:
        return []
    text = (
        f"units are stated of {', '.join(stated)}, for the tables of a folder log; of this {recording.source.format} "
        "recording they were used for nothing. A mapping states units beside fields: signals: … units"
    )
    return [Finding("units-not-used", "warning", text)]


def clock_findings(description: LogDescription, streams: Collection[str]) -> list[Finding]:
    """Findings on clocks that a recording states for streams that it does not have: their offsets do nothing.

    Parameters
    ----------
    description : LogDescription
    streams : names
        Signals of the recording.
    """
    there = sorted({*streams, FRAMES} - {DERIVED})
    stated = description.document.get("clocks", {})
    unknown = [name for name in stated if name not in {*there, *SIGNAL_COLUMNS} - {DERIVED}]
    found = []
    for name in unknown:
        near = difflib.get_close_matches(name, there, n=1, cutoff=0.6)
        meant = f"; did you mean {near[0]}?" if near else f": there are {', '.join(there)}."
        text = (
            f"clocks.{name} is of no stream of the recording, so that what it states was used for nothing{meant} "
            f"Images of all cameras go by {FRAMES}"
        )
        found.append(Finding("clock-unknown", "warning", text))
    return found


def _is_placeholder(name: str) -> bool:
    return name.startswith(f"{PLACEHOLDER}-")


def _indenter_findings(name: str, entry: Mapping[str, Any]) -> list[Finding]:
    """Whether the shape can be made; of a mesh only its place, its content is looked at by whoever uses it."""
    if (mesh := entry.get("mesh")) is not None:
        if not _leads_out(str(mesh)):
            return []
        text = (
            f"indenters.{name} names the mesh {mesh!r}, which leads out of the recording and is never read; expected a "
            "path beside it"
        )
        return [Finding("indenter-unusable", "warning", text)]
    try:
        make_indenter(entry, None, f"indenters.{name}")
    except TactileDataError as error:
        shape = str(entry.get("shape", "")).lower()
        hint = f" {entry['shape']!r} is called {OTHER_WORDS[shape]} here." if shape in OTHER_WORDS else ""
        if shape in INDENTERS and shape != entry["shape"]:
            hint = f" Names are written in small letters: {shape}."
        return [Finding("indenter-unusable", "warning", f"{error}{hint}")]
    return []


def mesh_findings(description: LogDescription, recording: Path) -> list[Finding]:
    """Findings on mesh files that a recording, or the mapping that it is read by, names and that are not beside it.

    They are looked for in the recording's folder and, where the recording is a folder, beside that too.
    """
    folders = (recording, recording.parent) if recording.is_dir() else (recording.parent,)
    named = {f"indenters.{name}": entry.get("mesh") for name, entry in description.indenters.items()}
    named |= {f"sensors.{name}.gel": facts.get("gel", {}).get("mesh") for name, facts in description.sensors.items()}
    found = []
    for place, mesh in named.items():
        if mesh is None or _leads_out(str(mesh)) or any(_is_file(folder, str(mesh)) for folder in folders):
            continue
        text = (
            f"{place} names the mesh {str(mesh)!r}, and there is no such file in {folders[0]}: nothing can be computed "
            "with it. Correct the name or copy the file there; for files elsewhere, give their folder to commands that "
            "compute as --indenters FOLDER"
        )
        found.append(Finding("mesh-missing", "warning", text))
    return found


def _leads_out(mesh: str) -> bool:
    path = PurePosixPath(mesh.replace("\\", "/"))
    return path.is_absolute() or ".." in path.parts


def _is_file(folder: Path, name: str) -> bool:
    try:
        return path_inside(folder, name, "a mesh").is_file()
    except (UnsafeContent, OSError):
        return False


def _model_findings(serial: str, model: str) -> list[Finding]:
    if model in SENSORS or model in UNDESCRIBED_MODELS:
        return []
    near = difflib.get_close_matches(model.lower().replace(" ", "_").replace("-", "_"), list(SENSORS), n=2, cutoff=0.5)
    meant = f"did you mean {' or '.join(near)}?" if near else f"known are {', '.join(SENSORS)}"
    text = (
        f"sensors.{serial}.model is {model!r}, which is not known: {meant} Its images were not checked against a model"
    )
    return [Finding("sensor-model-unknown", "warning", text)]


def _implausible_numbers(description: LogDescription) -> Iterator[tuple[str, object, str]]:
    """Place, value and reason of numbers that are most likely in another unit, or no rotation."""
    for place, pose in _poses(description):
        xyz, xyzw = pose
        limit = FARTHEST[place.rpartition(".")[2]]
        if np.linalg.norm(xyz) > limit:
            yield f"{place}.xyz", list(xyz), f"more than {limit:g} m away; lengths are in metres"
        length = float(np.linalg.norm(xyzw))
        if abs(length - 1) > UNIT_TOLERANCE:
            yield f"{place}.xyzw", list(xyzw), f"a quaternion of length {length:.4g}; it was scaled to 1"
    for serial, facts in description.sensors.items():
        gel = facts.get("gel", {})
        lengths = [*gel.get("outline", ()), *(gel[key] for key in ("thickness", "edge_thickness") if key in gel)]
        beyond = [length for length in lengths if not SMALLEST_GEL < length < LARGEST_GEL]
        if beyond:
            why = f"expected {SMALLEST_GEL:g} to {LARGEST_GEL:g}; lengths are in metres"
            yield f"sensors.{serial}.gel", beyond, why
    tool = description.robot.get("tool", {})
    if tool.get("mass", 0) > HEAVIEST_TOOL:
        yield "robot.tool.mass", tool["mass"], f"more than {HEAVIEST_TOOL:g} kg; masses are in kilograms"
    place = "robot.tool.centre_of_gravity"
    if np.linalg.norm(tool.get("centre_of_gravity", ())) > FARTHEST[place]:
        why = f"more than {FARTHEST[place]:g} m from the tcp; lengths are in metres"
        yield place, tool["centre_of_gravity"], why


def _poses(description: LogDescription) -> Iterator[tuple[str, tuple[Sequence[float], Sequence[float]]]]:
    """Stated poses with their places; those that are matrices were checked when they were read."""
    stated = {f"robot.{name}": description.robot.get(name) for name in ("tcp_from_gel", "tcp_from_ft")}
    for name, entry in description.indenters.items():
        stated[f"indenters.{name}.base_from_indenter"] = entry.get("base_from_indenter")
    for place, value in stated.items():
        if isinstance(value, Mapping):
            yield place, (value.get("xyz", ()), value.get("xyzw", UNTURNED))
        elif value is not None:
            yield place, ([row[3] for row in value[:3]], UNTURNED)
