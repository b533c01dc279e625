"""A store in numbers, for people who ask what is in it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
import pyarrow as pa

from tactiledata.contract.records import Finding
from tactiledata.store.read.flags import flagged_trajectories
from tactiledata.store.read.named_trajectories import full_names
from tactiledata.store.read.recording_names import recording_names
from tactiledata.store.read.simulated import simulated_recordings

if TYPE_CHECKING:
    from tactiledata.store.read.reader import Store

NOTHING_BESIDE: Mapping[int, Sequence[Finding]] = MappingProxyType({})
"""No finding but those that the store keeps."""


def overview(store: Store, beside: Mapping[int, Sequence[Finding]] = NOTHING_BESIDE) -> dict[str, Any]:
    """Counts of cameras, sensors, indenters, statuses and findings of a store, and its signals, as JSON values.

    Parameters
    ----------
    store : Store
    beside : dict, row of a recording -> findings
        Findings that the store does not keep and that are counted with its own.
    """
    trajectories = store.trajectories(["sensor", "indenter", "frame_start", "frame_stop"])
    sources = store.sources(["status"])
    return {
        "sources": sources.num_rows,
        "trajectories": trajectories.num_rows,
        "frames": store.n_frames,
        "simulated_recordings": simulated_recordings(store).document(),
        "digest": store.digest,
        "cameras": list(store.cameras),
        "by_camera": _by_camera(store),
        "by_sensor": _by_sensor(store, trajectories),
        "by_indenter": _by_indenter(trajectories),
        "signals": {name: _signal(store, name) for name in store.signal_names},
        "status": dict(Counter(sources["status"].to_pylist())),
        "findings": _findings(_finding_rows(store, beside)),
        "splits": list(store.split_names()),
        "flagged": [flag.document() for flag in flagged_trajectories(store).values()],
        "meshes": {name: _mesh(store, name) for name in store.mesh_names},
    }


def listed_trajectories(store: Store) -> list[dict[str, Any]]:
    """The trajectories of a store in their order, as JSON values: what each is called, and what it holds.

    Returns
    -------
    list of dict
        ``name``, ``uid``, ``sensor``, ``indenter``; ``images``; ``seconds``; ``peak_force`` in N, ``None`` where no
        force was recorded; ``flag``, its reason, empty where it has none.
    """
    flagged = flagged_trajectories(store)
    columns = ["uid", "sensor", "indenter", "start_ns", "end_ns", "frame_start", "frame_stop", "peak_force"]
    rows = store.trajectories(columns).to_pylist()
    return [
        {
            "name": name,
            **{key: row[key] for key in ("uid", "sensor", "indenter")},
            "images": row["frame_stop"] - row["frame_start"],
            "seconds": (row["end_ns"] - row["start_ns"]) / 1e9,
            "peak_force": None if row["peak_force"] is None or np.isnan(row["peak_force"]) else row["peak_force"],
            "flag": flagged[row["uid"]].reason if row["uid"] in flagged else "",
        }
        for name, row in zip(full_names(store), rows, strict=True)
    ]


def found_in(store: Store, beside: Mapping[int, Sequence[Finding]] = NOTHING_BESIDE) -> list[dict[str, Any]]:
    """Every finding of a store, as JSON values, each with the name of its recording as ``source``.

    Parameters
    ----------
    store : Store
    beside : dict, row of a recording -> findings
        Findings that the store does not keep.
    """
    keys = recording_names(store)
    return [{**row, "source": keys[row["source"]]} for row in _finding_rows(store, beside)]


def _finding_rows(store: Store, beside: Mapping[int, Sequence[Finding]]) -> list[dict[str, Any]]:
    further = [{"source": row, **vars(finding)} for row, found in beside.items() for finding in found]
    return [*store.findings().to_pylist(), *further]


def _by_camera(store: Store) -> dict[str, dict[str, Any]]:
    keys = recording_names(store)
    rows = store.frames(["camera", "source"]).group_by(["camera", "source"]).aggregate([([], "count_all")]).to_pylist()
    found: dict[str, dict[str, Any]] = {}
    for row in sorted(rows, key=lambda row: (row["camera"], row["source"])):
        entry = found.setdefault(row["camera"], {"frames": 0, "recordings": []})
        entry["frames"] += row["count_all"]
        entry["recordings"].append(keys[row["source"]])
    return found


def _by_sensor(store: Store, trajectories: pa.Table) -> dict[str, dict[str, Any]]:
    touched = Counter(trajectories["sensor"].to_pylist())
    counts = store.frames(["sensor"])["sensor"].value_counts().to_pylist()
    pictured = {entry["values"]: entry["counts"] for entry in counts}
    facts = store.sensors()
    return {
        name: {
            "model": facts.get(name, {}).get("model", ""),
            "trajectories": touched.get(name, 0),
            "frames": pictured.get(name, 0),
        }
        for name in sorted({*touched, *pictured, *facts} - {""})
    }


def _by_indenter(trajectories: pa.Table) -> dict[str, dict[str, int]]:
    frames = trajectories["frame_stop"].to_numpy() - trajectories["frame_start"].to_numpy()
    names, row = np.unique(
        np.array(trajectories["indenter"].to_pylist(), dtype=object).astype(str), return_inverse=True
    )
    totals = np.bincount(row, weights=frames, minlength=len(names)).astype(int)
    touches = np.bincount(row, minlength=len(names))
    return {
        str(name): {"trajectories": int(touch), "frames": int(total)}
        for name, touch, total in zip(names, touches, totals, strict=True)
    }


def shown_rate(rate: float | None) -> float | str:
    """Return a rate (Hz) as people read it, to a tenth; a dash where there is none."""
    return round(rate, 1) if rate else "-"


def _signal(store: Store, name: str) -> dict[str, Any]:
    signal = store.signal(name)
    return {
        "columns": list(signal.columns),
        "units": list(signal.units),
        "frame": signal.frame,
        "samples": signal.n_rows,
        "rate_hz": signal.attributes.get("rate_hz"),
        "effective_rate_hz": signal.attributes.get("effective_rate_hz"),
    }


def _mesh(store: Store, name: str) -> dict[str, Any]:
    mesh = store.mesh(name)
    return {
        "frames": mesh.facts["rows"],
        "vertices": mesh.facts["sizes"]["vertices"],
        "kept": mesh.facts["sizes"]["kept"],
        "fidelity": mesh.settings["fidelity"],
        "material": mesh.settings["material"],
        "effects": [effect["effect"] for effect in mesh.settings.get("effects", [])],
        "status": {mesh.statuses[int(code)]: count for code, count in sorted(mesh.facts["counts"].items())},
    }


def _findings(rows: Sequence[Mapping[str, Any]]) -> dict[str, dict[str, Any]]:
    codes: dict[str, dict[str, Any]] = {}
    for row in rows:
        entry = codes.setdefault(row["code"], {"severity": row["severity"], "count": 0, "in": set()})
        entry["count"] += row["count"]
        entry["in"].add(row["source"])
    return {
        code: {"severity": entry["severity"], "count": entry["count"], "sources": len(entry["in"])}
        for code, entry in sorted(codes.items())
    }
