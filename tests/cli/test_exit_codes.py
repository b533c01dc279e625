"""Every command answers what is not there with exit code 2, in words for people and as JSON for machines."""

import json

import pytest
from command import run_command

from tactiledata.cli.main import app

NOWHERE = "nowhere.zarr"
MISSING_PATH = {
    "demo": ["--world", "nowhere.yaml"],
    "record": ["nowhere.yaml", "--out", "out"],
    "inspect": ["nowhere.mcap"],
    "ingest": ["nowhere.mcap", "--store", "new.zarr"],
    "info": [NOWHERE],
    "check": [NOWHERE],
    "merge": [NOWHERE, "--into", "new.zarr"],
    "sensors": [NOWHERE],
    "report": [NOWHERE],
    "split": [NOWHERE],
    "audit": [NOWHERE],
    "replay": [NOWHERE, "--youngs-modulus", "8e5", "--poisson-ratio", "0.48", "--friction", "0.8"],
    "calibrate": [NOWHERE],
    "diagnose": ["nowhere.csv"],
    "scene": [NOWHERE, "--trajectory", "t00000"],
    "transfer": [NOWHERE, "--to", "ycb-sensorA"],
    "score": [NOWHERE, "--metric", "shade"],
    "train": ["nowhere.yaml"],
    "evaluate": ["nowhere.yaml"],
    "run": ["nowhere.yaml"],
    "export": ["nowhere.yaml"],
    "export-data": [NOWHERE, "--to", "lerobot"],
    "fine-tune": [NOWHERE],
    "view": [NOWHERE],
    "flag": [NOWHERE, "--list"],
    "prove": ["--verify", "nowhere"],
    "plant": [NOWHERE, "--effect", "lag", "--into", "new.zarr"],
}
WITHOUT_PATHS = {"formats", "indenters", "effects"}
WRONG_CALLS = {
    "no store in the folder": ["info"],
    "an option that is not there": ["info", "--nope"],
    "a mapping that is not there": ["ingest", "log", "--mapping", "nowhere.yaml"],
    "inspect by a mapping that is not there": ["inspect", "log", "--mapping", "nowhere.yaml"],
    "a picture that is not there": ["sensors", "add", "D1", "--background", "no.png", "--store", "ds.zarr"],
    "a sensor out of a store that is not there": ["sensors", "remove", "D1", "--store", NOWHERE],
    "a sensor for a store that is not there": ["sensors", "add", "D1", "--background", "picture", "--store", NOWHERE],
    "a second store that is not there": ["merge", "ds.zarr", NOWHERE, "--into", "new.zarr"],
    "a repair of nothing": ["check", NOWHERE, "--repair"],
    "report of an unknown split": ["report", "ds.zarr", "--split", "nope"],
    "audit of an unknown split": ["audit", "ds.zarr", "--split", "nope"],
    "no path at all": ["ingest"],
    "a scene of no such trajectory": ["scene", "ds.zarr", "--trajectory", "nope", "--out", "scene.xml"],
    "an export in no known format": ["export-data", "ds.zarr", "--to", "avi"],
    "an export without a format": ["export-data", "ds.zarr"],
    "a scene as a film": ["scene", "ds.zarr", "--trajectory", "t00000", "--out", "scene.mp4"],
    "a replay without a material": ["replay", "ds.zarr", "--friction", "0.8"],
    "a recipe that does not come with it": ["train", "nope"],
    "a scale that there is not": ["run", "nope", "--scale", "big"],
    "a view of no such trajectory": ["view", "ds.zarr", "nope"],
    "a view as a film": ["view", "ds.zarr", "--out", "view.mp4"],
    "a view of no frames": ["view", "ds.zarr", "--stride", "0"],
    "a flag without a reason": ["flag", "ds.zarr", "t00000"],
    "a flag for no such trajectory": ["flag", "ds.zarr", "nope", "--reason", "bad"],
    "a flag taken off that is not there": ["flag", "ds.zarr", "t00000", "--remove"],
    "a replay by a calibration that is not there": ["replay", "ds.zarr", "--calibration", "nowhere.json"],
}


@pytest.fixture
def folder(tmp_path, tiny_store, tiny_folders, monkeypatch):
    """An empty folder to stand in, and by name a store, a folder log and a picture elsewhere, for reading only."""
    monkeypatch.chdir(tmp_path)
    picture = next((tiny_folders[0] / "frames").iterdir())
    return {"ds.zarr": str(tiny_store), "log": str(tiny_folders[0]), "picture": str(picture)}


def test_the_table_names_every_command():
    """A new command must say here what it does with a missing path."""
    assert {command.name for command in app.registered_commands} == MISSING_PATH.keys() | WITHOUT_PATHS


def answers(capsys, arguments):
    """The answer for people and the one for machines: both must be there, and neither on the other's stream."""
    code, out, err = run_command(capsys, *arguments)
    as_json, document, chatter = run_command(capsys, *arguments, "--json")
    assert (code, as_json) == (2, 2), out + err + document + chatter
    assert out == ""
    assert "rror: " in err
    assert "Traceback" not in err + chatter
    assert chatter == ""
    found = json.loads(document)
    assert set(found) == {"error", "expected", "hint", "code"}
    assert found["code"] == 2
    assert found["error"]
    return found


@pytest.mark.parametrize("name", MISSING_PATH)
def test_a_missing_path_is_wrong_usage(name, folder, tmp_path, capsys):
    """Exit code 2, a JSON object with --json, and nothing is left behind."""
    found = answers(capsys, [name, *MISSING_PATH[name]])
    assert "nowhere" in found["error"]
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("what", WRONG_CALLS)
def test_wrong_calls_are_wrong_usage(what, folder, tmp_path, capsys):
    """Whatever else a call may have wrong is answered in the same way."""
    answers(capsys, [folder.get(word, word) for word in WRONG_CALLS[what]])
    assert list(tmp_path.iterdir()) == []


def test_a_document_that_does_not_fit_is_wrong_usage(folder, tmp_path, capsys):
    """A wrong key in a mapping or a scenario that is handed to a command; in a recording it would be exit code 1."""
    (tmp_path / "mapping.yaml").write_text("format: tactiledata-mapping/1\nsignals: {wrench: {tpoic: /w}}\n")
    (tmp_path / "world.yaml").write_text("format: tactiledata-scenario/1\nseed: many\n")
    for call in (
        ["ingest", folder["log"], "--mapping", "mapping.yaml"],
        ["inspect", folder["log"], "--mapping", "mapping.yaml"],
        ["record", "world.yaml", "--out", "out"],
        ["demo", "--world", "world.yaml"],
    ):
        assert "$." in answers(capsys, call)["error"]
    assert not (tmp_path / "demo-out").exists()


def test_a_fault_of_ours_is_json_too(folder, capsys, monkeypatch):
    """An unexpected failure has code 3, and a refusal of the system code 1."""
    for error, code in ((RuntimeError("oops"), 3), (PermissionError(13, "Permission denied", "x"), 1)):

        def fail(*_, error=error):
            raise error

        monkeypatch.setattr("tactiledata.store.read.overview.overview", fail)
        found, out, err = run_command(capsys, "info", folder["ds.zarr"], "--json")
        assert (found, json.loads(out)["code"], err) == (code, code, "")


def test_ctrl_c_says_that_work_is_kept(folder, capsys, monkeypatch):
    """Ctrl-C gives one line and exit code 130."""

    def stop(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("tactiledata.store.read.overview.overview", stop)
    code, out, err = run_command(capsys, "info", folder["ds.zarr"])
    assert (code, out) == (130, "")
    assert err.splitlines() == ["interrupted: nothing is half written; the same command goes on from what is finished."]
    code, out, err = run_command(capsys, "info", folder["ds.zarr"], "--json")
    assert (code, json.loads(out)["code"], err) == (130, 130, "")


def test_helps_fit_on_a_line(capsys, monkeypatch):
    """No command's help is cut on a terminal of 80 columns."""
    monkeypatch.setenv("COLUMNS", "80")
    code, out, _ = run_command(capsys, "--help")
    assert code == 0
    lines = out[out.index("Commands:") :].splitlines()[1:]
    assert len(lines) == len(app.registered_commands)
    assert not [line for line in lines if line.endswith(("...", "…"))]


@pytest.mark.slow
def test_one_is_not_many(folder, tmp_path, capsys):
    """One recording is no recordings."""
    code, out, _ = run_command(capsys, "ingest", folder["log"], "--store", "one.zarr")
    assert code == 0
    assert "1 recording added to one.zarr" in out
    code, out, _ = run_command(capsys, "info", "one.zarr")
    assert "one.zarr: 1 recording, 2 trajectories" in out
