"""Latent arithmetic: encode, subtract the background, project, add a background, decode."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import torch
from torch import Tensor

from split_models.networks.end_to_end import EndToEnd
from split_models.networks.image_vae import ImageVae, as_input, as_pictures
from split_models.networks.latent_normal import draw
from split_models.networks.mesh_vae import MeshVae
from split_models.networks.network import Network
from split_models.networks.network_inputs import require_displacements, require_pictures
from split_models.networks.projection import Projection
from tactiledata.arrays import PictureArray, SingleArray
from tactiledata.errors import CheckpointError

Latents = Literal["mean", "sample"]
Steps = list[tuple[str, Callable[[Any], Any]]]
"""Named functions to apply in order: each takes the result of the function before it."""
CHUNK = 64
"""Frames that go through a network together, which limits memory."""


def encode_pictures(vae: ImageVae, pictures: PictureArray, latents: Latents = "mean") -> Tensor:
    """Latent vectors (n, d), on the CPU, of pictures (n, h, w, 3), uint8.

    Parameters
    ----------
    vae : ImageVae
    pictures : (n, h, w, 3) uint8 RGB
        Pictures of the size that the VAE was trained on.
    latents : "mean" or "sample"
        Whether a vector is the mean of the encoder's distribution or a sample of it.

    Raises
    ------
    UsageError
        The pictures have another size than the VAE's.
    """
    require_pictures(vae.size, pictures)
    return _in_chunks(vae, pictures, lambda chunk: _chosen(vae.distribution(as_input(chunk)), latents))


def encode_displacements(vae: MeshVae, displacements: SingleArray, latents: Latents = "mean") -> Tensor:
    """Latent vectors (n, d), on the CPU, of displacements (n, v, 3), m.

    Parameters
    ----------
    vae : MeshVae
    displacements : (n, v, 3) m, gel frame
        Displacements on the mesh that the VAE was trained on.
    latents : "mean" or "sample"
        Whether a vector is the mean of the encoder's distribution or a sample of it.

    Raises
    ------
    UsageError
        The number of vertices is not the VAE's, or displacements are NaN.
    """
    require_displacements(vae.hierarchy.sizes[0], displacements)
    return _in_chunks(vae, displacements, lambda chunk: _chosen(vae.distribution(chunk), latents))


def decode_pictures(vae: ImageVae, latent: Tensor) -> PictureArray:
    """Pictures (n, h, w, 3), uint8, that the VAE decodes from latent vectors (n, d)."""
    return _in_chunks(vae, latent, lambda chunk: as_pictures(vae.decode(chunk))).numpy()


def decode_displacements(vae: MeshVae, latent: Tensor) -> SingleArray:
    """Displacements (n, v, 3), m, that the VAE decodes from latent vectors (n, d)."""
    return _in_chunks(vae, latent, vae.decode).numpy()


def project(projection: Projection, latent: Tensor) -> Tensor:
    """Latent vectors (n, outputs), on the CPU, that the projection gives for latent vectors (n, inputs)."""
    return _in_chunks(projection, latent, projection)


def subtract(latent: Tensor, background: Tensor) -> Tensor:
    """Latent vectors of the deformation: Z_Deform = Z_Image - Z_Base."""
    return latent - background


def add(deformation: Tensor, background: Tensor) -> Tensor:
    """Latent vectors of the picture: Z_Image = Z_Deform + Z_Base."""
    return deformation + background


@dataclass(frozen=True)
class LatentMeshToImage:
    """Pictures of meshes by two VAEs and a projection: SPLIT with latent arithmetic, NOSPLIT without.

    Parameters
    ----------
    name : str
        Name of the row in tables.
    mesh_vae : MeshVae
    image_vae : ImageVae
    projection : Projection
        From the mesh's latent space to the picture's.
    is_split : bool
        Whether the projection gives the deformation's vector, to which the background's is added.
    latents : "mean" or "sample"
        How the mesh's latent vectors are taken from the encoder's distribution.

    Raises
    ------
    CheckpointError
        The latent vectors of the networks have different sizes.
    """

    name: str
    mesh_vae: MeshVae
    image_vae: ImageVae
    projection: Projection
    is_split: bool = True
    latents: Latents = "mean"

    def __post_init__(self) -> None:
        _require_fit(self.projection, self.mesh_vae.latent, self.image_vae.latent)

    def predict(self, displacements: SingleArray, background: PictureArray) -> PictureArray:
        """Pictures (n, h, w, 3), uint8, of displacements (n, v, 3), m, on a background (h, w, 3)."""
        projected = project(self.projection, encode_displacements(self.mesh_vae, displacements, self.latents))
        if self.is_split:
            projected = add(projected, encode_pictures(self.image_vae, background[None]))
        return decode_pictures(self.image_vae, projected)

    def steps(self, background: PictureArray) -> Steps:
        """The steps of `predict` as named functions; the background is encoded once for all frames."""
        base = encode_pictures(self.image_vae, background[None]) if self.is_split else torch.zeros(1)
        return [
            ("mesh encoder", lambda moved: encode_displacements(self.mesh_vae, moved, self.latents)),
            ("projection", lambda latent: add(project(self.projection, latent), base)),
            ("decoder", lambda latent: decode_pictures(self.image_vae, latent)),
        ]


@dataclass(frozen=True)
class SplitOnBackground:
    """SPLIT's change of the picture, added to the recorded background, which decoding would blur.

    Beyond the paper: background + decode(Z_Deform + Z_Base) - decode(Z_Base).
    """

    name: str
    split: LatentMeshToImage

    def predict(self, displacements: SingleArray, background: PictureArray) -> PictureArray:
        """Pictures (n, h, w, 3), uint8, of displacements (n, v, 3), m, on a background (h, w, 3)."""
        vae = self.split.image_vae
        untouched = decode_pictures(vae, encode_pictures(vae, background[None])).astype(np.int16)
        change = self.split.predict(displacements, background) - untouched
        return np.clip(background + change, 0, 255).astype(np.uint8)


@dataclass(frozen=True)
class LatentImageToMesh:
    """Meshes of pictures by two VAEs and a projection: SPLIT with latent arithmetic, NOSPLIT without.

    Parameters
    ----------
    name : str
        Name of the row in tables.
    image_vae : ImageVae
    mesh_vae : MeshVae
    projection : Projection
        From the picture's latent space to the mesh's.
    is_split : bool
        Whether the background's vector is subtracted before the projection.
    latents : "mean" or "sample"
        How the pictures' latent vectors are taken from the encoder's distribution.

    Raises
    ------
    CheckpointError
        The latent vectors of the networks have different sizes.
    """

    name: str
    image_vae: ImageVae
    mesh_vae: MeshVae
    projection: Projection
    is_split: bool = True
    latents: Latents = "mean"

    def __post_init__(self) -> None:
        _require_fit(self.projection, self.image_vae.latent, self.mesh_vae.latent)

    def latent(self, pictures: PictureArray, background: PictureArray) -> Tensor:
        """The mesh's latent vectors (n, d) for pictures (n, h, w, 3) of a sensor with a background (h, w, 3)."""
        latent = encode_pictures(self.image_vae, pictures, self.latents)
        if self.is_split:
            latent = subtract(latent, encode_pictures(self.image_vae, background[None]))
        return project(self.projection, latent)

    def predict(self, pictures: PictureArray, background: PictureArray) -> SingleArray:
        """Displacements (n, v, 3), m, of pictures (n, h, w, 3) of a sensor with a background (h, w, 3)."""
        return decode_displacements(self.mesh_vae, self.latent(pictures, background))


@dataclass(frozen=True)
class DirectMeshToImage:
    """Pictures of meshes by the end-to-end network, which does not get the background."""

    name: str
    network: EndToEnd

    def predict(self, displacements: SingleArray, background: PictureArray) -> PictureArray:
        """Pictures (n, h, w, 3), uint8, of displacements (n, v, 3), m."""
        require_displacements(len(self.network.mean), displacements)
        return _in_chunks(self.network, displacements, lambda chunk: as_pictures(self.network(chunk))).numpy()


@dataclass(frozen=True)
class NoContact:
    """The background itself as the picture of every mesh: the baseline that any method must beat."""

    name: str = "no_contact"

    def predict(self, displacements: SingleArray, background: PictureArray) -> PictureArray:
        """The background (h, w, 3), repeated n times."""
        return np.broadcast_to(background, (len(displacements), *background.shape)).copy()


@dataclass(frozen=True)
class AtRest:
    """The undeformed mesh for every picture: the baseline that any method must beat."""

    vertices: int
    name: str = "at_rest"

    def predict(self, pictures: PictureArray, background: PictureArray) -> SingleArray:
        """Displacements of 0, (n, v, 3), m."""
        return np.zeros((len(pictures), self.vertices, 3), np.float32)


def _require_fit(projection: Projection, inputs: int, outputs: int) -> None:
    """Refuse a projection whose input or output size differs from those of the VAEs."""
    sizes = projection.settings["inputs"], projection.settings["outputs"]
    if sizes != (inputs, outputs):
        raise CheckpointError(
            f"a projection from {sizes[0]} to {sizes[1]} latent dimensions",
            f"from {inputs} to {outputs}, the latent dimensions of the VAEs",
            "Train the projection with these VAEs.",
        )


def _chosen(distribution: tuple[Tensor, Tensor], latents: Latents) -> Tensor:
    """Mean of the distribution, or a sample of it, (n, d)."""
    mean, log_variance = distribution
    return draw(mean, log_variance) if latents == "sample" else mean


@torch.no_grad()
def _in_chunks(network: Network, values: Any, work: Callable[[Tensor], Tensor]) -> Tensor:
    """Results of ``work`` for all values (n, ...), `CHUNK` at a time on the network's device, gathered on the CPU."""
    network.eval()

    def results() -> Iterator[Tensor]:
        for start in range(0, len(values), CHUNK):
            chunk = torch.as_tensor(values[start : start + CHUNK]).to(network.device)
            yield work(chunk).cpu()

    return torch.cat(list(results()))
