"""From a store to every table, by the command, on models of which nothing is expected but that they run."""

import json
import os
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
import torch
import yaml
from copied_trees import copy_tree
from touch_world import UNSEEN, coarse_replay, tiny_recipe

from split_models.learning.checkpoint import load_checkpoint
from split_models.learning.data import TouchFrames, vertex_moments
from split_models.learning.items import PictureItems
from split_models.learning.train import LAST
from split_models.networks.latent import NoContact
from split_models.recipe.recipe import load_recipe
from split_models.recipe.recipe_run import RecipeRun
from split_models.tables.evaluate import image_values
from tactiledata.cli.main import run
from tactiledata.errors import CheckpointError, MissingSplit, StoreError, UsageError
from tactiledata.store.layout.manifest import write_manifest
from tactiledata.store.read.reader import Store


@pytest.fixture(scope="module")
def out(tmp_path_factory):
    """A folder for all recipes of this module: they share their models."""
    return tmp_path_factory.mktemp("runs")


def recipe_file(folder, store, table, **rows):
    path = folder / f"{table}.yaml"
    path.write_text(yaml.safe_dump(tiny_recipe(store, table, **rows)))
    return path


def command(monkeypatch, capsys, *arguments):
    monkeypatch.setattr("sys.argv", ["tactiledata", *map(str, arguments)])
    with pytest.raises(SystemExit) as ended:
        run()
    captured = capsys.readouterr()
    return ended.value.code, captured.out, captured.err


def recipe_run(folder, store, out, table="digit_images", **options):
    return RecipeRun(load_recipe(recipe_file(folder, store, table)), out, torch.device("cpu"), **options)


def test_frames_are_those_of_the_store(touch_store):
    """Pictures scaled, displacements, forces and backgrounds of the same rows; kept or read anew, the same."""
    frames = TouchFrames(touch_store, "default/train", size=(40, 30), mesh="", wrench="contact_wrench")
    anew = TouchFrames(touch_store, "default/train", size=(40, 30), mesh="", wrench="contact_wrench", kept_bytes=0)
    numbers = [3, 0, len(frames) - 1]
    store = Store.open(touch_store)
    assert frames.pictures(numbers).shape == (3, 40, 30, 3)
    assert np.array_equal(frames.pictures(numbers), anew.pictures(numbers))
    assert np.array_equal(frames.displacements(numbers), store.mesh("coarse").displacement(frames.rows[numbers]))
    assert np.array_equal(frames.displacements(numbers), anew.displacements(numbers))
    assert np.allclose(frames.forces(numbers), store.aligned("contact_wrench", frames.rows[numbers])[0][:, :3])
    assert UNSEEN not in frames.sensor_names
    mean, spread = vertex_moments(frames)
    whole = frames.displacements(range(len(frames))).astype(np.float64)
    assert np.allclose(mean, whole.mean(axis=0), atol=1e-12)
    assert np.allclose(spread, whole.std(axis=0), atol=1e-9)


def test_pictures_of_several_sets_keep_their_places(touch_store):
    """Any order of numbers over two sets and the backgrounds behind them gives the right pictures."""
    train = TouchFrames(touch_store, "default/train", size=(40, 30))
    val = TouchFrames(touch_store, "default/val", size=(40, 30))
    items = PictureItems([train, val], background_copies=2)
    assert len(items) == len(train) + len(val) + 2 * len(train.sensor_names)
    numbers = [len(items) - 1, 0, len(train) + 1, 5]
    found = items.batch(numbers)["image"].numpy()
    expected = [train.background(train.sensor_names[-1]), train.pictures([0])[0], val.pictures([1])[0]]
    assert all(np.array_equal(one, other) for one, other in zip(found, expected, strict=False))
    assert "background of" in items.where(numbers[0])
    assert f"frame {val.rows[1]} " in items.where(numbers[2])


@pytest.mark.slow
def test_the_table_of_pictures_from_nothing(touch_store, out, monkeypatch, capsys):
    """The table has every row on both parts, full frame and in contact; the second run trains nothing."""
    path = recipe_file(out, touch_store, "digit_images")
    code, printed, err = command(monkeypatch, capsys, "run", path, "--out", out, "--json")
    assert code == 0, err
    document = json.loads(printed)
    rows = {(row["part"], row["method"]): row["scores"] for row in document["rows"]}
    parts = ["test", "test_unseen"]
    assert list(dict.fromkeys(part for part, _ in rows)) == [
        title for part in parts for title in (part, f"{part}, each row less SPLIT")
    ]
    less = rows["test, each row less SPLIT", "no_contact"]["l1"]["value"]
    assert less == pytest.approx(rows["test", "no_contact"]["l1"]["value"] - rows["test", "split"]["l1"]["value"])
    assert [method for part, method in rows if part == "test"] == ["no_contact", "end_to_end", "nosplit", "split"]
    plain = rows["test_unseen", "no_contact"]
    scores = ("l1", "mse", "ssim", "psnr", "gradient_error")
    assert set(plain) == {f"{name}{where}" for name in scores for where in ("", "_contact")}
    assert plain["ssim"]["value"] > 0.8  # a picture without any contact scores high on the full frame
    assert plain["l1_contact"]["value"] > 2 * plain["l1"]["value"]
    before = {folder: (folder / LAST).stat().st_mtime_ns for folder in (out / "models").iterdir()}
    assert len(before) == 5
    again, printed, err = command(monkeypatch, capsys, "evaluate", path, "--out", out)
    assert again == 0, err
    assert "target background, no contact" in printed
    assert (out / "digit_images" / "small" / "table.md").read_text().strip() in printed
    assert {folder: (folder / LAST).stat().st_mtime_ns for folder in (out / "models").iterdir()} == before
    assert all((folder / "curve.csv").exists() for folder in before)
    grid = cv2.imread(str(out / "digit_images" / "small" / "pictures-test.png"))
    assert grid.shape[1] == 150 + 4 + 5 * 150 + 4 * 4  # words beside, five pictures five times as large, gaps


@pytest.mark.slow
@pytest.mark.parametrize("table", ["mesh", "force", "cyclic"])
def test_the_other_tables(table, touch_store, out, monkeypatch, capsys):
    """Rows of all methods; the VAEs are those of the table of pictures."""
    path = recipe_file(out, touch_store, table)
    code, printed, err = command(monkeypatch, capsys, "run", path, "--out", out, "--json")
    assert code == 0, err
    document = json.loads(printed)
    methods = list(dict.fromkeys(row["method"] for row in document["rows"]))
    expected = {
        "mesh": ["at_rest", "nosplit", "split"],
        "force": ["raw_mesh", "raw_image", "mesh", "image", "deformation", "projected_nosplit", "projected_split"],
        "cyclic": ["faded", "split", "split_sampled", "split_cycle_only", "split_cycle"],
    }
    assert methods == expected[table]
    assert all(score["value"] is not None for row in document["rows"] for score in row["scores"].values())
    assert len(list((out / "models").glob("image_vae-*"))) == 1
    if table == "mesh":
        shown = cv2.imread(str(out / "mesh" / "small" / "meshes-test.png"))
        assert shown.shape[1] == 150 + 4 + 5 * 150 + 4 * 4
    if table == "force":
        assert document["rows"][2]["scores"]["norm"]["seeds"] == 2
    if table == "cyclic":
        assert [row["cycle"] for row in document["rows"] if row["method"] == "split"] == [1, 2, 3] * 2
        assert (out / "cyclic" / "small" / "strip-test-split.png").stat().st_size > 0


@pytest.mark.slow
def test_two_processes_train_a_recipe(touch_store, tmp_path):
    """The whole command under torchrun: one of them writes and speaks, and both end."""
    recipe = tiny_recipe(touch_store, "mesh", methods=["split"])
    # how many frames the train part has goes by the last bits of recordings: steps of 8 are there in any case
    models = {
        name: {**model, "training": {**model["training"], "batch_size": 8}} for name, model in recipe["models"].items()
    }
    path = tmp_path / "mesh.yaml"
    path.write_text(yaml.safe_dump({**recipe, "models": models}))
    done = subprocess.run(
        [sys.executable, "-m", "torch.distributed.run", "--standalone", "--nproc-per-node", "2", "-m", "split_models",
         "train", str(path), "--out", str(tmp_path / "out"), "--json"],
        capture_output=True, text=True, check=False, timeout=400, cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(Path(__file__).resolve().parents[3]), "OMP_NUM_THREADS": "1"},
    )  # fmt: skip
    assert done.returncode == 0, done.stdout[-1500:] + done.stderr[-3500:]
    models = json.loads(done.stdout[done.stdout.index("{") :])["models"]
    assert list(models) == ["image_vae", "mesh_vae", "projection_image_to_mesh_split"]
    assert all(load_checkpoint(Path(folder) / LAST).progress["is_over"] for folder in models.values())


def test_a_model_that_is_not_trained_is_said(touch_store, tmp_path, monkeypatch, capsys):
    """Evaluate trains nothing; neither does a recipe without a table have one."""
    path = recipe_file(tmp_path, touch_store, "mesh")
    code, _, err = command(monkeypatch, capsys, "evaluate", path, "--out", tmp_path / "new")
    assert code == 2
    assert "is not trained yet" in err
    plain = {name: value for name, value in tiny_recipe(touch_store, "mesh").items() if name != "table"}
    path.write_text(yaml.safe_dump(plain))
    code, _, err = command(monkeypatch, capsys, "evaluate", path, "--out", tmp_path / "new")
    assert code == 2
    assert "has no table" in err


def test_bad_data_are_said_before_anything_is_learned(touch_store, tmp_path, tiny_store):
    """No meshes, no background of a sensor, no split, no such device, pictures that do not divide."""
    with pytest.raises(StoreError, match="has no meshes"):
        _ = recipe_run(tmp_path, tiny_store, tmp_path / "out").mesh_vae
    with pytest.raises(MissingSplit):
        TouchFrames(touch_store, "train")
    bare = tmp_path / "bare.zarr"
    copy_tree(touch_store, bare)
    manifest = json.loads((bare / "manifest.json").read_text())
    manifest["references"] = {}
    write_manifest(bare, manifest)
    with pytest.raises(StoreError, match="background"):
        TouchFrames(bare, "default/train", mesh="")
    document = tiny_recipe(touch_store, "mesh")
    document["data"]["image_size"] = [44, 30]
    path = tmp_path / "odd.yaml"
    path.write_text(yaml.safe_dump(document))
    with pytest.raises(UsageError, match="do not divide"):
        _ = RecipeRun(load_recipe(path), tmp_path / "out", torch.device("cpu")).image_vae
    assert not (tmp_path / "out" / "models").exists()


@pytest.mark.slow
def test_weights_of_another_state_are_refused(touch_store, tmp_path, out):
    """The store's meshes were made anew on another material, or the split drawn anew: what differs is said."""
    from tactiledata.gel.elasticity.material import GelMaterial
    from tactiledata.replay.attach import replay
    from tactiledata.splits.make import make_split

    place = tmp_path / "ds.zarr"
    copy_tree(touch_store, place)
    first = recipe_run(tmp_path, place, tmp_path / "out")
    assert first.mesh_vae.topology == first.topology.digest
    replay(place, coarse_replay(material=GelMaterial(0.8e6, 0.45, 0.8)), replace=True)
    with pytest.raises(CheckpointError, match="the frames that it learns from"):
        _ = recipe_run(tmp_path, place, tmp_path / "out").mesh_vae
    make_split(Store.open(place), by="trajectory,sensor", fractions=(0.4, 0.3, 0.3), force=(0.3, 13.0), replace=True)
    with pytest.raises(CheckpointError, match="the split"):
        _ = recipe_run(tmp_path, place, tmp_path / "out").mesh_vae
    folder = next((tmp_path / "out" / "models").iterdir())
    assert load_checkpoint(folder / LAST).stamps.topology == first.topology.digest


def test_each_unit_may_have_its_method(touch_store):
    """A method with ``for_sensor`` is asked for every sensor, and frames get their own sensor's background."""
    frames = TouchFrames(touch_store, "default/train", size=(40, 30), mesh="")
    asked = []

    class Own(NoContact):
        def for_sensor(self, sensor):
            asked.append(sensor)
            return NoContact()

    values = image_values(Own(), frames, ["l1"])
    assert set(asked) == set(frames.sensor_names)
    number = len(frames) - 1
    shown = frames.pictures([number])[0].astype(float)
    expected = np.abs(shown - frames.background(frames.sensors[number])).mean()
    assert values["l1"][number] == pytest.approx(expected, rel=1e-5)
