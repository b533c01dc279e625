"""Paths that documents name, and names that users give: kept inside the folder that they belong to."""

from __future__ import annotations

import re
from pathlib import Path, PurePosixPath

from tactiledata.errors import UnsafeContent, UsageError

NAME_PATTERN = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,63}")
"""A name that a user gives to something, and that becomes the name of files."""

LONGEST_NAME = 255
"""Bytes of the name of a file or folder, as file systems have them."""
LONGEST_PATH = 3000
"""Bytes of a relative path: the system's 4096 less what the folder takes."""


def need_file_name(name: object, kind: str, example: str) -> str:
    """A name given with ``--name`` that is safe as a file name; other files about the same carry it and a dot.

    Parameters
    ----------
    name : object
        What was given.
    kind : str
        Of what it is the name, for the message: a split, a mesh.
    example : str
        A name that serves, for the message.

    Raises
    ------
    UsageError
        Anything else: paths, spaces, dots, no text.

    Examples
    --------
    >>> need_file_name("by-robot", "split", "default")
    'by-robot'
    """
    if not isinstance(name, str) or not NAME_PATTERN.fullmatch(name):
        raise UsageError(
            f"the {kind} name {name!r} cannot be a file name",
            "letters, digits, '_' and '-', at most 64, starting with a letter or digit",
            f"For example --name {example}.",
            name=name,
        )
    return name


def path_inside(folder: Path, name: str, where: str) -> Path:
    """The path ``folder/name``, where a document named ``name``.

    Parameters
    ----------
    folder : Path
        The folder that must not be left.
    name : str
        A relative path with ``/`` or backslashes, as the document gives it.
    where : str
        The place in the document, with which the error begins.

    Raises
    ------
    UnsafeContent
        The name is absolute, or leads out of the folder by ``..`` or by a link, a link leads to itself, or no file can
        have that name.
    """
    if _is_impossible(name):
        raise UnsafeContent(
            f"{where} names the path {name[:80]!r}{'…' if len(name) > 80 else ''} ({len(name)} characters)",
            f"names of Unicode characters, of at most {LONGEST_NAME} bytes each and {LONGEST_PATH} together",
            "No file can have that name: correct it.",
            path=name,
        )
    pure = PurePosixPath(name.replace("\\", "/"))
    escapes = pure.is_absolute() or ".." in pure.parts or "\0" in name or (pure.parts and ":" in pure.parts[0])
    if not escapes:
        path = folder / pure
        try:
            escapes = not path.resolve().is_relative_to(folder.resolve())
        except (RuntimeError, OSError):  # a link that leads to itself: Python 3.11 raises RuntimeError
            escapes = True
    if escapes:
        raise UnsafeContent(
            f"{where} names the path {name!r}, which leaves the folder {folder}",
            "a relative path inside the folder",
            "Copy the file into the folder and name it from there.",
            path=name,
        )
    return path


def _is_impossible(name: str) -> bool:
    """Whether no file can have this name: the system would refuse to look for it."""
    try:
        encoded = name.replace("\\", "/").encode()
    except UnicodeEncodeError:
        return True
    return len(encoded) > LONGEST_PATH or any(len(part) > LONGEST_NAME for part in encoded.split(b"/"))
