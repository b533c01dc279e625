"""Files of PyTorch tensors from strangers: read without running code, refused in words of our own.

PyTorch's own messages advise to load a refused file without the check that refused it, so none of them is passed on.
"""

from __future__ import annotations

import pickle
import pickletools
import re
import struct
import warnings
import zipfile
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from tactiledata.errors import TactileDataError

MAX_SCANNED = 2**20
"""Bytes of a refused file that are searched for the name of code."""

FETCH_AGAIN = "Remove it, and fetch or train the weights again."
FAULTS = (
    ArithmeticError,
    AssertionError,
    AttributeError,
    EOFError,
    ImportError,
    LookupError,
    MemoryError,
    OSError,
    RuntimeError,
    TypeError,
    ValueError,
    pickle.UnpicklingError,
    struct.error,
    zipfile.BadZipFile,
)
"""What PyTorch raises on a file that a stranger wrote."""

_CODE = re.compile(r"GLOBAL ([A-Za-z_][\w.]*)")
_HARMLESS = ("torch", "collections")


def read_tensors(path: Path, refused: str, kind: type[TactileDataError]) -> Any:
    """The content of a file of tensors, on the CPU; only tensors and plain values are read, no code is run.

    Parameters
    ----------
    path : Path
    refused : str
        What an error says of the file, for example ``"cannot be read as a checkpoint"``.
    kind : type
        The error's class.

    Raises
    ------
    TactileDataError
        Of that class, also where a part does not fit its checksum; what PyTorch said is not shown with it.
    """
    import torch

    part = _damaged_part(path)
    if part:
        # PyTorch does not look at the checksums that it writes: a flipped bit would be another weight
        raise kind(
            f"{path} {refused}: its part {part} does not fit its CRC-32",
            "the file that was written",
            FETCH_AGAIN,
            path=str(path),
        )
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return torch.load(path, map_location="cpu", weights_only=True)
    except FAULTS as error:
        why, remedy = refusal(path, error)
        raise kind(
            f"{path} {refused}: {why}",
            "a file that PyTorch wrote, with tensors and plain values alone",
            remedy,
            path=str(path),
        ) from None


def _damaged_part(path: Path) -> str:
    """Name of the first part of an archive that does not fit its CRC-32; empty where there is none to be found."""
    try:
        if not zipfile.is_zipfile(path):
            return ""
        with zipfile.ZipFile(path) as archive:
            return archive.testzip() or ""
    except (*FAULTS, zlib.error):
        return ""  # what cannot be unpacked is refused in words by `read_tensors`


def refusal(path: Path, error: Exception) -> tuple[str, str]:
    """What is wrong with a file that PyTorch refused to read, and what to do; PyTorch's text is not repeated."""
    if isinstance(error, OSError) and error.strerror:
        return f"the system refused ({error.strerror})", "Check the path and its permissions."
    try:
        content, is_archive = _begin_of(path), zipfile.is_zipfile(path)
    except OSError as fault:
        return f"the system refused ({fault.strerror})", "Check the path and its permissions."
    code = _code_in(error, b"" if is_archive else content)
    if code:
        return (
            f"it names {code}, which is code and no tensor; the code was not run",
            "A file that holds code can harm your machine. Do not open it with another program; remove it, and fetch "
            "or train the weights again.",
        )
    if not content:
        return "it is empty (0 bytes)", FETCH_AGAIN
    if not is_archive:
        return "it is torn, or PyTorch did not write it", FETCH_AGAIN
    return "it is damaged, or holds more than tensors", FETCH_AGAIN


def _begin_of(path: Path) -> bytes:
    with path.open("rb") as stream:
        return stream.read(MAX_SCANNED)


def _code_in(error: Exception, content: bytes) -> str:
    """The name of the code that a file would run: as PyTorch's error says it, else from the file itself."""
    said = _CODE.search(str(error)) if isinstance(error, pickle.UnpicklingError) else None
    if said is not None:
        return said[1]
    names = (name for name in _names_in(content) if not name.startswith(_HARMLESS))
    return next((name for name in names if re.fullmatch(r"[A-Za-z_][\w.]{0,200}", name)), "")


def _names_in(content: bytes) -> Iterator[str]:
    """Dotted names that a pickle looks up, as far as it can be taken apart; nothing is looked up."""
    texts = ["", ""]
    try:
        for opcode, argument, _ in pickletools.genops(content):
            if opcode.name in ("GLOBAL", "INST"):
                yield str(argument).replace(" ", ".")
            elif opcode.name == "STACK_GLOBAL":
                yield ".".join(texts)
            elif isinstance(argument, str):
                texts = [texts[-1], argument]
    except (ValueError, UnicodeError, OverflowError, MemoryError):
        return
