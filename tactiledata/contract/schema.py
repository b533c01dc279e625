"""Documents checked against the JSON Schemas in ``schemas/``; a fault is reported with its path in the document."""

from __future__ import annotations

import difflib
import json
import re
from collections.abc import Mapping
from contextlib import suppress
from functools import cache
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

import jsonschema
import yaml

from tactiledata.contract.lfs_pointer import refuse_lfs_pointer
from tactiledata.contract.near_path import near_path
from tactiledata.contract.wording import counted, listed
from tactiledata.errors import MissingFile, SchemaError

DOCUMENT_ENDINGS = (".json", ".yaml", ".yml")
"""What names of documents end in; a document of another name is read as well."""
MAX_DOCUMENT_BYTES = 64 * 2**20
"""Largest document that is parsed; YAML from strangers must not exhaust the memory."""

MAX_DEPTH = 100
"""Collections inside one another that a document may have; libyaml overruns its stack at some ten thousand."""

MAX_VALUES = 2**25
"""Values that a document may stand for, aliases written out: a few lines of aliases of aliases can mean billions."""

LARGEST_NUMBER = 1e300
"""In a document; what is no number or infinite is beyond it, too."""

PAGES = {
    "calibration": "docs/calibration.md",
    "columns": "docs/diagnose-table.md",
    "diagnosis": "docs/diagnose-table.md",
    "effect": "docs/effects.md",
    "export": "docs/export.md",
    "flags": "docs/splits.md",
    "log": "docs/formats-folder.md",
    "mapping": "docs/formats-mcap.md",
    "recipe": "docs/models.md",
    "scenario": "docs/rig.md",
    "split": "docs/splits.md",
    "store": "docs/store.md",
}
"""The page that explains the documents of each schema, with an example."""


def shipped_folder(name: str) -> Traversable:
    """The folder ``schemas``, ``recipes`` or ``docs``: in the installed package, or beside it in a source checkout."""
    inside = resources.files("tactiledata") / name
    return inside if inside.is_dir() else Path(__file__).resolve().parents[2] / name


@cache
def load_schema(name: str) -> dict[str, Any]:
    """The JSON Schema ``schemas/<name>.json``."""
    return json.loads((shipped_folder("schemas") / f"{name}.json").read_text(encoding="utf-8"))


def check_document(document: Any, schema: str, where: str) -> None:
    """Refuse a document that does not fit ``schemas/<schema>.json``.

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
    _refuse_other_kind(document, schema, where)
    told = [(f"at {_path(fault)}: ", *_words(fault)) for fault in faults[:5]]
    lines = [f"{place}{_short(found)}" for place, found, _ in told]
    asked = [(place if len(told) > 1 else "") + _short(expected) for place, _, expected in told if expected]
    more = f" (and {len(faults) - 5} more)" if len(faults) > 5 else ""
    raise SchemaError(
        f"{where} does not fit schema {schema!r}: " + "; ".join(lines) + more,
        "; ".join(asked),
        f"{PAGES[schema]} shows how it is written; every field is described in schemas/{schema}.json.",
        path=_path(faults[0]),
        file=where,
    )


def _refuse_other_kind(document: Any, schema: str, where: str) -> None:
    """Refuse a document of another kind as what it is: its own faults would only be that it is not this kind."""
    expected = load_schema(schema)["properties"]["format"]["const"]
    given = document.get("format") if isinstance(document, Mapping) else None
    kinds = [load_schema(name)["properties"]["format"]["const"].partition("/")[0] for name in PAGES]
    if isinstance(given, str) and (kind := given.partition("/")[0]) in kinds and kind != expected.partition("/")[0]:
        raise SchemaError(
            f"{where} is another kind of document: its format is {_short(given, 60)}",
            f"format {expected}",
            f"Name another file; {PAGES[schema]} shows how it is written.",
            path="$.format",
            file=where,
        )


def _path(fault: jsonschema.ValidationError) -> str:
    path = "$"
    for part in fault.absolute_path:
        path += f"[{part}]" if isinstance(part, int) else f".{part}"
    return path


def _words(fault: jsonschema.ValidationError) -> tuple[str, str]:
    """What a fault says, and what is expected, if that is told.

    Of a value that the schema excludes, its own ``refusal`` is said.
    """
    schema: Any = fault.schema
    asked: Any = fault.validator_value
    given: Any = fault.instance
    if fault.validator in ("not", "pattern") and isinstance(schema, Mapping) and "refusal" in schema:
        return f"{given!r} {schema['refusal']}", ""
    if fault.validator == "type" and asked == "object":
        return f"{fault.message}, which means keys with values (key: value)", ""
    if fault.validator == "additionalProperties" and asked is False:
        return _unknown_keys(given, sorted(schema.get("properties", {})))
    if fault.validator == "required":
        name = next(name for name in asked if fault.message.startswith(repr(name)))
        const = schema.get("properties", {}).get(name, {}).get("const")
        return f"the key {name!r} is missing" + (f"; write {name}: {const}" if isinstance(const, str) else ""), ""
    if fault.validator in ("minItems", "maxItems"):
        exact = schema.get("minItems") == schema.get("maxItems")
        side = "" if exact else "at least " if fault.validator == "minItems" else "at most "
        return f"the list has {counted(len(given), 'entry')}", f"{side}{asked}"
    return fault.message, ""


def _unknown_keys(given: Mapping[Any, Any], known: list[str]) -> tuple[str, str]:
    """Name the keys that a schema does not have with the nearest that it has, and all that it has."""
    unknown = [key for key in given if key not in known]
    near = [hit for key in unknown for hit in difflib.get_close_matches(str(key), known, n=1)]
    meant = f" (did you mean {' and '.join(dict.fromkeys(near))}?)" if near else ""
    return f"the key {listed([repr(key) for key in unknown], 5)} is not known{meant}", f"one of: {listed(known, 30)}"


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


# YAML 1.1, which the library speaks, takes 1e-5 for a text
_StrictLoader.add_implicit_resolver(
    "tag:yaml.org,2002:float", re.compile(r"[-+]?(\d+\.?\d*|\.\d+)[eE][-+]?\d+$"), list("-+.0123456789")
)


def parse_document(text: str, where: str) -> Any:
    """A YAML or JSON text as plain Python values.

    Raises
    ------
    SchemaError
        Neither JSON nor YAML, a key given twice, a value inside itself, or nesting beyond `MAX_DEPTH`; with the line
        where there is one.
    """
    try:
        if text.lstrip().startswith(("{", "[")):
            # JSON as JSON: YAML reads some of its escapes otherwise, and is many times slower
            with suppress(json.JSONDecodeError):
                return _parsed_json(text, where)
        _check_shape(text, where)
        return yaml.load(text, Loader=_StrictLoader)
    except (yaml.YAMLError, UnicodeEncodeError) as error:
        told = str(error).replace('in "<unicode string>", line', "at line")  # the library's name of a text without one
        raise SchemaError(
            f"{where} is not valid YAML: {_short(' '.join(told.split()))}",
            "YAML or JSON",
            "Mend the line that the message names.",
            path="$",
            file=where,
        ) from error
    except RecursionError as error:
        raise _too_deep(where) from error


def _parsed_json(text: str, where: str) -> Any:
    def once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        content = dict(pairs)
        if len(content) < len(pairs):
            names = [name for name, _ in pairs]
            twice = next(name for name in content if names.count(name) > 1)
            raise SchemaError(
                f"{where}: the key {_short(twice)!r} is given twice", "each key once", path="$", file=where
            )
        return content

    document = json.loads(text, object_pairs_hook=once)
    level: list[Any] = [document]
    for _ in range(MAX_DEPTH):
        level = [
            inner
            for value in level
            for inner in (value.values() if isinstance(value, dict) else value)
            if isinstance(inner, dict | list)
        ]
        if not level:
            return document
    raise _too_deep(where)


def _too_deep(where: str) -> SchemaError:
    return SchemaError(f"{where} is nested more than {MAX_DEPTH} levels deep", "a plain document", path="$", file=where)


def _check_shape(text: str, where: str) -> None:
    """Refuse text whose collections lie too deep or inside themselves, or that stands for more than `MAX_VALUES`.

    Events are met one by one, without recursion; aliases are counted as if they were written out, as whoever writes the
    document as JSON would do.
    """
    counts = [0]  # values inside each open collection
    anchors: list[str | None] = []
    sizes: dict[str | None, int] = {}
    for event in yaml.parse(text, Loader=_StrictLoader):
        if isinstance(event, yaml.CollectionStartEvent):
            counts.append(1)
            anchors.append(event.anchor)
            if len(anchors) > MAX_DEPTH:
                raise _too_deep(where)
        elif isinstance(event, yaml.CollectionEndEvent):
            size, anchor = counts.pop(), anchors.pop()
            counts[-1] += size
            if anchor is not None:
                sizes[anchor] = size
        elif isinstance(event, yaml.AliasEvent):
            if event.anchor in anchors:
                found = f"{where} holds a value that contains itself: *{event.anchor} inside &{event.anchor}"
                raise SchemaError(found, "a plain document", path="$", file=where)
            counts[-1] += sizes.get(event.anchor, 1)
        elif isinstance(event, yaml.ScalarEvent):
            counts[-1] += 1
        if counts[-1] > MAX_VALUES:
            raise SchemaError(
                f"{where} stands for more than {MAX_VALUES} values", "a plain document", path="$", file=where
            )


def _check_numbers(document: Any, where: str, path: str = "$") -> None:
    """Numbers that can be computed with."""
    if isinstance(document, Mapping):
        for key, value in document.items():
            _check_numbers(value, where, f"{path}.{key}")
    elif isinstance(document, list):
        for place, value in enumerate(document):
            _check_numbers(value, where, f"{path}[{place}]")
    elif isinstance(document, int | float) and not -LARGEST_NUMBER < document < LARGEST_NUMBER:
        raise SchemaError(
            f"{where} holds {_short(repr(document), 40)} at {path}, no number a machine can keep",
            f"numbers within {LARGEST_NUMBER:g}",
            path=path,
            file=where,
        )


def read_document(path: Path, schema: str | None = None) -> Any:
    """The document in a YAML or JSON file, checked against a schema where one is named."""
    if not path.exists():
        raise MissingFile(
            f"{path} does not exist", "a YAML or JSON file", near_path(path, DOCUMENT_ENDINGS), path=str(path)
        )
    if not path.is_file():
        raise SchemaError(f"{path} is no file", "a YAML or JSON file", "Name another.", file=str(path))
    size = path.stat().st_size
    if size > MAX_DOCUMENT_BYTES:
        raise SchemaError(
            f"{path} has {size} bytes", f"a document of at most {MAX_DOCUMENT_BYTES} bytes", path="$", file=str(path)
        )
    try:
        refuse_lfs_pointer(path)
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise SchemaError(
            f"{path} is not UTF-8 text (byte {error.start})", "a text file", path="$", file=str(path)
        ) from error
    if schema is not None and not text.strip():
        raise SchemaError(f"{path} is empty", f"a document of the kind {schema}", "Write it anew.", file=str(path))
    document = parse_document(text, str(path))
    _check_numbers(document, str(path))
    if schema is not None:
        check_document(document, schema, str(path))
    return document
