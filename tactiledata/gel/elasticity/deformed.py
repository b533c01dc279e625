"""Factorised tangent stiffness of a deformed pad, and the compliance of the patches that may be pressed there."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array
from scipy.sparse.linalg import SuperLU, splu

from tactiledata.arrays import Array, Indices
from tactiledata.gel.elasticity.compliance import BATCH, FactorisedPad
from tactiledata.gel.elasticity.internal_forces import ElasticPad
from tactiledata.gel.elasticity.stiffening import Stiffening
from tactiledata.gel.elasticity.tangent import TangentAssembly
from tactiledata.gel.elasticity.triangular import BlockFactor
from tactiledata.gel.mesh.surface import ContactSurface

WIDE = 48
"""Right-hand sides of the compliance that are solved together; more are no faster."""


@dataclass(frozen=True)
class DeformedPad:
    """Tangent stiffness at one deformation, factorised.

    Parameters
    ----------
    factor : BlockFactor
        Factor for the free degrees of freedom.
    free : (n,)
        Numbers of the free degrees of freedom.
    members : (k,)
        Numbers of the patches whose compliance is known, ascending.
    compliance : (k, k, 3, 3) 1/m
        Mean displacement of a member by a unit force on a member, for a Young's modulus of 1.
    is_filtered : bool
        Whether negative eigenvalues of single cells were set to zero.
    """

    factor: BlockFactor
    free: Indices
    members: Indices
    compliance: NDArray[np.float32]
    is_filtered: bool

    def solve(self, forces: Array) -> Array:
        """Displacements (v, 3), m, that nodal forces (v, 3), m^2, add; relative error 1e-6."""
        displacement = np.zeros(forces.size)
        displacement[self.free] = self.factor.solve(forces.reshape(1, -1)[:, self.free], lanes=1)[0]
        return displacement.reshape(forces.shape)


class TangentFactory:
    """Maker of factorised tangents of one pad; what they share is worked out when the first one is needed.

    Parameters
    ----------
    pad : FactorisedPad
        Mesh and Poisson's ratio.
    elastic : ElasticPad
        Cells of the same mesh.
    surface : ContactSurface
        Patches of the same mesh.
    stiffening : Stiffening
        Yeoh's terms of the law.
    """

    def __init__(
        self, pad: FactorisedPad, elastic: ElasticPad, surface: ContactSurface, stiffening: Stiffening
    ) -> None:
        self._pad, self._elastic, self._surface, self._stiffening = pad, elastic, surface, stiffening

    @cached_property
    def _assembly(self) -> TangentAssembly:
        """Assembly of the tangent stiffness."""
        return TangentAssembly(self._elastic, self._pad.mesh.free, self._pad.poisson_ratio, self._stiffening)

    def at(self, displacement: Array, members: Indices, is_filtered: bool) -> DeformedPad:
        """Return the factorised tangent at displacements (v, 3), m, with the compliance of patches ``members`` (k,).

        Parameters
        ----------
        displacement : (v, 3) m
            Displacements of all nodes.
        members : (k,)
            Numbers of the patches, ascending.
        is_filtered : bool
            Whether to set negative eigenvalues of single cells to zero in any case; otherwise that is done where the
            tangent is not positive definite, after a factorisation in vain.
        """
        factor = self._factor(displacement, is_filtered)
        if not is_filtered and not (factor.inverse_diagonal > 0).all():
            # only the contact keeps the pad from giving way: leave out what would make it
            is_filtered = True
            factor = self._factor(displacement, is_filtered)
        return DeformedPad(factor, self._pad.mesh.free, members, self._compliance(factor, members), is_filtered)

    def _factor(self, displacement: Array, is_filtered: bool) -> BlockFactor:
        """Factor of the tangent at displacements (v, 3), m, without row exchanges."""
        return BlockFactor.of(_factorised(self._assembly.matrix(displacement, is_filtered=is_filtered)))

    def _compliance(self, factor: BlockFactor, members: Indices) -> NDArray[np.float32]:
        """Mean displacements of patches under unit forces on them: (k, k, 3, 3), 1/m."""
        free, surface = self._pad.mesh.free, self._surface
        averaging = surface.averaging[members]
        count = len(members)
        flat = np.empty((count, 3, count, 3))
        loads = np.zeros((BATCH, 3 * len(self._pad.mesh.vertices)))
        rows = 3 * surface.nodes[:, None] + np.arange(3)
        spread = averaging.toarray()
        for start in range(0, count, BATCH // 3):
            columns = range(start, min(start + BATCH // 3, count))
            loads[:] = 0.0
            for place, column in enumerate(columns):
                for axis in range(3):
                    loads[3 * place + axis, rows[:, axis]] = spread[column]
            used = 3 * len(columns)
            moved = np.zeros((used, loads.shape[1]))
            moved[:, free] = factor.solve(loads[:used][:, free], lanes=WIDE)
            # (3 columns, s, 3) to mean displacements (k, 3) of the members
            means = np.einsum("ks,bsi->bki", spread, moved[:, rows], optimize=True)
            flat[:, :, columns.start : columns.stop, :] = means.reshape(len(columns), 3, count, 3).transpose(2, 3, 0, 1)
        blocks = flat.transpose(0, 2, 1, 3)
        return np.ascontiguousarray((blocks + blocks.transpose(1, 0, 3, 2)) / 2, dtype=np.float32)


def _factorised(matrix: csc_array) -> SuperLU:
    """Factor of a symmetric matrix, without row exchanges."""
    return splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
