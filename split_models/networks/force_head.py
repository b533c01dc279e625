"""Networks for contact forces: from latent vectors, or from the pretrained encoders of the VAEs, fine-tuned."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn

from split_models.networks.image_vae import ImageVae
from split_models.networks.mesh_vae import MeshVae
from split_models.networks.network import Network
from split_models.networks.perceptron import perceptron

Vae = ImageVae | MeshVae
VAES: dict[str, type[Vae]] = {ImageVae.kind: ImageVae, MeshVae.kind: MeshVae}


class Forces(Network):
    """A network whose scaled output stands for contact forces (n, 3): fx, fy, fz in N.

    Attributes
    ----------
    mean, spread : (3,) N
        Mean and standard deviation of the forces of the train part, by which outputs are scaled.
    """

    mean: Tensor
    spread: Tensor

    def keep_scale(self, mean: Sequence[float], spread: Sequence[float]) -> None:
        """Register mean and spread (3,), N, as buffers, so that they are saved with the weights."""
        self.register_buffer("mean", torch.as_tensor(mean).float())
        self.register_buffer("spread", torch.as_tensor(spread).float())

    def forces(self, inputs: Tensor) -> Tensor:
        """Contact forces (n, 3), N, for a batch of inputs of the network."""
        scaled: Tensor = self(inputs)
        return scaled * self.spread + self.mean


class ForceHead(Forces):
    """A perceptron from fixed latent vectors (n, inputs) to contact forces.

    Parameters
    ----------
    inputs : int
        Latent dimensions.
    layers : sequence of int
        Widths of the hidden layers.
    dropout : sequence of float
        Shares dropped after the first layers.
    mean, spread : (3,) N
        Mean and standard deviation of the forces of the train part.
    """

    kind = "force_head"

    def __init__(
        self,
        inputs: int,
        layers: Sequence[int] = (128, 512, 512, 128),
        dropout: Sequence[float] = (0.2, 0.2),
        mean: Sequence[float] = (0.0, 0.0, 0.0),
        spread: Sequence[float] = (1.0, 1.0, 1.0),
    ) -> None:
        super().__init__()
        self.settings = {"inputs": inputs, "layers": list(layers), "dropout": list(dropout)}
        self.layers = perceptron(inputs, layers, 3, dropout)
        self.keep_scale(mean, spread)

    def forward(self, latent: Tensor) -> Tensor:
        """Scaled forces (n, 3), dimensionless, for latent vectors (n, inputs)."""
        scaled: Tensor = self.layers(latent)
        return scaled


class RawForces(Forces):
    """Contact forces from meshes or pictures: a VAE's encoder whose bottleneck is replaced by one dense layer.

    Parameters
    ----------
    vae : ImageVae or MeshVae
        Its encoder is used without a copy and trained further; pass a copy.
    mean, spread : (3,) N
        Mean and standard deviation of the forces of the train part.
    """

    kind = "raw_forces"

    def __init__(
        self, vae: Vae, mean: Sequence[float] = (0.0, 0.0, 0.0), spread: Sequence[float] = (1.0, 1.0, 1.0)
    ) -> None:
        super().__init__()
        self.settings = {"encoder": vae.kind, "of": vae.settings}
        self.convolves = vae.convolves
        self._topology, self._extras = vae.topology, vae.extras()
        self.output = nn.Linear(vae.from_latent.out_features, 3)
        self.vae = _without_bottleneck(vae)
        self.keep_scale(mean, spread)

    @property
    def topology(self) -> str:
        """Digest of the mesh that the encoder is for; empty for an encoder of pictures."""
        return self._topology

    def extras(self) -> dict[str, Tensor]:
        """Tensors that the encoder is built from, beside settings and weights."""
        return self._extras

    @classmethod
    def rebuilt(cls, settings: Mapping[str, Any], extras: Mapping[str, Tensor], topology: str) -> RawForces:
        """The network that a checkpoint describes, with initial weights.

        Parameters
        ----------
        settings : dict
            ``encoder``, the kind of the VAE, and ``of``, its settings.
        extras : dict of Tensor
            Extras of the VAE.
        topology : str
            Digest of the VAE's mesh; empty for an image VAE.
        """
        return cls(VAES[settings["encoder"]].rebuilt(settings["of"], extras, topology))

    def forward(self, inputs: Tensor) -> Tensor:
        """Scaled forces (n, 3), dimensionless, for a batch of the encoder's inputs."""
        scaled: Tensor = self.output(self.vae.features(inputs))
        return scaled


def _without_bottleneck(vae: Vae) -> Vae:
    """The VAE without its bottleneck and decoder, whose parameters would receive no gradient."""
    for name in ("to_mean", "to_log_variance", "decoder", "from_latent"):
        setattr(vae, name, nn.Identity())
    return vae


def predicted_forces(head: Forces, given: Tensor) -> np.ndarray:
    """Contact forces (n, 3), N, that a trained network predicts for a batch of its inputs."""
    with torch.no_grad():
        forces: Tensor = head.forces(given.to(head.device)).float().cpu()
    return forces.numpy()
