"""The gel engine for a gel that differs from the nominal one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tactiledata.arrays import Array
from tactiledata.effects.touch.response import GelVariant
from tactiledata.gel.elasticity.stiffening import Stiffening
from tactiledata.gel.engines.fem import FemEngine, Fidelity
from tactiledata.gel.mesh.pad import PadMesh
from tactiledata.indenters.base import Indenter
from tactiledata.indenters.base.turned import reach_below_tip


def variant_engine(mesh: PadMesh, poisson_ratio: float, fidelity: Fidelity, variant: GelVariant) -> FemEngine:
    """Return a gel engine for a variant of the gel: another pad, elastic law, or stiffness of cells.

    ``variant.indenter_scale`` has no effect here: the caller scales the indenter.

    Parameters
    ----------
    mesh : PadMesh
        The nominal pad.
    poisson_ratio : float
        Of the nominal gel.
    fidelity : Fidelity
        Which equations the engine solves.
    variant : GelVariant
        Deviations from the nominal gel.
    """
    return FemEngine(
        warped(mesh, variant),
        poisson_ratio,
        fidelity,
        stiffening=Stiffening(variant.c20, variant.c30),
        modulus=_cell_factors(mesh, variant),
    )


def surface_height(mesh: PadMesh, places: Array) -> Array:
    """Height (n,), m, of the undeformed outer surface at places (n, 2), m; gel frame."""
    from scipy.interpolate import LinearNDInterpolator, NearestNDInterpolator

    nodes = np.unique(mesh.faces)
    points = mesh.vertices[nodes]
    # of nodes above one another, on the pad's sides, only the uppermost belongs to the surface seen from above
    order = np.lexsort((-points[:, 2], *np.round(points[:, :2], 7).T))
    points = points[order]
    first = np.ones(len(points), dtype=bool)
    first[1:] = (np.abs(np.diff(np.round(points[:, :2], 7), axis=0)) > 0).any(axis=1)
    points = points[first]
    height = np.asarray(LinearNDInterpolator(points[:, :2], points[:, 2])(places))
    outside = ~np.isfinite(height)
    height[outside] = NearestNDInterpolator(points[:, :2], points[:, 2])(places[outside])
    return height


def contact_height(mesh: PadMesh, indenter: Indenter, poses: Array) -> Array:
    """Return the height of the tip (n,), m, gel frame, at which the indenter's lowest point meets the surface.

    Parameters
    ----------
    mesh : PadMesh
        Undeformed pad.
    indenter : Indenter
        The solid that presses.
    poses : (n, 4, 4) m
        gel_from_indenter, every one known.
    """
    return surface_height(mesh, poses[:, :2, 3]) + reach_below_tip(indenter, poses)


def warped(mesh: PadMesh, variant: GelVariant) -> PadMesh:
    """Return the pad with the thickness and the dome of a variant, its vertices moved along z; the same if nominal."""
    if variant.thickness == 1.0 and variant.dome == 0.0:
        return mesh
    x, y, z = mesh.vertices.T
    top = surface_height(mesh, mesh.vertices[:, :2])
    bottom = mesh.vertices[mesh.base, 2].max()
    share = (z - bottom) / (top - bottom)
    lower = bottom - (variant.thickness - 1.0) * mesh.thickness
    fall = mesh.thickness * variant.dome * (x**2 + y**2)
    moved = np.column_stack([x, y, lower + share * (top - fall - lower)])
    return replace(mesh, name=f"{mesh.name}, varied", vertices=moved)


def _cell_factors(mesh: PadMesh, variant: GelVariant) -> Array | None:
    """Factors (c,) on the modulus of the cells, by skin and soft spots; ``None`` where the variant has neither."""
    if variant.skin == 0.0 and not variant.spots:
        return None
    corners = mesh.vertices[mesh.cells]
    centres = corners.mean(axis=1)
    heights = np.ptp(corners[:, :, 2], axis=1)
    factors = np.ones(len(mesh.cells))
    # a skin stiffens cells with a face on the outer surface
    is_upper = np.isin(mesh.cells, np.unique(mesh.faces)).sum(axis=1) >= 4
    is_upper &= surface_height(mesh, centres[:, :2]) - centres[:, 2] < heights
    factors[is_upper] += variant.skin / heights[is_upper]
    for spot in variant.spots:
        away = (centres[:, 0] - spot.x) ** 2 + (centres[:, 1] - spot.y) ** 2
        factors *= 1.0 - spot.loss * np.exp(-away / (2.0 * spot.radius**2))
    return factors
