"""The tool that is put to the proof, frozen: its thresholds as numbers, and digests of the program."""

from __future__ import annotations

import hashlib
import subprocess
from collections.abc import Mapping
from dataclasses import fields
from functools import cache
from pathlib import Path
from typing import Any

import tactiledata
from tactiledata.contract.program import statements
from tactiledata.contract.provenance import digest_of

ROOMS = ("calibrate", "diagnose", "effects", "gel", "indenters", "ingest", "nuisance", "replay")
"""Packages whose program decides an answer."""


def frozen_tool() -> dict[str, Any]:
    """Return the tool as it is now: version, commit, digests of its program and all numbers that decide a claim.

    Fields: ``version``; ``commit``, empty outside of a checkout; ``is_changed``, whether the checkout differs from the
    commit; ``program``, a digest for each package; ``numbers``, by group and name; ``digest`` of program and numbers.
    """
    numbers = deciding_numbers()
    programs = {room: program_digest(room) for room in ROOMS}
    commit, is_changed = _commit()
    return {
        "version": tactiledata.__version__,
        "commit": commit,
        "is_changed": is_changed,
        "program": programs,
        "numbers": numbers,
        "digest": digest_of({"program": programs, "numbers": numbers}),
    }


def tool_digest(tool: Mapping[str, Any]) -> str:
    """Return the digest that a frozen tool's program and numbers have, whatever it states itself."""
    return digest_of({"program": tool.get("program"), "numbers": tool.get("numbers")})


def deciding_numbers() -> dict[str, dict[str, float]]:
    """Return every number that decides a claim: thresholds, sizes of the simulation's errors, ranges of effects."""
    from tactiledata.diagnose.naming.options import NamingOptions
    from tactiledata.diagnose.touches.own_errors import OwnErrors
    from tactiledata.effects import EFFECTS

    options = NamingOptions()
    ranges = {}
    for name in EFFECTS:
        for parameter in EFFECTS[name]().parameters:
            for what in ("bounds", "plausible"):
                low, high = getattr(parameter, what)
                ranges[f"{name}.{parameter.name} {what} low"] = float(low)
                ranges[f"{name}.{parameter.name} {what} high"] = float(high)
    needed = {**options.thresholds.usual_claims, **options.thresholds.claims}
    claims = {f"claim of {name}": float(value) for name, value in needed.items()}
    return {
        "thresholds": {**_numbers(options.thresholds), **claims},
        "errors": _numbers(options.errors),
        "own errors": _numbers(OwnErrors()),
        "options": _numbers(options),
        "ranges": ranges,
    }


def changed_numbers(frozen: Mapping[str, Any], now: Mapping[str, Any]) -> list[str]:
    """Return in words which numbers differ between two frozen tools, each with both values.

    Parameters
    ----------
    frozen, now : dict
        Documents of `frozen_tool`.
    """
    old, new = frozen.get("numbers", {}), now.get("numbers", {})
    words = []
    for group in sorted({*old, *new}):
        before, after = old.get(group, {}), new.get(group, {})
        for name in sorted({*before, *after}):
            if before.get(name) != after.get(name):
                words.append(f"{group}: {name} is {after.get(name)}, was {before.get(name)} when the proof was sealed")
    return words


@cache
def program_digest(room: str) -> str:
    """Return the digest (hex) of the statements of a package of this toolkit; comments and docstrings do not count."""
    folder = Path(tactiledata.__file__).parent / room
    whole = hashlib.sha256()
    for source in sorted(folder.rglob("*.py")):
        whole.update(source.relative_to(folder).as_posix().encode() + statements(source.read_text("utf-8")))
    return whole.hexdigest()


def _numbers(record: Any) -> dict[str, float]:
    """Return the fields of a record that are numbers."""
    values = {field.name: getattr(record, field.name) for field in fields(record)}
    return {name: float(value) for name, value in values.items() if isinstance(value, int | float)}


def _commit() -> tuple[str, bool]:
    """Return the commit of the checkout that holds this package, and whether it was changed since; empty for none."""
    folder = Path(tactiledata.__file__).resolve().parent

    def git(*words: str) -> str:
        done = subprocess.run(["git", "-C", str(folder), *words], capture_output=True, text=True, check=True)
        return done.stdout.strip()

    try:
        return git("rev-parse", "HEAD"), bool(git("status", "--porcelain", "--", str(folder)))
    except (OSError, subprocess.CalledProcessError):
        return "", False
