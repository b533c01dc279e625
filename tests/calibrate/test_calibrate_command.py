"""The command on a recorded store, and what it says of stores that it cannot use."""

import json
import sys

import pytest
from copied_trees import copy_tree

from tactiledata.calibrate.measured import read_measured
from tactiledata.calibrate.options import CalibrationOptions
from tactiledata.cli.main import run
from tactiledata.gel.mesh import structured_pad
from tactiledata.gel.mesh.structured_pad import GridPlan
from tactiledata.replay.opened import OpenedStore
from tactiledata.store.change.flag import flag_trajectories
from tactiledata.store.read.reader import Store

COARSE = GridPlan(5, 6, 1.2e-3, (4.8e-3, 6.0e-3), (0.0, 0.6, 1.0))


def run_command(capsys, monkeypatch, *arguments):
    """Exit code, standard output and standard error."""
    monkeypatch.setattr(sys, "argv", ["tactiledata", *map(str, arguments)])
    with pytest.raises(SystemExit) as stop:
        run()
    printed = capsys.readouterr()
    return stop.value.code, printed.out, printed.err


@pytest.mark.slow
def test_the_command_on_a_recorded_world(tiny_store, tmp_path, capsys, monkeypatch):
    """The command writes a result and a page, the same bytes again, JSON for machines, and offsets by uid."""
    pytest.importorskip("matplotlib")
    monkeypatch.setitem(structured_pad.PLANS, "low", COARSE)
    out = tmp_path / "calibration.json"
    arguments = ("calibrate", tiny_store, "--fidelity", "linear", "--out", out)
    code, printed, _ = run_command(capsys, monkeypatch, *arguments)
    assert code == 0
    assert "95 % interval" in printed
    first = out.read_bytes()
    page = (tmp_path / "calibration.html").read_text()
    # four trajectories; two maps; residuals over force and their counts
    assert page.count("data:image/png") == 4 + 2 + 2
    assert page.count("Simulated recordings.</figcaption>") == 3
    assert "<h1>Calibration of the gel (simulated recordings)</h1>" in page
    assert "Simulated recordings: all " in printed
    assert json.loads(first)["simulated_recordings"]["simulated"] >= 2
    code, printed, _ = run_command(capsys, monkeypatch, *arguments, "--json")
    assert code == 0
    assert out.read_bytes() == first
    document = json.loads(printed)
    assert document == json.loads(first)
    assert len(document["offsets"]) == len(document["trajectories"]["fitted"] + document["trajectories"]["held_out"])


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--loss", "l2"), "vector or norm"),
        (("--fidelity", "fine"), "finite-strain or linear"),
        (("--engine", "isaac"), "fem or mujoco-flex"),
        (("--engine", "mujoco-flex", "--fidelity", "linear"), "linear preview"),
        (("--bounds", "narrow"), "paper, wide"),
        (("--trajectories", "1"), "at least 2"),
        (("--hold-out", "1.5"), "0 to below 1"),
        (("--out", "calibration.yaml"), "ends in .json"),
        (("--shore-a", "140"), "Shore A"),
        (("--sensor", "D99999"), "D20001"),
    ],
)
def test_wrong_options_are_wrong_usage(tiny_store, tmp_path, capsys, monkeypatch, options, words):
    """An option outside its range exits with 2, says what is allowed and writes no file."""
    monkeypatch.chdir(tmp_path)
    code, _, said = run_command(capsys, monkeypatch, "calibrate", tiny_store, *options)
    assert code == 2
    assert words in said
    assert "Traceback" not in said
    assert not list(tmp_path.glob("calibration*"))


@pytest.mark.slow
def test_a_store_without_a_wrench_names_the_reason(tiny_folders, tmp_path, capsys, monkeypatch):
    """Recordings whose forces were not recorded are not said to have felt little force."""
    from tactiledata.ingest.pipeline import ingest

    recording = tmp_path / "recording"
    copy_tree(tiny_folders[0], recording)
    (recording / "wrench.csv").unlink()
    ingest([recording], tmp_path / "ds.zarr")
    monkeypatch.chdir(tmp_path)
    code, _, said = run_command(capsys, monkeypatch, "calibrate")
    assert code == 1
    assert "no force: no reading of the force sensor belongs to it" in said
    assert "less than" not in said


@pytest.mark.slow
def test_a_store_without_poses_names_the_reason(tiny_folders, tmp_path, capsys, monkeypatch):
    """Recordings whose arm was not recorded: data fell short, and why."""
    from tactiledata.ingest.pipeline import ingest

    recording = tmp_path / "recording"
    copy_tree(tiny_folders[0], recording)
    for name in ("tcp.csv", "joints.csv"):
        (recording / name).unlink()
    ingest([recording], tmp_path / "ds.zarr")
    monkeypatch.chdir(tmp_path)
    code, _, said = run_command(capsys, monkeypatch, "calibrate")
    assert code == 1
    assert "no stream of tcp poses" in said
    assert "0 trajectories can be used" in said


def test_the_flex_leaves_out_what_it_cannot_press(tiny_store):
    """The cross of the tiny world is counted with its reason for mujoco-flex, and takes part for fem."""
    opened = OpenedStore.planned(Store.open(tiny_store), CalibrationOptions().pads)
    reason = "an indenter that is not convex, which mujoco-flex cannot press"
    flex, fem = (read_measured(opened, CalibrationOptions(engine=engine)) for engine in ("mujoco-flex", "fem"))
    assert flex.left_out.get(reason, 0) > 0
    assert reason not in fem.left_out
    assert len(flex.touches) + flex.left_out[reason] == len(fem.touches)


def test_flagged_touches_take_no_part(tiny_store, tmp_path):
    """A trajectory that is flagged as bad is counted with that reason; the others take part as before."""
    place = tmp_path / "ds.zarr"
    copy_tree(tiny_store, place)
    before = read_measured(OpenedStore.planned(Store.open(place), CalibrationOptions().pads), CalibrationOptions())
    assert "flagged as bad" not in before.left_out
    uid = before.touches[0].uid
    flag_trajectories(place, [uid], "slipped")
    after = read_measured(OpenedStore.planned(Store.open(place), CalibrationOptions().pads), CalibrationOptions())
    assert after.left_out["flagged as bad"] == 1
    assert {touch.uid for touch in after.touches} == {touch.uid for touch in before.touches} - {uid}
