"""The folder of a proof: which files it has, and how each of them is written and read.

::

    proof.json           what was asked: configurations, counts of each kind, seed
    sealed/draws/        cases as they are drawn, before they have a name
    sealed/labels.json   labels and salts of all cases, by name
    cases/NAME.npz       readings of a case: all that the diagnosis sees
    seal.json            commitments, their root, digests of the cases, the frozen tool; written before any answer
    attempts/NAME-1.json every start of a diagnosis
    answers/NAME-1.json  every answer
    score.json           what it comes to; report.html, the same for people
"""

from __future__ import annotations

import io
import json
import os
import re
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tactiledata.contract.atomic import write_atomic, write_json_atomic
from tactiledata.contract.provenance import bytes_digest, json_bytes
from tactiledata.contract.sealed import fits_seal, sealed_json
from tactiledata.errors import MissingFile, StoreError, UnsafeContent

FORMAT = "tactiledata-proof/1"
SAME_TIME = 1_000_000_000
"""Time, s since the epoch, that all case files are given: when a file was written must not tell what is in it."""
LARGEST = 64 * 1024 * 1024
"""Largest size, bytes, of a file that is read."""
_NAME = re.compile(r"[0-9a-f]{16}")
MOST_LOGS = 64
"""Largest number of logs of a case."""
MOST_ROWS = 10_000_000
"""Largest number of readings of a log."""


@dataclass(frozen=True)
class ProofFolder:
    """A folder with a proof in it.

    Parameters
    ----------
    path : Path
        The folder.
    is_published : bool
        Whether it was unpacked from a published archive, which holds no readings.
    """

    path: Path
    is_published: bool = False

    @property
    def proof(self) -> Path:
        """What was asked."""
        return self.path / "proof.json"

    @property
    def labels(self) -> Path:
        """Labels and salts."""
        return self.path / "sealed" / "labels.json"

    @property
    def seal(self) -> Path:
        """Commitments, digests and the frozen tool."""
        return self.path / "seal.json"

    @property
    def score(self) -> Path:
        """The file of the score."""
        return self.path / "score.json"

    @property
    def page(self) -> Path:
        """The page for people."""
        return self.path / "report.html"

    def draw(self, number: int) -> Path:
        """Return the file of a drawn case without its readings."""
        return self.path / "sealed" / "draws" / f"{number:05d}.json"

    def drawn_readings(self, number: int) -> Path:
        """Return the file of the readings of a drawn case."""
        return self.path / "sealed" / "draws" / f"{number:05d}.npz"

    def case(self, name: str) -> Path:
        """Return the file of a case under its random name."""
        return self.path / "cases" / f"{checked_name(name)}.npz"

    def attempt(self, name: str, number: int) -> Path:
        """Return the file that says when a diagnosis was begun."""
        return self.path / "attempts" / f"{checked_name(name)}-{number}.json"

    def answer(self, name: str, number: int) -> Path:
        """Return the file of an answer."""
        return self.path / "answers" / f"{checked_name(name)}-{number}.json"

    def attempts_of(self, name: str) -> list[int]:
        """Return the numbers of the attempts at a case, in order."""
        return _numbers_of(self.path / "attempts", checked_name(name))

    def answers_of(self, name: str) -> list[int]:
        """Return the numbers of the answers to a case, in order; the last one counts."""
        return _numbers_of(self.path / "answers", checked_name(name))


def last_answer(folder: ProofFolder, name: str) -> dict[str, Any] | None:
    """Return the document of the last answer to a case, which is the one that counts; ``None`` without an answer."""
    numbers = folder.answers_of(name)
    return read_sealed(folder.answer(name, numbers[-1]))[0] if numbers else None


def checked_name(name: str) -> str:
    """Return the name of a case; refuse one that could lead out of the folder.

    Raises
    ------
    UnsafeContent
        It is no name that a seal gives.
    """
    if not _NAME.fullmatch(name):
        raise UnsafeContent(f"a case called {name!r}", "16 hexadecimal digits", "This folder is none of ours.")
    return name


def _numbers_of(folder: Path, name: str) -> list[int]:
    """Return the numbers in the names of a case's files."""
    ends = (path.stem.rpartition("-")[2] for path in folder.glob(f"{name}-*.json"))
    return sorted(int(end) for end in ends if end.isdigit())


def read_json(path: Path, limit: int = LARGEST) -> Any:
    """Return the document in a file of a proof.

    Parameters
    ----------
    path : Path
        The file.
    limit : int
        Largest size, bytes.

    Raises
    ------
    MissingFile
        There is no such file.
    StoreError
        The file is too large, no JSON, or has numbers or letters that no JSON can have.
    """
    try:
        if path.stat().st_size > limit:
            raise StoreError(f"{path} has {path.stat().st_size} bytes", f"at most {limit}", "It is none of ours.")
        document = json.loads(path.read_bytes())
        json_bytes(document)  # the package reads NaN, Infinity, 1e999 and halves of letters, none of which has a digest
        return document
    except FileNotFoundError as error:
        raise MissingFile(f"{path} is missing", "a folder that `tactiledata prove --out` made") from error
    except (ValueError, RecursionError) as error:
        raise StoreError(f"{path} is no JSON ({error})", "a file of a proof", "Restore it from a copy.") from error


def write_sealed(path: Path, document: Mapping[str, Any]) -> None:
    """Write a document with the digest of its own bytes, whole or not at all."""
    write_atomic(path, sealed_json(document))


def read_sealed(path: Path) -> tuple[dict[str, Any], bool]:
    """Return a document, and whether its bytes are those that were sealed."""
    document = read_json(path)
    if not isinstance(document, dict):
        raise StoreError(f"{path} holds no JSON object", "a file of a proof", "Restore it from a copy.")
    return document, fits_seal(path.read_bytes())


def readings_bytes(logs: Sequence[tuple[np.ndarray, np.ndarray]]) -> bytes:
    """Return the bytes of a case file: times (n,), ns, and readings (n, 6) of each log; equal readings, equal bytes."""
    arrays = {}
    for number, (t_ns, values) in enumerate(logs):
        arrays[f"t_ns_{number}"] = np.asarray(t_ns, dtype=np.int64)
        arrays[f"values_{number}"] = np.asarray(values, dtype=np.float64)
    content = io.BytesIO()
    # not compressed: a size that depends on the values would tell of them
    np.savez(content, **arrays)  # type: ignore[arg-type]
    return content.getvalue()


def read_readings(path: Path) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return times (n,), ns, and readings (n, 6), N and N m, of each log of a case file.

    Raises
    ------
    MissingFile
        There is no such file.
    StoreError
        The file is no case of a proof.
    """
    try:
        if path.stat().st_size > LARGEST:
            raise StoreError(f"{path} has {path.stat().st_size} bytes", f"at most {LARGEST}", "It is none of ours.")
        with np.load(io.BytesIO(path.read_bytes()), allow_pickle=False) as kept:
            found: list[tuple[np.ndarray, np.ndarray]] = []
            while f"t_ns_{len(found)}" in kept and len(found) < MOST_LOGS:
                t_ns, values = kept[f"t_ns_{len(found)}"], kept[f"values_{len(found)}"]
                if values.shape != (len(t_ns), 6) or len(t_ns) > MOST_ROWS or t_ns.dtype != np.int64:
                    raise ValueError(f"readings of shape {values.shape} at {len(t_ns)} times")
                found.append((t_ns, values.astype(float)))
    except FileNotFoundError as error:
        raise MissingFile(f"{path} is missing", "a case of a proof") from error
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
        raise StoreError(f"{path} cannot be read ({error})", "a case of a proof", "Restore it from a copy.") from error
    if not found:
        raise StoreError(f"{path} holds no readings", "a case of a proof", "Restore it from a copy.")
    return found


def write_case(path: Path, content: bytes) -> str:
    """Write a case file, whole or not at all, with the same time stamps as all others; return its SHA-256."""
    write_atomic(path, content)
    os.utime(path, (SAME_TIME, SAME_TIME))
    return bytes_digest(content)


def write_proof(folder: ProofFolder, document: Mapping[str, Any]) -> None:
    """Write what was asked."""
    write_json_atomic(folder.proof, dict(document))
