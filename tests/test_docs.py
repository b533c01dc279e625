"""Every code block of README and docs runs, or says beside it why it does not."""

import itertools
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from copied_trees import copy_tree
from page_server import LONGEST, PLAIN, PageServer

ROOT = Path(__file__).resolve().parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
LONG = {"diagnose.md", "diagnose-table.md", "first-hour.md", "models.md", "transfer.md"}
"""Pages whose blocks take longest: they run every night. By day the README and the notebook do what most of them do,
and tests of the commands train, transfer and diagnose tables."""
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


ENVIRONMENT = {
    **os.environ,
    "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",
    "PYTHONPATH": str(ROOT),
    "PYTHONWARNINGS": "error",
}


@pytest.fixture(scope="session")
def server():
    """A process that has imported the package, for programs and for commands that need no shell."""
    one = PageServer(ENVIRONMENT)
    yield one
    one.close()


def ended(block, folder, said, server):
    """The exit code of a block that runs in a folder, and what it has printed as output and as errors."""
    said.mkdir()
    for name in ("out", "err"):
        (said / name).touch()
    lines = [re.sub(r"^\$ ", "", line) for line in block["code"].splitlines()]
    if block["language"] == "python":
        code = server.run([], block["code"], folder, said)
    elif all(PLAIN.fullmatch(line) for line in lines):
        code = next((failed for line in lines if (failed := server.run(shlex.split(line), "", folder, said))), 0)
    else:
        command = ["bash", "-euo", "pipefail", "-c", "\n".join(lines)]
        with (said / "out").open("w") as out, (said / "err").open("w") as err:
            code = subprocess.run(
                command, cwd=folder, env=ENVIRONMENT, stdout=out, stderr=err, check=False, timeout=LONGEST
            ).returncode
    return code, (said / "out").read_text(), (said / "err").read_text()


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_no_block_is_empty(page):
    """A block without a line is a table or a program that was lost while the page was written."""
    assert all(block["code"].strip() for block in blocks(page))


@pytest.mark.slow
@pytest.mark.parametrize(
    "page",
    [
        pytest.param(page, marks=pytest.mark.nightly if page.name in LONG else (), id=str(page.relative_to(ROOT)))
        for page in PAGES
    ],
)
def test_blocks_run(page, prepared, server, tmp_path):
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
    printed = {match["code"]: match["printed"] for match in PRINTED.finditer(page.read_text(encoding="utf-8"))}
    for number, block in enumerate(runnable):
        code, out, err = ended(block, tmp_path / "work", tmp_path / f"said-{number}", server)
        assert code == 0, f"{page.name}:\n{block['code']}\n{out[-2000:]}\n{err[-2000:]}"
        if block["code"] in printed:
            assert printed_alike(out, printed[block["code"]]), f"{page.name}: {out}"


@pytest.mark.slow
def test_a_block_that_fails_is_seen(server, tmp_path):
    """Programs, commands and lines of a shell that fail give their exit code and what they said; none sees another."""
    blocks = [
        ("python", "left = 1\nprint('said')", 0, "said"),
        ("python", "print('begun')\nleft", 1, "begun"),
        ("python", "import warnings\nwarnings.warn('odd')", 1, ""),
        ("bash", "$ tactiledata --help\n", 0, "Usage"),
        ("bash", "tactiledata info nowhere.zarr\ntactiledata --help", 2, ""),
        ("bash", "echo one | cat\nfalse\necho two", 1, "one\n"),
    ]
    for number, (language, code, expected, words) in enumerate(blocks):
        found, out, err = ended({"language": language, "code": code}, tmp_path, tmp_path / str(number), server)
        assert found == expected, (code, out, err)
        assert words in out, code
        assert bool(out) == bool(words), code


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
