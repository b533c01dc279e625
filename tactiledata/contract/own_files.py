"""Files that this program wrote, known by a mark inside: only they may be replaced without being asked for."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

from tactiledata.contract.atomic import write_atomic
from tactiledata.errors import UsageError

MARKS = {
    ".html": b'<meta name="generator" content="tactiledata">',
    ".json": b'"tool": "tactiledata"',
    ".mcap": b"tactiledata rig",
    ".png": b"Software\0tactiledata",
    ".rrd": b"tactiledata-",
    ".xml": b'<mujoco model="touch">',
    ".yaml": b"tool: tactiledata rig",
}
"""Bytes that files of ours hold, by the ending of their names."""
LOG = "log.yaml"
"""File of a recording that is a folder: its mark is that of the folder."""
CHUNK = 1 << 20
"""Bytes of a file that are looked at together."""
_HEADER = 33
"""Bytes of a PNG before the second chunk: eight of the signature, and the first chunk."""


def is_ours(path: Path) -> bool:
    """Whether a file, or a recording that is a folder, was written by this program, or holds nothing yet.

    Parameters
    ----------
    path : Path
        A file, or a folder, that exists.
    """
    if path.is_dir():
        return not any(path.iterdir()) or ((path / LOG).is_file() and _holds(path / LOG, MARKS[".yaml"]))
    mark = MARKS.get(path.suffix.lower())
    return path.stat().st_size == 0 or (mark is not None and _holds(path, mark))


def refuse_foreign(path: Path) -> None:
    """Refuse to replace what this program did not write.

    Parameters
    ----------
    path : Path
        Where something will be written; nothing need be there.

    Raises
    ------
    UsageError
        A file or a folder of others is there.
    """
    if path.exists() and not is_ours(path):
        raise UsageError(
            f"{path} is there, and tactiledata did not write it",
            "a place where nothing is, or a file that an earlier run wrote there",
            "Move it, or name another place.",
        )


def marked_png(content: bytes) -> bytes:
    """The bytes of a PNG with the mark of this program, as a text in its second chunk.

    Parameters
    ----------
    content : bytes
        A PNG without the mark.
    """
    text = b"tEXt" + MARKS[".png"]
    chunk = struct.pack(">I", len(text) - 4) + text + struct.pack(">I", zlib.crc32(text))
    return content[:_HEADER] + chunk + content[_HEADER:]


def mark_png(path: Path) -> None:
    """Give the mark of this program to a PNG that a part of it wrote without."""
    write_atomic(path, marked_png(path.read_bytes()))


def _holds(path: Path, mark: bytes) -> bool:
    """Whether a file holds these bytes."""
    before = b""
    with path.open("rb") as stream:
        while content := stream.read(CHUNK):
            if mark in before + content:
                return True
            before = (before + content)[-len(mark) :]
    return False
