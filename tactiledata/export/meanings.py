"""What the streams of a store mean, in words: frame, sign, and where they come from."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping
from typing import Any

from tactiledata.loaders.streams import Stream
from tactiledata.store.read.reader import Store

SIGNS = {
    "load_on_sensor": "what the world exerts on the tool side: pressing pushes the gel along its -z",
    "reaction": "what the tool side exerts on the world",
    "": "the sign is not stated",
}
POSE = "pose of the tool centre point as the controller reports it: x y z, then a quaternion x y z w"


def stream_facts(store: Store, stream: Stream) -> dict[str, Any]:
    """Return columns, units, frame and meaning of a stream, as JSON values."""
    frame, meaning = _frame_and_words(store, stream)
    return {"columns": list(stream.columns), "units": list(stream.units), "frame": frame, "meaning": meaning}


def _frame_and_words(store: Store, stream: Stream) -> tuple[str, str]:
    """Return the frame of a stream's vectors, and a clause that says what it is."""
    base = stream.name.partition("@")[0]
    if stream.kind == "mesh_wrench":
        return "gel", "what the simulated gel exerts on the indenter (tactiledata replay); pressing gives fz > 0"
    if stream.kind == "frame_value":
        note = store.meaning("frame_values", stream.name).attributes.get("note", "")
        return store.meaning("frame_values", stream.name).frame, str(note) or "annotated frame by frame by the corpus"
    aligned = store.meaning("aligned", stream.name)
    signal = store.meaning("signals", stream.name) if stream.name in store.signal_names else aligned
    if stated := signal.attributes.get("meaning"):
        about = signal.attributes.get("torque_about")
        return aligned.frame, f"{stated}; torque about the {about}" if about else str(stated)
    if base == "wrench":
        return aligned.frame, f"reading of the force sensor; {_wrench_words(store)}"
    if base == "ur_wrench":
        return aligned.frame, "the robot's own estimate at its flange"
    if base == "tcp":
        return aligned.frame, POSE
    return aligned.frame, "joint angles, base to wrist" if base == "joints" else "as recorded"


def _wrench_words(store: Store) -> str:
    """Return sign and gravity of the force readings, with counts where recordings differ."""
    counts = Counter((stated.get("sign", ""), stated.get("gravity", "")) for stated in _stated_wrenches(store))
    clauses = []
    for (sign, gravity), count in sorted(counts.items()):
        weight = f"gravity {gravity}" if gravity else "whether gravity is included is not stated"
        share = f" ({count} recordings)" if len(counts) > 1 else ""
        clauses.append(f"{SIGNS.get(sign, sign)}, {weight}{share}")
    return "; ".join(clauses)


def _stated_wrenches(store: Store) -> list[Mapping[str, Any]]:
    """Return what each recording states of its force readings."""
    texts = store.sources(["description"])["description"].to_pylist()
    return [json.loads(text or "{}").get("wrench", {}) for text in texts]


def robot_model(store: Store) -> str | None:
    """Return the robot's model, where all recordings that state one agree; else ``None``."""
    texts = store.sources(["description"])["description"].to_pylist()
    stated = {json.loads(text or "{}").get("robot", {}).get("model", "") for text in texts} - {""}
    return stated.pop() if len(stated) == 1 else None
