"""The label of a planted store, sealed outside of the copy: what was planted, its commitment, and the score."""

from __future__ import annotations

import secrets
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from tactiledata.contract.atomic import write_json_atomic
from tactiledata.contract.provenance import file_digest
from tactiledata.errors import MissingFile, StoreError, UsageError
from tactiledata.prove.plant.effects import ANY, NOTHING, PLANTS, find_plant
from tactiledata.prove.plant.planting import Planting
from tactiledata.prove.seal.folder import read_json
from tactiledata.prove.seal.frozen import frozen_tool
from tactiledata.prove.seal.merkle import commitment, new_salt
from tactiledata.store.read.reader import Store

FORMAT = "tactiledata-planted/1"

MOST = 1e3
"""Sizes below it can be planted, in the effect's unit."""


def drawn_planting(effect: str, size: float | None, seed: int | None = None) -> Planting:
    """Return what is planted; what is not stated is drawn from the system's random numbers.

    Parameters
    ----------
    effect : str
        Name of an effect, ``nothing``, or ``any`` for one of these by chance.
    size : float, optional
        Size in the effect's unit; drawn where ``None``.
    seed : int, optional
        Seed of the draws; drawn where ``None``, so that nobody knows it.

    Raises
    ------
    UsageError
        There is no such effect, or the size is not positive.
    """
    seed = secrets.randbits(63) if seed is None else seed
    chance = np.random.default_rng([seed, 1])
    if effect == ANY:
        effect = str(chance.choice([*PLANTS, NOTHING]))
        size = None
    if effect == NOTHING:
        return Planting(NOTHING, 0.0, seed)
    plant = find_plant(effect)
    if size is not None and not 0.0 < size < MOST:
        raise UsageError(
            f"a size of {size:g} {plant.unit}", f"more than 0 and less than {MOST:g}", f"For example {plant.low:g}."
        )
    return Planting(effect, plant.drawn(chance) if size is None else size, seed)


def seal_files(copy: Path) -> tuple[Path, Path]:
    """Return the files of a planted copy, beside it: its seal, which may be seen, and its label, which may not."""
    return copy.with_name(f"{copy.name}.seal.json"), copy.with_name(f"{copy.name}.label.json")


def write_label(copy: Path, planting: Planting) -> dict[str, Any]:
    """Write seal and label of what is to be planted into a copy; return the seal.

    It is written before the copy, so that a copy without a seal never exists. A seal that is there stays.

    Parameters
    ----------
    copy : Path
        Where the copy will be.
    planting : Planting
        What is planted.
    """
    seal_file, label_file = seal_files(copy)
    salt = new_salt()
    label = {"effect": planting.effect, "size": planting.size, "seed": planting.seed}
    tool = frozen_tool()
    seal = {
        "format": FORMAT,
        "commitment": commitment(salt, label),
        "tool": {key: tool[key] for key in ("version", "commit", "is_changed", "digest")},
    }
    write_json_atomic(label_file, {"format": FORMAT, "salt": salt, "label": label})
    write_json_atomic(seal_file, seal)
    return seal


def kept_planting(copy: Path) -> Planting | None:
    """Return what an interrupted call began to plant into a copy; ``None`` where none did."""
    seal_file, label_file = seal_files(copy)
    if not seal_file.is_file() or not label_file.is_file():
        return None
    label = read_json(label_file)["label"]
    return Planting(str(label["effect"]), float(label["size"]), int(label["seed"]))


def score_planting(copy: Path, diagnosis: Path) -> dict[str, Any]:
    """Return whether a diagnosis names what was planted.

    Parameters
    ----------
    copy : Path
        The planted copy; its seal and label lie beside it.
    diagnosis : Path
        ``diagnosis.json`` of the copy.

    Raises
    ------
    StoreError
        Label and seal do not fit; or the diagnosis is none, or one of another store. The label is then not opened.
    MissingFile
        There is no seal beside the copy.
    """
    seal_file, label_file = seal_files(copy)
    if not seal_file.is_file() or not label_file.is_file():
        missing = label_file if seal_file.is_file() else seal_file
        raise MissingFile(
            f"there is no {missing}",
            f"a copy that `tactiledata plant STORE --into {copy}` made, with seal and label beside it",
            "Check the name of the copy, or put seal and label back beside it.",
        )
    document = read_json(diagnosis)
    naming = _naming_of(document, diagnosis)
    _need_diagnosis_of(copy, document, diagnosis)
    seal, kept = read_json(seal_file), read_json(label_file)
    try:
        fits = commitment(kept["salt"], kept["label"]) == seal["commitment"]
    except (KeyError, TypeError, ValueError):
        fits = False
    if not fits:
        raise StoreError(
            f"{label_file} does not fit {seal_file}", "the label that was sealed", "One of the two was changed."
        )
    return _score(kept["label"], naming, document, file_digest(diagnosis))


def _naming_of(document: Any, diagnosis: Path) -> Mapping[str, Any]:
    """Return what a diagnosis names; refuse a document that is none, or in which a name is no text."""
    try:
        naming = document["naming"]
        ties = [tie["name"] for tie in naming.get("ties", [])]
        shown = [one["effect"] for what in ("zeros", "readings") for one in document.get(what, [])]
        texts = [naming["verdict"], *naming["names"], *ties, *shown]
    except (KeyError, TypeError, AttributeError) as error:
        raise StoreError(
            f"{diagnosis} holds no naming that can be read", "the diagnosis.json of a store", "Diagnose the copy."
        ) from error
    for text in texts:
        if not isinstance(text, str):
            raise StoreError(
                f"{diagnosis} has {text!r} in place of a name",
                "the diagnosis.json of a store",
                "Diagnose the copy.",
            )
    return dict(naming)


def _need_diagnosis_of(copy: Path, document: Mapping[str, Any], diagnosis: Path) -> None:
    """Refuse the diagnosis of another store than the copy."""
    store = Store.open(copy).digest
    provenance = document.get("provenance")
    inputs = provenance.get("inputs") if isinstance(provenance, Mapping) else None
    told = inputs.get("store") if isinstance(inputs, Mapping) else None
    if told != store:
        of_what = f"of a store with the digest {told[:12]}…" if isinstance(told, str) else "of no store that it names"
        raise StoreError(
            f"{diagnosis} is {of_what}",
            f"a diagnosis of {copy}, whose digest is {store[:12]}…",
            f"Diagnose the copy: `tactiledata diagnose {copy} --out DIR`. The label was not opened.",
        )


def _score(
    label: Mapping[str, Any], naming: Mapping[str, Any], document: Mapping[str, Any], sha: str
) -> dict[str, Any]:
    """Return what was planted, what was said of it, and in one word whether that is right."""
    effect = str(label["effect"])
    wanted = set() if effect == NOTHING else set(find_plant(effect).named)
    names = list(naming["names"])
    ties = [tie["name"] for tie in naming.get("ties", [])] if names else []
    shown = [one for what in ("zeros", "readings") for one in document.get(what, [])]
    zeros = [one["effect"] for one in shown if one.get("matters", True)]
    if not wanted:
        outcome = "false alarm" if names else "nothing named"
    elif wanted & {*names, *zeros}:
        outcome = "named"
    elif wanted & set(ties):
        outcome = "in the set"
    else:
        outcome = "wrong" if names else "missed"
    return {
        "planted": effect,
        "size": label["size"],
        "unit": "" if effect == NOTHING else find_plant(effect).unit,
        "verdict": naming["verdict"],
        "names": names,
        "ties": ties,
        "zeros": zeros,
        "outcome": outcome,
        "diagnosis_sha256": sha,
    }
