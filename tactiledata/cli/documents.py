"""Documents that a user gives to a command, and results that it finds in its way: what fits, and of which store it is.

A document that does not fit its schema is wrong usage.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any

from tactiledata.contract.wording import counted
from tactiledata.errors import MissingFile, SchemaError, UsageError

if TYPE_CHECKING:
    from tactiledata.store.read.reader import Store

PAGE_FACTS = re.compile(
    r"The store (?:is )?(?P<name>[^<]*?)(?:\.</p>| holds ).*store digest (?P<digest>[0-9a-f]{64})", re.DOTALL
)
"""What the page of a replay, or that of a store, says of its store."""


@contextmanager
def wrong_document_is_wrong_usage(written_by: str = "") -> Iterator[None]:
    """Turn a `SchemaError` into a `UsageError`, whose exit code is 2, and say of a missing file what writes one.

    Parameters
    ----------
    written_by : str
        A sentence on the command that writes such a document; empty where none does.
    """
    try:
        yield
    except MissingFile as error:
        remedy = " ".join(filter(None, [error.remedy, written_by]))
        raise MissingFile(error.found, error.expected, remedy, **error.facts) from error
    except SchemaError as error:
        raise UsageError(error.found, error.expected, error.remedy, **error.facts) from error


def calibration_document(path: Path) -> Any:
    """Return the content of a calibration.json (schemas/calibration.json)."""
    from tactiledata.contract.schema import read_document

    with wrong_document_is_wrong_usage("`tactiledata calibrate STORE` writes one."):
        return read_document(path, "calibration")


def effects_document(path: Path) -> Any:
    """Return the content of an effects.json (schemas/effect.json)."""
    from tactiledata.contract.schema import read_document

    with wrong_document_is_wrong_usage(
        "`tactiledata diagnose STORE --out FOLDER` writes one where it names an effect."
    ):
        return read_document(path, "effect")


def mapping_document(path: Path | None) -> Any:
    """Return the mapping in a file (schemas/mapping.json); ``None`` where no file is named."""
    from tactiledata.contract.schema import read_document

    if path is None:
        return None
    with wrong_document_is_wrong_usage(
        "`tactiledata inspect RECORDING --suggest-mapping > mapping.yaml` makes one to begin with."
    ):
        return read_document(path, "mapping")


def made_of_another_store(document: Mapping[str, Any], store: Store) -> str:
    """Say that a result was made from another store; empty where it was made from this one, or does not tell.

    A store that got recordings since is the same one: it holds some of the trajectories that the result rests on.

    Parameters
    ----------
    document : dict
        A calibration, effects, or a diagnosis.
    store : Store
        The store that a command works on.
    """
    digest = document.get("provenance", {}).get("inputs", {}).get("store")
    used = _trajectories_of(document)
    if not digest or not used or digest == store.digest:
        return ""
    if used & set(store.trajectories(["uid"])["uid"].to_pylist()):
        return ""
    return f"it was made from another store: this one holds none of its {counted(len(used), 'trajectory')}"


def _trajectories_of(document: Mapping[str, Any]) -> set[str]:
    """Return the uids of the trajectories that a result rests on; empty where it does not tell."""
    named = document.get("trajectories", [])
    listed = [*named.get("fitted", ()), *named.get("held_out", ())] if isinstance(named, Mapping) else named
    return {*listed, *document.get("offsets", {})}


def refuse_result_of_another_store(path: Path, store: Store, replace: bool) -> None:
    """Refuse to replace a calibration, a diagnosis, or the page of a replay or a store, made from another store.

    Parameters
    ----------
    path : Path
        Where the result will be written; nothing need be there.
    store : Store
        The store that it will be of.
    replace : bool
        Whether it may be replaced all the same.

    Raises
    ------
    UsageError
        A result of another store is there.
    """
    if replace or not path.is_file():
        return
    text = path.read_text(encoding="utf-8", errors="replace")
    why = ""
    if path.suffix == ".json":
        try:
            document = json.loads(text)
        except (ValueError, RecursionError):
            return
        why = made_of_another_store(document, store) if isinstance(document, dict) else ""
    elif (facts := PAGE_FACTS.search(text)) and facts["digest"] != store.digest:
        is_other = facts["name"] != PurePosixPath(store.location).name
        why = f"it was made from another store, {facts['name']}" if is_other else ""
    if why:
        raise UsageError(
            f"{path} would be replaced, and {why}",
            "a result of the same store, or nothing",
            "Name another place with --out, or replace it with --replace.",
        )
