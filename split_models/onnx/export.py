"""SPLIT's networks as ONNX files, which run without PyTorch; each is compared with PyTorch when it is written."""

from __future__ import annotations

import logging
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
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
from tactiledata.contract.extras import need_packages
from tactiledata.contract.provenance import digest_of
from tactiledata.errors import TactileDataError

TOLERANCE = 1e-4
"""Largest accepted difference to PyTorch, as a share of the largest value that a network gives."""
PACKAGES = ("onnx", "onnxruntime", "onnxscript")
"""Packages that an export needs."""


class PictureLatents(nn.Module):
    """Network from pictures (n, h, w, 3), uint8, to their mean latent vectors (n, d)."""

    def __init__(self, vae: ImageVae) -> None:
        super().__init__()
        self.vae = vae

    def forward(self, pictures: Tensor) -> Tensor:
        """Mean latent vectors (n, d) of pictures (n, h, w, 3), uint8."""
        return self.vae.distribution(as_input(pictures))[0]


class LatentPictures(nn.Module):
    """Network from latent vectors (n, d) to pictures (n, h, w, 3) in [0, 1]."""

    def __init__(self, vae: ImageVae) -> None:
        super().__init__()
        self.vae = vae

    def forward(self, latent: Tensor) -> Tensor:
        """Pictures (n, h, w, 3) in [0, 1] of latent vectors (n, d)."""
        return self.vae.decode(latent).add(1.0).mul(0.5).permute(0, 2, 3, 1)


class MeshLatents(nn.Module):
    """Network from displacements (n, v, 3), m, to their mean latent vectors (n, d)."""

    def __init__(self, vae: MeshVae) -> None:
        super().__init__()
        self.vae = with_gathers(vae)

    def forward(self, displacements: Tensor) -> Tensor:
        """Mean latent vectors (n, d) of displacements (n, v, 3), m."""
        return self.vae.distribution(displacements)[0]


class LatentMeshes(nn.Module):
    """Network from latent vectors (n, d) to displacements (n, v, 3), m."""

    def __init__(self, vae: MeshVae) -> None:
        super().__init__()
        self.vae = with_gathers(vae)

    def forward(self, latent: Tensor) -> Tensor:
        """Displacements (n, v, 3), m, of latent vectors (n, d)."""
        return self.vae.decode(latent)


def split_onnx(recipe_run: RecipeRun) -> OnnxMeshToImage:
    """SPLIT from meshes to pictures by onnxruntime, with as many threads as PyTorch uses."""
    return OnnxMeshToImage(onnx_models(recipe_run))


def split_onnx_mesh(recipe_run: RecipeRun) -> OnnxImageToMesh:
    """SPLIT from pictures to meshes by onnxruntime, with as many threads as PyTorch uses."""
    return OnnxImageToMesh(onnx_models(recipe_run))


def onnx_models(recipe_run: RecipeRun) -> OnnxModels:
    """SPLIT's networks of a recipe, exported into ``out/onnx`` unless they are there already.

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
        examples = np.unique(np.linspace(0, len(frames) - 1, 4).astype(np.int64))
        export_models(folder, *vaes, forth, back, frames.pictures(examples), frames.displacements(examples))
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
    """Write the six networks of SPLIT and ``models.json``, whose document is returned.

    Parameters
    ----------
    folder : Path
        Folder to write into; it is made where it is missing.
    image_vae, mesh_vae, mesh_to_image, image_to_mesh
        Networks that were trained together.
    pictures : (n, h, w, 3) uint8
    displacements : (n, v, 3) m
        Examples on which the files are compared with PyTorch, two or more of each.

    Raises
    ------
    UsageError
        The packages for ONNX are not installed.
    TactileDataError
        An exported network gives other values than PyTorch.
    """
    # each network with the names of its input and output, and an example of the input
    need_packages("an export to ONNX", *PACKAGES)
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
    # the document tells a reader sizes, inputs and outputs without opening the files
    document = {
        "format": "tactiledata-onnx/1",
        "image_size": list(image_vae.size),
        "vertices": mesh_vae.hierarchy.sizes[0],
        "topology": mesh_vae.topology,
        "latent": {"image": image_vae.latent, "mesh": mesh_vae.latent},
        "files": {name: {"input": source, "output": target} for name, (_, source, target, _) in given.items()},
    }
    document["difference"] = _agreement(folder, document, {name: (entry[0], entry[3]) for name, entry in given.items()})
    write_json_atomic(folder / MODELS, document)
    return document


def write_network(path: Path, network: nn.Module, source: str, target: str, example: Tensor) -> None:
    """Write an ONNX file of a network with one input tensor (n, ...), for any number n.

    Parameters
    ----------
    path : Path
    network : Module
    source, target : str
        Names of the input and of the output.
    example : (n, ...) Tensor
        An input by which the network is traced.
    """
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


def _agreement(
    folder: Path, document: Mapping[str, Any], networks: Mapping[str, tuple[nn.Module, Tensor]]
) -> dict[str, float]:
    """Largest difference of each file to PyTorch, as a share of the largest value; one above the limit is refused."""
    models, differences = OnnxModels(folder, document), {}
    for name, (network, example) in networks.items():
        with torch.no_grad():
            true = network(example).numpy()
        difference = float(np.abs(models.run(name, example.numpy()) - true).max() / max(np.abs(true).max(), 1e-12))
        if not difference <= TOLERANCE:
            raise TactileDataError(
                f"{folder / name}.onnx differs from PyTorch by {difference:.2g} of the largest value",
                f"at most {TOLERANCE:g}",
                "The versions of torch and onnxruntime do not fit each other: install those of constraints.txt.",
            )
        differences[name] = difference
    return differences


@contextmanager
def _quiet_exporter() -> Iterator[None]:
    """Within the context the exporter's warnings are silent; they concern its internals and missing torchvision."""
    log = logging.getLogger("torch.onnx._internal.exporter._registration")
    before = log.level
    log.setLevel(logging.ERROR)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        log.setLevel(before)
