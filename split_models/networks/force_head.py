"""Contact forces from latent vectors, or from the pretrained encoders of the VAEs, fine-tuned."""

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
    """A network that gives (n, 3) forces: fx, fy, fz, N, of its scaled output.

    Parameters
    ----------
    mean, spread : (3,) N
        Of the train part.
    """

    mean: Tensor
    spread: Tensor

    def keep_scale(self, mean: Sequence[float], spread: Sequence[float]) -> None:
        """Take mean and spread as buffers."""
        self.register_buffer("mean", torch.as_tensor(mean).float())
        self.register_buffer("spread", torch.as_tensor(spread).float())

    def forces(self, inputs: Tensor) -> Tensor:
        """Forces (n, 3), N."""
        scaled: Tensor = self(inputs)
        return scaled * self.spread + self.mean


class ForceHead(Forces):
    """Forces from fixed latent vectors (n, inputs)."""

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
        """Forces (n, 3), scaled, of latent vectors."""
        scaled: Tensor = self.layers(latent)
        return scaled


class RawForces(Forces):
    """Forces from meshes or pictures: a VAE's encoder, its bottleneck replaced by one dense layer.

    Parameters
    ----------
    vae : ImageVae or MeshVae
        Its encoder is taken as it is, and learns on; hand a copy.
    mean, spread : (3,) N
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
        """That of the encoder."""
        return self._topology

    def extras(self) -> dict[str, Tensor]:
        """Those of the encoder."""
        return self._extras

    @classmethod
    def rebuilt(cls, settings: Mapping[str, Any], extras: Mapping[str, Tensor], topology: str) -> RawForces:
        """The network of a checkpoint, before its weights are loaded."""
        return cls(VAES[settings["encoder"]].rebuilt(settings["of"], extras, topology))

    def forward(self, inputs: Tensor) -> Tensor:
        """Forces (n, 3), scaled, of what the encoder takes."""
        scaled: Tensor = self.output(self.vae.features(inputs))
        return scaled


def _without_bottleneck(vae: Vae) -> Vae:
    """The VAE without what only decoding needs: parameters that take part in no gradient."""
    for name in ("to_mean", "to_log_variance", "decoder", "from_latent"):
        setattr(vae, name, nn.Identity())
    return vae


def predicted_forces(head: Forces, given: Tensor) -> np.ndarray:
    """Forces (n, 3), N, of what a head takes."""
    with torch.no_grad():
        forces: Tensor = head.forces(given.to(head.device)).float().cpu()
    return forces.numpy()
