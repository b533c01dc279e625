"""Every code block of README and docs runs, or says beside it why it does not."""

import itertools
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from copied_trees import copy_tree

ROOT = Path(__file__).resolve().parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
RUNNABLE = {"python", "bash", "sh", "console"}
BLOCK = re.compile(
    r"(?P<comment><!-- not run: (?P<reason>[^>]+) -->\n)?```(?P<language>[a-z]*) ?(?P<file>[^\n]*)\n(?P<code>.*?)^```",
    re.DOTALL | re.MULTILINE,
)
PRINTED = re.compile(
    r"^```python\n(?P<code>.*?)^```\n\nIt prints:\n\n```text\n(?P<printed>.*?)^```", re.DOTALL | re.MULTILINE
)
"""A block and what the page says that it prints."""
NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?")
LINK = re.compile(r"\]\((?!https?://|#|mailto:)(?P<target>[^)#\s]+)")


def blocks(page):
    return [match.groupdict() for match in BLOCK.finditer(page.read_text(encoding="utf-8"))]


def printed_alike(one, other):
    """Whether two texts have the same words, and numbers that differ by a tenth or by one in the last digit."""
    if NUMBER.sub("#", one).split() != NUMBER.sub("#", other).split():
        return False
    numbers = zip(NUMBER.findall(one), NUMBER.findall(other), strict=True)
    return all(
        abs(float(a) - float(b)) <= max(0.1 * abs(float(b)), 1.01 * 10.0 ** -len(b.partition(".")[2]))
        for a, b in numbers
    )


@pytest.fixture(scope="session")
def prepared(tmp_path_factory):
    """A folder as the pages assume it: recordings/ of a tiny recorded world, and ds.zarr made of them, with a split.

    Eight touches: of four, chance, which another processor draws anew, leaves a half without any one time in eight.
    """
    from tactiledata.ingest.pipeline import ingest
    from tactiledata.rig.record import record
    from tactiledata.rig.scenario.scenario import load_scenario
    from tactiledata.rig.scenario.worlds import find_scenario
    from tactiledata.splits.make import make_split
    from tactiledata.store.read.reader import Store

    folder = tmp_path_factory.mktemp("pages")
    world = dict(find_scenario("tiny"))
    world["generate"] = {**world["generate"], "count": 8}
    record(load_scenario(world), folder / "recordings", "mcap")
    ingest([folder / "recordings"], folder / "ds.zarr")
    make_split(Store.open(folder / "ds.zarr"), hold_out="none")
    return folder


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_blocks_run(page, prepared, tmp_path):
    """The runnable blocks of a page run one after another in one folder, beside the files that its blocks show."""
    runnable = [block for block in blocks(page) if block["language"] in RUNNABLE and not block["reason"]]
    if not runnable:
        return
    copy_tree(prepared, tmp_path / "work")
    for block in blocks(page):
        if block["file"]:
            shown = tmp_path / "work" / block["file"]
            shown.parent.mkdir(parents=True, exist_ok=True)
            shown.write_text(block["code"], encoding="utf-8")
    environment = {
        **os.environ,
        "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",
        "PYTHONPATH": str(ROOT),
        "PYTHONWARNINGS": "error",
    }
    printed = {match["code"]: match["printed"] for match in PRINTED.finditer(page.read_text(encoding="utf-8"))}
    for block in runnable:
        if block["language"] == "python":
            command = [sys.executable, "-c", block["code"]]
        else:
            lines = [re.sub(r"^\$ ", "", line) for line in block["code"].splitlines()]
            command = ["bash", "-euo", "pipefail", "-c", "\n".join(lines)]
        done = subprocess.run(
            command, cwd=tmp_path / "work", env=environment, capture_output=True, text=True, check=False, timeout=900
        )
        assert done.returncode == 0, f"{page.name}:\n{block['code']}\n{done.stdout[-2000:]}\n{done.stderr[-2000:]}"
        if block["code"] in printed:
            assert printed_alike(done.stdout, printed[block["code"]]), f"{page.name}: {done.stdout}"


def test_what_pages_print_is_compared():
    """Rounding and another processor do not matter; other numbers, other words and lines too many do."""
    assert printed_alike("error 0.3 N of 845 kPa\n", "error 0.3 N of 850 kPa\n")
    for other in ("error 0.5 N of 845 kPa\n", "error 0.3 N of 745 kPa\n", "error 0.3 mN of 845 kPa\n", "error 0.3 N\n"):
        assert not printed_alike(other, "error 0.3 N of 845 kPa\n")
    assert sum(len(PRINTED.findall(page.read_text(encoding="utf-8"))) for page in PAGES) >= 3


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_somewhere(page):
    """Every relative link and picture of a page exists."""
    text = page.read_text(encoding="utf-8")
    for match in LINK.finditer(text):
        assert (page.parent / match["target"]).exists(), f"{page.name}: {match['target']}"


def test_every_block_is_run_or_says_why_not():
    """A fenced block has a language; what is not run and is not data, output or a listing gives its reason."""
    quiet = RUNNABLE | {"yaml", "json", "text", "csv"}
    for page in PAGES:
        for block in blocks(page):
            assert block["language"] in quiet, f"{page.name}: a block in {block['language']!r}:\n{block['code'][:200]}"


def test_every_list_is_one_on_the_site():
    """A list follows a blank line, a heading or a list: right after a line of text the site takes it for that text."""
    item, other = re.compile(r"(- |\* |\d+\. )"), re.compile(r"\s*([-*] |\d+\. )|\s{2,}|#|```|\||<|!\[|>|$")
    torn = []
    for page in [*PAGES, *sorted((ROOT / "docs" / "decisions").glob("*.md"))]:
        lines = BLOCK.sub("```", page.read_text(encoding="utf-8")).splitlines()
        torn += [
            f"{page.name}: {line}"
            for before, line in itertools.pairwise(lines)
            if item.match(line) and not other.match(before)
        ]
    assert torn == []
    # a control: this is what the law is about
    assert item.match("- one")
    assert not other.match("It holds:")
