"""`tactiledata diagnose TABLE`: sentences, JSON, files, exit codes."""

import json
import sys

import pytest
from tables import presses

from tactiledata.cli.main import run


def run_command(capsys, monkeypatch, *arguments):
    """Exit code, standard output and standard error of `diagnose`."""
    monkeypatch.setattr(sys, "argv", ["tactiledata", "diagnose", *arguments])
    with pytest.raises(SystemExit) as stop:
        run()
    printed = capsys.readouterr()
    return stop.value.code or 0, printed.out, printed.err


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder to stand in, with a table that has structure and one that has none."""
    monkeypatch.chdir(tmp_path)
    presses(1, 30, 8, rate=0.15).to_csv("rate.csv", index=False)
    presses(2, 30, 8).to_csv("quiet.csv", index=False)
    return tmp_path


@pytest.mark.slow
def test_sentences_and_files(folder, capsys, monkeypatch):
    """The answer comes first; the page and the document lie in the folder; without --gate the code is 0."""
    code, out, err = run_command(capsys, monkeypatch, "rate.csv", "--out", "diagnosis")
    assert code == 0, err
    assert out.startswith("Something is missing")
    assert {path.name for path in (folder / "diagnosis").iterdir()} == {"report.html", "diagnosis.json"}
    assert "diagnosing" in err


@pytest.mark.slow
def test_the_gate(folder, capsys, monkeypatch):
    """1 where structure is found, 0 where none is."""
    assert run_command(capsys, monkeypatch, "rate.csv", "--gate", "--json")[0] == 1
    code, out, err = run_command(capsys, monkeypatch, "quiet.csv", "--gate", "--json")
    assert (code, err) == (0, "")
    assert json.loads(out)["answer"] == "nothing found"


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (["nowhere.csv"], 2, "does not exist"),
        (["rate.csv", "--group", "tril"], 2, "trial"),
        (["rate.csv", "--columns", "nowhere.yaml"], 2, "does not exist"),
        (["columns.yaml"], 2, "no table"),
        (["rate.csv", "--columns", "columns.yaml"], 2, "$"),
        (["one.csv"], 1, "one group only"),
        (["rate.csv", "--fidelity", "linear"], 2, "--fidelity with a table"),
        (["rate.csv", "--calibration", "c.json"], 2, "--calibration with a table"),
        (["rate.zarr", "--calibration", "c.json"], 2, "`tactiledata calibrate STORE` writes one"),
        (["rate.csv", "--out", "rate.csv"], 2, "cannot be written to"),
        (["rate.csv", "--seed", "-1"], 2, "--seed"),
        (["rate.zarr", "--effects", ",,"], 2, "names nothing"),
        (["rate.zarr", "--indenters", "nowhere"], 2, "is no folder"),
        (["rate.zarr", "--group", "trial"], 2, "--group with a store"),
    ],
)
def test_wrong_calls(folder, capsys, monkeypatch, arguments, code, words):
    """2 for a wrong call, 1 for a table that holds too little, and words for both."""
    (folder / "columns.yaml").write_text("format: tactiledata-columns/1\n")
    presses(1, 1).to_csv("one.csv", index=False)
    found, _, err = run_command(capsys, monkeypatch, *arguments)
    assert (found, words in err) == (code, True), err
    assert "Traceback" not in err
