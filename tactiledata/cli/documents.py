"""Documents that a user gives to a command: a document that does not fit its schema is wrong usage."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from tactiledata.errors import MissingFile, SchemaError, UsageError


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
