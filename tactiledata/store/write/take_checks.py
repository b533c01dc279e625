"""Whether a take fits together, before anything of it is kept."""

from __future__ import annotations

import json

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from tactiledata.contract.provenance import json_bytes
from tactiledata.contract.take import FINDING_SCHEMA, FRAME_SCHEMA, TRAJECTORY_SCHEMA, Take
from tactiledata.errors import StoreError
from tactiledata.store.layout.places import folder_name

STATUSES = ("ok", "unverified", "damaged")


def check_take(take: Take, n_images: int) -> None:
    """Refuse a take whose tables lack their schemas, whose rows point outside, or whose arrays have other lengths.

    Parameters
    ----------
    n_images : int
        Images that were spooled.

    Raises
    ------
    StoreError
        Naming the first fault.
    """
    if take.status not in STATUSES:
        raise _fault(take, f"status {take.status!r}", f"one of {', '.join(STATUSES)}")
    _check_tables(take)
    _check_frames(take, n_images)
    _check_trajectories(take)
    _check_signals(take)
    _check_documents(take)


def _fault(take: Take, found: str, expected: str) -> StoreError:
    return StoreError(
        f"the take of {take.source.key} has {found}", expected, "This is a fault of the reader or of ingest; report it."
    )


def _check_tables(take: Take) -> None:
    wanted = {"frames": FRAME_SCHEMA, "trajectories": TRAJECTORY_SCHEMA, "findings": FINDING_SCHEMA}
    for name, schema in wanted.items():
        table: pa.Table = getattr(take, name)
        if table.column_names != schema.names:
            raise _fault(take, f"columns {table.column_names} in table {name}", f"{schema.names}")
        try:
            table.cast(schema)
        except (pa.ArrowInvalid, pa.ArrowNotImplementedError) as error:
            raise StoreError(f"table {name} of {take.source.key} has other types: {error}", f"{schema}") from error


def _check_frames(take: Take, n_images: int) -> None:
    frames = take.frames
    trajectory = np.asarray(frames["trajectory"])
    if len(trajectory) and not (trajectory.min() >= -1 and trajectory.max() < len(take.trajectories)):
        raise _fault(take, f"frames in trajectory {trajectory.max()}", f"rows below {len(take.trajectories)}, or -1")
    offset, length = np.asarray(frames["offset"]), np.asarray(frames["length"])
    kept = np.asarray(pc.not_equal(frames["encoding"].cast(pa.string()), "missing"))
    if (offset[kept] < 0).any() or (length[kept] < 0).any():
        raise _fault(take, "frames with an encoding but no bytes", "offset and length in the spool")
    if len(frames) > n_images:
        raise _fault(take, f"{len(frames)} frames", f"at most the {n_images} images of its spool")


def _check_trajectories(take: Take) -> None:
    start, stop = np.asarray(take.trajectories["frame_start"]), np.asarray(take.trajectories["frame_stop"])
    if ((start < 0) | (stop < start) | (stop > len(take.frames))).any():
        raise _fault(take, "trajectories with frames outside the take", f"frame ranges within {len(take.frames)}")
    for text in take.trajectories["signal_rows"].to_pylist():
        try:
            ranges = json.loads(text)
            fits = all(0 <= first <= last <= len(take.signals[name].t_ns) for name, (first, last) in ranges.items())
        except (ValueError, KeyError, TypeError, AttributeError):
            fits = False
        if not fits:
            raise _fault(take, f"signal_rows {text!r}", "JSON {signal: [start, stop]} within the take's signals")


def _check_signals(take: Take) -> None:
    for name, signal in take.signals.items():
        if signal.values.shape != (len(signal.t_ns), len(signal.columns)) or len(signal.stamps) != len(signal.t_ns):
            raise _fault(take, f"signal {name!r} with values {signal.values.shape}", f"({len(signal.t_ns)}, columns)")
        if (np.diff(signal.t_ns) < 0).any():
            raise _fault(take, f"signal {name!r} whose time runs backwards", "t_ns that never falls")
    n_frames = len(take.frames)
    for name, aligned in take.aligned.items():
        if aligned.values.shape != (n_frames, len(aligned.columns)) or aligned.gap_ns.shape != (n_frames,):
            raise _fault(
                take, f"aligned {name!r} with values {aligned.values.shape}", f"a row for each of {n_frames} frames"
            )
    for name, values in take.frame_values.items():
        if values.values.shape != (n_frames, len(values.columns)):
            raise _fault(take, f"frame values {name!r} {values.values.shape}", f"a row for each of {n_frames} frames")
    for sensor, reference in take.references.items():
        if reference.image.ndim != 3 or reference.image.shape[2] != 3 or reference.image.dtype != np.uint8:
            raise _fault(take, f"reference of {sensor!r} {reference.image.shape}", "(height, width, 3) uint8 RGB")


def _check_documents(take: Take) -> None:
    documents = {name: getattr(take, name) for name in ("description", "provenance", "sensors")}
    documents |= {f"attributes of signal {name!r}": signal.attributes for name, signal in take.signals.items()}
    for name, document in documents.items():
        try:
            json_bytes(document)
        except (TypeError, ValueError) as error:
            raise StoreError(
                f"{name} of {take.source.key} is not JSON: {error}", "finite numbers, text, lists and mappings"
            ) from error
    for kind in (take.signals, take.aligned, take.frame_values, take.references, take.sensors):
        for entry in kind:
            folder_name(entry)
