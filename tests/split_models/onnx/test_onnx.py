"""Exported networks give what PyTorch gives, for any number of items, and refuse what does not fit."""

import json
import sys

import numpy as np
import pytest
import torch
from small_models import grid_topology as grid
from small_models import image_vae, mesh_vae, pictures, presses

from split_models.networks.latent import LatentImageToMesh, LatentMeshToImage
from split_models.networks.projection import Projection
from split_models.networks.sparse_map import SparseMap
from split_models.onnx.export import TOLERANCE, export_models
from split_models.onnx.gather_map import GatherMap, with_gathers
from split_models.onnx.models import MODELS, OnnxImageToMesh, OnnxMeshToImage, OnnxModels
from tactiledata.errors import CheckpointError, MissingFile, TactileDataError, UsageError

BACKGROUND = pictures(1, seed=9)[0]


@pytest.fixture(scope="module")
def networks():
    """Both VAEs and projections, of random weights; blocks that start as the identity made to do something."""
    torch.manual_seed(0)
    image, mesh = image_vae(), mesh_vae()
    for one in (image, mesh):
        for weight in one.parameters():
            torch.nn.init.normal_(weight, std=0.1)
    spread = torch.rand_like(mesh.spread) * 1e-4 + 1e-5
    mesh.spread.copy_(spread)
    return image.eval(), mesh.eval(), Projection(8, 16, (16, 16)).eval(), Projection(16, 8, (16, 16)).eval()


@pytest.fixture(scope="module")
def exported(networks, tmp_path_factory):
    folder = tmp_path_factory.mktemp("onnx")
    export_models(folder, *networks, pictures(2), presses(grid(), 2))
    return folder


def test_gathers_are_the_sparse_product():
    """Gathers are the product of every constant matrix of a mesh VAE; the copy leaves the network as it was."""
    vae = mesh_vae()
    copied = with_gathers(vae)
    maps = [one for one in vae.modules() if isinstance(one, SparseMap)]
    gathers = [one for one in copied.modules() if isinstance(one, GatherMap)]
    assert len(maps) == len(gathers) == 12
    assert not any(isinstance(one, SparseMap) for one in copied.modules())
    for one, other in zip(maps, gathers, strict=True):
        values = torch.randn(one.shape[1], 2, 3)
        assert torch.allclose(one(values), other(values), atol=1e-5)
    moved = torch.from_numpy(presses(grid(), 3))
    assert torch.allclose(vae.eval()(moved)[0], copied(moved)[0], atol=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("count", [1, 5])
def test_both_ways_agree_with_pytorch(networks, exported, count):
    """Latent vectors and meshes agree within 1e-4 of the largest value, pictures within a grey level of rounding."""
    image, mesh, forth, back = networks
    models = OnnxModels(exported)
    assert max(models.document["difference"].values()) < TOLERANCE
    moved, shown = presses(grid(), count, seed=3), pictures(count, seed=4)
    with torch.no_grad():
        true = mesh.distribution(torch.from_numpy(moved))[0].numpy()
    found = models.mesh_latents(moved)
    assert np.abs(found - true).max() < 1e-4 * np.abs(true).max()
    drawn = LatentMeshToImage("split", mesh, image, forth).predict(moved, BACKGROUND)
    ours = OnnxMeshToImage(models).predict(moved, BACKGROUND)
    assert ours.shape == drawn.shape == (count, 40, 30, 3)
    assert np.abs(ours.astype(int) - drawn).max() <= 1
    assert (ours != drawn).mean() < 1e-3
    meshes = LatentImageToMesh("split", image, mesh, back).predict(shown, BACKGROUND)
    assert np.abs(OnnxImageToMesh(models).predict(shown, BACKGROUND) - meshes).max() < 1e-4 * np.abs(meshes).max()


def test_what_does_not_fit_is_refused(tmp_path):
    """Another mesh, NaN, another picture size, no folder, another format and a missing network are refused."""
    files = {"mesh_encoder": {"input": "displacements", "output": "latent"}}
    document = {"format": "tactiledata-onnx/1", "image_size": [40, 30], "vertices": 204, "files": files}
    models = OnnxModels(tmp_path, document)
    with pytest.raises(UsageError, match=r"\(n, 204, 3\): the mesh topology"):
        OnnxMeshToImage(models).predict(np.zeros((1, 7, 3), np.float32), BACKGROUND)
    with pytest.raises(UsageError, match="NaN"):
        OnnxMeshToImage(models).predict(np.full((1, 204, 3), np.nan, np.float32), BACKGROUND)
    with pytest.raises(UsageError, match="Scale the pictures"):
        OnnxImageToMesh(models).predict(pictures(1, size=(44, 30)), BACKGROUND)
    with pytest.raises(MissingFile, match="tactiledata export"):
        OnnxModels(tmp_path)
    (tmp_path / MODELS).write_text(json.dumps({**document, "format": "x/1"}))
    with pytest.raises(CheckpointError, match="x/1"):
        OnnxModels(tmp_path)
    (tmp_path / MODELS).write_text(json.dumps(document))
    with pytest.raises(MissingFile, match=r"mesh_encoder\.onnx"):
        OnnxMeshToImage(OnnxModels(tmp_path)).predict(presses(grid(), 1), BACKGROUND)


def test_an_export_that_differs_is_refused(networks, tmp_path, monkeypatch):
    """A network that is random after all: its file cannot agree."""
    image, mesh, forth, back = networks
    monkeypatch.setattr(OnnxModels, "run", lambda self, name, values: np.zeros(1, np.float32))
    monkeypatch.setattr("split_models.onnx.export.write_network", lambda *_: None)
    with pytest.raises(TactileDataError, match="differs from PyTorch"):
        export_models(tmp_path, image, mesh, forth, back, pictures(2), presses(grid(), 2))


def test_packages_that_are_missing_are_said(networks, tmp_path, monkeypatch):
    """Before anything is written."""
    monkeypatch.setattr("tactiledata.contract.extras.find_spec", lambda name: None if name == "onnxscript" else name)
    with pytest.raises(UsageError, match="needs onnxscript, which is not installed"):
        export_models(tmp_path / "new", *networks, pictures(2), presses(grid(), 2))
    assert not (tmp_path / "new").exists()


@pytest.mark.slow
def test_running_needs_no_pytorch(exported):
    """The module that runs exported networks imports none."""
    import subprocess

    program = (
        "import sys; from pathlib import Path; from split_models.onnx.models import OnnxModels; "
        f"OnnxModels(Path({str(exported)!r})).run; assert 'torch' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", program], check=True)
