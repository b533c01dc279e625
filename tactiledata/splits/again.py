"""The command that brings a split up to date: the one that it was made with."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from typing import Any

from tactiledata.splits.options import SplitOptions

PARTED = frozenset(",;=")
"""A name that holds one of these cannot be typed after --hold-out."""


def command(location: str, name: str, options: Mapping[str, Any]) -> str:
    """Return a command as people type it. What has its default is left out, and names that cannot be typed are dots.

    Parameters
    ----------
    location : str
        The store.
    name : str
    options : dict
        ``options`` of the split's document (``schemas/split.json``).
    """
    usual = SplitOptions().document()
    chosen = [word for key, words in _typed(options).items() if options[key] != usual[key] for word in words]
    chosen += ["--with-flagged"] if options.get("with_flagged") else []
    return shlex.join(["tactiledata", "split", location, "--name", name, *chosen])


def typed_options(options: Mapping[str, Any]) -> dict[str, str]:
    """Return each option as people type it, also where it has its default.

    Parameters
    ----------
    options : dict
        ``options`` of a split's document.
    """
    flagged = "--with-flagged" if options.get("with_flagged") else "no --with-flagged"
    return {**{key: " ".join(words) for key, words in _typed(options).items()}, "with_flagged": flagged}


def _typed(options: Mapping[str, Any]) -> dict[str, tuple[str, str]]:
    """Return the name and the text of each option that has a text."""
    force = options["force"]
    return {
        "by": ("--by", ",".join(options["by"])),
        "hold_out": ("--hold-out", _held(options["hold_out"])),
        "fractions": ("--fractions", ",".join(map(repr, options["fractions"]))),
        "force": ("--force", "none" if force is None else "..".join(map(repr, force))),
        "seed": ("--seed", str(options["seed"])),
    }


def _held(hold_out: str | Mapping[str, list[str]]) -> str:
    if isinstance(hold_out, str):
        return hold_out
    return ";".join(
        f"{kind}={','.join('…' if PARTED & set(name) else name for name in names)}" for kind, names in hold_out.items()
    )
