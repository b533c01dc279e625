"""Documents checked against the JSON Schemas in ``schemas/``; a fault is reported with its path in the document."""

from __future__ import annotations

import json
from functools import cache
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

import jsonschema
import yaml

from tactiledata.errors import MissingFile, SchemaError

MAX_DOCUMENT_BYTES = 64 * 2**20
"""Largest document that is parsed; YAML from strangers must not exhaust the memory."""


def shipped_folder(name: str) -> Traversable:
    """The folder ``schemas`` or ``recipes``: inside the installed package, or beside it in a source checkout."""
    inside = resources.files("tactiledata") / name
    return inside if inside.is_dir() else Path(__file__).resolve().parents[2] / name


@cache
def load_schema(name: str) -> dict[str, Any]:
    """The JSON Schema ``schemas/<name>.json``."""
    return json.loads((shipped_folder("schemas") / f"{name}.json").read_text(encoding="utf-8"))


def check_document(document: Any, schema: str, where: str) -> None:
    """Nothing, where the document fits ``schemas/<schema>.json``.

    Parameters
    ----------
    document : object
        A parsed document.
    schema : str
        The schema's name, for example ``"log"``.
    where : str
        The file or record that the document came from, for the message.

    Raises
    ------
    SchemaError
        The first faults (at most five), each with its path inside the document.
    """
    validator = jsonschema.Draft202012Validator(load_schema(schema))
    faults = sorted(validator.iter_errors(document), key=lambda fault: [str(part) for part in fault.absolute_path])
    if not faults:
        return
    lines = [f"at {_path(fault)}: {_short(fault.message)}" for fault in faults[:5]]
    more = f" (and {len(faults) - 5} more)" if len(faults) > 5 else ""
    raise SchemaError(
        f"{where} does not fit schema {schema!r}: " + "; ".join(lines) + more,
        "",
        f"The schema with a description of every field is schemas/{schema}.json; docs/formats.md has an example.",
        path=_path(faults[0]),
        file=where,
    )


def _path(fault: jsonschema.ValidationError) -> str:
    path = "$"
    for part in fault.absolute_path:
        path += f"[{part}]" if isinstance(part, int) else f".{part}"
    return path


def _short(message: str, limit: int = 300) -> str:
    return message if len(message) <= limit else message[: limit - 1] + "…"


class _StrictLoader(yaml.CSafeLoader if hasattr(yaml, "CSafeLoader") else yaml.SafeLoader):  # type: ignore[misc]
    """YAML without object construction, that refuses a key given twice."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        seen: set[Any] = set()
        for key_node, _ in node.value:
            key = self.construct_object(key_node, deep=True)
            if isinstance(key, str | int | float | bool) and key in seen:
                raise yaml.constructor.ConstructorError(
                    None, None, f"the key {key!r} is given twice", key_node.start_mark
                )
            if isinstance(key, str | int | float | bool):
                seen.add(key)
        return super().construct_mapping(node, deep=deep)


def parse_document(text: str, where: str) -> Any:
    """A YAML or JSON text as plain Python values.

    Raises
    ------
    SchemaError
        Not YAML, a key given twice, or nesting that cannot be parsed; with the line.
    """
    try:
        return yaml.load(text, Loader=_StrictLoader)
    except yaml.YAMLError as error:
        raise SchemaError(
            f"{where} is not valid YAML: {_short(' '.join(str(error).split()))}",
            "YAML or JSON",
            "Mend the line that the message names.",
            path="$",
            file=where,
        ) from error
    except RecursionError as error:
        raise SchemaError(f"{where} is nested too deeply", "a plain document", path="$", file=where) from error


def read_document(path: Path, schema: str | None = None) -> Any:
    """The document in a YAML or JSON file, checked against a schema where one is named."""
    if not path.is_file():
        raise MissingFile(f"{path} does not exist", "a YAML or JSON file", path=str(path))
    size = path.stat().st_size
    if size > MAX_DOCUMENT_BYTES:
        raise SchemaError(
            f"{path} has {size} bytes", f"a document of at most {MAX_DOCUMENT_BYTES} bytes", path="$", file=str(path)
        )
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise SchemaError(
            f"{path} is not UTF-8 text (byte {error.start})", "a text file", path="$", file=str(path)
        ) from error
    document = parse_document(text, str(path))
    if schema is not None:
        check_document(document, schema, str(path))
    return document
