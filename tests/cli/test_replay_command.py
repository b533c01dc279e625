"""The command `replay`: what it prints, where it points, and what it refuses."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest
from command import run_command
from copied_trees import copy_tree

from tactiledata.gel.mesh import structured_pad
from tactiledata.gel.mesh.structured_pad import GridPlan
from tactiledata.store.read.reader import Store

pytestmark = pytest.mark.slow

MATERIAL = ["--youngs-modulus", "0.88e6", "--poisson-ratio", "0.45", "--friction", "0.8"]
ROUGH = GridPlan(5, 6, 1.2e-3, (4.8e-3, 6.0e-3), (0.0, 0.6, 1.0))


@pytest.fixture
def store(tiny_store, tmp_path, monkeypatch):
    """A copy of the tiny store in the working folder; the pad called low is a coarse one."""
    monkeypatch.setenv("TACTILEDATA_CACHE", str(tmp_path / "cache"))
    monkeypatch.setitem(structured_pad.PLANS, "low", ROUGH)
    monkeypatch.chdir(tmp_path)
    return copy_tree(tiny_store, tmp_path / "ds.zarr")


def calibration(offsets):
    """A document as `tactiledata calibrate` writes it."""
    interval = {"low": 1.0, "high": 2.0, "low_is_bound": False, "high_is_bound": False}
    three = {"youngs_modulus": 0.88e6, "poisson_ratio": 0.45, "friction": 0.8}
    losses = {"start": 1.0, "fitted": 1.0, "held_out_start": None, "held_out": None}
    return {
        "format": "tactiledata-calibration/1",
        **three,
        "intervals": {
            "method": "profile likelihood",
            "inflation": [1, 1, 1],
            "with_simulation_error": {"force_error": 0.02, "law_error": 0.06, **{key: [1.0, 2.0] for key in three}},
            **dict.fromkeys(three, interval),
        },
        "correlation": np.eye(3).tolist(),
        "bounds": {"name": "paper", **{key: [0.0, 1.0] for key in three}},
        "start": three,
        "loss": "vector",
        "losses": {"vector": losses, "norm": losses},
        "offsets": offsets,
        "trajectories": {"fitted": ["a", "b"], "held_out": [], "left_out": {}, "frames": 2},
        "noise": {"source": "stated", "deviations": [0.1] * 6, "inflation": 1},
        "engine": "fem",
        "fidelity": "linear",
        "mesh": {"name": "digit-low", "sha256": "0" * 64},
        "interpolation_error": {"rms": None, "largest": None},
        "findings": [],
        "provenance": {},
    }


def test_it_attaches_and_says_where_to_look(store, capsys):
    """A preview is called one; the page is there; info and report know the mesh."""
    code, out, err = run_command(capsys, "replay", "--fidelity", "linear", *MATERIAL)
    assert code == 0, err
    assert "preview" in out
    page = next(line.partition("look: ")[2] for line in out.splitlines() if line.startswith("look: "))
    assert "data:image/png;base64," in Path(page).read_text(encoding="utf-8")
    assert "flagged as bad" not in out
    assert "mesh: low-linear, linear" in run_command(capsys, "info")[1]
    run_command(capsys, "report", "--out", "page")
    assert "Mesh low-linear" in Path("page/report.html").read_text(encoding="utf-8")


def test_flagged_trajectories_are_played_and_said_to_be(store, capsys):
    """A bad trajectory gets a mesh, which may show what was bad in it; nobody has to guess so."""
    uid = Store.open(store).trajectories(["uid"])["uid"][0].as_py()
    assert run_command(capsys, "flag", "ds.zarr", uid, "--reason", "bent")[0] == 0
    code, out, err = run_command(capsys, "replay", "--fidelity", "linear", *MATERIAL)
    assert code == 0, err
    assert "1 trajectory flagged as bad was played as well: splits leave it out" in out
    assert json.loads(run_command(capsys, "replay", "--fidelity", "linear", *MATERIAL, "--json")[1])["flagged"] == [uid]


def test_a_calibration_gives_material_and_offsets(store, capsys):
    """A calibration is taken as a document for machines; what is stated beside it wins."""
    uid = Store.open(store).trajectories(["uid"])["uid"][0].as_py()
    Path("calibration.json").write_text(json.dumps(calibration({uid: 2e-5})))
    options = ("--fidelity", "linear", "--calibration", "calibration.json")
    code, out, err = run_command(capsys, "replay", *options, "--friction", "0.5", "--json")
    assert code == 0, err
    document = json.loads(out)
    assert document["with_mesh"] == Store.open(store).n_frames
    settings = Store.open(store).mesh("low-linear").settings
    assert settings["material"] == {"youngs_modulus": 0.88e6, "poisson_ratio": 0.45, "friction": 0.5}
    assert settings["offsets"] == 1
    code, out, _ = run_command(capsys, "replay", *options, "--json")
    assert code == 2
    assert "--replace" in json.loads(out)["hint"]


def test_a_calibration_of_another_store_is_taken_and_said(store, capsys):
    """Its material serves; a line, and the JSON, say that none of its touches is in this store."""
    other = calibration({}) | {"provenance": {"inputs": {"store": "0" * 64}}}
    other["trajectories"] = {**other["trajectories"], "fitted": ["a" * 16, "b" * 16]}
    Path("calibration.json").write_text(json.dumps(other))
    options = ("--fidelity", "linear", "--calibration", "calibration.json")
    code, _, err = run_command(capsys, "replay", *options)
    assert code == 0, err
    assert "note: calibration.json: it was made from another store: this one holds none of its 2" in err
    code, out, _ = run_command(capsys, "replay", *options, "--json")
    assert len(json.loads(out)["of_other_stores"]) == 1


def test_a_missing_material_is_said_before_anything_is_loaded(store, capsys, monkeypatch):
    """It names what is missing in words and as the options that state it; the gel's engine is not imported for it."""
    monkeypatch.setitem(sys.modules, "tactiledata.replay.attach", None)
    code, _, err = run_command(capsys, "replay", "--friction", "0.5")
    assert code == 2
    assert "nothing states the gel's Young's modulus and Poisson's ratio; expected" in err
    assert "or --youngs-modulus … --poisson-ratio …." in err


@pytest.mark.parametrize(
    "options",
    [
        ["--resolution", "middle"],
        ["--fidelity", "exact"],
        ["--keep", "some"],
        ["--gap-limit", "0"],
        ["--poisson-ratio", "0.5"],
        ["--pad", "nowhere.msh"],
        ["--workers", "0"],
        ["--name", "../../outside"],
        ["--name", "a/b"],
    ],
)
def test_wrong_calls_change_nothing(store, options, capsys):
    """Wrong calls give exit code 2, an error in words, and a store without meshes."""
    code, _, err = run_command(capsys, "replay", *MATERIAL, *options)
    assert code == 2, err
    assert "rror: " in err
    assert Store.open(store).mesh_names == ()
    assert not list(store.parent.glob("**/replay*"))
