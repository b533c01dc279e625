"""A folder that appears when all of it is written: killed at any moment, it is not there, and the next run goes on.

The files are made in a hidden folder beside the place. Large ones are noted there when they are whole, so that a run
that was killed goes on behind them. At the end the hidden folder is renamed.
"""

from __future__ import annotations

import fcntl
import json
import os
import shutil
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from tactiledata.contract.atomic import sync_folder, write_atomic, write_json_atomic
from tactiledata.contract.provenance import file_digest
from tactiledata.contract.sealed import fits_seal, sealed_json
from tactiledata.errors import StoreBusy, StoreError, UsageError

DOCUMENT = "export.json"
"""Written last: a folder with it is whole."""
PLAN = ".plan.json"
NOTES = ".written"
"""Folder of notes, one for each large file that is whole."""
PART = ".part"
"""Suffix of files that are being written."""


def read_export(folder: Path) -> dict[str, Any] | None:
    """Return the document of a finished export; ``None`` where the folder holds none that is whole."""
    try:
        content = (folder / DOCUMENT).read_bytes()
        document = json.loads(content)
    except (OSError, ValueError, RecursionError):
        return None
    is_ours = isinstance(document, dict) and str(document.get("format", "")).startswith("tactiledata-export/")
    return document if is_ours and fits_seal(content) else None


def finished_export(
    out: Path, key: str, replace: bool, unlike: Callable[[Mapping[str, Any]], Sequence[str]]
) -> dict[str, Any] | None:
    """Return the document of the export that is wanted where it is there already, ``None`` where it must be made.

    Parameters
    ----------
    out : Path
        The folder that is asked for.
    key : str
        Digest of all that decides the bytes of the export.
    replace : bool
        Whether another export may be replaced.
    unlike : callable
        Says in what the export with a document differs from the one that is wanted.

    Raises
    ------
    UsageError
        Something else is there: a file, other files, or another export without ``replace``.
    """
    if not out.exists() and not out.is_symlink():
        return None
    if Path.cwd().is_relative_to(out.resolve()):
        raise UsageError(
            f"{out} is the working folder, or holds it", "a place for a new folder", "Name a folder inside with --out."
        )
    if not out.is_dir():
        raise UsageError(f"--out {out} is not a folder", "a place for a new folder", "Name another place with --out.")
    names = sorted(path.name for path in out.iterdir())
    if not names:
        return None
    document = read_export(out)
    if document is None:
        listed = ", ".join(names[:3]) + (" …" if len(names) > 3 else "")
        raise UsageError(
            f"{out} holds other files, or an export that is not complete: {listed}",
            "an empty folder, or a place where nothing is",
            "Name another place with --out, or move what is there.",
        )
    fault = _missing_file(out, document)
    if document["key"] == key and not fault:
        return document
    if not replace:
        what = (
            f"an export that lacks {fault}"
            if fault
            else f"another export ({document['to']}): {'; '.join(unlike(document))}"
        )
        raise UsageError(
            f"{out} holds {what}",
            "an empty folder, or an export of the same store with the same options",
            "--replace replaces it; --out names another place.",
        )
    if added := _added_file(out, document):
        raise UsageError(
            f"{out} holds {added}, which is no part of the export there",
            "an export and nothing else, as all of it would go",
            "Move it, or name another place with --out.",
        )
    return None


def _missing_file(out: Path, document: Mapping[str, Any]) -> str:
    """Return the first file of an export that is gone or has another size; empty where all are there."""
    for name, facts in document["files"].items():
        path = out / name
        if not path.is_file() or path.stat().st_size != facts["bytes"]:
            return str(name)
    return ""


def _added_file(out: Path, document: Mapping[str, Any]) -> str:
    """Return the first file in a folder that is not of its export; empty where there is none."""
    names = (path.relative_to(out).as_posix() for path in sorted(out.rglob("*")) if not path.is_dir())
    return next((name for name in names if name not in document["files"] and name != DOCUMENT), "")


class ExportFolder:
    """The hidden folder in which an export is made."""

    def __init__(self, out: Path, folder: Path) -> None:
        self.out, self.folder = out, folder

    def note(self, number: int) -> dict[str, Any] | None:
        """Return what is noted of a large file that is whole; ``None`` where it must be written."""
        try:
            noted = json.loads(self._note_path(number).read_bytes())
        except (OSError, ValueError):
            return None
        path = self.folder / noted["path"]
        return noted if path.is_file() and path.stat().st_size == noted["bytes"] else None

    def noted(self, number: int) -> dict[str, Any]:
        """Return what is noted of a large file that was written."""
        noted = self.note(number)
        if noted is None:
            raise StoreError(
                f"file {number} of the export at {self.out} is gone while it is made",
                "a folder that nobody else changes",
                "Run the same command again.",
            )
        return noted

    @contextmanager
    def large_file(self, number: int, name: str, facts: dict[str, Any]) -> Iterator[Path]:
        """Give the block a path to write to; the file counts when the block has ended.

        Parameters
        ----------
        number : int
            Number of the file.
        name : str
            Its path in the export.
        facts : dict
            What the block wants noted; it fills it before it ends.
        """
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        beside = path.with_name(f".{path.name}{PART}")
        try:
            yield beside
            with beside.open("rb") as stream:
                os.fsync(stream.fileno())
            digest, size = file_digest(beside), beside.stat().st_size
            beside.replace(path)
        finally:
            beside.unlink(missing_ok=True)
        sync_folder(path.parent)
        write_json_atomic(self._note_path(number), {"path": name, "sha256": digest, "bytes": size, "facts": facts})

    def _note_path(self, number: int) -> Path:
        return self.folder / NOTES / f"{number:08d}.json"

    def finish(self, document: Mapping[str, Any], known: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
        """Write the document with the digests of all files, and put the folder in its place.

        Parameters
        ----------
        document : dict
            The document, without ``files``.
        known : dict
            Size and digest of the large files, by path.
        """
        files = {}
        for path in sorted(self.folder.rglob("*")):
            name = path.relative_to(self.folder).as_posix()
            if path.is_file() and not name.startswith("."):
                files[name] = known.get(name) or {"sha256": file_digest(path), "bytes": path.stat().st_size}
        whole = {**document, "files": files}
        write_atomic(self.folder / DOCUMENT, sealed_json(whole))
        self.put_in_place()
        return whole

    def put_in_place(self) -> None:
        """Rename the finished folder to its place; what it replaces goes."""
        shutil.rmtree(self.folder / NOTES, ignore_errors=True)
        (self.folder / PLAN).unlink(missing_ok=True)
        sync_folder(self.folder)
        old = replaced_folder(self.out)
        if self.out.is_dir():
            if any(self.out.iterdir()):
                shutil.rmtree(old, ignore_errors=True)
                self.out.rename(old)
            else:
                self.out.rmdir()
        self.folder.rename(self.out)
        sync_folder(self.out.parent)
        shutil.rmtree(old, ignore_errors=True)


def replaced_folder(out: Path) -> Path:
    """Return where an export lies for the moment in which another takes its place."""
    return out.with_name(f".{out.name}.replaced")


@contextmanager
def export_folder(out: Path, key: str) -> Iterator[ExportFolder]:
    """Open the hidden folder of an export, locked; what another export began there is removed.

    Parameters
    ----------
    out : Path
        Where the export appears at the end.
    key : str
        Digest of all that decides its bytes.

    Raises
    ------
    StoreBusy
        Another process makes an export at this place.
    UsageError
        Something else lies where the hidden folder belongs.
    """
    folder = out.with_name(f".{out.name}.exporting")
    folder.mkdir(parents=True, exist_ok=True)
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            raise StoreBusy(
                f"another process makes an export at {out}", "one at a time", "Wait until it has ended."
            ) from error
        _clear(folder, key)
        try:
            yield ExportFolder(out, folder)
        except Exception:
            # nothing to go on from: what failed will fail again
            if not (folder / NOTES).is_dir():
                shutil.rmtree(folder, ignore_errors=True)
            raise
    finally:
        os.close(descriptor)


def _clear(folder: Path, key: str) -> None:
    """Leave in a hidden folder only what the export with this key had finished."""
    document = read_export(folder)
    if document is not None and document["key"] == key:
        return
    plan = folder / PLAN
    try:
        is_same = json.loads(plan.read_bytes())["key"] == key
    except (OSError, ValueError, KeyError, TypeError):
        is_same = False
    if is_same:
        for path in list(folder.rglob(f"*{PART}")):
            path.unlink()
        return
    foreign = [path.name for path in folder.iterdir() if not path.name.startswith(".")]
    if foreign and not plan.exists() and document is None:
        raise UsageError(
            f"{folder} holds {foreign[0]}, which no export wrote",
            "a folder that only exports write to",
            "Move it, or name another place with --out.",
        )
    for path in list(folder.iterdir()):
        shutil.rmtree(path) if path.is_dir() and not path.is_symlink() else path.unlink()
    write_json_atomic(plan, {"key": key})
