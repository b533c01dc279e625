"""What a program does, as bytes for a digest: words about it are no part of it."""

from __future__ import annotations

import ast


def statements(source: str) -> bytes:
    """Return the syntax tree of a program as bytes; comments, docstrings and blank space are no part of it.

    A cache whose keys hold a digest of this keeps its results when only words in the program have changed.

    Parameters
    ----------
    source : str
        A Python module.

    Raises
    ------
    SyntaxError
        The source is no Python module.
    """
    tree = ast.parse(source)
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(body, list):
            # a text that stands alone as a statement documents what is around or above it
            node.body = [part for part in body if not _is_text(part)]  # type: ignore[attr-defined]
    return ast.dump(tree).encode()


def _is_text(statement: ast.stmt) -> bool:
    """Whether a statement is nothing but a text."""
    return (
        isinstance(statement, ast.Expr)
        and isinstance(statement.value, ast.Constant)
        and isinstance(statement.value.value, str)
    )
