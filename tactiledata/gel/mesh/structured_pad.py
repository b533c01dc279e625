"""Pads from a sensor's gel geometry: hexahedra in a grid that is fine where indenters touch."""

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
    """How a pad is divided.

    Parameters
    ----------
    across, along : intervals from the middle to the rim, along x and y
    spacing : m, of the uniform middle
    uniform : (x, y) m, half the size of the uniform middle
    levels : ascending shares of the thickness at which the layers of nodes lie, 0 (base) to 1 (surface)
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
    """The pad of a sensor.

    ``low`` has 6,105 vertices, ``high`` 80,190: the sizes of the SPLIT paper (6,103 and 80,744) within one percent.

    Parameters
    ----------
    sensor : str
        Goes into the mesh's name.
    geometry : GelGeometry
        What a log states, or the sensor model's own.

    Raises
    ------
    UsageError
        A resolution that does not exist.
    """
    plan = PLANS.get(resolution)
    if plan is None:
        raise UsageError(f"resolution {resolution!r}", " or ".join(PLANS), "Name one of them.", resolution=resolution)
    return structured_pad(f"{sensor}-{resolution}", geometry, plan)


def structured_pad(name: str, geometry: GelGeometry, plan: GridPlan) -> PadMesh:
    """The pad on a grid of one's own."""
    s, t, level = np.meshgrid(*grid_lines(geometry, plan), indexing="ij")
    x, y = _outlined(s, t, geometry)
    # the dome falls to the rim's height all around: 0 in the middle, 1 on the outline
    fall = 1.0 - (1.0 - s**2) * (1.0 - t**2)
    height = geometry.thickness - (geometry.thickness - geometry.edge_thickness) * fall
    z = level * height - geometry.thickness
    return _as_mesh(name, np.stack([x, y, z], axis=-1))


def grid_lines(geometry: GelGeometry, plan: GridPlan) -> tuple[Array, Array, Array]:
    """Where the grid's planes lie along x and y, as shares of the half outline in [-1, 1], and of the thickness."""
    half_short, half_long = geometry.outline[0] / 2, geometry.outline[1] / 2
    across = _graded(half_short, plan.across, plan.spacing, plan.uniform[0]) / half_short
    along = _graded(half_long, plan.along, plan.spacing, plan.uniform[1]) / half_long
    return _mirrored(across), _mirrored(along), np.asarray(plan.levels)


def _graded(half: float, count: int, spacing: float, uniform: float) -> Array:
    """Positions (count + 1,) from 0 to ``half``: evenly ``spacing`` apart up to ``uniform``, then ever wider."""
    inner = round(uniform / spacing)
    outer = count - inner
    if outer < 1 or inner * spacing >= half or (inner + outer) * spacing >= half:
        return np.linspace(0.0, half, count + 1)
    start = inner * spacing

    def miss(ratio: float) -> float:
        return float(start + spacing * sum(ratio**k for k in range(1, outer + 1)) - half)

    ratio = brentq(miss, 1.0, 10.0)
    widths = spacing * ratio ** np.arange(1, outer + 1)
    return np.concatenate([np.arange(inner + 1) * spacing, start + np.cumsum(widths)])


def _mirrored(positive: Array) -> Array:
    return np.concatenate([-positive[:0:-1], positive])


def _outlined(s: Array, t: Array, geometry: GelGeometry) -> tuple[Array, Array]:
    """Grid coordinates in [-1, 1] to metres on the outline: a half-elliptic end at +y, rounded corners at -y.

    Both maps leave the middle as it is. The round end is the elliptical grid mapping of a half square on a half disc
    (Fong, Analytical Methods for Squaring the Disc, 2015).
    """
    half_short, half_long = geometry.outline[0] / 2, geometry.outline[1] / 2
    x, y = s * half_short, t * half_long
    if geometry.round_end > 0:
        start = half_long - geometry.round_end
        into = np.clip((y - start) / geometry.round_end, 0.0, 1.0)
        y = np.where(y > start, start + geometry.round_end * into * np.sqrt(1.0 - s**2 / 2), y)
        x = x * np.sqrt(1.0 - into**2 / 2)
    if geometry.corner_radius > 0:
        # the corner of a square lies (sqrt 2 - 1) r further out than that of a rounded one
        inset = (1.0 - np.sqrt(0.5)) * geometry.corner_radius
        sharp = (np.abs(s) * np.maximum(-t, 0.0)) ** 10
        x = x - np.sign(s) * inset * sharp
        y = y + inset * sharp
    return x, y


def _as_mesh(name: str, grid: Array) -> PadMesh:
    """Hexahedra between the nodes of a grid (nx, ny, nz, 3)."""
    nx, ny, nz = grid.shape[:3]
    number = np.arange(nx * ny * nz, dtype=np.int64).reshape(nx, ny, nz)

    def corner(i: int, j: int, k: int) -> Indices:
        return number[i : nx - 1 + i, j : ny - 1 + j, k : nz - 1 + k].ravel()

    ring = ((0, 0), (1, 0), (1, 1), (0, 1))
    cells = np.stack([corner(i, j, k) for k in (0, 1) for i, j in ring], axis=1)
    top = number[:, :, -1]
    faces = np.stack([top[i : nx - 1 + i, j : ny - 1 + j].ravel() for i, j in ring], axis=1)
    return PadMesh(name, "hexahedron8", grid.reshape(-1, 3), cells, number[:, :, 0].ravel(), faces)
