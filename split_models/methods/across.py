"""ACROSS as a baseline: the mesh VAE encodes and decodes a mesh, and Taxim renders the decoded mesh.

Source: Zai El Amri et al., ACROSS, 2025: deformations are decoded from a latent vector of a mesh VAE and rendered by
Taxim. ACROSS obtains that vector from the signals of a BioTac; that half of the method has no counterpart here.
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
    taxim : OpticalMethod
        Taxim for the same mesh.
    name : str
        Name of the row in tables.
    """

    mesh_vae: MeshVae
    taxim: OpticalMethod
    name: str = "across"

    def predict(self, displacements: Any, background: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Pictures (n, rows, columns, 3) uint8 of displacements (n, k, 3), m, on a background (rows, columns, 3).

        Raises
        ------
        UsageError
            The meshes have another number of vertices than the VAE's, or displacements are NaN.
        """
        latent = encode_displacements(self.mesh_vae, np.asarray(displacements, np.float32))
        return self.taxim.predict(decode_displacements(self.mesh_vae, latent), background)
