"""Export of a store: tables say which files it gets, each file is written whole, and a rename ends it."""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from tactiledata.contract.atomic import write_atomic
from tactiledata.contract.progress import Progress, no_progress
from tactiledata.contract.schema import check_document
from tactiledata.export import EXPORTERS
from tactiledata.export.base import ExportedFile, Exporter, FileFacts
from tactiledata.export.card import card
from tactiledata.export.document import export_document, exported_frames
from tactiledata.export.episodes import Episodes
from tactiledata.export.find_episodes import chosen_split, find_episodes
from tactiledata.export.folder import ExportFolder, export_folder, finished_export, read_export, replaced_folder
from tactiledata.export.plan import NO_SPLIT, ExportPlan
from tactiledata.export.tables import write_tables
from tactiledata.splits.manifest import load_split
from tactiledata.store.read.flags import flagged_trajectories
from tactiledata.store.read.reader import Store

CARD = "README.md"


@dataclass(frozen=True)
class ExportReport:
    """What an export holds.

    Parameters
    ----------
    folder : Path
    document : dict
        As in ``schemas/export.json``.
    was_there : bool
        Whether it had been finished before, so that nothing was written.
    """

    folder: Path
    document: dict[str, Any]
    was_there: bool = False


def export_data(
    store: Store, plan: ExportPlan, out: Path, replace_other: bool = False, progress: Progress = no_progress
) -> ExportReport:
    """Write a store in another format into a new folder.

    Killed at any moment, the folder is not there, and the same call goes on behind the files that were finished.
    Equal stores and options give equal bytes.

    Parameters
    ----------
    store : Store
        What is exported.
    plan : ExportPlan
        Format and options; a split that is not named is ``default``.
    out : Path
        The folder; it must be empty, or not there.
    replace_other : bool
        Whether another export at that place is replaced.
    progress : Progress
        Called with the number of frames written and of all frames.

    Raises
    ------
    UnknownName
        There is no such format, camera, stream or split.
    MissingSplit, LeakError
        No split is there, or it does not know every trajectory.
    UsageError
        Something else lies at the place, or pictures of several sizes go into a format that has one.
    StoreError
        Damage in the store, or times that the format cannot hold.
    """
    exporter: Exporter = EXPORTERS[plan.to]()
    plan.require_frames(exporter.at_frames)
    chosen = chosen_split(store, plan.split or None, exporter.at_frames)
    plan = replace(plan, split=chosen)
    split = None if chosen == NO_SPLIT else dict(load_split(store, chosen).document)
    flags = {uid: flag.reason for uid, flag in flagged_trajectories(store).items()}
    key = plan.key(store.digest, store.row_state, split, flags)

    def unlike(document: Mapping[str, Any]) -> list[str]:
        """Say in what a finished export at the place is another one."""
        return plan.unlike(document, store.digest, split)

    if (document := finished_export(out, key, replace_other, unlike)) is not None:
        shutil.rmtree(replaced_folder(out), ignore_errors=True)
        return ExportReport(out, document, was_there=True)
    # what is wrong with the options is said before anything is made
    episodes = find_episodes(store, plan, may_be_empty=not exporter.at_frames)
    files = exporter.files(episodes, plan)
    with export_folder(out, key) as place:
        if (document := read_export(place.folder)) is not None:
            # killed between the last file and the renaming
            place.put_in_place()
            return ExportReport(out, document)
        _write_files(exporter, episodes, files, place, progress)

        def facts() -> Iterator[FileFacts]:
            """Yield what was noted of each large file."""
            return (place.noted(number)["facts"] for number in range(len(files)))

        exporter.finish(episodes, files, facts, place.folder)
        write_tables(episodes, place.folder)
        made = export_document(exporter, episodes, plan, key, split, facts())
        head = exporter.front_matter(episodes, files, key)
        page = card(made, exporter.title, exporter.snippet(episodes, files), head)
        write_atomic(place.folder / CARD, page.encode())
        check_document({**made, "files": {}}, "export", str(out))
        known = {file.path: _size_and_digest(place, number) for number, file in enumerate(files)}
        return ExportReport(out, place.finish(made, known))


def _size_and_digest(place: ExportFolder, number: int) -> dict[str, Any]:
    """Return size and digest of a large file as the document keeps them."""
    noted = place.noted(number)
    return {"sha256": noted["sha256"], "bytes": noted["bytes"]}


def _write_files(
    exporter: Exporter, episodes: Episodes, files: Sequence[ExportedFile], place: ExportFolder, progress: Progress
) -> None:  # fmt: skip
    """Write the large files that are not there yet."""
    total, done = exported_frames(files), 0
    for number, file in enumerate(files):
        before = done
        if place.note(number) is None:
            facts: dict[str, Any] = {}
            with place.large_file(number, file.path, facts) as path:

                def advance(count: int, name: str = file.path) -> None:
                    """Report that more frames are written."""
                    nonlocal done
                    done += count
                    progress(done, total, name)

                facts.update(exporter.write(episodes, file, path, advance))
        done = before + file.frames
        progress(done, total, file.path)
