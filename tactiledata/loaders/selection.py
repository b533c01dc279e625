"""Which frames a dataset holds: those of one part of a split, and what was left out and why."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

from tactiledata.contract.take import UNUSABLE, FrameFlag
from tactiledata.contract.wording import agreeing, counted
from tactiledata.errors import MissingSplit, UsageError
from tactiledata.splits.again import command
from tactiledata.splits.flagged import SHOWN, flagged_in_parts
from tactiledata.splits.manifest import Split, frame_rows, load_split, partition_rows
from tactiledata.splits.options import PARTITIONS
from tactiledata.store.read.flags import flag_words, flagged_trajectories

if TYPE_CHECKING:
    from tactiledata.store.read.reader import Store

ALL = "all"
COLUMNS = ("trajectory", "camera", "flags")
FILTERED = "outside the split's contact filter"


class FlaggedTrajectoriesWarning(UserWarning):
    """A dataset holds trajectories that were flagged as bad after its split was drawn."""


@dataclass(frozen=True)
class LoadReport:
    """What a dataset holds and what it leaves out.

    Parameters
    ----------
    split : str
        ``"<split>/<part>"`` or ``"all"``.
    frames, trajectories : int
        How many it holds.
    left_out : dict, reason -> frames
        Frames of the part's trajectories that it does not hold.
    missing : dict, stream -> Gaps
        Where streams of numbers have no values; streams that are whole are not named.
    notes : tuple of str
    """

    split: str
    frames: int
    trajectories: int
    left_out: Mapping[str, int] = field(default_factory=dict)
    missing: Mapping[str, Any] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    def noted(self, *notes: str) -> LoadReport:
        """The report with more notes; empty ones are dropped."""
        return replace(self, notes=(*self.notes, *(note for note in notes if note)))

    def document(self) -> dict[str, Any]:
        """The report as JSON values."""
        missing = {stream: gaps.document() for stream, gaps in self.missing.items()}
        return {**vars(self), "left_out": dict(self.left_out), "missing": missing, "notes": list(self.notes)}

    def __str__(self) -> str:
        parts = [f"{self.split}: {self.frames} frames of {self.trajectories} trajectories"]
        parts += [f"left out: {count} frames, {reason}" for reason, count in self.left_out.items()]
        parts += [f"{stream}: {gaps}" for stream, gaps in self.missing.items()]
        return "; ".join([*parts, *self.notes])


@dataclass(frozen=True)
class Selection:
    """The frames of a dataset.

    Parameters
    ----------
    rows : (n,) int64
        Rows over all frames of the store, ascending.
    in_split : (n,) bool
        Whether the split's contact filter takes the frame; all, unless whole trajectories were asked for.
    split : Split, optional
        ``None`` for ``"all"``.
    report : LoadReport
    """

    rows: NDArray[np.int64]
    in_split: NDArray[np.bool_]
    split: Split | None
    report: LoadReport


def select(
    store: Store, split: str | None, camera: str | None = None, *, whole: bool = False, allow_leaks: bool = False
) -> Selection:
    """The frames of one part of a split, of one camera where one is named.

    Parameters
    ----------
    store : Store
    split : str
        ``"<split>/<part>"``, for example ``"default/train"``; ``"all"`` only with ``allow_leaks``.
    camera : str, optional
    whole : bool
        Take every readable frame of a trajectory that has one in the split, the frames of free air included.
    allow_leaks : bool
        Take every frame without regard to splits.

    Raises
    ------
    MissingSplit
        No split was named, it does not exist, or the part is missing from the name.
    UsageError
        ``"all"`` without ``allow_leaks``.
    """
    frames = store.frames(list(COLUMNS))
    trajectory, flags = frames["trajectory"].to_numpy(), frames["flags"].to_numpy()
    of_camera = np.ones(len(flags), bool)
    if camera is not None:
        of_camera = pc.equal(frames["camera"].cast(pa.string()), camera).to_numpy()
    chosen, taken, belongs = _taken(store, split, trajectory, flags, allow_leaks)
    kept = taken & of_camera
    in_split = kept
    if whole:
        touched = np.unique(trajectory[kept & (trajectory >= 0)])
        kept = np.isin(trajectory, touched) & of_camera & ((flags & UNUSABLE) == 0)
    reasons = {
        "of another camera": ~of_camera,
        "no image recorded": of_camera & ((flags & FrameFlag.MISSING) != 0),
        "image does not decode": of_camera & ((flags & (FrameFlag.MISSING | FrameFlag.BROKEN)) == FrameFlag.BROKEN),
        "another size than its sensor's images": of_camera
        & ((flags & (UNUSABLE - FrameFlag.BLANK)) == FrameFlag.STRAY_SIZE),
        "an image of one colour": of_camera & ((flags & UNUSABLE) == FrameFlag.BLANK),
    }
    left_out = {reason: int((belongs & mask).sum()) for reason, mask in reasons.items()}
    left_out[FILTERED] = int((belongs & ~kept).sum()) - sum(left_out.values())
    n_trajectories = len(np.unique(trajectory[kept & (trajectory >= 0)]))
    counts = {reason: count for reason, count in left_out.items() if count}
    report = LoadReport(split or "", int(kept.sum()), n_trajectories, counts).noted(_flagged_note(store, split, chosen))
    return Selection(np.flatnonzero(kept).astype(np.int64), in_split[kept], chosen, report)


def _flagged_note(store: Store, split: str | None, chosen: Split | None) -> str:
    """Say which flagged trajectories a part of a split holds, and warn of them; empty where there are none."""
    if chosen is None:
        flags = list(flagged_trajectories(store).values())
        return f"{counted(len(flags), 'flagged trajectory')} among them: {flag_words(flags, SHOWN)}" if flags else ""
    part = (split or "").rpartition("/")[2]
    held = flagged_in_parts(store, chosen, part)
    if not held:
        return ""
    note = f"{counted(len(held), 'trajectory')} {agreeing(len(held), 'was', 'were')} flagged since the split was drawn"
    again = command(store.location, chosen.name, chosen.document["options"])
    warnings.warn(
        f"{split} of {store.location}: {note} ({flag_words(held, SHOWN)}), and is loaded all the same. Run `{again}` "
        "again, which leaves flagged trajectories out; or with --with-flagged, where they are meant.",
        FlaggedTrajectoriesWarning,
        stacklevel=4,
    )
    return note


def _taken(
    store: Store, split: str | None, trajectory: NDArray[np.int32], flags: NDArray[np.uint32], allow_leaks: bool
) -> tuple[Split | None, NDArray[np.bool_], NDArray[np.bool_]]:
    """The split, which frames its part takes, and which belong to its trajectories."""
    if split == ALL:
        if not allow_leaks:
            raise UsageError(
                "split='all' mixes the data that models learn from with the data that they are tested on",
                f"one part of a split: {_choices(store)}",
                "Name a part, or say allow_leaks=True where nothing will be learned from the data.",
            )
        return None, (flags & UNUSABLE) == 0, np.ones(len(flags), bool)
    chosen, part = _split_and_part(store, split)
    taken = np.zeros(len(flags), bool)
    taken[frame_rows(store, chosen, part)] = True
    of_part = np.append(partition_rows(chosen, store.trajectories(["uid"])["uid"]) == part, False)  # row -1: outside
    return chosen, taken, of_part[trajectory]


def _split_and_part(store: Store, split: str | None) -> tuple[Split, str]:
    name, slash, part = (split or "").rpartition("/")
    if not slash or not name or part not in PARTITIONS:
        raise MissingSplit(
            "no split was named" if not split else f"{split!r} does not name a part of a split",
            f"split='<split>/<part>', {_choices(store)}",
            _command(store),
            split=split,
        )
    names = list(store.split_names())
    if name not in names:
        raise MissingSplit(
            f"the store {store.location} has no split {name!r}", _choices(store), _command(store, name), split=split
        )
    return load_split(store, name), part


def _choices(store: Store) -> str:
    names = list(store.split_names())
    parts = ", ".join(PARTITIONS)
    return f"a split of this store ({', '.join(names) or 'it has none yet'}) and one of its parts ({parts})"


def _command(store: Store, name: str = "default") -> str:
    named = "" if name == "default" else f" --name {name}"
    have = list(store.split_names())
    example = f"For example split='{have[0]}/train'. " if have else ""
    return f"{example}A split is made by `tactiledata split {store.location} --by trajectory,sensor{named}`."
