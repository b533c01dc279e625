"""A mapping to start from, by the names and shapes of the arrays; what only a person knows is marked."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import yaml

from tactiledata.contract.description import PLACEHOLDER
from tactiledata.contract.wording import listed
from tactiledata.formats.hdf5.arrays import FEWEST_ROWS, FoundArray, joined, paths_read, streams_of

WORDS = {
    "wrench": r"wrench|force|(^|[/_])ft([/_\d]|$)|robotiq",
    "tcp": r"tcp|pose|(^|[/_])ee([/_]|$)|eef|end_?effector",
    "joints": r"joint|(^|[/_])q(pos)?([/_]|$)",
}
"""What is in the path of a signal that the toolkit knows."""
OTHER_WORDS = {
    "wrench": r"tcp|robot|(^|[/_])ur",
    "tcp": r"force|wrench|speed|vel|twist|acc",
    "joints": r"vel|speed|torque|effort|current|acc",
}
"""What says that it is something else: an arm's own estimate of force is not the force sensor's."""
COLUMNS = {
    "wrench": (("fx", "fy", "fz", "tx", "ty", "tz"), ("fx", "fy", "fz", "mx", "my", "mz")),
    "tcp": (("x", "y", "z", "qx", "qy", "qz", "qw"), ("x", "y", "z", "rx", "ry", "rz")),
    "joints": (tuple(f"q{joint}" for joint in range(6)), tuple(f"q{joint}" for joint in range(1, 7))),
}
"""Names of arrays in a group, an array a column."""
WIDTHS = {"wrench": (6,), "tcp": (7, 6), "joints": (6,)}
"""Numbers of columns of each, the likeliest first."""
MOST_SHOWN = 30
"""Arrays that are listed in comments."""

HEAD = """\
# A draft by the names and shapes of the arrays: check every line. topic and time are paths in the file.
# Pictures are taken to be RGB; write channel_order: bgr for pictures as OpenCV has them.
# wrench needs fx, fy, fz, tx, ty, tz in N and N m; tcp x, y, z in m and a quaternion x, y, z, w, or
# rotation: rotation_vector; joints six angles in rad. Other units are brought to these where they are stated:
# units: [mN, mN, mN, N mm, N mm, N mm].
# Columns of a wider array: fields: ["[0]", "[1]", "[2]", "[3]", "[4]", "[5]"].
"""
MORE = """\
# What the file does not say of itself goes under `description:` too (docs/formats-folder.md), for example:
#   wrench: {sign: load_on_sensor, gravity: included}
#   trajectories: [{trajectory: t0, start_ns: 0, end_ns: 1000000000, indenter: ball4}]
"""


@dataclass(frozen=True)
class ArrayDraft:
    """A mapping for a file of arrays.

    Parameters
    ----------
    document : dict
        It fits ``schemas/mapping.json``.
    text : str
        The same as YAML, with remarks in comments.
    """

    document: dict[str, Any]
    text: str


def draft_mapping(arrays: Sequence[FoundArray]) -> ArrayDraft:
    """Return a mapping that reads what names and shapes tell; it fits the schema as it stands.

    Parameters
    ----------
    arrays : sequence of FoundArray
        The arrays of a file.
    """
    streams = streams_of(arrays)
    signals: dict[str, dict[str, Any]] = {}
    for name, words in WORDS.items():
        for width in WIDTHS[name]:
            found = [
                (one, time)
                for one, time in streams
                if one.kind == "numbers"
                and one.shape[1:] == (width,)
                and re.search(words, one.path, re.IGNORECASE)
                and not re.search(OTHER_WORDS[name], one.path.replace("robotiq", ""), re.IGNORECASE)
            ]
            if found:
                signals[name] = _entry(*found[0])
                if name == "tcp" and width == 6:
                    signals[name]["rotation"] = "rotation_vector"
                break
        if name not in signals and (entry := _by_columns(name, streams)):
            signals[name] = entry
    pictures = [(one, time) for one, time in streams if one.kind in ("pictures", "packed pictures")]
    images, sensors = {}, {}
    for number, (one, time) in enumerate(pictures):
        camera = "digit" if number == 0 else f"digit_{number + 1}"
        serial = f"{PLACEHOLDER}-with-serial-of-{camera}"
        images[camera] = {**_entry(one, time), "sensor": serial}
        sensors[serial] = {"model": "digit"}
    document: dict[str, Any] = {"format": "tactiledata-mapping/1"}
    document |= {"signals": signals} if signals else {}
    document |= {"images": images} if images else {}
    document |= {"description": {"sensors": sensors}} if sensors else {}
    read = paths_read(document)
    return ArrayDraft(document, _text(document, [one for one in arrays if one.path not in read], streams))


def _by_columns(name: str, streams: Sequence[tuple[FoundArray, FoundArray]]) -> dict[str, Any]:
    """Return what a mapping says of a signal whose columns are arrays of one group; empty where there is none."""
    columns = {one.path: time for one, time in streams if one.kind == "numbers" and one.shape[1:] in ((), (1,))}
    for folder in dict.fromkeys(one.folder for one, _ in streams):
        for fields in COLUMNS[name]:
            paths = [joined(folder, field) for field in fields]
            if all(path in columns for path in paths):
                time = columns[paths[0]]
                entry = {"topic": folder or "/", "fields": list(fields), "time": time.path, "time_unit": time.unit}
                return {**entry, "rotation": "rotation_vector"} if "rx" in fields else entry
    return {}


def _entry(array: FoundArray, time: FoundArray) -> dict[str, Any]:
    """Return what a mapping says of an array and of its times."""
    return {"topic": array.path, "time": time.path, "time_unit": time.unit}


def _line_for(array: FoundArray, time: FoundArray | None, document: dict[str, Any]) -> str:
    """Return a line of a mapping that would read an array of which the name says too little; empty for none."""
    if array.is_time or array.kind == "other" or array.rows < FEWEST_ROWS:
        return ""
    entry = {"topic": array.path, "time": f"{PLACEHOLDER}-with-path-of-times"} if time is None else _entry(array, time)
    if array.kind != "numbers":
        camera = re.sub(r"[^a-z0-9_]", "_", array.name.lower()).lstrip("_0123456789") or "camera"
        return f"images: {_flow({camera: {**entry, 'sensor': f'{PLACEHOLDER}-with-serial'}})}"
    width = array.shape[1] if len(array.shape) == 2 else 1
    likely = [
        name
        for name in WIDTHS
        if width in WIDTHS[name] and name not in document.get("signals", {})
        if not re.search(OTHER_WORDS[name], array.path, re.IGNORECASE)
    ]
    if likely and (likely[0], width) == ("tcp", 6):
        entry["rotation"] = "rotation_vector"
    return f"signals: {_flow({likely[0]: entry})}" if likely else ""


def _flow(entry: dict[str, Any]) -> str:
    """Return an entry as YAML in one line."""
    return yaml.safe_dump(entry, sort_keys=False, default_flow_style=True, width=10_000, allow_unicode=True).strip()


def _text(
    document: dict[str, Any], unread: Sequence[FoundArray], streams: Sequence[tuple[FoundArray, FoundArray]]
) -> str:
    """Return the document as YAML, and the arrays that it does not read in comments."""
    times = {one.path: time for one, time in streams}
    text = HEAD + yaml.safe_dump(document, sort_keys=False, allow_unicode=True)
    if unread:
        text += "# Not read:\n"
        for one in unread[:MOST_SHOWN]:
            beside = f", times in {times[one.path].path}" if one.path in times else ""
            path = one.path if one.path.isprintable() else repr(one.path)  # a line break would end the comment
            text += f"#   {path}: {one.dtype} {listed([str(size) for size in one.shape], 4)}{beside}\n"
            if line := _line_for(one, times.get(one.path), document):
                text += f"#       to read it: {line}\n"
        if len(unread) > MOST_SHOWN:
            text += f"#   and {len(unread) - MOST_SHOWN} more\n"
    return text + MORE
