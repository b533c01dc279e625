"""Codes of findings on a page lead to what they mean and what to do, on the same page."""

import re
from pathlib import Path

import pytest

from tactiledata.report import finding_words
from tactiledata.report.finding_words import codes_section, words_of_codes
from tactiledata.report.page import Section, render_page

PAGE = Path(__file__).resolve().parents[2] / "docs" / "findings.md"


def rendered(*sections):
    return render_page("Title", ["In [gap] a sentence before."], sections, "the end")


def test_every_code_of_the_documentation_has_words():
    """Every row of the tables of findings becomes a code, a meaning and a remedy, without marks of Markdown."""
    words = words_of_codes()
    rows = re.findall(r"^\| `([a-z0-9-]+)` \| (?:info|warning|damage) \|", PAGE.read_text(), re.MULTILINE)
    assert sorted(words) == sorted(rows)
    assert all(meaning and remedy for meaning, remedy in words.values())
    assert not [code for code, texts in words.items() if "`" in "".join(texts) or "](" in "".join(texts)]


def test_a_code_in_brackets_leads_to_its_row():
    """Codes that the page explains become links to rows that are there; other words in brackets stay as they are."""
    said = Section("Checks", [("warning", "wrench has 3 gaps [gap]"), ("", "shape [320, 240] of [nobody-knows]")])
    html = rendered(said, codes_section(["gap", "gap", "chunk-crc", "nobody-knows"]))
    assert html.count('[<a href="#word-gap">gap</a>]') == 2
    links = set(re.findall('href="#(word-[a-z-]+)"', html))
    ids = re.findall('<tr id="([a-z-]+)">', html)
    assert links <= set(ids)
    assert sorted(ids) == ["word-chunk-crc", "word-gap"]
    assert "[320, 240] of [nobody-knows]" in html


def test_without_codes_there_is_no_section(monkeypatch):
    """A page whose checks found nothing has no such section, nor has one where the documentation is not there."""
    assert codes_section([]) is None
    assert codes_section(["nobody-knows"]) is None
    assert "#word-" not in rendered(Section("Checks", [("", "nothing [gap]")]))
    monkeypatch.setattr(finding_words, "shipped_folder", lambda name: Path("nowhere"))
    words_of_codes.cache_clear()
    assert codes_section(["gap"]) is None
    words_of_codes.cache_clear()


@pytest.mark.parametrize("code", ["camera-names", "recording-twin", "begins-under-force"])
def test_words_are_those_of_the_documentation(code):
    """The meaning on a page is the documentation's own sentence."""
    meaning, _ = words_of_codes()[code]
    assert meaning.split(".")[0].replace("`", "") in PAGE.read_text().replace("`", "")
