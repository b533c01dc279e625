"""SPLIT's networks as ONNX files, which run without PyTorch; each is checked against PyTorch as it is written."""

from __future__ import annotations

import logging
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn

from split_models.networks.image_vae import ImageVae, as_input
from split_models.networks.mesh_vae import MeshVae
from split_models.networks.projection import Projection
from split_models.onnx.gather_map import with_gathers
from split_models.onnx.models import MODELS, OnnxImageToMesh, OnnxMeshToImage, OnnxModels
from split_models.recipe.recipe_run import RecipeRun
from tactiledata.contract.atomic import write_json_atomic
from tactiledata.contract.provenance import digest_of
from tactiledata.errors import TactileDataError, UsageError

TOLERANCE = 1e-4
"""Largest difference to PyTorch, as a share of the largest value that a network gives."""
PACKAGES = ("onnx", "onnxruntime", "onnxscript")


class PictureLatents(nn.Module):
    """Mean latent vectors (n, d) of pictures (n, h, w, 3), uint8."""

    def __init__(self, vae: ImageVae) -> None:
        super().__init__()
        self.vae = vae

    def forward(self, pictures: Tensor) -> Tensor:
        """Latent vectors."""
        return self.vae.distribution(as_input(pictures))[0]


class LatentPictures(nn.Module):
    """Pictures (n, h, w, 3), 0 to 1, of latent vectors (n, d)."""

    def __init__(self, vae: ImageVae) -> None:
        super().__init__()
        self.vae = vae

    def forward(self, latent: Tensor) -> Tensor:
        """Pictures."""
        return self.vae.decode(latent).add(1.0).mul(0.5).permute(0, 2, 3, 1)


class MeshLatents(nn.Module):
    """Mean latent vectors (n, d) of displacements (n, v, 3), m."""

    def __init__(self, vae: MeshVae) -> None:
        super().__init__()
        self.vae = with_gathers(vae)

    def forward(self, displacements: Tensor) -> Tensor:
        """Latent vectors."""
        return self.vae.distribution(displacements)[0]


class LatentMeshes(nn.Module):
    """Displacements (n, v, 3), m, of latent vectors (n, d)."""

    def __init__(self, vae: MeshVae) -> None:
        super().__init__()
        self.vae = with_gathers(vae)

    def forward(self, latent: Tensor) -> Tensor:
        """Displacements."""
        return self.vae.decode(latent)


def split_onnx(recipe_run: RecipeRun) -> OnnxMeshToImage:
    """SPLIT's pictures of meshes by onnxruntime, on as many threads as PyTorch."""
    return OnnxMeshToImage(onnx_models(recipe_run))


def split_onnx_mesh(recipe_run: RecipeRun) -> OnnxImageToMesh:
    """SPLIT's meshes of pictures by onnxruntime, on as many threads as PyTorch."""
    return OnnxImageToMesh(onnx_models(recipe_run))


def onnx_models(recipe_run: RecipeRun) -> OnnxModels:
    """SPLIT's networks of a recipe, exported into ``out/onnx`` where they are not there yet.

    Raises
    ------
    UsageError
        The packages for ONNX are not installed.
    TactileDataError
        An exported network gives other values than PyTorch.
    """
    forth, back = recipe_run.projection("mesh_to_image", True), recipe_run.projection("image_to_mesh", True)
    vaes, keys = (recipe_run.image_vae, recipe_run.mesh_vae), recipe_run.kept.keys
    folder = recipe_run.out / "onnx" / digest_of(sorted(keys.items()))[:12]
    if not (folder / MODELS).exists():
        frames = recipe_run.frames("val")
        some = np.unique(np.linspace(0, len(frames) - 1, 4).astype(np.int64))
        export_models(folder, *vaes, forth, back, frames.pictures(some), frames.displacements(some))
    return OnnxModels(folder, threads=torch.get_num_threads())


def export_models(
    folder: Path,
    image_vae: ImageVae,
    mesh_vae: MeshVae,
    mesh_to_image: Projection,
    image_to_mesh: Projection,
    pictures: Any,
    displacements: Any,
) -> dict[str, Any]:
    """Write the six networks and ``models.json``; the document is given back.

    Parameters
    ----------
    folder : Path
    image_vae, mesh_vae, mesh_to_image, image_to_mesh
        Networks that belong together.
    pictures : (n, h, w, 3) uint8
    displacements : (n, v, 3) m
        To check the files on, two or more of each.

    Raises
    ------
    UsageError
        The packages for ONNX are not installed.
    TactileDataError
        An exported network gives other values than PyTorch.
    """
    require_packages()
    folder.mkdir(parents=True, exist_ok=True)
    shown, moved = torch.as_tensor(pictures), torch.as_tensor(displacements)
    given: dict[str, tuple[nn.Module, str, str, Tensor]] = {
        "image_encoder": (PictureLatents(image_vae), "pictures", "latent", shown),
        "mesh_encoder": (MeshLatents(mesh_vae), "displacements", "latent", moved),
    }
    with torch.no_grad():
        seen, felt = (given[name][0].cpu().eval()(given[name][3]) for name in given)
    given |= {
        "mesh_to_image": (mesh_to_image, "latent", "deformation", felt),
        "image_to_mesh": (image_to_mesh, "deformation", "latent", seen - seen[:1]),
        "image_decoder": (LatentPictures(image_vae), "latent", "pictures", seen),
        "mesh_decoder": (LatentMeshes(mesh_vae), "latent", "displacements", felt),
    }
    for name, (network, source, target, example) in given.items():
        write_network(folder / f"{name}.onnx", network, source, target, example)
    document = {
        "format": "tactiledata-onnx/1",
        "image_size": list(image_vae.size),
        "vertices": mesh_vae.hierarchy.sizes[0],
        "topology": mesh_vae.topology,
        "latent": {"image": image_vae.latent, "mesh": mesh_vae.latent},
        "files": {name: {"input": source, "output": target} for name, (_, source, target, _) in given.items()},
    }
    document["difference"] = _agreement(folder, document, {name: (one[0], one[3]) for name, one in given.items()})
    write_json_atomic(folder / MODELS, document)
    return document


def write_network(path: Path, network: nn.Module, source: str, target: str, example: Tensor) -> None:
    """An ONNX file of a network of one tensor (n, ...), for any n."""
    batch = torch.export.Dim("n", min=1)
    with _quiet_exporter():
        program = torch.onnx.export(
            network.cpu().eval(),
            (example,),
            dynamo=True,
            input_names=[source],
            output_names=[target],
            dynamic_shapes=({0: batch},),
            verbose=False,
        )
        assert program is not None  # without dynamo it would be
        program.save(str(path))


def require_packages() -> None:
    """Nothing, where the packages for ONNX are installed; else `UsageError`."""
    missing = [name for name in PACKAGES if find_spec(name) is None]
    if missing:
        raise UsageError(
            f"{', '.join(missing)} not installed",
            "what exports to ONNX",
            "pip install -c constraints.txt -e '.[models]'",
        )


def _agreement(
    folder: Path, document: Mapping[str, Any], networks: Mapping[str, tuple[nn.Module, Tensor]]
) -> dict[str, float]:
    """The largest difference of each file to PyTorch, as a share of the largest value."""
    models, found = OnnxModels(folder, document), {}
    for name, (network, example) in networks.items():
        with torch.no_grad():
            true = network(example).numpy()
        difference = float(np.abs(models.run(name, example.numpy()) - true).max() / max(np.abs(true).max(), 1e-12))
        if not difference <= TOLERANCE:
            raise TactileDataError(
                f"{folder / name}.onnx differs from PyTorch by {difference:.2g} of the largest value",
                f"at most {TOLERANCE:g}",
                "Its versions of torch and onnxruntime do not go together: install those of constraints.txt.",
            )
        found[name] = difference
    return found


@contextmanager
def _quiet_exporter() -> Iterator[None]:
    """The exporter warns of its own insides, and that torchvision, which nothing here needs, is not there."""
    log = logging.getLogger("torch.onnx._internal.exporter._registration")
    before = log.level
    log.setLevel(logging.ERROR)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        log.setLevel(before)
