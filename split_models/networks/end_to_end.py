"""The baseline with one latent space: a single autoencoder from a mesh to its picture."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from split_models.networks.image_vae import ImageVae
from split_models.networks.mesh_graph import Hierarchy
from split_models.networks.mesh_vae import MeshVae
from split_models.networks.network import Network


class EndToEnd(Network):
    """The mesh VAE's encoder and the image VAE's decoder with one vector between them, trained together from scratch.

    The network does not get the background, as in the paper.

    Parameters
    ----------
    hierarchy : Hierarchy
        The mesh and its coarser levels.
    mesh : dict
        ``filters`` and ``order``, as for `MeshVae`.
    image : dict
        Settings as for `ImageVae`; ``latent`` is the size of the vector between encoder and decoder.
    mean, spread : (v, 3) m, optional
        Mean and standard deviation of the train part's displacements, vertex by vertex.
    """

    kind = "end_to_end"
    convolves = True
    mean: Tensor
    spread: Tensor

    def __init__(
        self,
        hierarchy: Hierarchy,
        mesh: Mapping[str, Any],
        image: Mapping[str, Any],
        mean: NDArray[np.floating[Any]] | None = None,
        spread: NDArray[np.floating[Any]] | None = None,
    ) -> None:
        super().__init__()
        self.settings = {"mesh": dict(mesh), "image": dict(image)}
        vae, pictures = MeshVae(hierarchy, **mesh, mean=mean, spread=spread), ImageVae(**image)
        self._topology, self._extras = vae.topology, vae.extras()
        self.size = pictures.size
        self.inner: Sequence[int] = pictures.inner
        self.encoder = vae.encoder
        self.register_buffer("mean", vae.mean)
        self.register_buffer("spread", vae.spread)
        self.to_latent = nn.Linear(vae.encoder.features, pictures.latent)
        self.from_latent = pictures.from_latent
        self.decoder = pictures.decoder

    @property
    def topology(self) -> str:
        """Digest of the mesh that the network is for."""
        return self._topology

    def extras(self) -> dict[str, Tensor]:
        """Arrays of the mesh's levels, so that a checkpoint can rebuild the network."""
        return self._extras

    @classmethod
    def rebuilt(cls, settings: Mapping[str, Any], extras: Mapping[str, Tensor], topology: str) -> EndToEnd:
        """The network that a checkpoint describes, with initial weights.

        Parameters
        ----------
        settings : dict
            ``mesh`` and ``image``, the arguments of the class.
        extras : dict of Tensor
            Arrays of the mesh's levels.
        topology : str
            Digest of the mesh.
        """
        arrays = {name: values.numpy() for name, values in extras.items()}
        return cls(Hierarchy.from_arrays(topology, arrays), **settings)

    def forward(self, displacements: Tensor) -> Tensor:
        """Pictures (n, 3, h, w) in [-1, 1] of displacements (n, v, 3), m."""
        scaled = ((displacements - self.mean) / self.spread).transpose(0, 1)
        latent = torch.tanh(self.to_latent(self.encoder(scaled)))
        pictures: Tensor = self.decoder(self.from_latent(latent).unflatten(1, tuple(self.inner)))
        return pictures
