"""Results of another store are not replaced unless asked for, and a calibration of another store is called so."""

import json
import re
from pathlib import Path

import pytest
from command import run_command

from tactiledata.cli.documents import made_of_another_store, refuse_result_of_another_store
from tactiledata.contract.own_files import MARKS
from tactiledata.errors import UsageError
from tactiledata.store.read.reader import Store

MATERIAL = ("--youngs-modulus", "0.9e6", "--poisson-ratio", "0.45", "--friction", "0.8")


def result(digest, uids):
    """What results have in common: provenance, and the trajectories that they rest on."""
    return {"trajectories": {"fitted": list(uids), "held_out": []}, "offsets": {},
            "provenance": {"tool": "tactiledata", "inputs": {"store": digest}}}  # fmt: skip


def page(name, digest):
    """The page of a replay, as far as it tells its store."""
    return f"{MARKS['.html'].decode()}<p>The store is {name}.</p><footer>t 1; store digest {digest}; mesh</footer>"


@pytest.fixture
def opened(tiny_store):
    return Store.open(tiny_store)


@pytest.fixture
def results(tmp_path, monkeypatch):
    """A working folder with a calibration, a diagnosis, and the pages of a replay and of another store."""
    monkeypatch.chdir(tmp_path)
    other = json.dumps(result("0" * 64, ["f" * 16, "e" * 16]))
    Path("calibration.json").write_text(other)
    for folder in ("diagnosis", "replay", "report"):
        Path(folder).mkdir()
    Path("diagnosis/diagnosis.json").write_text(other)
    Path("replay/replay-low-linear.html").write_text(page("other.zarr", "0" * 64))
    shown = f"{MARKS['.html'].decode()}<p>The store other.zarr holds 1 recording with 2 trajectories.</p>"
    Path("report/report.html").write_text(f"{shown}<footer>t 1; store digest {'0' * 64}</footer>")
    return tmp_path


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "file"),
    [
        (["calibrate"], "calibration.json"),
        (["diagnose", "--out", "diagnosis"], "diagnosis/diagnosis.json"),
        (["replay", "--fidelity", "linear", *MATERIAL], "replay/replay-low-linear.html"),
        (["report"], "report/report.html"),
    ],
    ids=["calibrate", "diagnose", "replay", "report"],
)
def test_a_result_of_another_store_is_not_replaced(words, file, results, tiny_store, capsys):
    """Before any work the command refuses, names the file and both ways out; the file stays."""
    before = Path(file).read_bytes()
    code, out, _ = run_command(capsys, words[0], tiny_store, *words[1:], "--json")
    told = json.loads(out)
    assert code == 2
    assert f"{file} would be replaced" in out
    assert "another store" in out
    assert "--out" in told["hint"]
    assert "--replace" in told["hint"]
    assert Path(file).read_bytes() == before


def test_results_of_the_same_store_are_replaced(opened, tmp_path):
    """A result of the same store is replaced, also of an earlier state of it; so is one that names no store."""
    uids = opened.trajectories(["uid"])["uid"].to_pylist()
    path = tmp_path / "calibration.json"
    for content in (
        json.dumps(result(opened.digest, ["f" * 16])),
        json.dumps(result("0" * 64, [uids[0], "f" * 16])),
        json.dumps({"provenance": {}}),
        json.dumps(result("0" * 64, [])),
        "{ torn",
        "[1]",
    ):
        path.write_text(content)
        refuse_result_of_another_store(path, opened, replace=False)
    path.write_text(json.dumps(result("0" * 64, ["f" * 16])))
    refuse_result_of_another_store(path, opened, replace=True)
    with pytest.raises(UsageError, match="holds none of its 1 trajectory"):
        refuse_result_of_another_store(path, opened, replace=False)
    refuse_result_of_another_store(tmp_path / "nothing.json", opened, replace=False)


def test_pages_of_the_same_store_are_replaced(opened, tmp_path):
    """A page tells its store by name and digest: another state of a store of this name is no other store."""
    path, own = tmp_path / "replay-low.html", Path(opened.location).name
    for name, digest in ((own, "0" * 64), ("other.zarr", opened.digest)):
        path.write_text(page(name, digest))
        refuse_result_of_another_store(path, opened, replace=False)
    path.write_text(page("other.zarr", "0" * 64))
    with pytest.raises(UsageError, match=r"other\.zarr"):
        refuse_result_of_another_store(path, opened, replace=False)


def test_a_calibration_of_another_store_is_called_so(opened):
    """One line says it; of the own store, also before recordings were added, nothing is said."""
    uids = opened.trajectories(["uid"])["uid"].to_pylist()
    assert made_of_another_store(result(opened.digest, uids), opened) == ""
    assert made_of_another_store(result("0" * 64, uids[:1]), opened) == ""
    assert made_of_another_store({"offsets": {uids[0]: 0.0}, "provenance": {"inputs": {"store": "0"}}}, opened) == ""
    said = made_of_another_store(result("0" * 64, ["f" * 16, "e" * 16]), opened)
    assert re.fullmatch("it was made from another store: this one holds none of its 2 trajectories", said)
