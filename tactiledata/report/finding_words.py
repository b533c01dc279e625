"""What the codes of findings mean and what to do about them, by docs/findings.md, for the page that names them."""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import cache

from tactiledata.contract.schema import shipped_folder
from tactiledata.report.page import Section

ROW = re.compile(
    r"^\| `(?P<code>[a-z0-9-]+)` \| (?:info|warning|damage) \| (?P<meaning>.+?) \| (?P<remedy>.+?) \|$", re.M
)
"""A row of a table of findings."""
LINK = re.compile(r"\[([^\]]*)\]\([^)]*\)")
"""A link, of which a page keeps the words."""


@cache
def words_of_codes() -> dict[str, tuple[str, str]]:
    """Return meaning and remedy of each code; none where the documentation was not shipped."""
    page = shipped_folder("docs") / "findings.md"
    if not page.is_file():
        return {}
    text = page.read_text(encoding="utf-8")
    return {row["code"]: (_plain(row["meaning"]), _plain(row["remedy"])) for row in ROW.finditer(text)}


def _plain(text: str) -> str:
    return LINK.sub(r"\1", text).replace("`", "")


def codes_section(codes: Iterable[str]) -> Section | None:
    """Return a section on the codes of a page, to which the codes in its sentences lead; ``None`` without any.

    Parameters
    ----------
    codes : iterable of str
        Codes of findings, in any order, also several times.
    """
    known = words_of_codes()
    rows = [(code, *known[code]) for code in sorted(set(codes)) if code in known]
    columns = ("code", "what it means", "what to do")
    return Section("What the findings mean", columns=columns, rows=rows, is_glossary=True) if rows else None
