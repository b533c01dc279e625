"""Height maps and imprints of meshes with gradients, so that a predicted mesh can be compared with a picture."""

from __future__ import annotations

import numpy as np
import torch
from scipy.sparse import csr_array
from torch import Tensor, nn

from split_models.networks.sparse_map import SparseMap
from tactiledata.optics.height_map import covered
from tactiledata.optics.surface import GelSurface
from tactiledata.optics.view import View

ROUNDS = 3
"""Fixed-point iterations that find the gel point which lies over a pixel after the deformation."""
ROUNDED = 1e-4
"""Slope below which the root is smoothed, so that flat gel has a gradient."""


class DepthRenderer(nn.Module):
    """Indentations (n, 1, rows, columns), metres, of displacements (n, k, 3), metres.

    Displacements are interpolated over the undeformed triangles, and each pixel looks up the point that lies over it
    after the deformation. Where the surface does not fold, the result is that of
    `tactiledata.optics.height_map.Indentation`.
    """

    rest: Tensor
    places: Tensor
    to_share: Tensor

    def __init__(self, surface: GelSurface, view: View) -> None:
        super().__init__()
        # weights that interpolate the values of nodes at each pixel
        self.shape = view.shape
        pixel, which, shares = covered(view.pixels_at(surface.places[:, :2]), surface.triangles, view.shape)
        pixel, first = np.unique(pixel, return_index=True)  # a pixel on a border is covered twice
        nodes = surface.triangles[which[first]]
        size = (view.shape[0] * view.shape[1], len(surface.places))
        weights = csr_array((shares[first].ravel(), (np.repeat(pixel, 3), nodes.ravel())), shape=size)
        self.spread = SparseMap(weights)
        self.register_buffer("rest", torch.as_tensor(weights @ surface.places[:, 2]).float().view(1, 1, *view.shape))
        # metres on the gel to shares of the picture, which runs from -1 to 1
        pixel_from_gel = np.linalg.inv(view.gel_from_pixel)[:2, :2]
        half = (np.array([view.shape[1], view.shape[0]]) - 1) / 2
        self.register_buffer("to_share", torch.as_tensor(pixel_from_gel / half[:, None]).float())
        rows, columns = torch.meshgrid(*(torch.linspace(-1, 1, side) for side in view.shape), indexing="ij")
        self.register_buffer("places", torch.stack([columns, rows], dim=-1)[None])
        self.pitches = view.pitches

    def forward(self, displacements: Tensor) -> Tensor:
        """Indentations (n, 1, rows, columns), metres, of displacements (n, k, 3), metres."""
        spread = self.spread(displacements.transpose(0, 1)).permute(1, 2, 0).unflatten(2, self.shape)
        sideways = torch.einsum("sg,ngrc->nrcs", self.to_share, spread[:, :2])
        source = self.places - sideways
        for _ in range(ROUNDS - 1):
            source = self.places - _looked_up(sideways.permute(0, 3, 1, 2), source).permute(0, 2, 3, 1)
        height: Tensor = self.rest - _looked_up(self.rest + spread[:, 2:], source)
        return height

    def imprint(self, displacements: Tensor, gain: Tensor) -> Tensor:
        """Imprints (n, 1, rows, columns), 0 to 1, that a picture shows of meshes: bright where the gel is steep."""
        depth = self(displacements)
        along = torch.gradient(depth, spacing=self.pitches[0], dim=3)[0]
        down = torch.gradient(depth, spacing=self.pitches[1], dim=2)[0]
        steep = torch.sqrt(along**2 + down**2 + ROUNDED**2) - ROUNDED
        return torch.tanh(gain * steep)


def _looked_up(values: Tensor, source: Tensor) -> Tensor:
    """Values (n, c, rows, columns), interpolated at positions (n, rows, columns, 2) in [-1, 1]."""
    batch = values.expand(len(source), -1, -1, -1)
    return nn.functional.grid_sample(batch, source, padding_mode="border", align_corners=True)
