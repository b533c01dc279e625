"""What cannot be read: what the system refuses, links that lead nowhere, names that are no text."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from tactiledata.contract.near_path import dead_link
from tactiledata.contract.records import Finding, Source
from tactiledata.errors import BrokenLog, TactileDataError

LEVELS = 3
"""Folders below a place that are looked into for one that cannot be read."""


@contextmanager
def refusals_told(source: Source) -> Iterator[None]:
    """A block that reads a source; where it cannot be read, that is an error of this recording alone.

    Raises
    ------
    BrokenLog
        The system refuses one of its files, or a name of one is no text.
    """
    for name in (source.path, *source.files):
        if not is_text(name):
            raise _no_text(name)
    try:
        yield
    except TactileDataError:
        raise
    except OSError as error:
        raise _refused(error.filename or source.path, error) from error


def refuse_folder(folder: Path) -> None:
    """Refuse a folder whose content cannot be listed, or lies where nothing may be reached.

    Raises
    ------
    BrokenLog
        The system refuses it.
    """
    try:
        for child in folder.iterdir():
            child.is_symlink()
            break
    except OSError as error:
        raise _refused(folder, error, "folder") from error


def is_text(name: str) -> bool:
    """Whether the name of a file is text: one of bytes that are not UTF-8 cannot be written into a store."""
    try:
        name.encode()
    except UnicodeEncodeError:
        return False
    return True


def refused_findings(unclaimed: Sequence[Path]) -> tuple[list[Path], list[Finding]]:
    """Places that no format claims without those that cannot be read, and what is said of these."""
    links, shut, others = [], [], []
    for path in unclaimed:
        if dead_link(path):
            links.append(path)
        elif reason := why_shut(path):
            shut.append(f"{path} was left out: {reason}")
        else:
            others.append(path)
    findings = [Finding("place-unreadable", "damage", text) for text in shut]
    if links:
        more = f"; so do {len(links) - 1} more" if links[1:] else ""
        text = f"{links[0]} leads nowhere: {dead_link(links[0])}{more}"
        findings.append(Finding("dead-link", "warning", text, count=len(links)))
    return others, findings


def why_shut(path: Path) -> str:
    """Why a place, or a folder a few levels below it, cannot be looked into; empty where all can.

    Parameters
    ----------
    path : Path
        A folder; a file is shut only where its folder may not be entered.
    """
    try:
        if not path.is_dir():
            return ""
        refuse_folder(path)
        for place, folders, _ in os.walk(path):
            below = [Path(place, name) for name in folders]
            for folder in below:
                refuse_folder(folder)
            if len(Path(place).parts) - len(path.parts) >= LEVELS:
                folders.clear()
    except BrokenLog as error:
        return error.found
    except OSError as error:
        return _refused(path, error).found
    return ""


def _refused(path: str | Path, error: OSError, kind: str = "file") -> BrokenLog:
    what = "the folder " if kind == "folder" else ""
    return BrokenLog(
        f"{what}{path} cannot be read ({error.strerror or error})",
        f"a readable {kind}",
        "Check the path and its permissions.",
        path=str(path),
    )


def _no_text(name: str) -> BrokenLog:
    shown = os.fsencode(name).decode(errors="backslashreplace")
    return BrokenLog(
        f"the name {shown} holds bytes that are not UTF-8",
        "a name of a file that is text, as the store keeps it",
        "Rename it with `mv`, then run the same command again.",
        path=shown,
    )
