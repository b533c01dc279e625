"""Transfer of one recording: new pictures, and trajectories that name their parents."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import cv2
import google_crc32c
import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

from split_models.transfer.methods import TransferMethod
from tactiledata.contract.image_batches import image_batches
from tactiledata.contract.provenance import digest_of, provenance
from tactiledata.contract.records import FrameValues, Image, Source
from tactiledata.contract.take import FRAME_SCHEMA, UNUSABLE, Reference, Take, findings_table
from tactiledata.errors import UsageError
from tactiledata.ingest.trajectories.cut import trajectory_uid
from tactiledata.store.change.pieces import Piece, take_of
from tactiledata.store.read.targets import Target
from tactiledata.store.write.spool import Spool
from tactiledata.store.write.writer import StagedTake, stage, staging_folder

BATCH = 64
"""Largest number of pictures in memory at once."""
PARENT = "parent_row"
"""Name of the frame values that hold the row in the source store from which each frame was made."""


@dataclass(frozen=True)
class Transfer:
    """The settings of a transfer, which are the same for every recording.

    Parameters
    ----------
    target : Target
    method : TransferMethod
    backgrounds : dict of (H, W, 3) uint8
        Background of each sensor whose frames are transferred.
    settings : dict
        Values that shape the output, as JSON values.
    measured : dict
        Figures on how much of the touches is kept, as JSON values; they are kept in each recording's description.
    """

    target: Target
    method: TransferMethod
    backgrounds: Mapping[str, NDArray[np.uint8]]
    settings: Mapping[str, Any]
    measured: Mapping[str, Any] = field(default_factory=dict)

    def digest(self, piece: Piece) -> str:
        """Digest of a recording's transfer, by which the output store recognises it."""
        sensors = {
            name: crc_of(self.backgrounds[name])
            for name in sorted(set(piece.contents["sensors"]) & set(self.backgrounds))
        }
        return digest_of({"parent": piece.facts["sha256"], "sensors": sensors, **self.settings})

    def selected(self, piece: Piece) -> NDArray[np.int64]:
        """Rows, in the source store, of the frames of a recording that are transferred.

        These are the frames of the chosen sensors that lie in a trajectory and have a whole picture. A frame outside
        every trajectory could name no parent.
        """
        table = piece.origin.frames.slice(piece.first_frame, piece.facts["frames"])
        barred = np.logical_or.reduce(list(barred_frames(table, list(self.backgrounds)).values()))
        return piece.first_frame + np.flatnonzero(~barred)


def barred_frames(frames: pa.Table, sensors: Sequence[str]) -> dict[str, NDArray[np.bool_]]:
    """Return why frames are not transferred: for each reason, in words, the frames (n,) for which it holds.

    Parameters
    ----------
    frames : pyarrow.Table
        The n frames, with their sensor, flags and trajectory.
    sensors : sequence of str
        Serials of the sensors that are transferred.
    """
    of_sensors = pc.is_in(frames["sensor"].cast(pa.string()), pa.array(list(sensors), pa.string()))
    return {
        f"of sensors other than {', '.join(sensors)}": ~np.asarray(of_sensors),
        "without a whole image": (np.asarray(frames["flags"]) & UNUSABLE) != 0,
        "in no trajectory": np.asarray(frames["trajectory"]) < 0,
    }


def crc_of(image: NDArray[np.uint8]) -> int:
    """CRC-32C of a picture's bytes."""
    return google_crc32c.value(np.ascontiguousarray(image).tobytes())


def stage_transfer(out: Path, piece: Piece, transfer: Transfer, largest_payload: int) -> StagedTake:
    """The transferred recording, staged in the output store.

    Parameters
    ----------
    out : Path
        The output store.
    piece : Piece
        The recording in the source store.
    transfer : Transfer
    largest_payload : int
        Largest size in bytes of an encoded picture.
    """
    sha256 = transfer.digest(piece)
    rows = transfer.selected(piece)
    with Spool(staging_folder(out, sha256), largest_payload) as spool:
        for image in _transferred(piece, transfer, rows):
            spool.add(image)
        return stage(out, spool, _take(piece, transfer, rows, sha256, spool.columns()))


def _transferred(piece: Piece, transfer: Transfer, rows: NDArray[np.int64]) -> Iterator[Image]:
    """Yield the new pictures as PNG in order; at most `BATCH` are in memory, fewer where they are large."""
    frames = piece.origin.frames.select(["camera", "sensor", "log_ns", "publish_ns", "header_ns"])
    height, width = (piece.origin.frames[side].to_numpy().astype(np.int64)[rows] for side in ("height", "width"))
    for start, stop in image_batches(height * width, BATCH):
        chunk = rows[start:stop]
        facts = frames.take(pa.array(chunk)).to_pylist()
        pictures = _batch(transfer, [np.asarray(image) for image in piece.store.images(chunk)], facts, chunk)
        for picture, row in zip(pictures, facts, strict=True):
            content = cv2.imencode(".png", picture[..., ::-1], [cv2.IMWRITE_PNG_COMPRESSION, 1])[1].tobytes()
            stamps = {name: row[name] for name in ("log_ns", "publish_ns", "header_ns")}
            height, width = picture.shape[:2]
            yield Image(row["camera"], content, "png", height, width, **stamps, sensor=transfer.target.name)


def _batch(
    transfer: Transfer, images: list[NDArray[np.uint8]], facts: list[dict[str, Any]], rows: NDArray[np.int64]
) -> list[NDArray[np.uint8]]:
    """New pictures of a batch, whose frames may be of several sensors; frames and background must have one size."""
    changed: list[NDArray[np.uint8]] = list(images)
    sensors = [row["sensor"] for row in facts]
    for sensor in dict.fromkeys(sensors):
        places = [place for place, name in enumerate(sensors) if name == sensor]
        background = transfer.backgrounds[sensor]
        for place in places:
            if images[place].shape != background.shape:
                raise UsageError(
                    f"frame {rows[place]} of sensor {sensor} is {images[place].shape[0]} rows x "
                    f"{images[place].shape[1]} columns, its background {background.shape[0]} x {background.shape[1]}",
                    "frames and background of one size",
                    f"Give the sensor a background of its frames' size: `tactiledata sensors add {sensor} --background "
                    "FILE... --replace`. Where single frames differ, ingest their recording again with --replace: "
                    "they are then marked and left out.",
                )
        moved = transfer.method.transfer(
            np.stack([images[place] for place in places]), background, transfer.target.background
        )
        for place, picture in zip(places, moved, strict=True):
            changed[place] = picture
    return changed


def _take(piece: Piece, transfer: Transfer, rows: NDArray[np.int64], sha256: str, spooled: pa.Table) -> Take:
    """The transferred recording: signals unchanged, selected frames with new pictures, trajectories as children."""
    target = transfer.target
    local = rows - piece.first_frame
    whole = take_of(piece, pa.table({}), findings_table([]), {})
    trajectories, kept = _trajectories(whole.trajectories, transfer, sha256, local, _owners(piece, rows))
    frames = _frames(piece, transfer, rows, kept, spooled)
    key = f"{piece.facts['key']} as {target.name}"
    made = provenance("transfer", {"parent": piece.facts["sha256"]}, transfer.settings)
    parent_row = FrameValues(
        rows[:, None].astype(np.float64), ("row",), ("1",), f"row in the store of digest {piece.store.digest}"
    )
    return Take(
        source=Source(key, key, piece.facts["format"], ()),
        sha256=sha256,
        status=whole.status,
        description=_description(whole.description, transfer),
        provenance=made,
        frames=frames,
        trajectories=trajectories,
        findings=findings_table([]),
        signals=whole.signals,
        aligned={
            name: type(signal)(
                signal.values[local],
                signal.gap_ns[local],
                signal.columns,
                signal.units,
                signal.frame,
                signal.method,
            )
            for name, signal in whole.aligned.items()
        },
        frame_values={
            **{
                name: FrameValues(known.values[local], known.columns, known.units, known.note)
                for name, known in whole.frame_values.items()
            },
            PARENT: parent_row,
        },
        references={target.name: Reference(target.background, target.resolved, target.licence, target.model)},
        sensors={target.name: {"model": target.model}},
    )


def _owners(piece: Piece, rows: NDArray[np.int64]) -> NDArray[np.int64]:
    """Row of each frame's trajectory within the recording."""
    return np.asarray(piece.origin.frames["trajectory"].take(pa.array(rows))) - piece.first_trajectory


def _trajectories(
    table: pa.Table, transfer: Transfer, sha256: str, local: NDArray[np.int64], owner: NDArray[np.int64]
) -> tuple[pa.Table, NDArray[np.int64]]:
    """Trajectories that keep frames, as children, and the new row of each old trajectory, -1 where it keeps none."""
    counts = np.bincount(owner, minlength=len(table))
    held = np.flatnonzero(counts)
    kept = np.full(len(table), -1, np.int64)
    kept[held] = np.arange(len(held))
    stops = np.cumsum(counts[held])
    table = table.take(pa.array(held))
    changed = {
        "uid": [trajectory_uid(sha256, name) for name in table["trajectory"].to_pylist()],
        "parent": table["uid"].to_pylist(),
        "sensor": [transfer.target.name] * len(held),
        "frame_start": stops - counts[held],
        "frame_stop": stops,
        "extra": [
            json.dumps({**json.loads(text), "transfer": transfer.method.name, "parent_sensor": sensor}, sort_keys=True)
            for text, sensor in zip(table["extra"].to_pylist(), table["sensor"].to_pylist(), strict=True)
        ],
    }
    return _replaced(table, changed), kept


def _frames(
    piece: Piece, transfer: Transfer, rows: NDArray[np.int64], kept: NDArray[np.int64], spooled: pa.Table
) -> pa.Table:
    """Frames table of the transfer: times, forces and flags of the parents, pictures of the spool."""
    table = piece.origin.frames.take(pa.array(rows))
    n = len(rows)
    sensor = pa.DictionaryArray.from_arrays(pa.array(np.zeros(n, np.int32)), pa.array([transfer.target.name]))
    changed = {
        "trajectory": kept[_owners(piece, rows)],
        "source": np.zeros(n, np.int32),
        "sensor": sensor,
        # the parents lie in another store: `parent_row` and the trajectory's parent name them
        "parent_frame": np.full(n, -1, np.int64),
        **{name: spooled[name] for name in ("offset", "length", "crc32c", "encoding", "height", "width")},
    }
    return _replaced(table.select(FRAME_SCHEMA.names), changed)


def _replaced(table: pa.Table, columns: Mapping[str, Any]) -> pa.Table:
    """A table with columns replaced, each cast to the type that it had."""
    for name, values in columns.items():
        field = table.schema.field(name)
        column = values if isinstance(values, pa.Array | pa.ChunkedArray) else pa.array(values)
        table = table.set_column(table.schema.get_field_index(name), field, column.cast(field.type))
    return table


def _description(description: Mapping[str, Any], transfer: Transfer) -> dict[str, Any]:
    """The recording's description with the target among its sensors, and with what was measured of the transfer."""
    sensors = {**description.get("sensors", {}), transfer.target.name: {"model": transfer.target.model}}
    measured = {"transfer": dict(transfer.measured)} if transfer.measured else {}
    return {**description, "sensors": sensors, **measured}
