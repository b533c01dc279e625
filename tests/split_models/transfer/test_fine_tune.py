"""Fine-tuning: a VAE comes nearer to another sensor's pictures, goes on, and refuses what it cannot take."""

import json
import shutil

import pytest
import torch
from cli.command import run_command
from loaders.loader_stores import split_store, write_loader_store
from small_models import image_vae, mesh_vae

from split_models.learning.checkpoint import Checkpoint, TrainedOn, load_checkpoint, save_checkpoint
from split_models.networks.image_vae import ImageVae

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """Two sensors' pictures of 16 x 12, and a model of 40 x 30."""
    folder = tmp_path_factory.mktemp("tuned")
    split_store(folder / "ds.zarr")
    torch.manual_seed(0)
    save_checkpoint(folder / "vae.ckpt", Checkpoint.of(image_vae(), TrainedOn(recipe="5ec1be")))
    return folder


def test_it_learns_and_again_is_no_change(touch_store, place, capsys):
    """The error falls, what is written is an image VAE of the same sizes, the parent stays; again: the same bytes."""
    typed = ["fine-tune", touch_store, "--model", place / "vae.ckpt", "--out", place / "out", "--json"]
    wanted = ["--epochs", "2", "--learning-rate", "0.003"]
    parent = (place / "vae.ckpt").read_bytes()
    code, out, err = run_command(capsys, *typed, *wanted)
    assert code == 0, err
    found = json.loads(out)
    assert found["after"] < 0.9 * found["before"]
    made = load_checkpoint(place / "out" / "best.pt")
    assert isinstance(made.network(), ImageVae)
    assert made.settings == load_checkpoint(place / "vae.ckpt").settings
    assert (place / "vae.ckpt").read_bytes() == parent
    before = (place / "out" / "best.pt").read_bytes()
    code, out, _ = run_command(capsys, *typed, *wanted)
    assert code == 0
    assert json.loads(out)["before"] == found["before"]
    assert (place / "out" / "best.pt").read_bytes() == before
    code, out, _ = run_command(capsys, *typed, "--epochs", "3")
    assert code == 1
    assert "another state" in json.loads(out)["error"]


def test_a_model_that_became_worse_is_said(touch_store, place, capsys):
    """Steps far too large spoil a model: the command says so, and so does its document; a good one is not blamed."""
    typed = ["fine-tune", touch_store, "--model", place / "vae.ckpt", "--epochs", "1"]
    spoilt = ["--learning-rate", "0.1", "--out", place / "spoilt"]
    code, out, _ = run_command(capsys, *typed, *spoilt)
    assert code == 0
    assert "worse than the model it began with" in " ".join(out.split())
    _, out, _ = run_command(capsys, *typed, *spoilt, "--json")
    assert json.loads(out)["is_worse"] is True
    _, out, _ = run_command(capsys, *typed, "--learning-rate", "0.003", "--out", place / "good")
    assert "worse" not in out
    assert "name it with --model" in out


@pytest.mark.parametrize(
    ("words", "code", "says"),
    [
        (["--split", "other"], 2, "other"),
        (["--camera", "digitt"], 2, "digit"),
        (["--epochs", "0"], 2, "epochs"),
        (["--learning-rate", "-1"], 2, "learning-rate"),
        (["--device", "tpu"], 2, "tpu"),
        (["--model", "nowhere.ckpt"], 2, "nowhere.ckpt"),
        (["--model", "mesh.ckpt"], 1, "an image_vae"),
    ],
)
def test_wrong_calls(place, capsys, monkeypatch, words, code, says):
    """Said in a line, before anything is written; a model of another kind falls short, all else is wrong usage."""
    monkeypatch.chdir(place)
    save_checkpoint(place / "mesh.ckpt", Checkpoint.of(mesh_vae(), TrainedOn()))
    found, _, err = run_command(capsys, "fine-tune", "ds.zarr", "--model", "vae.ckpt", *words, "--out", "none")
    assert found == code
    assert says in err
    assert "Traceback" not in err
    assert not (place / "none").exists()


def test_stores_that_fall_short(place, capsys, tmp_path):
    """No split is said with the command that makes one; of two cameras one must be named."""
    write_loader_store(tmp_path / "bare.zarr")
    shutil.copy(place / "vae.ckpt", tmp_path)
    write_loader_store(tmp_path / "two.zarr", cameras=("digit", "scene"))
    for store, says in (("bare.zarr", "tactiledata split"), ("two.zarr", "--camera")):
        code, _, err = run_command(
            capsys, "fine-tune", tmp_path / store, "--model", tmp_path / "vae.ckpt", "--out", tmp_path / "out"
        )
        assert code == 2, err
        assert says in err
