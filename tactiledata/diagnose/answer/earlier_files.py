"""Files of an earlier diagnosis in the same folder: those that the new one does not write are removed before it."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

from tactiledata.contract.atomic import sync_folder
from tactiledata.contract.own_files import is_ours
from tactiledata.diagnose.next_trial.kinds import TRIALS

EFFECTS = "effects.json"
"""Name of the file of the claimed effects, which a replay takes."""
NEXT = "next"
"""Name of the folder of the scenarios of trials."""


def trial_files() -> list[str]:
    """Return the names of all files that a diagnosis may write into the folder `next`, one for each trial."""
    return [f"{make.__name__}.yaml" for make in TRIALS]


def remove_earlier(folder: Path, kept: Collection[Path]) -> None:
    """Remove what an earlier diagnosis wrote and the new one does not: claimed effects and scenarios of trials.

    It is done, and on disk, before the new page is written: effects of one diagnosis never stand beside the page of
    another that does not claim them. Files of others stay.

    Parameters
    ----------
    folder : Path
        The folder of the diagnosis.
    kept : collection of Path
        Files that the new diagnosis writes.
    """
    for path in (folder / EFFECTS, *(folder / NEXT / name for name in trial_files())):
        if path not in kept and path.is_file() and is_ours(path):
            path.unlink()
            sync_folder(path.parent)
