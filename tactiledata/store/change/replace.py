"""Recordings of a store replaced by corrected ones, in one commit; images that stay are not moved."""

from __future__ import annotations

import copy
import json
import shutil
from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from tactiledata.contract.records import Finding
from tactiledata.contract.take import Reference
from tactiledata.errors import StoreError, UnknownName
from tactiledata.store.change.keep_sensors import BY_HAND
from tactiledata.store.change.pieces import Origin, Piece, parents, pieces_of, rows_of, take_of
from tactiledata.store.layout.batch import Batch
from tactiledata.store.layout.manifest import Manifest, empty_manifest, extended_digest, settings_of
from tactiledata.store.layout.places import TABLES
from tactiledata.store.layout.sensors_table import Facts
from tactiledata.store.read.flags import stored_flags
from tactiledata.store.read.reader import Store
from tactiledata.store.write.appender import Appender, last_part
from tactiledata.store.write.commit import changing
from tactiledata.store.write.writer import StagedTake, stage_placed

Replacements = Mapping[str, StagedTake | None]
"""The staged take that comes in the place of a source, by the source's digest; ``None`` where a source only goes."""


def replace_takes(store_path: Path | str, replacements: Replacements) -> list[Finding]:
    """What is worth saying after sources were replaced; the store is then as if the new ones had come in their places.

    All tables and numbers are written anew into files that the old manifest does not name, so that the new manifest
    changes over to them in one moment. Images of the sources that stay are not touched; those that went stay in the
    heaps as bytes that nothing names, until the store is merged into a new one. Memory: the tables of the store.

    Raises
    ------
    StoreBusy
        Another process writes to the store.
    StoreError
        The disk is full, or numbers of a source that stays are damaged; the store is as it was before.
    """
    takes: list[StagedTake] = []
    with changing(store_path) as (folder, manifest):
        origin = Origin.of(Store.open(folder))
        before = origin.store.manifest
        renewed = _renewed_pictures(origin, replacements)
        facts, pictures = _by_hand(origin, renewed)
        unfounded = _unfounded_pictures(origin, replacements) - set(pictures)
        manifest.clear()
        manifest.update(_emptied(before))
        with Batch(folder) as batch:
            appender = Appender(batch, manifest, {table: 1 + last_part(before, table) for table in TABLES})
            appender.sensors.keep_pictures(pictures)
            for take in _takes(folder, origin, replacements, unfounded | renewed):
                takes.append(take)
                appender.add(take)
            appender.sensors.fill_facts(facts)
            appender.finish()
            batch.publish()
        _forget_cameras(manifest, takes)
        for sensor in sorted({*facts, *pictures}):
            crc = manifest["references"].get(sensor)
            addition = f"sensor {sensor} {manifest['sensors'].get(sensor)} {crc}"
            manifest["digest"] = extended_digest(manifest["digest"], addition)
    for take in takes:
        shutil.rmtree(take.folder, ignore_errors=True)
    dropped = [_mesh_finding(name) for name in origin.store.mesh_names]
    dropped += [_picture_finding(sensor) for sensor in sorted(unfounded - set(manifest["references"]))]
    return [*dropped, *_flag_findings(origin, Store.open(store_path))]


def _emptied(before: Manifest) -> Manifest:
    """A manifest without rows whose images go on where those of another end."""
    return {
        **empty_manifest(settings_of(before)),
        "cameras": copy.deepcopy(before["cameras"]),
        "generation": before.get("generation", 0) + 1,
    }


def _renewed_pictures(origin: Origin, replacements: Replacements) -> set[str]:
    """Sensors whose picture without contact is damaged in the store, and comes with what is put in a place."""
    damaged = {sensor for sensor in _brought(replacements) if _is_damaged(origin.store, sensor)}
    return damaged & set(origin.store.manifest["references"])


def _is_damaged(store: Store, sensor: str) -> bool:
    try:
        store.reference(sensor)
    except UnknownName:
        return False
    except StoreError:
        return True
    return False


def _brought(replacements: Replacements) -> set[str]:
    """Sensors whose picture without contact comes with what is put in a place."""
    return {sensor for take in replacements.values() if take is not None for sensor in take.document["references"]}


def _by_hand(origin: Origin, renewed: Collection[str]) -> tuple[Facts, dict[str, Reference]]:
    """Facts of the sensors that no recording names, and the pictures that no recording brought or brings anew."""
    contents = [piece.contents for piece in pieces_of(origin)]
    named = {sensor for one in contents for sensor in one["sensors"]}
    brought = {sensor for one in contents for sensor in one["references"]}
    kept = sorted(set(origin.store.manifest["references"]).difference(renewed))
    pictures = {
        sensor: reference
        for sensor, reference in ((name, origin.store.reference(name)) for name in kept)
        if sensor not in brought or reference.origin.startswith(BY_HAND)
    }
    facts = {sensor: dict(values) for sensor, values in origin.sensors.items() if sensor not in named}
    return {**{sensor: {"model": one.model} for sensor, one in pictures.items()}, **facts}, pictures


def _unfounded_pictures(origin: Origin, replacements: Replacements) -> set[str]:
    """Sensors whose picture came with a source that goes, and that nothing in its place has a picture of."""
    first: dict[str, str] = {}
    for piece in pieces_of(origin):
        for sensor in piece.contents["references"]:
            first.setdefault(sensor, piece.facts["sha256"])
    return {sensor for sensor, sha256 in first.items() if sha256 in replacements} - _brought(replacements)


def _takes(folder: Path, origin: Origin, replacements: Replacements, left_out: Collection[str]) -> Iterator[StagedTake]:
    """The sources of the store that will be, in order: those that stay are staged without their images."""
    starts = _starts(origin, replacements)
    touched = _touched_sensors(origin, replacements)
    for piece in pieces_of(origin):
        if piece.facts["sha256"] in replacements:
            replacement = replacements[piece.facts["sha256"]]
            if replacement is not None:
                yield replacement
            continue
        findings = _lasting(rows_of(origin.findings, piece.row), touched)
        take = take_of(piece, _frames(piece, starts), findings, _stated_facts(piece), left_out)
        yield stage_placed(folder, take, piece.contents["content"])


def _starts(origin: Origin, replacements: Replacements) -> dict[str, int]:
    """First frame of each source; of a replaced one where the new one has as many frames, so that they correspond."""
    starts, row = {}, 0
    for piece in pieces_of(origin):
        sha256, count = piece.facts["sha256"], piece.facts["frames"]
        replacement = replacements.get(sha256)
        if sha256 in replacements:
            count = 0 if replacement is None else replacement.n_frames
        if count == piece.facts["frames"]:
            starts[sha256] = row
        row += count
    return starts


def _touched_sensors(origin: Origin, replacements: Replacements) -> set[str]:
    old = (piece.contents for piece in pieces_of(origin) if piece.facts["sha256"] in replacements)
    new = (take.document for take in replacements.values() if take is not None)
    return {sensor for one in (*old, *new) for kind in ("sensors", "references") for sensor in one[kind]}


def _lasting(findings: pa.Table, touched: Collection[str]) -> pa.Table:
    """Findings without those that compare the recording with others; they are judged anew."""
    conflict = pc.and_(
        pc.equal(findings["code"].cast(pa.string()), "sensor-conflict"),
        pc.is_in(findings["stream"].cast(pa.string()), pa.array(sorted(touched), pa.string())),
    )
    variant = pc.equal(findings["code"].cast(pa.string()), "signal-variant")
    return findings.filter(pc.invert(pc.or_(conflict, variant)))


def _frames(piece: Piece, starts: Mapping[str, int]) -> pa.Table:
    table = piece.origin.frames.slice(piece.first_frame, piece.facts["frames"])
    trajectory = np.asarray(table["trajectory"])
    changed = {
        "trajectory": np.where(trajectory < 0, -1, trajectory - piece.first_trajectory),
        "source": np.zeros(len(table)),
        "parent_frame": parents(piece, np.asarray(table["parent_frame"]), starts),
    }
    for name, values in changed.items():
        field = table.schema.field(name)
        table = table.set_column(table.schema.get_field_index(name), field, pa.array(values).cast(field.type))
    return table


def _stated_facts(piece: Piece) -> Facts:
    """What the source itself says of its sensors; what the store says where the source's description names none."""
    stated = json.loads(piece.facts["description"]).get("sensors", {})
    known = piece.origin.sensors
    return {
        sensor: {key: value for key, value in stated.get(sensor, known.get(sensor, {})).items() if key != "background"}
        for sensor in piece.contents["sensors"]
    }


def _forget_cameras(manifest: Manifest, takes: Sequence[StagedTake]) -> None:
    """Cameras that no frame is of any more are not named."""
    live = {name for take in takes for name in pc.unique(take.table("frames")["camera"]).to_pylist()}
    manifest["cameras"] = {name: facts for name, facts in manifest["cameras"].items() if name in live}


def _mesh_finding(name: str) -> Finding:
    text = (
        f"the mesh {name!r} was dropped: its rows were those of the store before a recording was replaced. Replay again"
    )
    return Finding("mesh-dropped", "warning", text, stream=name)


def _flag_findings(origin: Origin, now: Store) -> list[Finding]:
    """Findings on flags whose trajectory was in the store before recordings were replaced, and is not any more."""
    there = set(now.trajectories(["uid"])["uid"].to_pylist())
    flags = stored_flags(now)
    gone = [uid for uid in origin.trajectories["uid"].to_pylist() if uid in flags and uid not in there]
    return [_flag_finding(flags[uid]) for uid in gone]


def _flag_finding(flag: Mapping[str, str]) -> Finding:
    name = f"{flag['recording']}/{flag['trajectory']}"
    text = (
        f"{name} was flagged ({flag['reason']}) and came with a recording that was replaced; nothing in its place is "
        f"flagged. Look at the new one (`tactiledata view`), and flag it again where it is still bad"
    )
    return Finding("flag-left", "warning", text, stream=name)


def _picture_finding(sensor: str) -> Finding:
    text = (
        f"the picture of {sensor!r} without contact came with a recording that was replaced and does not name it any "
        f"more; it was dropped. Add one (`tactiledata sensors add`), or ingest a recording of {sensor!r} with --replace"
    )
    return Finding("picture-dropped", "warning", text, stream=sensor)
