"""The command `export-data`: what it prints, its exit codes, and what it leaves behind."""

import json

import pytest
from command import run_command
from copied_trees import copy_tree

from tactiledata.export import EXPORTERS
from tactiledata.export.card import card


@pytest.fixture
def folder(tiny_store, tmp_path, monkeypatch):
    """A working folder that holds one store."""
    copy_tree(tiny_store, tmp_path / "ds.zarr")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_it_says_what_it_made_and_what_is_lost(folder, capsys):
    """With neither store nor folder named: parts, what is lost, and the page that says how to load it."""
    code, out, _ = run_command(capsys, "export-data", "--to", "webdataset")
    assert code == 0
    assert "Simulated recordings: all 2 recordings." in out
    assert "lost: Samples between the frames" in out
    assert "how to load it: ds-webdataset/README.md" in out
    assert (folder / "ds-webdataset" / "README.md").is_file()
    code, out, _ = run_command(capsys, "export-data", "--to", "webdataset")
    assert code == 0
    assert "it was there already" in out


def test_the_document_for_machines(folder, capsys):
    """With --json one document is printed: the content of export.json, and the folder."""
    code, out, _ = run_command(capsys, "export-data", "ds.zarr", "--to", "mcap", "--out", "x", "--json")
    assert code == 0
    printed = json.loads(out)
    written = json.loads((folder / "x" / "export.json").read_text())
    assert {name: printed[name] for name in written if name != "file_sha256"} == {
        name: value for name, value in written.items() if name != "file_sha256"
    }
    assert printed["folder"] == "x"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--to", "lerobt"], "Did you mean lerobot"),
        (["--to", "mcap", "--camera", "digit"], "keeps whole recordings"),
        (["--to", "huggingface", "--streams", "wrench,nose"], "unknown stream 'nose'"),
        (["--to", "huggingface", "--streams", ","], "no stream is named"),
        (["--to", "huggingface", "--file-mb", "0"], "from 1 to"),
        (["--to", "huggingface", "--split", "other"], "default"),
        (
            ["--to", "huggingface", "--out", "mine"],
            "mine holds other files, or an export that is not complete: thesis.tex",
        ),
    ],
)
def test_wrong_usage(arguments, words, folder, capsys):
    """Exit code 2, a sentence that helps, no traceback, and nothing is left behind."""
    (folder / "mine").mkdir()
    (folder / "mine" / "thesis.tex").write_text("mine")
    code, out, err = run_command(capsys, "export-data", *arguments)
    assert code == 2, out + err
    assert words in " ".join(err.split())
    assert {path.name for path in folder.iterdir()} == {"ds.zarr", "mine"}
    assert (folder / "mine" / "thesis.tex").read_text() == "mine"


def test_the_export_of_models_points_here(capsys):
    """Whoever asks `export` for a format of recordings is told the command."""
    code, _, err = run_command(capsys, "export", "ds.zarr", "--to", "lerobot")
    assert code == 2
    assert "tactiledata export-data STORE --to lerobot" in " ".join(err.split())
    code, _, err = run_command(capsys, "export", "ds.zarr", "--to", "tensorflow")
    assert "export-data" not in err


def test_a_place_that_cannot_be_written(folder, capsys):
    """A folder below a file is an error of the system in words, not a traceback."""
    (folder / "file").write_text("mine")
    code, _, err = run_command(capsys, "export-data", "--to", "webdataset", "--out", "file/x")
    assert code == 1
    assert "the system refused" in err


def test_every_format_stands_in_the_help(capsys):
    """The help names every format."""
    code, out, _ = run_command(capsys, "export-data", "--help")
    assert code == 0
    for name in EXPORTERS:
        assert name in out


def test_the_page_shows_names_that_look_like_tags():
    """A reason that somebody gave for a flag is read on the page as it was written, and starts nothing there."""
    page = card(
        {
            "simulated_recordings": {},
            "split": None,
            "provenance": {"version": "1"},
            "store": {"digest": "0" * 64},
            "parts": {},
            "streams": {},
            "left_out": {},
            "lost": [],
            "remarks": ["1 flagged trajectory (t<1>: <script>alert(1)</script>) went out"],
        },
        "pages",
        "print()",
    )
    assert "(t&lt;1>: &lt;script>alert(1)&lt;/script>) went out" in page
