"""Transfer of a whole store: a new store as the target might have recorded it, whose trajectories name parents."""

from __future__ import annotations

import json
from collections.abc import Generator, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from split_models.transfer.methods import TransferMethod
from split_models.transfer.transfer_take import Transfer, crc_of, stage_transfer
from split_models.transfer.transfer_tasks import staged_by
from tactiledata.compute import make_scheduler
from tactiledata.compute.base import Scheduler
from tactiledata.contract.progress import Progress
from tactiledata.contract.provenance import digest_of
from tactiledata.contract.records import Finding
from tactiledata.contract.wording import counted
from tactiledata.errors import StoreError, UnknownName, UsageError
from tactiledata.sensors.average_background import refuse_swapped_channels
from tactiledata.store.change.flag import carry_flags
from tactiledata.store.change.pieces import Origin, Piece, pieces_of
from tactiledata.store.layout.manifest import settings_of
from tactiledata.store.layout.places import MANIFEST
from tactiledata.store.read.reader import Store
from tactiledata.store.read.seen_target import target_findings
from tactiledata.store.read.targets import Target
from tactiledata.store.write.commit import commit_groups, recover
from tactiledata.store.write.intake import intake
from tactiledata.store.write.writer import StagedTake, find_staged


@dataclass(frozen=True)
class TransferReport:
    """Report of a store's transfer.

    Parameters
    ----------
    out : str
        The store that was written.
    target : Target
    method : str
        Name of the method.
    sensors : tuple of str
        Sensors whose frames were transferred.
    recordings, frames : int
        Recordings and frames that the store holds now.
    added : int
        Recordings that this call added; the others were there before.
    left_out : int
        Frames of the source store that were not transferred: other cameras, no whole image, in no trajectory.
    notes : tuple of str
        Remarks for the user.
    findings : tuple of Finding
        Warnings where the target is a sensor of the source store, or one that the model was trained on, and flags of
        trajectories that came along.
    """

    out: str
    target: Target
    method: str
    sensors: tuple[str, ...]
    recordings: int
    frames: int
    added: int
    left_out: int
    notes: tuple[str, ...]
    findings: tuple[Finding, ...] = ()

    def document(self) -> dict[str, Any]:
        """The report as JSON values."""
        facts = {name: value for name, value in vars(self).items() if name not in ("target", "findings")}
        target = {name: value for name, value in vars(self.target).items() if name != "background"}
        return {**facts, "target": target, "findings": [vars(finding) for finding in self.findings]}


def transfer_store(
    store: Store,
    target: Target,
    method: TransferMethod,
    out: Path,
    sensors: Sequence[str] | None = None,
    progress: Progress | None = None,
    measured: Mapping[str, Any] | None = None,
    *,
    workers: int = 1,
    scheduler: str | None = None,
) -> TransferReport:
    """Write a store with every touch of a store as the target sensor might have recorded it, and report on it.

    Signals, forces and times are the parents'. Pictures are new and lossless, and meshes stay with the parents. Each
    trajectory names its parent, so that `split` and `audit` keep the family together once both stores are merged. What
    is made of a flagged trajectory counts as flagged.
    A call that was killed and is repeated resumes at the first unfinished recording and ends with the same bytes.
    Memory holds the source's tables, one recording's numbers, and 64 pictures.

    Parameters
    ----------
    store : Store
        The source store.
    target : Target
        The sensor whose style is given.
    method : TransferMethod
    out : Path
        A new store, or one that an earlier call with the same settings made.
    sensors : list of str, optional
        Sensors whose frames are transferred; all with frames unless given.
    progress : callable, optional
        Called with recordings done, recordings in all, and the name of the last one.
    measured : dict, optional
        Figures on how much of the touches is kept, as JSON values, which are stored with each recording.
    workers : int
        Number of local processes, each of which transfers whole recordings.
    scheduler : str, optional
        Address of a Dask scheduler whose workers do so instead; they see both stores at the same paths.

    Raises
    ------
    UnknownName
        The store does not know a sensor.
    UsageError
        Backgrounds have different sizes, ``out`` holds another store, or no Dask scheduler answers.
    StoreError
        A sensor has no picture without contact, or no frame can be transferred.
    """
    backgrounds = refuse_unfit(store, target, method, out, sensors)
    transfer = Transfer(target, method, backgrounds, _settings(target, method), measured or {})
    runner = make_scheduler(workers, scheduler) if scheduler or workers != 1 else None
    pieces = list(pieces_of(Origin.of(store)))
    counts = [len(transfer.selected(piece)) for piece in pieces]
    chosen = [piece for piece, count in zip(pieces, counts, strict=True) if count]
    if not chosen:
        raise StoreError(
            f"no frame of {store.location} can be transferred",
            f"whole images of {', '.join(sorted(backgrounds))} in trajectories",
            "`tactiledata info` shows what the store holds.",
        )
    # resume an earlier call's store, or make a new one, which is gone again where nothing could be transferred
    if (out / MANIFEST).exists():
        _refuse_other_transfer(out, transfer, chosen)
    with intake(out, None if (out / MANIFEST).exists() else settings_of(store.manifest)):
        recover(out)
        # before the recordings: what is made of a flagged trajectory is never there without the flag of its parent
        carried = carry_flags([store], out, derived=True)
        added = _write(out, chosen, transfer, runner, progress)
        recover(out)  # locks of workers need not stay
    made = Store.open(out)
    notes = [f"meshes stay with the parents: {', '.join(store.mesh_names)}"] if store.mesh_names else []
    return TransferReport(
        str(out),
        target,
        method.name,
        tuple(sorted(backgrounds)),
        made.sources(["sha256"]).num_rows,
        made.n_frames,
        added,
        left_out=store.n_frames - sum(counts),
        notes=tuple(notes),
        findings=(*carried, *target_findings(target, store, backgrounds, getattr(method, "learned_from", None))),
    )


def _write(
    out: Path, pieces: Sequence[Piece], transfer: Transfer, runner: Scheduler | None, progress: Progress | None
) -> int:
    """Stage and commit the recordings that the output store lacks; the number that was added."""
    held = set(Store.open(out).manifest["sources"])
    waiting = find_staged(out)
    fresh = [piece for piece in pieces if transfer.digest(piece) not in held]
    largest = settings_of(Store.open(out).manifest).heap_chunk_bytes

    def takes() -> Iterator[StagedTake]:
        lacking = [piece for piece in fresh if transfer.digest(piece) not in waiting]
        made: Generator[StagedTake, None, None]
        if runner is None:
            made = (stage_transfer(out, piece, transfer, largest) for piece in lacking)
        else:
            made = staged_by(runner, lacking, out, transfer, largest)
        with closing(made):
            for done, piece in enumerate(fresh, start=len(pieces) - len(fresh) + 1):
                yield waiting.get(transfer.digest(piece)) or next(made)
                if progress is not None:
                    progress(done, len(pieces), piece.facts["key"])

    commit_groups(out, takes())
    return len(fresh)


def _settings(target: Target, method: TransferMethod) -> dict[str, Any]:
    """Values that shape the output, beside the recordings and their backgrounds."""
    return {
        "method": method.name,
        "model": getattr(method, "model", ""),
        "recipe": getattr(method, "recipe", ""),
        "target": target.name,
        "target_picture": target.resolved,
        "target_crc32c": crc_of(target.background),
    }


def refuse_unfit(
    store: Store, target: Target, method: TransferMethod, out: Path, sensors: Sequence[str] | None = None
) -> dict[str, NDArray[np.uint8]]:
    """Background of each sensor whose frames are transferred, or a refusal; nothing is written.

    Parameters
    ----------
    store, target, method, out, sensors
        As in `transfer_store`.

    Raises
    ------
    UnknownName, UsageError, StoreError
        As in `transfer_store`.
    """
    _refuse_itself(store, out)
    return _backgrounds(store, target, method, sensors)


def _backgrounds(
    store: Store, target: Target, method: TransferMethod, sensors: Sequence[str] | None
) -> dict[str, NDArray[np.uint8]]:
    """Picture without contact of each sensor whose frames are transferred; sensors without one are refused."""
    if target.model == "digit":
        refuse_swapped_channels(target.background, f"the background of {target.name}")
    facts = store.sensors()
    tactile = [name for name in sorted(facts) if facts[name].get("model") != "camera"]
    if sensors is not None and (unknown := [name for name in sensors if name not in facts]):
        raise UnknownName("sensor of the store", unknown[0], facts)
    named = list(sensors) if sensors is not None else _with_frames(store, tactile)
    held = store.manifest["references"]
    if lacking := [name for name in named if name not in held]:
        raise StoreError(
            f"{counted(len(lacking), 'sensor')} of {store.location} without a picture without contact: "
            + ", ".join(lacking),
            "a background for every sensor that is transferred",
            f"`tactiledata sensors add {lacking[0]} --background FILE...`, or name others with --from.",
        )
    images = {name: store.reference(name).image for name in named}
    if not getattr(method, "scales", False):
        _refuse_other_sizes(images, target)
    return images


def _with_frames(store: Store, names: Sequence[str]) -> list[str]:
    """The sensors among the names that have a trajectory in the store."""
    there = set(store.trajectories(["sensor"])["sensor"].to_pylist())
    return [name for name in names if name in there]


def _refuse_other_sizes(backgrounds: dict[str, NDArray[np.uint8]], target: Target) -> None:
    """Refuse source backgrounds of another size than the target's."""
    size = target.background.shape
    others = {name: image.shape for name, image in backgrounds.items() if image.shape != size}
    if others:
        name, shape = next(iter(others.items()))
        raise UsageError(
            f"the background of {target.name} is {size[0]} rows x {size[1]} columns, that of {name} "
            f"{shape[0]} x {shape[1]}",
            "backgrounds of one size",
            "Name a target of that size, or leave the sensor out with --from.",
        )


def _refuse_itself(store: Store, out: Path) -> None:
    """Refuse to write the transferred store over its source."""
    if Path(store.location).resolve() == out.resolve():
        raise UsageError(f"{out} would be transferred into itself", "another store to write to", "Name it with --out.")


def _refuse_other_transfer(out: Path, transfer: Transfer, pieces: Sequence[Piece]) -> None:
    """Refuse an output store that holds recordings of other settings, sensors or backgrounds than this transfer's."""
    settings_digest, expected = digest_of(transfer.settings), {p.facts["sha256"]: transfer.digest(p) for p in pieces}
    for row in Store.open(out).sources(["key", "sha256", "provenance"]).to_pylist():
        made = json.loads(row["provenance"])
        if made.get("step") != "transfer":
            content = f"the recording {row['key']}"
        elif made["settings_sha256"] != settings_digest:
            before = made["settings"]
            content = f"frames transferred to {before['target']} by {before['method']}, with other settings than now"
        elif expected.get(made["inputs"]["parent"], row["sha256"]) != row["sha256"]:
            content = f"{row['key']}, with other source sensors or backgrounds than now"
        else:
            continue
        raise UsageError(
            f"{out} holds {content}", "a new store, or one of the same transfer", "Name another one with --out."
        )
