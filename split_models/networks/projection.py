"""The network between the latent spaces of meshes and pictures."""

from __future__ import annotations

from collections.abc import Sequence

from torch import Tensor

from split_models.networks.network import Network
from split_models.networks.perceptron import perceptron


class Projection(Network):
    """A perceptron from latent vectors of one kind to latent vectors of another.

    It goes from mesh to picture or from picture to mesh. With latent arithmetic (SPLIT) the picture's vector is that of
    the deformation, the background's subtracted; without (NOSPLIT) it is that of the whole picture. The caller decides
    which: see `split_models.networks.latent`.

    Parameters
    ----------
    inputs, outputs : int
        Sizes of the two latent vectors.
    layers, dropout : sequence
        Widths and dropped shares, as for `perceptron`.
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
        """Latent vectors (n, outputs) for latent vectors (n, inputs)."""
        projected: Tensor = self.layers(latent)
        return projected
