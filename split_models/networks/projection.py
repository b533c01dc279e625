"""The networks between the latent spaces of meshes and images."""

from __future__ import annotations

from collections.abc import Sequence

from torch import Tensor

from split_models.networks.network import Network
from split_models.networks.perceptron import perceptron


class Projection(Network):
    """Latent vectors of one kind to those of another.

    Mesh to image or image to mesh; with latent arithmetic (SPLIT) the image's vector is that of the deformation, the
    background's subtracted, without (NOSPLIT) that of the whole picture. Which it is, is the caller's business: see
    `split_models.networks.latent`.

    Parameters
    ----------
    inputs, outputs : int
    layers, dropout : as for `perceptron`
    """

    kind = "projection"

    def __init__(
        self,
        inputs: int,
        outputs: int,
        layers: Sequence[int] = (512, 1024, 1024, 256),
        dropout: Sequence[float] = (0.2, 0.4),
    ) -> None:
        super().__init__()
        self.settings = {
            "inputs": inputs,
            "outputs": outputs,
            "layers": list(layers),
            "dropout": list(dropout),
        }
        self.layers = perceptron(inputs, layers, outputs, dropout)

    def forward(self, latent: Tensor) -> Tensor:
        """Latent vectors (n, outputs) of latent vectors (n, inputs)."""
        projected: Tensor = self.layers(latent)
        return projected
