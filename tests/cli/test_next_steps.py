"""Each command that is said to come next, and all code on a page or a card, runs on the store that it was said of."""

import html
import re
import shlex
import shutil

import numpy as np
import pytest
from command import run_command
from copied_trees import copy_tree
from generators.folder_log import write

from tactiledata.ingest.pipeline import ingest
from tactiledata.ingest.sources.overview import choose_touches, draw, page
from tactiledata.splits.make import make_split
from tactiledata.store.read.reader import Store
from tactiledata.store.write.commit import create

STEP = re.compile(r"(?:next|draw it again): (tactiledata .*)")


def without(*names):
    """Takes files and folders out of a log."""

    def spoil(log):
        for name in names:
            place = log / name
            shutil.rmtree(place) if place.is_dir() else place.unlink()

    return spoil


KINDS = {
    "everything": (2, without()),
    "no forces": (2, without("wrench.csv")),
    "no poses": (2, without("tcp.csv", "joints.csv")),
    "no numbers": (2, without("wrench.csv", "tcp.csv", "joints.csv")),
    "no images": (2, without("frames.csv", "frames")),
    "one touch": (1, without()),
    "many touches": (12, without("joints.csv")),
}
"""Logs that lack something: number of touches, and what is taken out."""


@pytest.fixture(params=KINDS)
def store(request, tmp_path, monkeypatch, capsys):
    """A store called ``my data/ds.zarr`` of such a log, in the working folder; and what its ingest printed."""
    touches, spoil = KINDS[request.param]
    write(tmp_path / "log", touches=touches)
    spoil(tmp_path / "log")
    (tmp_path / "my data").mkdir()
    monkeypatch.chdir(tmp_path / "my data")
    _, printed, err = run_command(capsys, "ingest", tmp_path / "log", "--store", tmp_path / "my data" / "ds.zarr")
    assert "Traceback" not in err
    return tmp_path / "my data" / "ds.zarr", printed


def followed(capsys, printed):
    """The commands that a text says come next, run one after another with all that they print in turn."""
    done = []
    waiting = STEP.findall(printed)
    while waiting:
        step = waiting.pop(0)
        code, out, err = run_command(capsys, *shlex.split(step)[1:])
        assert code == 0, f"{step}\n{out}\n{err}"
        done.append(shlex.split(step)[1])
        waiting += STEP.findall(out)
    return done


def run_code(capsys, text, marks):
    """The blocks of a text between marks: commands are typed, programs are run."""
    blocks = [html.unescape(block) for block in re.findall(marks, text, re.DOTALL)]
    assert blocks
    for block in blocks:
        if block.startswith("tactiledata "):
            followed(capsys, f"next: {block}")
        else:
            exec(compile(block, "page", "exec"), {"__name__": "page"})


@pytest.mark.slow
def test_every_step_that_is_printed_runs(store, capsys):
    """Every next step of ingest and `info` ends with exit code 0; where no split can be drawn none is named.

    `info` names the split where there is none, its audit where there is one, and how to draw it again where it is
    damaged. It lists signals where the store has some: a store without numbers gets no header without rows.
    """
    place, printed = store
    _, out, _ = run_command(capsys, "info", place)
    assert ("changes at Hz" in out) == bool(Store.open(place).signal_names)
    assert STEP.findall(out) == STEP.findall(printed)
    can_split = len(Store.open(place).trajectories()) > 1 and len(Store.open(place).frames()) > 0
    for text in (out, printed):
        assert ("no split can be drawn yet" in text) != can_split
    assert followed(capsys, printed) == (["split", "audit"] if can_split else [])
    if not can_split:
        return
    _, out, _ = run_command(capsys, "info", place)
    assert STEP.findall(out) == [shlex.join(["tactiledata", "audit", str(place), "--split", "default"])]
    assert followed(capsys, out) == ["audit"]
    (place / "splits" / "default.parquet").write_bytes(b"x")
    _, out, _ = run_command(capsys, "info", place)
    assert "the split default is damaged" in out
    assert followed(capsys, out) == ["split", "audit"]


@pytest.mark.slow
def test_code_on_pages_runs(store, capsys):
    """All commands and programs on the report page and on the card run, before and after a split."""
    place, printed = store
    for _ in range(2):
        text = page(Store.open(place), None, "default")
        run_code(capsys, text, "<pre[^>]*>(.*?)</pre>")
        run_code(capsys, (place / "README.md").read_text(), "```python\n(.*?)```")
        followed(capsys, printed)


@pytest.mark.slow
def test_a_split_that_is_out_of_date_has_its_command_on_the_page(tmp_path, capsys):
    """After more touches came, ingest and the page name a command that brings the split up to date."""
    write(tmp_path / "log", touches=3)
    write(tmp_path / "more", touches=3, seed=1)
    place = tmp_path / "ds.zarr"
    run_command(capsys, "ingest", tmp_path / "log", "--store", place)
    make_split(Store.open(place), force="none", hold_out="none")
    _, printed, _ = run_command(capsys, "ingest", tmp_path / "more", "--store", place)
    text = page(Store.open(place), None, "default")
    assert "out of date" in text
    _, shown, _ = run_command(capsys, "info", place)
    assert STEP.findall(shown) == STEP.findall(printed)
    assert followed(capsys, printed) == ["split", "audit"]
    [command] = [html.unescape(code) for code in re.findall("<pre[^>]*>(tactiledata .*?)</pre>", text)]
    assert command in printed.replace("\n", " ")


@pytest.mark.slow
def test_a_picture_of_a_store_without_forces_claims_none(tmp_path, capsys):
    """Without forces there is no plot of forces, and nothing is said to be at the largest one; with them there is."""
    for name, spoil in (("with", without()), ("none", without("wrench.csv"))):
        write(tmp_path / name)
        spoil(tmp_path / name)
        run_command(capsys, "ingest", tmp_path / name, "--store", tmp_path / f"{name}.zarr")
    pictures = {name: draw(choose_touches(Store.open(tmp_path / f"{name}.zarr"))) for name in ("with", "none")}
    figure, caption = pictures["with"]
    assert len(figure.axes) % 4 == 0
    assert "largest force" in caption
    figure, caption = pictures["none"]
    words = [axes.get_title() + axes.get_ylabel() for axes in figure.axes]
    assert len(figure.axes) % 3 == 0
    assert not any("force" in word or "frame)" in word for word in [*words, caption])
    assert np.isfinite(figure.get_size_inches()).all()


def test_info_of_an_empty_store_has_no_empty_tables(tmp_path, capsys):
    """A store without recordings has neither heads without rows nor a status of nothing; it says what to do."""
    create(tmp_path / "ds.zarr")
    code, out, _ = run_command(capsys, "info", tmp_path / "ds.zarr")
    assert code == 0
    assert not re.search(r"^(sensor|indenter|status)", out, re.MULTILINE)
    assert "Ingest recordings first" in out


def test_info_says_what_follows_the_audit(tiny_store, tmp_path, capsys):
    """An audit leaves no trace in a store: its line stays, and the one after it names a command that runs."""
    copy_tree(tiny_store, tmp_path / "ds.zarr")
    _, out, _ = run_command(capsys, "info", tmp_path / "ds.zarr")
    assert "next: tactiledata audit" in out
    command = re.search(r"where the audit found no leak: .*, or (tactiledata .*)", out)[1]
    code, printed, err = run_command(capsys, *shlex.split(command)[1:], "--out", tmp_path / "out")
    assert code == 0, printed + err


def test_info_of_a_store_whose_trajectories_are_all_flagged_shows_it(tiny_mcaps, tmp_path, capsys):
    """`info` says that nothing can be split where all trajectories are flagged, and exits with 0."""
    store = tmp_path / "ds.zarr"
    ingest(tiny_mcaps, store)
    names = [row["key"] for row in Store.open(store).sources(["key"]).to_pylist()]
    assert run_command(capsys, "flag", store, *names, "--reason", "the gel was torn")[0] == 0
    code, out, err = run_command(capsys, "info", store)
    assert (code, err) == (0, "")
    assert "no split can be drawn yet: all trajectories that could be learned from are flagged" in " ".join(out.split())
