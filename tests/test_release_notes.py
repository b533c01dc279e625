"""Fragments of changes become release notes: none is lost, and none stands twice."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

HOME = Path(__file__).resolve().parents[1]
KINDS = ("feature", "change", "fix", "doc")
FRAGMENTS = sorted((HOME / "changes").glob("[!.]*"))


def towncrier(folder, *words):
    """What towncrier prints, in a folder with a pyproject.toml."""
    words = (sys.executable, "-m", "towncrier", "build", "--dir", folder, "--version", "9.9.9", *words)
    return subprocess.run(list(map(str, words)), capture_output=True, text=True, check=True).stdout


@pytest.mark.parametrize("fragment", FRAGMENTS, ids=lambda path: path.name)
def test_a_fragment_has_a_kind_and_says_something(fragment):
    """Another kind of file would be left out of the notes without a word."""
    assert re.fullmatch(rf"[a-z0-9-]+\.({'|'.join(KINDS)})\.md", fragment.name), fragment.name
    assert fragment.read_text().strip()


@pytest.mark.slow
def test_a_release_gathers_every_fragment_once(tmp_path):
    """Each stands below the heading of its kind, below the new release, above the older ones; the fragments go."""
    for name in ("pyproject.toml", "CHANGELOG.md"):
        shutil.copy(HOME / name, tmp_path)
    (tmp_path / "changes").mkdir()
    shutil.copy(HOME / "changes" / ".release.jinja", tmp_path / "changes")
    for number, kind in enumerate(KINDS):
        (tmp_path / "changes" / f"made-{number}.{kind}.md").write_text(f"Sentence {number} of `{kind}`.\n")
    towncrier(tmp_path, "--yes")
    notes = (tmp_path / "CHANGELOG.md").read_text()
    places = [notes.index("## 9.9.9"), *(notes.index(f"Sentence {n} of `{kind}`.") for n, kind in enumerate(KINDS))]
    assert places == sorted(places)
    assert places[-1] < notes.index("## 0.1.0")
    assert all(notes.count(f"Sentence {number}") == 1 for number in range(len(KINDS)))
    assert re.findall(r"^### (.*)$", notes[: notes.index("## 0.1.0")], re.M) == [
        "New",
        "Changed",
        "Mended",
        "Documentation",
    ]
    assert list((tmp_path / "changes").glob("[!.]*")) == []
