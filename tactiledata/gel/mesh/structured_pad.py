"""Pads of hexahedra from a sensor's gel geometry, on a grid that is fine where indenters touch."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.optimize import brentq

from tactiledata.arrays import Array
from tactiledata.errors import UsageError
from tactiledata.gel.mesh.pad import Indices, PadMesh
from tactiledata.sensors.base import GelGeometry

Resolution = Literal["low", "high"]


@dataclass(frozen=True)
class GridPlan:
    """Numbers and spacing of the intervals into which a pad is divided.

    Parameters
    ----------
    across, along : int
        Intervals from the middle to the rim, along x and y.
    spacing : m
        Spacing in the uniform middle.
    uniform : (x, y) m
        Half the size of the uniform middle.
    levels : ascending
        Heights of the layers of nodes as shares of the thickness, 0 (base) to 1 (surface).
    """

    across: int
    along: int
    spacing: float
    uniform: tuple[float, float]
    levels: tuple[float, ...]


PLANS: dict[Resolution, GridPlan] = {
    "low": GridPlan(16, 18, 0.4e-3, (4.8e-3, 5.6e-3), (0.0, 0.42, 0.70, 0.88, 1.0)),
    "high": GridPlan(40, 49, 0.18e-3, (5.4e-3, 6.3e-3), (0.0, 0.21, 0.38, 0.52, 0.635, 0.73, 0.81, 0.88, 0.945, 1.0)),
}


def pad_mesh(sensor: str, geometry: GelGeometry, resolution: Resolution = "low") -> PadMesh:
    """Make the pad of a sensor.

    ``low`` has 6,105 vertices, ``high`` 80,190: the sizes of the SPLIT paper (6,103 and 80,744) within one percent.

    Parameters
    ----------
    sensor : str
        Sensor model, for the mesh's name.
    geometry : GelGeometry
        Dimensions from a log, or those of the sensor model.
    resolution : "low" or "high"
        Key of ``PLANS``.

    Raises
    ------
    UsageError
        An unknown resolution.
    """
    plan = PLANS.get(resolution)
    if plan is None:
        raise UsageError(f"resolution {resolution!r}", " or ".join(PLANS), "Name one of them.", resolution=resolution)
    return structured_pad(f"{sensor}-{resolution}", geometry, plan)


def structured_pad(name: str, geometry: GelGeometry, plan: GridPlan) -> PadMesh:
    """Make a pad on a given grid.

    Parameters
    ----------
    name : str
        Name of the mesh.
    geometry : GelGeometry
        Dimensions, m.
    plan : GridPlan
        Intervals of the grid.
    """
    s, t, level = np.meshgrid(*grid_lines(geometry, plan), indexing="ij")
    x, y = _outlined(s, t, geometry)
    # the dome falls to the rim's height all around: 0 in the middle, 1 on the outline
    rim_share = 1.0 - (1.0 - s**2) * (1.0 - t**2)
    height = geometry.thickness - (geometry.thickness - geometry.edge_thickness) * rim_share
    z = level * height - geometry.thickness
    return _as_mesh(name, np.stack([x, y, z], axis=-1))


def grid_lines(geometry: GelGeometry, plan: GridPlan) -> tuple[Array, Array, Array]:
    """Positions of the grid's planes along x and y, as shares of the half outline in [-1, 1], and of the thickness."""
    half_short, half_long = geometry.outline[0] / 2, geometry.outline[1] / 2
    across = _graded(half_short, plan.across, plan.spacing, plan.uniform[0]) / half_short
    along = _graded(half_long, plan.along, plan.spacing, plan.uniform[1]) / half_long
    return _mirrored(across), _mirrored(along), np.asarray(plan.levels)


def _graded(half: float, count: int, spacing: float, uniform: float) -> Array:
    """Positions (count + 1,), m, from 0 to ``half``: ``spacing`` apart up to ``uniform``, then widening."""
    inner = round(uniform / spacing)
    outer = count - inner
    if outer < 1 or inner * spacing >= half or (inner + outer) * spacing >= half:
        return np.linspace(0.0, half, count + 1)
    start = inner * spacing

    # the intervals grow by a constant ratio, such that the last one ends at the rim
    def excess(ratio: float) -> float:
        """Distance, m, by which the last interval ends beyond the rim."""
        return float(start + spacing * sum(ratio**k for k in range(1, outer + 1)) - half)

    ratio = brentq(excess, 1.0, 10.0)
    widths = spacing * ratio ** np.arange(1, outer + 1)
    return np.concatenate([np.arange(inner + 1) * spacing, start + np.cumsum(widths)])


def _mirrored(positive: Array) -> Array:
    """Positions from -1 to 1, from those from 0 to 1."""
    return np.concatenate([-positive[:0:-1], positive])


def _outlined(s: Array, t: Array, geometry: GelGeometry) -> tuple[Array, Array]:
    """Map grid coordinates in [-1, 1] to x and y in metres within the outline, with a round end and rounded corners.

    The half-elliptic end is at +y, the rounded corners are at -y; both maps leave the middle unchanged. The round end
    is the elliptical grid mapping of a half square on a half disc (Fong, Analytical Methods for Squaring the Disc,
    2015).
    """
    half_short, half_long = geometry.outline[0] / 2, geometry.outline[1] / 2
    x, y = s * half_short, t * half_long
    if geometry.round_end > 0:
        start = half_long - geometry.round_end
        end_share = np.clip((y - start) / geometry.round_end, 0.0, 1.0)
        y = np.where(y > start, start + geometry.round_end * end_share * np.sqrt(1.0 - s**2 / 2), y)
        x = x * np.sqrt(1.0 - end_share**2 / 2)
    if geometry.corner_radius > 0:
        # the corner of a square lies (sqrt 2 - 1) r further out than that of a rounded one
        inset = (1.0 - np.sqrt(0.5)) * geometry.corner_radius
        sharp = (np.abs(s) * np.maximum(-t, 0.0)) ** 10
        x = x - np.sign(s) * inset * sharp
        y = y + inset * sharp
    return x, y


def _as_mesh(name: str, grid: Array) -> PadMesh:
    """Mesh of hexahedra between the nodes of a grid (nx, ny, nz, 3), m; the lowest layer is the base."""
    nx, ny, nz = grid.shape[:3]
    number = np.arange(nx * ny * nz, dtype=np.int64).reshape(nx, ny, nz)

    def corner(i: int, j: int, k: int) -> Indices:
        """Node of every cell at its corner (i, j, k)."""
        return number[i : nx - 1 + i, j : ny - 1 + j, k : nz - 1 + k].ravel()

    ring = ((0, 0), (1, 0), (1, 1), (0, 1))
    cells = np.stack([corner(i, j, k) for k in (0, 1) for i, j in ring], axis=1)
    top = number[:, :, -1]
    faces = np.stack([top[i : nx - 1 + i, j : ny - 1 + j].ravel() for i, j in ring], axis=1)
    return PadMesh(name, "hexahedron8", grid.reshape(-1, 3), cells, number[:, :, 0].ravel(), faces)
