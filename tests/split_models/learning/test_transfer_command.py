"""The verb `transfer`: stores and pictures where one looks for them, errors that say what to do, exit codes."""

import json

import cv2
import numpy as np
import pytest
import torch
from cli.command import run_command
from copied_trees import copy_tree
from small_models import image_vae
from transfer_stores import write_two_sensors

from split_models.commands.transfer import method_help
from split_models.learning.checkpoint import Checkpoint, TrainedOn, save_checkpoint
from split_models.transfer import transfer_picture
from split_models.transfer.latent_vectors import vectors_by_model
from split_models.transfer.method_choice import choose_method
from split_models.transfer.methods import BUNDLED_MODEL, LATENT, transfer_method
from split_models.transfer.pixels import PIXEL_TRANSFERS
from split_models.transfer.transfer_picture import differences, sheet, titled
from tactiledata.sensors.backgrounds import load_background
from tactiledata.store.read.reader import Store


@pytest.fixture
def folder(short_store, tmp_path, monkeypatch):
    """A working folder with one store of real backgrounds, whose touches the rig recorded."""
    copy_tree(short_store, tmp_path / "ds.zarr")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.slow
def test_as_typed_in_the_folder_of_a_store(folder, capsys):
    """No store named: the only one is taken, and stays the only one, as all is written below; again: no change."""
    typed = ("transfer", "--to", "ycb-sensorB", "--method", "background-swap")
    code, out, _ = run_command(capsys, *typed)
    assert code == 0
    assert "comes with the toolkit" in out
    made = Store.open(folder / "transferred" / "ds-ycb-sensorB-background-swap.zarr")
    assert made.n_frames
    np.testing.assert_array_equal(made.reference("ycb-sensorB").image, load_background("ycb-sensorB"))
    picture = cv2.imread(str(folder / "transferred" / "ds-ycb-sensorB-background-swap.png"))
    assert picture is not None
    assert picture.shape[1] > 4 * 240
    code, out, _ = run_command(capsys, *typed, "--json")
    document = json.loads(out)
    assert code == 0
    assert (document["added"], document["frames"], document["method"]) == (0, made.n_frames, "background_swap")
    assert document["target"]["licence"] == "MIT"
    assert sorted(document["sensors"]) == ["D20001", "D20002"]


@pytest.mark.parametrize(
    ("words", "code", "says"),
    [
        (["--to", "ycb-sensora", "--method", "reinhard"], 2, "Did you mean"),
        (["--to", "ycb-sensorA", "--method", "reinhart"], 2, "Did you mean reinhard"),
        (["--to", "ycb-sensorA", "--method", "reinhard", "--model", "m.ckpt"], 2, "a method that uses a model"),
        (["--to", "ycb-sensorA", "--model", "nowhere.ckpt"], 2, "nowhere.ckpt"),
        (["--to", "ycb-sensorA", "--method", "reinhard", "--from", "D2001"], 2, "Did you mean"),
        (["--to", "ycb-sensorA", "--method", "reinhard", "--out", "ds.zarr"], 2, "into itself"),
        (["nowhere.zarr", "--to", "ycb-sensorA"], 2, "nowhere.zarr"),
        (["--method", "reinhard"], 2, "--to"),
        (["--to", "ycb-sensorA", "--device", "tpu"], 2, "unknown device 'tpu'"),
    ],
)
def test_wrong_calls(folder, capsys, words, code, says):
    """What is wrong is said in a line, exit 2, and nothing is written."""
    found, _, err = run_command(capsys, "transfer", *words)
    assert found == code
    assert says in err
    assert "Traceback" not in err
    assert not (folder / "transferred").exists()


def test_latent_without_a_model_says_what_to_do(folder, capsys, monkeypatch):
    """Where no model is bundled, a method that needs one names both ways out."""
    monkeypatch.setattr("split_models.transfer.methods.BUNDLED_MODEL", folder / "none.ckpt")
    code, _, err = run_command(capsys, "transfer", "--to", "ycb-sensorA", "--method", "latent-on-background")
    assert code == 2
    assert "tactiledata train RECIPE" in err
    assert "--method background-swap" in err


@pytest.mark.slow
def test_networks_run_on_the_named_device(monkeypatch):
    """The name of the device reaches the network of a method, of the choice and of latent vectors."""
    asked = []
    monkeypatch.setattr(
        "split_models.transfer.latent_transfer.find_device", lambda name: asked.append(name) or torch.device("meta")
    )
    method = transfer_method("latent", None, "cuda")
    assert method.vae.device.type == "meta"
    assert choose_method(None, None, [], "cuda").method.name == "relit"
    vectors_by_model(BUNDLED_MODEL, "cuda")
    assert asked == ["cuda"] * 3


@pytest.mark.slow
def test_the_default_needs_no_model(folder, capsys, monkeypatch):
    """Where no model is bundled, the default keeps the touch without one, and says so."""
    monkeypatch.setattr("split_models.transfer.method_choice.BUNDLED_MODEL", folder / "none.ckpt")
    code, out, err = run_command(capsys, "transfer", "--to", "ycb-sensorA")
    assert code == 0, err
    assert "no model of pictures is bundled" in " ".join(out.split())
    assert (folder / "transferred" / "ds-ycb-sensorA-relit.zarr").is_dir()


@pytest.mark.slow
def test_the_default_measures_itself_and_keeps_the_touch(tiny_store, tmp_path, monkeypatch, capsys):
    """What the model draws of the store's own touches and what is kept are printed, in JSON, and stored.

    The bundled model draws the four touches of the tiny world: arithmetic has a part in the transfer.
    """
    copy_tree(tiny_store, tmp_path / "ds.zarr")
    monkeypatch.chdir(tmp_path)
    code, out, err = run_command(capsys, "transfer", "--to", "ycb-sensorA")
    assert code == 0, err
    told = " ".join(out.split())
    assert "own touches drawn by the model, D20001: strength" in told
    assert "the model draws the touches of this store" in told
    assert "touches kept by latent-relit, D20002: strength" in told
    assert "touch-not-kept" not in told
    code, out, _ = run_command(capsys, "transfer", "--to", "ycb-sensorA", "--json")
    document = json.loads(out)
    assert (code, document["method"], document["added"]) == (0, "latent_relit", 0)
    for measured in ("kept_touch", "drawn_by_model"):
        assert min(one[name] for one in document[measured] for name in ("strength", "correlation", "overlap")) > 0.8
    stored = json.loads(Store.open(document["out"]).sources(["description"])["description"][0].as_py())
    assert stored["transfer"] == {name: document[name] for name in ("drawn_by_model", "kept_touch")}


@pytest.mark.slow
def test_a_model_that_draws_no_touch_has_no_part(folder, capsys):
    """Negative control: an untrained network draws none, which is said with its figures, and the touch is kept."""
    save_checkpoint(folder / "vae.ckpt", Checkpoint.of(image_vae(), TrainedOn()))
    code, out, err = run_command(capsys, "transfer", "--to", "ycb-sensorA", "--model", "vae.ckpt")
    assert code == 0, err
    told = " ".join(out.split())
    assert "below 0.8" in told
    assert "touches kept by relit, D20002: strength" in told
    assert "touch-not-kept" not in told
    assert (folder / "transferred" / "ds-ycb-sensorA-relit.zarr").is_dir()


@pytest.mark.slow
def test_a_named_method_is_used_and_what_it_loses_is_said(folder, capsys):
    """A method that was asked for is taken whatever it loses; the warning names the one that keeps the touch."""
    code, out, err = run_command(capsys, "transfer", "--to", "ycb-sensorA", "--method", "no-contact")
    assert code == 0, err
    assert "`--method relit` keeps them" in " ".join(out.split())
    assert (folder / "transferred" / "ds-ycb-sensorA-no-contact.zarr").is_dir()


@pytest.mark.slow
def test_a_checkpoint_of_pictures_transfers(folder, capsys):
    """An image VAE's checkpoint is used and its hashes are said; the target keeps its own size."""
    vae = image_vae()
    save_checkpoint(folder / "vae.ckpt", Checkpoint.of(vae, TrainedOn(recipe="5ec1be")))
    typed = ("transfer", "--to", "ycb-sensorB", "--model", "vae.ckpt")
    code, out, _ = run_command(capsys, *typed, "--method", "latent-on-background", "--json")
    document = json.loads(out)
    assert code == 0
    assert document["recipe"] == "5ec1be"
    assert len(document["model"]) == 64
    assert np.asarray(Store.open(document["out"]).images([0]))[0].shape == (320, 240, 3)


def test_a_store_that_lacks_backgrounds_falls_short(tmp_path, monkeypatch, capsys):
    """Data that fall short are exit 1, not wrong usage."""
    write_two_sensors(tmp_path / "bare.zarr", n_sources=2, with_backgrounds=())
    monkeypatch.chdir(tmp_path)
    code, _, err = run_command(capsys, "transfer", "--to", "ycb-sensorA", "--method", "reinhard")
    assert code == 1
    assert "sensors add D1" in err


def test_each_reason_for_which_frames_are_left_out_is_counted_apart(tmp_path, monkeypatch, capsys):
    """Frames of the other sensor, frames without a whole image, and those moved make up the store; no reason else."""
    source = write_two_sensors(tmp_path / "ds.zarr", n_sources=2)
    monkeypatch.chdir(tmp_path)
    code, out, err = run_command(
        capsys, "transfer", "--to", "D2", "--method", "background-swap", "--from", "D1", "--out", "moved.zarr"
    )
    assert code == 0, err
    left = {
        words: int(count.split()[0])
        for count, words in (line.split(" left out: ") for line in out.splitlines() if " left out: " in line)
    }
    assert set(left) == {"of sensors other than D1", "without a whole image"}
    assert left["without a whole image"] == 1
    assert sum(left.values()) + Store.open(tmp_path / "moved.zarr").n_frames == source.n_frames


def test_sheet_takes_pictures_of_any_size():
    """Cells of other sizes are shown at one height, rows of other lengths padded with white."""
    small, wide = np.zeros((32, 24, 3), np.uint8), np.zeros((120, 160, 3), np.uint8)
    drawn = sheet([[("a", small), ("b", wide)], [("c", small)]])
    assert drawn.dtype == np.uint8
    assert (drawn[-20:, -50:] == 255).all()
    assert (drawn == 0).any()


def test_the_help_lists_every_method(capsys, monkeypatch):
    """The help of ``--method`` names what the tables hold, and a method that is added to one of them."""
    monkeypatch.setenv("COLUMNS", "300")
    code, out, _ = run_command(capsys, "transfer", "--help")
    assert code == 0
    listed = " ".join(out.split()).partition("--method")[2].partition(" [default:")[0]
    names = [name.replace("_", "-") for name in (*LATENT, *PIXEL_TRANSFERS)]
    assert listed.endswith(f"{', '.join(names[:-1])} or {names[-1]}")
    monkeypatch.setitem(LATENT, "newest_way", "the newest way")
    assert "newest-way" in method_help().partition(" [default:")[0]


def test_a_title_is_above_and_is_not_cut():
    """A title leaves the sheet as it was below it, and a narrow sheet becomes as wide as its title."""
    small = sheet([[("a", np.zeros((320, 24, 3), np.uint8))]])
    drawn = titled(small, "Touches in the style of another sensor (simulated recordings)")
    height, width = small.shape[:2]
    np.testing.assert_array_equal(drawn[-height:, :width], small)
    assert drawn.shape[1] > 3 * width
    assert (drawn[-height:, width:] == 255).all()
    assert (drawn[:-height] < 255).any()
    assert (drawn[:, -2:] == 255).all()


@pytest.mark.slow
def test_the_picture_says_that_its_touches_are_simulated(folder, capsys, monkeypatch):
    """The title of a transfer of simulated recordings names the target and the method, and says what they are."""
    titles = []
    monkeypatch.setattr(transfer_picture, "titled", lambda drawn, title: titles.append(title) or titled(drawn, title))
    code, _, err = run_command(capsys, "transfer", "--to", "ycb-sensorB", "--method", "background-swap")
    assert code == 0, err
    assert titles == ["Touches in the style of ycb-sensorB, by background-swap (simulated recordings)"]


def test_differences_are_grey_where_a_touch_is_kept():
    """A touch that is moved whole leaves grey in the last picture; a lost one shows there."""
    rng = np.random.default_rng(0)
    untouched, target = (rng.integers(60, 190, (12, 9, 3)).astype(np.uint8) for _ in range(2))
    touch = np.zeros((12, 9, 3), np.uint8)
    touch[4:7, 3:6] = 20
    kept = differences(untouched, untouched + touch, target + touch, target)
    assert [picture.min() for _, picture in kept] == [128, 128, 128]
    assert [int(picture.max()) for _, picture in kept] == [168, 168, 128]
    _, (_, made), (_, lost) = differences(untouched, untouched + touch, target, target)
    assert (made == 128).all()
    assert (lost[touch > 0] == 128 - 40).all()
    wide = np.zeros((12, 16, 3), np.uint8)
    assert len(differences(untouched, untouched + touch, wide, wide)) == 2
    assert differences(untouched, wide, target, target) == []
