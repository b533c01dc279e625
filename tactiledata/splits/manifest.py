"""Splits on disk: a table of trajectories and the document that vouches for it, tied to its store."""

from __future__ import annotations

import json
import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq
from numpy.typing import NDArray

from tactiledata.contract.arrow_memory import arrow_reader, read_parquet
from tactiledata.contract.atomic import REFUSED, refusal, write_atomic
from tactiledata.contract.paths import NAME_PATTERN
from tactiledata.contract.provenance import bytes_digest, provenance
from tactiledata.contract.schema import check_document
from tactiledata.contract.sealed import SEAL, fits_seal, sealed_json
from tactiledata.contract.wording import counted
from tactiledata.errors import (
    LeakError,
    MissingFile,
    MissingSplit,
    NotFetched,
    SchemaError,
    StoreError,
    TactileDataError,
    UnknownName,
)
from tactiledata.splits.again import command
from tactiledata.splits.assign import SPLIT_SCHEMA
from tactiledata.splits.options import EXCLUDED, PARTITIONS, SplitOptions, check_name
from tactiledata.splits.report import SplitReport
from tactiledata.splits.select import FRAME_COLUMNS, taken_frames
from tactiledata.store.layout.made_splits import remember_split

if TYPE_CHECKING:
    from tactiledata.store.read.reader import Store

SPLIT_FORMAT = "tactiledata-split/1"


@dataclass(frozen=True)
class Split:
    """A split that was read and checked.

    Parameters
    ----------
    name : str
    table : pa.Table
        ``SPLIT_SCHEMA``
    document : dict
        As in ``schemas/split.json``.
    """

    name: str
    table: pa.Table
    document: Mapping[str, Any]

    @property
    def options(self) -> SplitOptions:
        """The options that it was made with."""
        return SplitOptions.checked(**self.document["options"])

    @property
    def held_out(self) -> dict[str, tuple[str, ...]]:
        """Units that are held out, by kind."""
        return {kind: tuple(names) for kind, names in self.document["held_out"].items()}

    @property
    def force(self) -> tuple[float, float] | None:
        """Lowest and highest contact force, N, of the frames that it takes."""
        return self.options.force


def split_document(report: SplitReport, table: pa.Table, sha256: str, store: Mapping[str, Any]) -> dict[str, Any]:
    """The document beside a split's table.

    Parameters
    ----------
    report : SplitReport
    table : pa.Table
        ``SPLIT_SCHEMA``
    sha256 : str
        Of the table's file.
    store : dict
        ``digest``, ``trajectories``, ``frames``.
    """
    return {
        "format": SPLIT_FORMAT,
        "name": report.name,
        "options": report.options.document(),
        "held_out": {kind: list(names) for kind, names in report.held_out.items()},
        "store": dict(store),
        "table": {"file": f"{report.name}.parquet", "sha256": sha256, "rows": table.num_rows},
        "counts": {part: count.document() for part, count in report.counts.items()},
        **({"flagged": list(report.flagged)} if report.flagged else {}),
        "notes": list(report.notes),
        "provenance": provenance("split", {"store": str(store["digest"])}, report.options.document()),
    }


def write_split(path: Path, report: SplitReport, table: pa.Table, store: Mapping[str, Any]) -> None:
    """Write a split: the table at ``path``, the document beside it, then its name in the store's list of splits.

    Killed after the table, it reads as torn; killed after the document, it is whole and not in the list.

    Parameters
    ----------
    path : Path
        File of the table, in the store's folder of splits.
    report : SplitReport
        What the document holds.
    table : pa.Table
        ``SPLIT_SCHEMA``
    store : dict
        ``digest``, ``trajectories``, ``frames`` of the store.

    Raises
    ------
    StoreError
        The files cannot be written: no right to, a full disk, or one that does not work.
    """
    buffer = pa.BufferOutputStream()
    pq.write_table(table, buffer, compression="zstd")
    content = buffer.getvalue().to_pybytes()
    document = split_document(report, table, bytes_digest(content), store)
    where = str(path.with_suffix(".json"))
    check_document(document, "split", where)
    try:
        write_atomic(path, content)
        write_atomic(path.with_suffix(".json"), sealed_json(document))
        remember_split(path.parent.parent, report.name)
    except OSError as error:
        raise _not_written(path, error) from error


def _not_written(path: Path, error: OSError) -> StoreError:
    found, expected, remedy = refusal(error, path.parent)
    if error.errno in REFUSED:
        remedy = "Copy the store to a place of yours, or ask its owner."
    return StoreError(found, expected, f"{remedy} The store itself is unharmed.", path=str(path))


def read_split_document(store: Store, name: str) -> dict[str, Any] | None:
    """The document of a split, checked; ``None`` where the store has no split of that name.

    Raises
    ------
    SchemaError
        It is not JSON, does not fit ``schemas/split.json``, or was changed since it was written.
    """
    place = f"splits/{check_name(name)}.json"
    where = f"{store.location}/{place}"
    try:
        content = store.read_file(place)
        document = json.loads(content)
    except MissingFile:
        return None
    except NotFetched:
        raise
    except (ValueError, RecursionError) as error:
        raise SchemaError(
            f"{where} is not JSON ({error})", "the document of a split", _again(store, name), path="$", file=where
        ) from error
    check_document(document, "split", where)
    if SEAL in document and not fits_seal(content):
        found = f"{where} is damaged: it does not fit its own SHA-256"
        raise SchemaError(found, "the file that was written", _again(store, name), path="$", file=where)
    return document


def _again(store: Store, name: str) -> str:
    return f"Run `{_split_command(store, name)} --replace` (see `tactiledata split --help`)."


def _split_command(store: Store, name: str) -> str:
    """The command that makes a split of a store, to be copied."""
    named = [] if name == "default" else ["--name", name]
    return shlex.join(["tactiledata", "split", store.location, "--by", "trajectory,sensor", *named])


def read_split(store: Store, name: str) -> Split:
    """A split whose files fit each other, whatever the store holds by now.

    Raises
    ------
    MissingSplit, UnknownName
        The store has no split (of that name).
    SchemaError, StoreError
        Its files are damaged, torn or were changed.
    """
    document = read_split_document(store, name)
    if document is None:
        names = [known for known in store.split_names() if NAME_PATTERN.fullmatch(known)]
        if not names:
            raise MissingSplit(
                f"the store {store.location} has no split",
                f"a split {name!r}",
                f"Run `{_split_command(store, name)}` first.",
                name=name,
            )
        raise UnknownName("split", name, names, unless_near=f"Run `{_split_command(store, name)}` to make it.")
    where = f"{store.location}/splits/{name}.parquet"
    try:
        content = store.read_file(f"splits/{name}.parquet")
    except MissingFile as error:
        raise StoreError(
            f"the split's table {where} is missing", "a table beside the document", _again(store, name), path=where
        ) from error
    digest = bytes_digest(content)
    if digest != document["table"]["sha256"]:
        raise StoreError(
            f"{where} was changed or torn: its SHA-256 is {digest[:12]}…",
            f"{document['table']['sha256'][:12]}…, as its document says",
            _again(store, name),
            path=where,
        )
    try:
        table = read_parquet(arrow_reader(content), SPLIT_SCHEMA)
    except (pa.ArrowException, KeyError, ValueError) as error:
        raise StoreError(
            f"{where} is not a table of a split: {error}", "the columns of a split", _again(store, name)
        ) from error
    known = pa.array([*PARTITIONS, EXCLUDED])
    if not pc.all(pc.is_in(table["partition"], value_set=known), min_count=0).as_py():
        raise StoreError(f"{where} holds an unknown partition", ", ".join([*PARTITIONS, EXCLUDED]), _again(store, name))
    return Split(name, table, document)


def load_split(store: Store, name: str) -> Split:
    """A split that is whole and knows every trajectory of the store.

    Raises
    ------
    MissingSplit, UnknownName
        The store has no split (of that name).
    SchemaError, StoreError
        Its files are damaged, torn or were changed.
    LeakError
        The store holds other trajectories than the split. What a split does not know is never in train.
    """
    split = read_split(store, name)
    if problem := coverage_problem(split, store.trajectories(["uid"])["uid"]):
        raise LeakError(
            f"split {name!r} of {store.location} is out of date: {problem}",
            "a split that knows every trajectory",
            f"Run `{command(store.location, name, split.document['options'])}` again. "
            "No trajectory that has a part gets another one.",
            name=name,
        )
    return split


def unusable_splits(store: Store) -> list[str]:
    """Return the names of the splits of a store that do not know all its trajectories, or are damaged."""
    names = []
    for name in store.split_names():
        try:
            load_split(store, name)
        except TactileDataError:
            names.append(name)
    return names


def coverage_problem(split: Split, uids: pa.ChunkedArray) -> str:
    """Say how the trajectories of a split and of a store differ; empty where they are the same."""
    inside = split.table["uid"]
    new = len(uids) - pc.sum(pc.is_in(uids, value_set=inside.combine_chunks()), min_count=0).as_py()
    gone = len(inside) - pc.sum(pc.is_in(inside, value_set=uids.combine_chunks()), min_count=0).as_py()
    parts = [f"the store has {counted(new, 'new trajectory')}"] if new else []
    parts += [f"{counted(gone, 'trajectory')} of the split can no longer be found"] if gone else []
    if not parts and len(inside) != len(uids):
        parts = [f"it has {len(inside)} rows for {len(uids)} trajectories"]
    return " and ".join(parts)


def partition_rows(split: Split, uids: pa.ChunkedArray) -> NDArray[np.object_]:
    """The partition (n,) of each trajectory of a store, by its uid; ``None`` for those that the split does not know."""
    rows = pc.index_in(uids, value_set=split.table["uid"].combine_chunks())
    return np.asarray(split.table["partition"].combine_chunks().take(rows.combine_chunks()).to_pylist(), object)


def frame_rows(store: Store, split: Split, part: str) -> NDArray[np.int64]:
    """Rows of the frames that belong to a part of a split, ascending.

    Frames without an image, with a broken one, or with a contact force outside the split's bounds are in no part.

    Parameters
    ----------
    store : Store
        The store that the split was loaded from.
    split : Split
    part : "train", "val", "test" or "test_unseen"

    Returns
    -------
    (n,) int64
        Rows over all frames of the store.
    """
    if part not in PARTITIONS:
        raise UnknownName("part of a split", part, PARTITIONS)
    frames = store.frames(list(FRAME_COLUMNS))
    belongs = partition_rows(split, store.trajectories(["uid"])["uid"]) == part
    return part_rows(frames, belongs, split.force)


def part_rows(frames: pa.Table, belongs: NDArray[np.bool_], force: tuple[float, float] | None) -> NDArray[np.int64]:
    """Return the rows of the taken frames whose trajectory belongs to a part, ascending.

    Parameters
    ----------
    frames : pa.Table
        ``FRAME_SCHEMA``
    belongs : (n_trajectories,) bool
        Whether a trajectory belongs to the part.
    force : (float, float), N, optional
        Lowest and highest contact force of the frames that are taken; ``None`` takes all.
    """
    taken = taken_frames(frames, force)
    rows = np.flatnonzero(taken)
    return rows[belongs[frames["trajectory"].to_numpy()[rows]]].astype(np.int64)
