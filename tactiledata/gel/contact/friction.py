"""Unilateral contact with Coulomb friction on condensed patches: nonlinear Gauss-Seidel."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from tactiledata.arrays import Array, Indices

PARTIAL_LOAD = 1.2
"""Added compliance of a patch of which the share c lies under the indenter, over that of the whole: this times
(1 - c) / c. Chosen so that flat punches anywhere on the grid err neither way: docs/decisions/0008."""


def solve_contact(
    compliance: NDArray[np.float32],
    patches: Indices,
    forces: Array,
    normals: Array,
    gaps: Array,
    slips: Array,
    openings: Array,
    covers: Array,
    friction: float,
    sweeps: int,
    tolerance: float,
) -> float:
    """Improve the contact forces in place by sweeps over the patches; returns the last relative change.

    One patch after the other is put on Signorini's and Coulomb's laws with all others held (Jourdan, Alart and Jean,
    Comput. Methods Appl. Mech. Eng. 155, 1998).

    Parameters
    ----------
    compliance : (m, m, 3, 3) 1/m
        Mean displacement of a patch by a unit force on a patch, for a Young's modulus of 1.
    patches : (k,)
        Those that may touch.
    forces : (k, 3) m^2
        On the gel, for a Young's modulus of 1: where to start, and the result.
    normals : (k, 3)
        Out of the indenter.
    gaps : (k,), slips : (k, 3), m
        Along the normal, and since the last frame relative to the indenter, both at the given forces.
    openings : (k,) m
        Gap at the last frame; 0 where they touched. Of a step in which a patch first touches only the part after
        touching counts as slip.
    covers : (k,)
        Share of the patch under the indenter, in (0, 1]. A load on a part of a patch sinks in deeper than one on all of
        it: ``PARTIAL_LOAD``.
    """
    if not len(patches):
        return 0.0
    change: float = _sweep(
        compliance, patches, forces, normals, gaps, slips, openings, covers, friction, sweeps, tolerance
    )
    return change


@njit(nogil=True, cache=True, fastmath=True)
def _sweep(
    compliance: NDArray[np.float32],
    patches: Indices,
    forces: Array,
    normals: Array,
    gaps: Array,
    slips: Array,
    openings: Array,
    covers: Array,
    friction: float,
    sweeps: int,
    tolerance: float,
) -> float:
    count = len(patches)
    moved = np.zeros(3 * count)
    # responses of the patches in use, side by side in memory; a row is fetched when its patch first carries a force
    responses = np.empty((count, 3, 3 * count), dtype=np.float32)
    is_fetched = np.zeros(count, dtype=np.bool_)
    stiff_normal = np.empty(count)
    stiff_tangent = np.empty(count)
    softness = np.empty(count)
    for i in range(count):
        own = compliance[patches[i], patches[i]]
        along = 0.0
        for a in range(3):
            for b in range(3):
                along += normals[i, a] * own[a, b] * normals[i, b]
        softness[i] = PARTIAL_LOAD * (1.0 - covers[i]) / covers[i] * along
        stiff_normal[i] = 1.0 / (along + softness[i])
        stiff_tangent[i] = 2.0 / (own[0, 0] + own[1, 1] + own[2, 2] - along)
    new, slip = np.empty(3), np.empty(3)
    largest = 0.0
    for _ in range(sweeps):
        change = 0.0
        largest = 0.0
        for i in range(count):
            n = normals[i]
            f = forces[i]
            before = f[0] * n[0] + f[1] * n[1] + f[2] * n[2]
            m0, m1, m2 = moved[3 * i], moved[3 * i + 1], moved[3 * i + 2]
            gap = gaps[i] + n[0] * m0 + n[1] * m1 + n[2] * m2 + softness[i] * before
            after = before - gap * stiff_normal[i]
            new[:] = 0.0
            if after > 0.0:
                depth = after / stiff_normal[i]
                share = 1.0 if openings[i] <= 0.0 else depth / (openings[i] + depth)
                slip[0], slip[1], slip[2] = slips[i, 0] + m0, slips[i, 1] + m1, slips[i, 2] + m2
                off = slip[0] * n[0] + slip[1] * n[1] + slip[2] * n[2]
                size = 0.0
                for a in range(3):
                    held = f[a] - before * n[a]
                    # the slip without this patch's own tangential force, of which only a share came after touching
                    free = (slip[a] - off * n[a]) - held / stiff_tangent[i]
                    new[a] = held - (share * free + held / stiff_tangent[i]) * stiff_tangent[i]
                    size += new[a] * new[a]
                size = np.sqrt(size)
                limit = friction * after
                shrink = limit / size if size > limit else 1.0
                for a in range(3):
                    new[a] = shrink * new[a] + after * n[a]
            elif before == 0.0 and f[0] == 0.0 and f[1] == 0.0 and f[2] == 0.0:
                continue
            d0, d1, d2 = new[0] - f[0], new[1] - f[1], new[2] - f[2]
            row = responses[i]
            if not is_fetched[i]:
                is_fetched[i] = True
                for k in range(count):
                    # symmetric: the block of (k, i) is the transpose of that of (i, k)
                    block = compliance[patches[i], patches[k]]
                    for b in range(3):
                        for a in range(3):
                            row[b, 3 * k + a] = block[b, a]
            along_x, along_y, along_z = row[0], row[1], row[2]
            for k in range(3 * count):
                moved[k] += along_x[k] * d0 + along_y[k] * d1 + along_z[k] * d2
            f[0], f[1], f[2] = new[0], new[1], new[2]
            change = max(change, abs(d0), abs(d1), abs(d2))
            largest = max(largest, after)
        if change <= tolerance * largest:
            return change / largest if largest > 0.0 else 0.0
    return change / largest if largest > 0.0 else 0.0
