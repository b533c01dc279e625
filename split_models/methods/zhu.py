"""Zhu et al. 2022 as a baseline: a graph network from pictures to meshes, adapted to real pictures without meshes.

Source: Zhu et al., Learning to synthesize volumetric meshes from vision-based tactile imprints, 2022. A network is
trained on imprints that are rendered of simulated meshes, with augmentation. On real pictures it is trained without
their meshes: the predicted mesh is rendered differentiably and compared with the imprint in the picture. The network
never learns which picture belongs to which mesh.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import cv2
import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from split_models.learning.data import TouchFrames
from split_models.learning.items import Batch, frame_of
from split_models.learning.objectives import Losses, Objective
from split_models.methods.depth_rendering import DepthRenderer
from split_models.networks.latent_normal import annealed
from split_models.networks.mesh_graph import Hierarchy
from split_models.networks.mesh_vae import MeshDecoder, MeshMaps
from split_models.networks.network import Network
from tactiledata.contract.provenance import digest_of
from tactiledata.errors import UsageError

LEVELS = 48.0
"""Change in grey levels that counts as a strong imprint."""
NOISE, GAIN_SPREAD = 0.03, 0.4
"""Augmentation of rendered imprints: standard deviations of the noise and of the logarithm of the gain."""
GAIN = 1.5
"""Imprint per slope before training."""
CHUNK = 64
"""Pictures that go through the network together."""


class ZhuNetwork(Network):
    """Displacements (n, v, 3), m, of imprints (n, 1, rows, columns): convolutions, then the mesh decoder.

    Parameters
    ----------
    hierarchy : Hierarchy
        The mesh and its coarser levels.
    size : (rows, columns)
        Size of the imprints.
    channels : sequence of int
        Widths of the convolutions, each of which halves the imprint.
    filters, order
        Filters and Chebyshev polynomials of the mesh decoder, as for `MeshVae`.
    mean, spread : (v, 3) m, optional
        Mean and standard deviation of the train part's displacements, vertex by vertex.
    """

    kind = "zhu"
    mean: Tensor
    spread: Tensor

    def __init__(
        self,
        hierarchy: Hierarchy,
        size: Sequence[int] = (80, 60),
        channels: Sequence[int] = (16, 32, 64, 64),
        filters: Sequence[int] = (16, 16, 16, 32),
        order: int = 6,
        mean: NDArray[np.floating[Any]] | None = None,
        spread: NDArray[np.floating[Any]] | None = None,
    ) -> None:
        super().__init__()
        self.hierarchy = hierarchy
        self.settings = {"size": list(size), "channels": list(channels), "filters": list(filters), "order": order}
        self.size = (int(size[0]), int(size[1]))
        layers: list[nn.Module] = []
        for inputs, outputs in pairwise([1, *channels]):
            layers += [nn.Conv2d(inputs, outputs, 3, stride=2, padding=1), nn.ELU()]
        self.encoder = nn.Sequential(*layers, nn.Flatten())
        with torch.no_grad():
            features = self.encoder(torch.zeros(1, 1, *self.size)).shape[1]
        maps = MeshMaps(hierarchy)
        self.to_mesh = nn.Linear(features, maps.sizes[len(filters)] * filters[-1])
        self.decoder = MeshDecoder(maps, filters, order)
        self.log_gain = nn.Parameter(torch.tensor(float(np.log(GAIN))))
        count = hierarchy.sizes[0]
        self.register_buffer("mean", torch.as_tensor(np.zeros((count, 3)) if mean is None else mean).float())
        self.register_buffer("spread", torch.as_tensor(np.ones((count, 3)) if spread is None else spread).float())

    def forward(self, imprints: Tensor) -> Tensor:
        """Displacements (n, v, 3), m, of imprints (n, 1, rows, columns)."""
        scaled = self.decoder(self.to_mesh(self.encoder(imprints))).transpose(0, 1)
        displacements: Tensor = scaled * self.spread + self.mean
        return displacements

    @property
    def topology(self) -> str:
        """Digest of the mesh that the network is for."""
        return self.hierarchy.digest

    def extras(self) -> dict[str, Tensor]:
        """Arrays of the mesh's levels, so that a checkpoint can rebuild the network."""
        return {name: torch.as_tensor(values) for name, values in self.hierarchy.arrays().items()}

    @classmethod
    def rebuilt(cls, settings: Mapping[str, Any], extras: Mapping[str, Tensor], topology: str) -> ZhuNetwork:
        """The network that a checkpoint describes, with initial weights.

        Parameters
        ----------
        settings : dict
            ``size``, ``channels``, ``filters`` and ``order``.
        extras : dict of Tensor
            Arrays of the mesh's levels.
        topology : str
            Digest of the mesh.
        """
        arrays = {name: values.numpy() for name, values in extras.items()}
        return cls(Hierarchy.from_arrays(topology, arrays), **settings)


def imprints_of(pictures: NDArray[np.uint8], background: NDArray[np.uint8], size: tuple[int, int]) -> Tensor:
    """Imprints (n, 1, rows, columns), 0 to 1, of pictures of a unit: the largest change of any channel, smoothed.

    Parameters
    ----------
    pictures : (n, h, w, 3) uint8
    background : (h, w, 3) uint8
        The unit's picture without contact.
    size : (rows, columns)
        Size of the imprints.

    Raises
    ------
    UsageError
        The background has another shape than the pictures.
    """
    if pictures.shape[1:] != background.shape:
        raise UsageError(f"pictures of {pictures.shape[1:]} on a background of {background.shape}", "one shape", "")
    seen = np.empty((len(pictures), 1, *size), np.float32)
    for row, picture in enumerate(pictures):
        change = np.abs(picture.astype(np.float32) - background).max(axis=2)
        small: Any = cv2.resize(change, size[::-1], interpolation=cv2.INTER_AREA)
        seen[row, 0] = cv2.GaussianBlur(small, (0, 0), 1.0)
    return torch.tanh(torch.from_numpy(seen) / LEVELS)


class ImprintItems:
    """Meshes (n, v, 3), m, of some frames with imprints (n, 1, rows, columns) of other frames, so that no pair matches.

    Parameters
    ----------
    frames : TouchFrames
    size : (rows, columns)
        Size of the imprints.
    """

    def __init__(self, frames: TouchFrames, size: tuple[int, int]) -> None:
        self.frames, self.size = frames, size
        self._others = np.random.default_rng(0).permutation(len(frames))

    @property
    def fingerprint(self) -> str:
        """Digest of the frames and of the imprints' size."""
        return digest_of([self.frames.fingerprint, "imprints", list(self.size)])

    def __len__(self) -> int:
        return len(self.frames)

    def batch(self, numbers: Sequence[int]) -> Batch:
        """``mesh`` of items by their number, and ``imprint`` of other items."""
        others = self._others[np.asarray(numbers, np.int64)]
        pictures, sensors = self.frames.pictures(others), self.frames.sensors[others]
        imprints = torch.empty(len(others), 1, *self.size)
        for sensor in set(sensors):
            mine = np.flatnonzero(sensors == sensor)
            imprints[torch.from_numpy(mine)] = imprints_of(pictures[mine], self.frames.background(sensor), self.size)
        return {"mesh": torch.from_numpy(self.frames.displacements(numbers)), "imprint": imprints}

    def where(self, number: int) -> str:
        """Store and frame of an item's mesh."""
        return frame_of(self.frames, number)


class ZhuObjective(Objective):
    """Squared error of meshes from rendered imprints, plus that of re-rendered imprints from pictures, weighted.

    Parameters
    ----------
    network : ZhuNetwork
    renderer : DepthRenderer
        Renderer at the network's size.
    adaptation_weight : float
        Final weight of the error on pictures; 0 leaves it out.
    anneal : int
        Epochs over which that weight grows from 0.
    """

    def __init__(self, network: ZhuNetwork, renderer: DepthRenderer, adaptation_weight: float, anneal: int) -> None:
        super().__init__()
        self.network = network
        self.zhu, self.renderer = network, renderer
        self.weight, self.anneal = adaptation_weight, anneal

    def forward(self, batch: Batch, epoch: float) -> Losses:
        """Scalars ``loss``, ``error`` of meshes and ``mismatch`` of imprints, for a batch of `ImprintItems`."""
        moved, zhu = batch["mesh"], self.zhu
        gain = torch.exp(zhu.log_gain)
        given = self._augmented(moved, gain.detach())
        error = nn.functional.mse_loss((zhu(given) - moved) / zhu.spread, torch.zeros_like(moved))
        shown = self.renderer.imprint(zhu(batch["imprint"]), gain)
        mismatch = nn.functional.mse_loss(shown, batch["imprint"])
        weight = annealed(self.weight, epoch, self.anneal) if self.training else self.weight
        return {"loss": error + weight * mismatch, "error": error.detach(), "mismatch": mismatch.detach()}

    def _augmented(self, moved: Tensor, gain: Tensor) -> Tensor:
        """Imprints rendered of displacements (n, v, 3), m; in training with random gains and noise."""
        if not self.training:
            return self.renderer.imprint(moved, gain)
        gains = gain * torch.exp(GAIN_SPREAD * torch.randn(len(moved), 1, 1, 1, device=moved.device))
        imprints = self.renderer.imprint(moved, gains)
        return imprints + NOISE * torch.randn_like(imprints)


@dataclass(frozen=True)
class ZhuMethod:
    """The trained network of Zhu et al. as a method that makes meshes of pictures."""

    network: ZhuNetwork
    name: str = "zhu"

    def predict(self, pictures: NDArray[np.uint8], background: NDArray[np.uint8]) -> NDArray[np.float32]:
        """Displacements (n, v, 3), m, of pictures (n, h, w, 3) of a unit with a background (h, w, 3)."""
        network = self.network.eval()
        imprints = imprints_of(pictures, background, network.size)
        with torch.no_grad():
            displacements = [network(chunk.to(network.device)).cpu() for chunk in imprints.split(CHUNK)]
        return torch.cat(displacements).numpy()
