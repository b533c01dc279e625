"""Recordings of one store whose cameras have other names although their sensors are of one model.

An export and a loader take one camera, by its name: what is called otherwise stays outside.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import pyarrow as pa

from tactiledata.contract.records import Finding
from tactiledata.contract.take import Take
from tactiledata.contract.wording import counted
from tactiledata.store.read.reader import Store

UNKNOWN = ("", "unknown")
"""What stands for a sensor's model where nobody states it."""

Cameras = Mapping[str, frozenset[str]]
"""Model of a sensor -> the names of the cameras of such sensors in one recording."""


def cameras_of_store(store: Store) -> list[Cameras]:
    """Return the cameras of each recording of a store, by the model of their sensors."""
    models = {sensor: str(facts.get("model", "")) for sensor, facts in store.sensors().items()}
    found: list[dict[str, frozenset[str]]] = [{} for _ in range(store.sources(["key"]).num_rows)]
    for row in _pairs(store.frames(["source", "camera", "sensor"]), "source", "camera", "sensor"):
        _add(found[row["source"]], models.get(row["sensor"], ""), row["camera"])
    return list(found)


def cameras_of_takes(takes: Sequence[Take | None]) -> list[Cameras]:
    """Return the cameras of recordings that are in no store yet, by the model of their sensors; ``None`` has none."""
    models: dict[str, str] = {}
    for take in takes:
        for sensor, facts in take.sensors.items() if take is not None else ():
            models[sensor] = models.get(sensor) or str(facts.get("model", ""))
    found: list[dict[str, frozenset[str]]] = [{} for _ in takes]
    for cameras, take in zip(found, takes, strict=True):
        pairs = () if take is None else _pairs(take.frames, "camera", "sensor")
        for row in pairs:
            _add(cameras, models.get(row["sensor"], ""), row["camera"])
    return list(found)


def _pairs(frames: pa.Table, *columns: str) -> list[dict[str, Any]]:
    """Return what stands together in columns of a table of frames, each once."""
    return frames.select(columns).group_by(list(columns)).aggregate([]).to_pylist()


def _add(cameras: dict[str, frozenset[str]], model: str, camera: str) -> None:
    cameras[model] = cameras.get(model, frozenset()) | {camera}


def camera_findings(keys: Sequence[str], cameras: Sequence[Cameras]) -> dict[int, Finding]:
    """A finding for each recording that has no camera of the name that most recordings give theirs.

    Cameras of sensors of different models are not compared. Where a recording does not state its sensor's model, its
    cameras are held against those of all recordings.

    Parameters
    ----------
    keys : sequence of str
        Names of the recordings.
    cameras : sequence of Cameras
        Of each recording.

    Returns
    -------
    dict, place of a recording -> Finding
        Of equally frequent names that of the sensor's model counts as usual, as a draft of a mapping takes it; then the
        one that is more frequent among all recordings, else the first.

    Examples
    --------
    >>> named = [{"digit": frozenset({"digit"})}, {"digit": frozenset({"digit"})}, {"digit": frozenset({"camera"})}]
    >>> [(row, finding.code) for row, finding in camera_findings(["a", "b", "c"], named).items()]
    [(2, 'camera-names')]
    """
    found: dict[int, Finding] = {}
    everywhere = Counter(name for of_recording in cameras for name in frozenset().union(*of_recording.values()))
    for model in dict.fromkeys(model for of_recording in cameras for model in of_recording):
        is_known = model not in UNKNOWN
        compared = {
            row: frozenset().union(*(names for other, names in of_recording.items() if other == model or not is_known))
            for row, of_recording in enumerate(cameras)
        }
        counts = Counter(name for names in compared.values() for name in sorted(names))
        usual = max(counts, key=lambda name: (counts[name], name == model, everywhere[name]))
        first = next(row for row, names in compared.items() if usual in names)
        for row, names in compared.items():
            if model in cameras[row] and usual not in names and row not in found:
                found[row] = _finding(sorted(names), model if is_known else "", usual, (keys[first], counts[usual]))
    return dict(sorted(found.items()))


def _finding(names: Sequence[str], model: str, usual: str, where: tuple[str, int]) -> Finding:
    key, times = where
    others = f"{key} and {counted(times - 1, 'more recording')}" if times > 1 else key
    kind = f"of other sensors of model {model}" if model else "of other recordings"
    text = (
        f"camera {', '.join(map(repr, names))} has another name than cameras {kind}: {usual!r} in {others}. "
        f"Exports and loaders take one camera, by its name. Write it as {usual} under images: in a mapping, "
        "then ingest with --mapping and --replace"
    )
    return Finding("camera-names", "warning", text, stream=names[0])
