"""What made a file: code version, recipe and inputs, without clock times, so that equal work gives equal bytes."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from tactiledata import __version__


def json_bytes(value: Any) -> bytes:
    """A value as canonical JSON: sorted keys, no spaces, UTF-8; equal values give equal bytes."""
    return json.dumps(value, sort_keys=True, separators=(",", ":"), ensure_ascii=False, allow_nan=False).encode()


def bytes_digest(content: bytes) -> str:
    """SHA-256 (hex) of bytes."""
    return hashlib.sha256(content).hexdigest()


def digest_of(value: Any) -> str:
    """SHA-256 (hex) of a value's canonical JSON."""
    return bytes_digest(json_bytes(value))


def file_digest(path: Path) -> str:
    """SHA-256 (hex) of a file's bytes."""
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def files_digest(root: Path, files: Iterable[Path]) -> str:
    """SHA-256 (hex) over the names relative to ``root`` and the contents of several files, in sorted order."""
    total = hashlib.sha256()
    names = {Path(os.path.relpath(path, root)).as_posix(): path for path in files}
    for name, path in sorted(names.items()):
        total.update(name.encode() + b"\0" + file_digest(path).encode() + b"\n")
    return total.hexdigest()


def provenance(step: str, inputs: Mapping[str, str], settings: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """A record of what made an output.

    Parameters
    ----------
    step : str
        The command or function.
    inputs : mapping
        Name of each input to its SHA-256.
    settings : mapping, optional
        Options that shape the output.
    """
    chosen = dict(settings or {})
    return {
        "tool": "tactiledata",
        "version": __version__,
        "step": step,
        "inputs": dict(sorted(inputs.items())),
        "settings": chosen,
        "settings_sha256": digest_of(chosen),
    }
