"""ACROSS' path as a baseline: a mesh goes through the mesh VAE, and Taxim draws what comes out.

Source: Zai El Amri et al., ACROSS, 2025: deformations are decoded from a latent vector of a mesh VAE and rendered by
Taxim. Its first half, from a BioTac's signals to that vector, has nothing to say here.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from split_models.methods.optical_method import OpticalMethod
from split_models.networks.latent import decode_displacements, encode_displacements
from split_models.networks.mesh_vae import MeshVae


@dataclass(frozen=True)
class AcrossMethod:
    """Pictures of deformed meshes by a mesh VAE and Taxim.

    Parameters
    ----------
    mesh_vae : MeshVae
    taxim : TaximMethod
        On the same mesh.
    name : str
    """

    mesh_vae: MeshVae
    taxim: OpticalMethod
    name: str = "across"

    def predict(self, displacements: Any, background: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Pictures (n, rows, columns, 3) uint8 of displacements (n, k, 3), m, on a background (rows, columns, 3).

        Raises
        ------
        UsageError
            Meshes of another topology than the VAE's, or NaN.
        """
        latent = encode_displacements(self.mesh_vae, np.asarray(displacements, np.float32))
        return self.taxim.predict(decode_displacements(self.mesh_vae, latent), background)
