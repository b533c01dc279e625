"""Which files belong to a folder log, none of them outside the folder."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path, PurePosixPath
from typing import Any

from tactiledata.contract.image_bytes import IMAGE_SUFFIXES
from tactiledata.contract.paths import path_inside
from tactiledata.contract.schema import read_document
from tactiledata.errors import BrokenLog, TactileDataError, UnsafeContent
from tactiledata.formats.reading.csv_tables import read_csv_table
from tactiledata.formats.reading.natural_order import natural_paths

DESCRIPTION = "log.yaml"
TABLES = ("trajectories.csv", "wrench.csv", "tcp.csv", "joints.csv", "frames.csv")
FRAMES = "frames"

SNIFFED = 64 * 2**10
"""Bytes of log.yaml in which its format is looked for."""

_FORMAT = re.compile(rb"""(?m)^[\s{]*["']?format["']?\s*:\s*["']?tactiledata-log/""")


def is_folder_log(path: Path) -> bool:
    """Whether a folder holds a log.yaml of ours, or a log.yaml (however broken) beside tables of ours."""
    description = path / DESCRIPTION
    if not description.exists():
        return False
    start = b""
    if description.is_file():  # a pipe would be waited for
        with suppress(OSError), description.open("rb") as stream:
            start = stream.read(SNIFFED)
    return bool(_FORMAT.search(start)) or any((path / name).is_file() for name in TABLES)


class LogFolder:
    """A folder log's root, from which files are looked up by the names that its documents give.

    Checking a name follows every link on the way, which is slow; so folders are checked once and remembered.
    """

    def __init__(self, root: Path) -> None:
        self.root = root
        self._checked: set[PurePosixPath] = set()

    def path(self, name: str, where: str) -> Path:
        """The path of a file that ``where`` names.

        Raises
        ------
        UnsafeContent
            It lies outside the folder, or a link leads there.
        """
        pure = PurePosixPath(name.replace("\\", "/"))
        if ":" in name or "\0" in name or pure.name in ("", ".."):
            return path_inside(self.root, name, where)
        if pure.parent not in self._checked:
            path_inside(self.root, name, where)  # says which file it is
            path_inside(self.root, str(pure.parent), where)
            self._checked.add(pure.parent)
        path = self.root / pure
        try:
            is_link = path.is_symlink()
        except OSError:  # a name longer than the file system has: no such file
            is_link = False
        return path_inside(self.root, name, where) if is_link else path

    def table(self, name: str) -> Path | None:
        """A table's path; ``None`` where the log does not have it."""
        path = self.path(name, "the log")
        if not path.exists() and not path.is_symlink():
            return None
        if not path.is_file():
            raise BrokenLog(f"{path} is not a file", "a CSV file", "Remove what stands in its place.", file=name)
        return path

    def belonging(self) -> list[Path]:
        """All files whose contents are the recording, in natural order: known or named, there, and inside.

        What cannot be read or leads outside is left for `read` to report.
        """
        names = {DESCRIPTION, *TABLES, *self._named_in_description(), *self._named_in_frames(), *self._pictures()}
        found = set()
        for name in names:
            try:
                path = self.path(name, "the log")
                if path.is_file():
                    found.add(path)
            except (UnsafeContent, OSError):
                continue
        return natural_paths(found)

    def _named_in_description(self) -> Iterator[str]:
        try:
            document = read_document(self.path(DESCRIPTION, "the log"))
        except TactileDataError:
            return
        yield from _texts(document, ("sensors", "*", "background"))
        yield from _texts(document, ("sensors", "*", "gel", "mesh"))
        yield from _texts(document, ("indenters", "*", "mesh"))

    def _named_in_frames(self) -> Iterator[str]:
        try:
            path = self.table("frames.csv")
            frames = None if path is None else read_csv_table(path)
        except TactileDataError:
            return
        if frames is not None and "file" in frames.columns:
            yield from (name for name in frames.text("file") if name)

    def _pictures(self) -> Iterator[str]:
        folder = self.root / FRAMES
        if folder.is_symlink():
            return
        for path in folder.rglob("*"):
            if path.suffix.lower() in IMAGE_SUFFIXES and not path.name.startswith("."):
                yield path.relative_to(self.root).as_posix()

    def unlisted_pictures(self, listed: set[str]) -> list[str]:
        """Images in ``frames/`` that no table names."""
        known = {PurePosixPath(name.replace("\\", "/")).as_posix() for name in listed}
        return sorted(set(self._pictures()) - known)


def _texts(value: Any, way: tuple[str, ...]) -> Iterator[str]:
    """The texts at a place in a document of unknown shape; ``*`` stands for every key."""
    if not way:
        if isinstance(value, str) and value:
            yield value
    elif isinstance(value, dict):
        for below in value.values() if way[0] == "*" else [value.get(way[0])]:
            yield from _texts(below, way[1:])
