"""What a program does, as bytes for a digest: words about it are no part of it, nor is the version of Python."""

from __future__ import annotations

import ast
from collections.abc import Iterable
from itertools import groupby
from typing import Any

SPELLING = ("kind", "type_comment")
"""Fields of syntax trees that say how a program is written, not what it does."""


def statements(source: str) -> bytes:
    """Return the syntax tree of a program as bytes; comments, docstrings and blank space are no part of it.

    A cache whose keys hold a digest of this keeps its results when only words in the program have changed.
    Every version of Python that can read the program gives the same bytes. `ast.dump` does not: it lists empty fields,
    of which newer versions have more.

    Parameters
    ----------
    source : str
        A Python module.

    Raises
    ------
    SyntaxError
        The source is no Python module.
    """
    return _text(ast.parse(source)).encode()


def _text(part: Any) -> str:
    """Return a part of a syntax tree as text: a node by its class and its fields that are not empty, by name."""
    if isinstance(part, list):
        return f"[{', '.join(map(_text, part))}]"
    if not isinstance(part, ast.AST):
        # which characters `repr` shows as they are depends on the version of Unicode
        return ascii(part)
    fields = (f"{name}={_text(value)}" for name, value in sorted(_fields(part)) if value is not None and value != [])
    return f"{type(part).__name__}({', '.join(fields)})"


def _fields(node: ast.AST) -> Iterable[tuple[str, Any]]:
    """Yield the fields of a node that say what it does."""
    for name, value in ast.iter_fields(node):
        if name == "body" and isinstance(value, list):
            # a text that stands alone as a statement documents what is around or above it
            yield name, [statement for statement in value if not _is_text(statement)]
        elif name == "values" and isinstance(node, ast.JoinedStr):
            yield name, _joined(value)
        elif name not in SPELLING:
            yield name, value


def _joined(parts: list[ast.expr]) -> list[ast.expr]:
    """Return the parts of an f-string, texts that follow one another as one: versions part them differently."""
    joined: list[ast.expr] = []
    for is_text, group in groupby(parts, lambda part: isinstance(part, ast.Constant)):
        if is_text:
            text = "".join(part.value for part in group)  # type: ignore[attr-defined]
            joined += [ast.Constant(text)] if text else []
        else:
            joined += group
    return joined


def _is_text(statement: ast.stmt) -> bool:
    """Whether a statement is nothing but a text."""
    return (
        isinstance(statement, ast.Expr)
        and isinstance(statement.value, ast.Constant)
        and isinstance(statement.value.value, str)
    )
