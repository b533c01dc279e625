"""Engine that interpolates the solution on the low-resolution pad to the high-resolution one."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, kron

from tactiledata.arrays import Array
from tactiledata.gel.contact.history import GelHistory, GelTouch
from tactiledata.gel.contact.recorder import Keep
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.gel.engines.fem import WIDTH, FemEngine, Fidelity
from tactiledata.gel.mesh.structured_pad import PLANS, grid_lines, pad_mesh
from tactiledata.gel.mesh.surface import contact_surface
from tactiledata.sensors.base import GelGeometry


class EmbeddedEngine:
    """Engine ``fem`` on the low-resolution pad, with displacements interpolated to the vertices of the high one.

    Only the mesh is finer, not the mechanics: the surface is within 3 to 4 % (root mean square, relative to its
    largest displacement) of a solution on the high mesh itself. Wrenches are those of the low mesh.

    Parameters
    ----------
    sensor : str
        Sensor model, for the meshes' names.
    geometry : GelGeometry
        Dimensions of the pad.
    poisson_ratio : float
        Of the gel.
    fidelity : "finite-strain" or "linear"
        As in ``FemEngine``.
    """

    def __init__(
        self, sensor: str, geometry: GelGeometry, poisson_ratio: float, fidelity: Fidelity = "finite-strain"
    ) -> None:
        self.mesh = pad_mesh(sensor, geometry, "high")
        self.surface = contact_surface(self.mesh)
        self._low = FemEngine(pad_mesh(sensor, geometry, "low"), poisson_ratio, fidelity)
        self.fidelity = fidelity
        # the pads' grids are products of lines, so that the interpolation is a product of three
        coarse, fine = (grid_lines(geometry, PLANS[resolution]) for resolution in ("low", "high"))
        lines = [_line_interpolation(*pair) for pair in zip(coarse, fine, strict=True)]
        self._carry = csr_array(kron(kron(lines[0], lines[1]), lines[2]))
        self._carry.eliminate_zeros()
        on_surface = self._carry[self.surface.nodes][:, self._low.surface.nodes]
        self._on_surface = csr_array(on_surface)
        areas = [_node_areas(engine) for engine in (self._low, self)]
        # pressures are interpolated, and a force is pressure times area; shares sum to one, so that no force is lost
        shares = on_surface.multiply(areas[1][:, None]).tocsc()
        totals = np.asarray(shares.sum(axis=0)).ravel()
        self._share = csr_array(shares.multiply(1.0 / np.where(totals > 0, totals, 1.0)))

    def play(
        self, touches: Sequence[GelTouch], material: GelMaterial, keep: Keep = "all", width: int = WIDTH
    ) -> Iterator[tuple[int, GelHistory]]:
        """Solve trajectories on the low-resolution mesh, and yield their answers on the high-resolution mesh.

        Each trajectory is yielded when it is done, as a pair of its index and its answer. Displacements
        (n, v, 3) and node forces (n, s, 3) are interpolated to the nodes of the high-resolution mesh; ``pressed`` is
        (n, s). Wrenches are those of the low-resolution solution.

        Parameters
        ----------
        touches : sequence of GelTouch
            Poses and indenters.
        material : GelMaterial
            Its Poisson's ratio must be the engine's.
        keep : "all", "surface" or "none"
            Nodes whose displacements are returned.
        width : int
            Trajectories solved in lockstep.
        """
        carry = self._carry if keep == "all" else self._carry[self.surface.nodes]
        for number, history in self._low.play(touches, material, "none" if keep == "none" else "all", width):
            displacement = history.displacement
            if keep != "none":
                displacement = np.stack([_carried(carry, frame) for frame in history.displacement])
            forces = np.stack([_carried(self._share, frame) for frame in history.node_forces])
            pressed = (self._on_surface @ history.pressed.T.astype(float)).T >= 0.5
            yield number, replace(history, displacement=displacement, node_forces=forces, pressed=pressed)


def _carried(operator: csr_array, field: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return a nodal field of the high mesh from one of the low mesh."""
    return np.asarray(operator @ field.astype(float), dtype=np.float32)


def _node_areas(engine: FemEngine | EmbeddedEngine) -> Array:
    """Undeformed area (s,), m^2, that belongs to each surface node."""
    surface = engine.surface
    areas: Array = surface.averaging.T @ surface.patch_areas
    return areas


def _line_interpolation(coarse: Array, fine: Array) -> csr_array:
    """Linear interpolation matrix (len(fine), len(coarse)) between ascending points on a line."""
    left = np.clip(np.searchsorted(coarse, fine, side="right") - 1, 0, len(coarse) - 2)
    share = (fine - coarse[left]) / (coarse[left + 1] - coarse[left])
    rows = np.tile(np.arange(len(fine)), 2)
    columns = np.concatenate([left, left + 1])
    return csr_array((np.concatenate([1.0 - share, share]), (rows, columns)), shape=(len(fine), len(coarse)))
