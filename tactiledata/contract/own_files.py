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
    ".yaml": b"tool: tactiledata ",
    ".zip": b"tactiledata proof",
}
"""Bytes that files of ours hold, by the ending of their names."""
LOG, RECORDED = "log.yaml", b"tool: tactiledata rig"
"""File of a recording that is a folder, and its mark: it is that of the folder."""
CHUNK = 1 << 20
"""Bytes of a file that are looked at together."""
_HEADER = 33
"""Bytes of a PNG before the second chunk: eight of the signature, and the first chunk."""
_BEFORE_PIXELS = 512
"""Bytes at the beginning of a PNG that hold the mark where there is one."""


def is_ours(path: Path, mark: bytes | None = None) -> bool:
    """Whether a file, or a recording that is a folder, was written by this program, or holds nothing yet.

    Parameters
    ----------
    path : Path
        A file, or a folder, that exists. A pipe or a device is never ours.
    mark : bytes, optional
        What a file of ours holds, where its name does not say so.
    """
    if path.is_dir():
        return not any(path.iterdir()) or ((path / LOG).is_file() and _holds(path / LOG, RECORDED))
    # pipes and devices have no bytes either, and reading one may never end
    if not path.is_file():
        return False
    mark = mark or MARKS.get(path.suffix.lower())
    return path.stat().st_size == 0 or (mark is not None and _holds(path, mark))


def is_own_picture(path: Path) -> bool:
    """Whether a file is a PNG that this program drew: its mark stands before the pixels, and no more is read."""
    with path.open("rb") as stream:
        return path.suffix.lower() == ".png" and MARKS[".png"] in stream.read(_BEFORE_PIXELS)


def refuse_foreign(path: Path, mark: bytes | None = None) -> None:
    """Refuse to replace what this program did not write.

    Parameters
    ----------
    path : Path
        Where something will be written; nothing need be there.
    mark : bytes, optional
        What a file of ours holds, where its name does not say so.

    Raises
    ------
    UsageError
        A file or a folder of others is there, or a pipe or a device.
    """
    if path.exists() and not is_ours(path, mark):
        is_plain = path.is_file() or path.is_dir()
        raise UsageError(
            f"{path} is there and carries no mark of tactiledata: others wrote it, or an earlier version did"
            if is_plain
            else f"{path} is no file, but a pipe, a device or a socket",
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


def marked_yaml(text: str, command: str) -> bytes:
    """The bytes of a YAML file with the mark of this program, as a comment in its first line.

    Parameters
    ----------
    text : str
        The document.
    command : str
        Name of the command that writes it.
    """
    return b"# " + MARKS[".yaml"] + f"{command}\n{text}".encode()


def _holds(path: Path, mark: bytes) -> bool:
    """Whether a file holds these bytes."""
    before = b""
    with path.open("rb") as stream:
        while content := stream.read(CHUNK):
            if mark in before + content:
                return True
            before = (before + content)[-len(mark) :]
    return False
