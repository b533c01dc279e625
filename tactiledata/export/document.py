"""The document of an export: where it came from, what its streams mean, and what was lost on the way."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from tactiledata.contract.provenance import digest_of, provenance
from tactiledata.contract.wording import agreeing, counted
from tactiledata.export.base import ExportedFile, Exporter, FileFacts
from tactiledata.export.episodes import Episodes
from tactiledata.export.meanings import stream_facts
from tactiledata.export.plan import ExportPlan
from tactiledata.loaders.streams import Stream
from tactiledata.splits.options import PARTITIONS
from tactiledata.store.read.flags import flag_words
from tactiledata.store.read.simulated import simulated_recordings

FORMAT = "tactiledata-export/1"
MOST_FLAGS = 3
"""Flags that a remark says in full."""


def export_document(
    exporter: Exporter,
    episodes: Episodes,
    plan: ExportPlan,
    key: str,
    split: Mapping[str, Any] | None,
    facts: Iterable[FileFacts],
) -> dict[str, Any]:
    """Return the document of an export (schemas/export.json), without its files.

    Parameters
    ----------
    exporter : Exporter
        The format.
    episodes : Episodes
        What went out.
    plan : ExportPlan
        The options.
    key : str
        Digest of all that decides the bytes.
    split : dict, optional
        The document of the split.
    facts : iterable of dict
        What was noted of each large file.
    """
    store = episodes.store
    missing: dict[str, dict[str, int]] = {}
    remade = undescribed = 0
    for noted in facts:
        remade += noted.get("remade", 0)
        undescribed += noted.get("undescribed", 0)
        for name, of_parts in noted.get("missing", {}).items():
            known = missing.setdefault(name, {})
            for part, count in of_parts.items():
                known[part] = known.get(part, 0) + count
    inputs = {"store": store.digest, **({} if split is None else {"split": digest_of(split)})}
    return {
        "format": FORMAT,
        "to": exporter.name,
        "key": key,
        "store": {
            "digest": store.digest,
            "frames": store.n_frames,
            "trajectories": store.manifest["rows"]["trajectories"],
            "recordings": store.manifest["rows"]["sources"],
        },
        "split": None if split is None else dict(split),
        "camera": episodes.camera,
        "parts": _parts(episodes),
        "streams": _streams(exporter, episodes, missing),
        "simulated_recordings": simulated_recordings(store).document(),
        "left_out": exporter.left_out(episodes),
        "lost": list(exporter.lost),
        "remarks": [
            *(_without_frames(split["counts"], _parts(episodes)) if exporter.at_frames and split is not None else ()),
            *_general_remarks(exporter, episodes, missing, remade, undescribed),
            *exporter.remarks(episodes),
        ],
        "provenance": provenance("export-data", inputs, plan.document()),
    }


def _parts(episodes: Episodes) -> dict[str, dict[str, int]]:
    """Return the numbers of trajectories and frames of each part."""
    index, counts = episodes.index, {}
    for part, (start, stop) in episodes.part_ranges().items():
        first, end = int(index.starts[start]), int(index.starts[stop])
        taken = int(index.in_split[first:end].sum())
        counts[part] = {"trajectories": stop - start, "frames": end - first, "in_split": taken}
    return counts


def _without_frames(counts: Mapping[str, Any], parts: Mapping[str, Mapping[str, int]]) -> list[str]:
    """Say how many trajectories of each part of a split an export does not hold; nothing where it holds all.

    Parameters
    ----------
    counts : dict, part -> counts
        Of the split.
    parts : dict, part -> counts
        Of the export; a part without an episode is not in it.
    """
    lacking = {
        part: count
        for part in PARTITIONS
        if (count := counts[part]["trajectories"] - parts.get(part, {"trajectories": 0})["trajectories"]) > 0
    }
    if not lacking:
        return []
    total = sum(lacking.values())
    where = ", ".join(f"{part} {count}" for part, count in lacking.items())
    return [
        f"{counted(total, 'trajectory')} of the split {agreeing(total, 'is', 'are')} not in this export ({where}): "
        f"of {agreeing(total, 'it', 'them')} the split takes no frame, or none of this camera can be read."
    ]


def _streams(
    exporter: Exporter, episodes: Episodes, missing: Mapping[str, Mapping[str, int]]
) -> dict[str, dict[str, Any]]:
    """Return name, columns, units, frame and meaning of each stream as it is kept."""
    store = episodes.store
    found = {}
    for stream in exported_streams(exporter, episodes):
        facts = episodes.stream_facts.get(stream.name) or stream_facts(store, stream)
        kept = exporter.kept_as(stream.name, episodes)
        of_parts = dict(missing.get(stream.name, {}))
        found[stream.name] = {"kept_as": kept, **facts, "missing": sum(of_parts.values()), "missing_in": of_parts}
    return found


def exported_streams(exporter: Exporter, episodes: Episodes) -> Sequence[Stream]:
    """Return the streams that an export keeps: those at the frames, or all signals at native rate."""
    if exporter.at_frames:
        return episodes.streams
    store = episodes.store
    names = (name for name in store.signal_names if name in store.aligned_names)
    return [Stream(name, "aligned", *_columns(episodes, name)) for name in names]


def _columns(episodes: Episodes, name: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
    signal = episodes.store.signal(name)
    return signal.columns, signal.units


def _general_remarks(
    exporter: Exporter, episodes: Episodes, missing: Mapping[str, Mapping[str, int]], remade: int, undescribed: int
) -> list[str]:
    """Return what an export derives, and which values it lacks, whatever its format."""
    remarks = []
    if episodes.flags:
        words = flag_words(episodes.flags, MOST_FLAGS)
        remarks.append(
            f"{counted(len(episodes.flags), 'flagged trajectory')} went out as well ({words}): the "
            "column `flag` of `tactiledata/trajectories.parquet` says which. A split drawn anew leaves them out."
        )
    if exporter.at_frames and episodes.action is not None:
        remarks.append(
            f"`action` is derived: the value of `{episodes.action.name}` at the next frame, at the last frame its own. "
            "No command of the robot was recorded. --action none leaves it out."
        )
    elif exporter.at_frames:
        remarks.append("There is no action: none was recorded, and none was derived.")
    for name, of_parts in missing.items():
        total = sum(of_parts.values())
        where = ", ".join(f"{part} {count:,}" for part, count in of_parts.items())
        remarks.append(
            f"`{name}` has no value at {counted(total, 'frame')} ({where}): NaN or null there, never zero. "
            "A training loop that reads it leaves these frames out."
        )
    if remade:
        remarks.append(
            f"{counted(remade, 'picture')} became PNG, without loss: raw frames, and files that readers understand in "
            "different ways (grey, indexed, alpha, 16 bits, an orientation in the metadata)."
        )
    if undescribed:
        remarks.append(
            f"{counted(undescribed, 'recording')} say of themselves what no log may (no sensor is known, for example): "
            "it stands in the record `tactiledata.export` of the file, and ingest does not read it."
        )
    return remarks


def exported_frames(files: Sequence[ExportedFile]) -> int:
    """Return how many frames an export writes, for progress."""
    return sum(file.frames for file in files)
