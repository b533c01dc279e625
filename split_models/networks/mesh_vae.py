"""The mesh beta-VAE: Chebyshev graph convolutions over a mesh that is pooled four times (CoMA)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.sparse import csr_array
from torch import Tensor, nn

from split_models.networks.latent_normal import draw
from split_models.networks.mesh_graph import Hierarchy
from split_models.networks.network import Network
from split_models.networks.sparse_map import SparseMap


class ChebyshevConvolution(nn.Module):
    """A graph convolution: a learned polynomial of the scaled Laplacian in Chebyshev's basis.

    Parameters
    ----------
    laplacian : Module
        The scaled Laplacian as a `SparseMap`.
    inputs, outputs : int
        Features of a vertex before and after.
    order : int
        Number of polynomials, K.

    Source: Defferrard et al. 2016, equation 4.
    """

    def __init__(self, laplacian: nn.Module, inputs: int, outputs: int, order: int) -> None:
        super().__init__()
        self.laplacian = laplacian
        self.order = order
        self.mix = nn.Linear(order * inputs, outputs)

    def forward(self, values: Tensor) -> Tensor:
        """Features (v, n, outputs) of features (v, n, inputs)."""
        terms = [values]
        if self.order > 1:
            terms.append(self.laplacian(values))
        for _ in range(2, self.order):
            terms.append(2.0 * self.laplacian(terms[-1]) - terms[-2])
        mixed: Tensor = self.mix(torch.cat(terms, dim=-1))
        return mixed


class MeshMaps(nn.Module):
    """The constant sparse matrices of a mesh's levels: Laplacians, pooling and interpolation."""

    def __init__(self, hierarchy: Hierarchy) -> None:
        super().__init__()
        self.sizes = hierarchy.sizes
        self.laplacians = _maps(hierarchy.laplacians[:-1])
        self.down = _maps(hierarchy.down)
        self.up = _maps(hierarchy.up)


def _maps(matrices: Sequence[csr_array]) -> nn.ModuleList:
    """Each sparse matrix as a `SparseMap`."""
    return nn.ModuleList(SparseMap(matrix) for matrix in matrices)


class MeshEncoder(nn.Module):
    """Convolution, ReLU and pooling at each level: scaled displacements (v, n, 3) become features (n, f)."""

    def __init__(self, maps: MeshMaps, filters: Sequence[int], order: int) -> None:
        super().__init__()
        self.maps = maps
        widths = [3, *filters]
        self.layers = nn.ModuleList(
            ChebyshevConvolution(maps.laplacians[level], inputs, outputs, order)
            for level, (inputs, outputs) in enumerate(pairwise(widths))
        )
        self.features = maps.sizes[len(filters)] * filters[-1]

    def forward(self, values: Tensor) -> Tensor:
        """Features (n, f) of scaled displacements (v, n, 3); f is the coarsest level's vertices times its filters."""
        for layer, pool in zip(self.layers, self.maps.down, strict=True):
            values = pool(torch.relu(layer(values)))
        return values.transpose(0, 1).flatten(1)


class MeshDecoder(nn.Module):
    """The mirror of `MeshEncoder`: features (n, f) become scaled displacements (v, n, 3)."""

    def __init__(self, maps: MeshMaps, filters: Sequence[int], order: int) -> None:
        super().__init__()
        self.maps = maps
        self.width = filters[-1]
        widths = [3, *filters]
        self.layers = nn.ModuleList(
            ChebyshevConvolution(maps.laplacians[level], widths[level + 1], widths[level], order)
            for level in reversed(range(len(filters)))
        )

    def forward(self, features: Tensor) -> Tensor:
        """Scaled displacements (v, n, 3) of features (n, f)."""
        values = features.unflatten(1, (-1, self.width)).transpose(0, 1)
        for step, (layer, lift) in enumerate(zip(self.layers, reversed(list(self.maps.up)), strict=True)):
            values = layer(lift(values))
            if step < len(self.layers) - 1:
                values = torch.relu(values)
        return values


class MeshVae(Network):
    """A beta-VAE of displacements on one mesh topology.

    Parameters
    ----------
    hierarchy : Hierarchy
        The mesh and its coarser levels.
    filters : (levels - 1,) int
        Features of a vertex after each of the encoder's convolutions; the decoder mirrors them.
    order : int
        Chebyshev polynomials of each convolution.
    latent : int
        Latent dimensions.
    mean, spread : (v, 3) m
        Mean and standard deviation of the train part's displacements, vertex by vertex; 0 and 1 unless given.
    """

    kind = "mesh_vae"
    mean: Tensor
    spread: Tensor

    def __init__(
        self,
        hierarchy: Hierarchy,
        filters: Sequence[int] = (16, 16, 16, 32),
        order: int = 6,
        latent: int = 128,
        mean: NDArray[np.floating[Any]] | None = None,
        spread: NDArray[np.floating[Any]] | None = None,
    ) -> None:
        super().__init__()
        self.hierarchy = hierarchy
        self.settings = {"filters": list(filters), "order": order, "latent": latent}
        maps = MeshMaps(hierarchy)
        self.encoder = MeshEncoder(maps, filters, order)
        self.decoder = MeshDecoder(maps, filters, order)
        self.latent = latent
        self.to_mean = nn.Linear(self.encoder.features, latent)
        self.to_log_variance = nn.Linear(self.encoder.features, latent)
        self.from_latent = nn.Linear(latent, self.encoder.features)
        count = hierarchy.sizes[0]
        self.register_buffer("mean", torch.as_tensor(np.zeros((count, 3)) if mean is None else mean).float())
        self.register_buffer("spread", torch.as_tensor(np.ones((count, 3)) if spread is None else spread).float())

    def scaled(self, displacements: Tensor) -> Tensor:
        """Displacements (n, v, 3), m, scaled to mean 0 and standard deviation 1 at every vertex."""
        return (displacements - self.mean) / self.spread

    def unscaled(self, values: Tensor) -> Tensor:
        """Displacements (n, v, 3), m, from scaled ones; the inverse of `scaled`."""
        return values * self.spread + self.mean

    def features(self, displacements: Tensor) -> Tensor:
        """Encoder features (n, f) of displacements (n, v, 3), m."""
        features: Tensor = self.encoder(self.scaled(displacements).transpose(0, 1))
        return features

    def distribution(self, displacements: Tensor) -> tuple[Tensor, Tensor]:
        """Mean and log variance (n, latent) of displacements (n, v, 3), m."""
        features = self.features(displacements)
        return self.to_mean(features), self.to_log_variance(features)

    def decode_scaled(self, latent: Tensor) -> Tensor:
        """Scaled displacements (n, v, 3) of latent vectors (n, latent)."""
        decoded: Tensor = self.decoder(self.from_latent(latent)).transpose(0, 1)
        return decoded

    def decode(self, latent: Tensor) -> Tensor:
        """Displacements (n, v, 3), m, of latent vectors (n, latent)."""
        return self.unscaled(self.decode_scaled(latent))

    def forward(self, displacements: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Scaled reconstruction (n, v, 3), mean and log variance (n, latent); training decodes a sample."""
        mean, log_variance = self.distribution(displacements)
        return self.decode_scaled(draw(mean, log_variance) if self.training else mean), mean, log_variance

    def extras(self) -> dict[str, Tensor]:
        """Arrays of the mesh's levels, so that a checkpoint can rebuild the mesh."""
        return {name: torch.as_tensor(values) for name, values in self.hierarchy.arrays().items()}

    @property
    def topology(self) -> str:
        """Digest of the mesh that the network is for."""
        return self.hierarchy.digest

    @classmethod
    def rebuilt(cls, settings: Mapping[str, Any], extras: Mapping[str, Tensor], topology: str) -> MeshVae:
        """The network that a checkpoint describes, with initial weights.

        Parameters
        ----------
        settings : dict
            ``filters``, ``order`` and ``latent``.
        extras : dict of Tensor
            Arrays of the mesh's levels.
        topology : str
            Digest of the mesh.
        """
        arrays = {name: values.numpy() for name, values in extras.items()}
        return cls(Hierarchy.from_arrays(topology, arrays), **settings)
