"""Tasks of a transfer: one recording each, which any process that sees both stores can stage."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from split_models.transfer.transfer_take import Transfer, stage_transfer
from tactiledata.compute.base import Scheduler
from tactiledata.errors import StoreError
from tactiledata.store.change.pieces import Origin, Piece, pieces_of
from tactiledata.store.layout.lock import reading_lock
from tactiledata.store.read.reader import Store
from tactiledata.store.write.writer import StagedTake, find_staged


@dataclass(frozen=True)
class TransferTask:
    """One recording to transfer, with all that a worker needs beside the two stores.

    Parameters
    ----------
    source : str
        Location of the source store, absolute where it is a path.
    digest : str
        Digest of the source store's content.
    row : int
        Row of the recording in its table of sources.
    key : str
        Name of the recording.
    out : Path
        Absolute path of the output store.
    transfer : Transfer
        Settings and method. The networks of a method travel with it, so that a worker needs no model file.
    largest_payload : int
        Largest size in bytes of an encoded picture.
    """

    source: str
    digest: str
    row: int
    key: str
    out: Path
    transfer: Transfer
    largest_payload: int

    def __str__(self) -> str:
        return self.key


def staged_by(
    runner: Scheduler, pieces: Sequence[Piece], out: Path, transfer: Transfer, largest_payload: int
) -> Generator[StagedTake, None, None]:
    """Yield transferred recordings in order, each staged by a worker of a scheduler.

    Parameters
    ----------
    runner : Scheduler
        Where the work is done; its workers see both stores at the same paths.
    pieces : sequence of Piece
        Recordings of one store.
    out : Path
        The output store.
    transfer : Transfer
        Settings and method.
    largest_payload : int
        Largest size in bytes of an encoded picture.
    """
    tasks = [
        TransferTask(
            _absolute(piece.store.location),
            piece.store.digest,
            piece.row,
            piece.facts["key"],
            out.resolve(),
            transfer,
            largest_payload,
        )
        for piece in pieces
    ]
    for outcome in runner.outcomes(stage_task, tasks):
        if outcome.value is not None:
            yield outcome.value


def stage_task(task: TransferTask) -> StagedTake:
    """Stage the recording of a task; runs in a worker.

    Raises
    ------
    StoreError
        The source store is not the one that the transfer began with.
    """
    piece = _pieces(task.source, task.digest)[task.row]
    sha256 = task.transfer.digest(piece)
    # a worker of a killed run may still be at this recording
    with reading_lock(task.out, sha256):
        waiting = find_staged(task.out).get(sha256)
        return waiting or stage_transfer(task.out, piece, task.transfer, task.largest_payload)


@lru_cache(maxsize=1)
def _pieces(location: str, digest: str) -> tuple[Piece, ...]:
    """Recordings of a store; those of the last store are kept, as its tables are the same for every task."""
    store = Store.open(location)
    if store.digest != digest:
        raise StoreError(
            f"{location} has changed since the transfer began",
            "a store that nobody writes meanwhile",
            "Run the same command again: it goes on with the recordings that are left.",
        )
    return tuple(pieces_of(Origin.of(store)))


def _absolute(location: str) -> str:
    """A store's location for processes in other folders; addresses are left as they are."""
    return location if "://" in location or "::" in location else str(Path(location).resolve())
