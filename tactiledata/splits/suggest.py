"""Which split can be drawn from a store as it is, and the command that draws it."""

from __future__ import annotations

import shlex
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tactiledata.errors import StoreError, UsageError
from tactiledata.splits.make import TRAJECTORY_COLUMNS, split_tables
from tactiledata.splits.options import SplitOptions
from tactiledata.splits.report import SplitReport
from tactiledata.splits.select import FRAME_COLUMNS
from tactiledata.store.read.flags import flagged_trajectories

if TYPE_CHECKING:
    from tactiledata.store.read.reader import Store


@dataclass(frozen=True)
class Suggestion:
    """A split that can be drawn, or why none can.

    Parameters
    ----------
    command : str
        As people type it; empty where no split can be drawn.
    report : SplitReport, optional
        What the command would give.
    reason : str
        Why no split can be drawn, and what to do.
    """

    command: str = ""
    report: SplitReport | None = None
    reason: str = ""


def suggest_split(store: Store) -> Suggestion:
    """The split by sensor that a store gives: of frames in contact, or of all where no force tells them."""
    trajectories = store.trajectories(list(TRAJECTORY_COLUMNS))
    frames, flags = store.frames(list(FRAME_COLUMNS)), flagged_trajectories(store)
    typed = ["tactiledata", "split", str(store.location), "--by", "trajectory,sensor"]
    reason = ""
    for options, more in ((SplitOptions(), []), (SplitOptions.checked(force="none"), ["--force", "none"])):
        try:
            report, _ = split_tables("default", trajectories, frames, options, flags=flags)
        except (StoreError, UsageError) as error:
            reason = str(error)
            continue
        return Suggestion(shlex.join([*typed, *more]), report)
    return Suggestion(reason=reason)
