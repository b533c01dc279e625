"""Contact forces on surface patches with Signorini's and Coulomb's laws, by nonlinear Gauss-Seidel."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from tactiledata.arrays import Array, Indices

PARTIAL_LOAD = 1.2
"""Factor of the compliance added to a partly covered patch: this times (1 - c) / c, c being the covered share.

It multiplies the patch's own compliance, and is chosen so that flat punches at any place on the grid have no bias:
docs/decisions/0008."""


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
    """Improve the contact forces in place by sweeps over the patches; return the last relative change.

    Only ``forces`` is changed. The answer is the largest change of a force component in the last sweep over the largest
    normal force: above ``tolerance`` where the sweeps did not suffice, and 0 without patches or without normal force.

    One patch after the other is made to obey Signorini's and Coulomb's laws while all others are held (Jourdan, Alart
    and Jean, Comput. Methods Appl. Mech. Eng. 155, 1998).

    Parameters
    ----------
    compliance : (m, m, 3, 3) 1/m
        Mean displacement of a patch by a unit force on a patch, for a Young's modulus of 1.
    patches : (k,)
        Numbers of the patches that may touch.
    forces : (k, 3) m^2
        Forces on the gel, for a Young's modulus of 1: the start on entry, the result on return.
    normals : (k, 3)
        Unit normals out of the indenter.
    gaps : (k,) m
        Mean distance of the patch from the indenter along the normal at the forces on entry; negative where they
        overlap.
    slips : (k, 3) m
        Motion relative to the indenter since the last load step, at the forces on entry; the part along the normal
        does not count.
    openings : (k,) m
        Gap at the last load step; 0 for a patch that touched. Where a patch first touches in this step, only the
        motion after touching counts as slip.
    covers : (k,)
        Share of the patch under the indenter, in (0, 1]. A load on a part of a patch sinks in deeper than one on all of
        it: ``PARTIAL_LOAD``.
    friction : float
        Coefficient of Coulomb friction.
    sweeps : int
        Most sweeps.
    tolerance : float
        Largest change of a force component, relative to the largest normal force, at which sweeps end.
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
    """Compiled loop of ``solve_contact``, with the same arguments."""
    count = len(patches)
    displaced = np.zeros(3 * count)
    # responses of the patches in use, side by side in memory; a row is fetched when its patch first carries a force
    responses = np.empty((count, 3, 3 * count), dtype=np.float32)
    is_fetched = np.zeros(count, dtype=np.bool_)
    # stiffness of each patch to its own force, along the normal and (mean) along the tangents
    stiff_normal = np.empty(count)
    stiff_tangent = np.empty(count)
    softness = np.empty(count)
    for i in range(count):
        own = compliance[patches[i], patches[i]]
        own_normal = 0.0
        for a in range(3):
            for b in range(3):
                own_normal += normals[i, a] * own[a, b] * normals[i, b]
        softness[i] = PARTIAL_LOAD * (1.0 - covers[i]) / covers[i] * own_normal
        stiff_normal[i] = 1.0 / (own_normal + softness[i])
        stiff_tangent[i] = 2.0 / (own[0, 0] + own[1, 1] + own[2, 2] - own_normal)
    new, slip = np.empty(3), np.empty(3)
    largest = 0.0
    for _ in range(sweeps):
        change = 0.0
        largest = 0.0
        for i in range(count):
            n = normals[i]
            f = forces[i]
            before = f[0] * n[0] + f[1] * n[1] + f[2] * n[2]
            m0, m1, m2 = displaced[3 * i], displaced[3 * i + 1], displaced[3 * i + 2]
            # Signorini: the normal force that closes the gap, or none
            gap = gaps[i] + n[0] * m0 + n[1] * m1 + n[2] * m2 + softness[i] * before
            after = before - gap * stiff_normal[i]
            new[:] = 0.0
            if after > 0.0:
                depth = after / stiff_normal[i]
                share = 1.0 if openings[i] <= 0.0 else depth / (openings[i] + depth)
                slip[0], slip[1], slip[2] = slips[i, 0] + m0, slips[i, 1] + m1, slips[i, 2] + m2
                normal_slip = slip[0] * n[0] + slip[1] * n[1] + slip[2] * n[2]
                size = 0.0
                # Coulomb: the tangential force that prevents slip, cut to friction times the normal force
                for a in range(3):
                    tangential = f[a] - before * n[a]
                    # the slip without this patch's own tangential force, of which only a share came after touching
                    free_slip = (slip[a] - normal_slip * n[a]) - tangential / stiff_tangent[i]
                    new[a] = tangential - (share * free_slip + tangential / stiff_tangent[i]) * stiff_tangent[i]
                    size += new[a] * new[a]
                size = np.sqrt(size)
                limit = friction * after
                shrink = limit / size if size > limit else 1.0
                for a in range(3):
                    new[a] = shrink * new[a] + after * n[a]
            elif before == 0.0 and f[0] == 0.0 and f[1] == 0.0 and f[2] == 0.0:
                continue
            d0, d1, d2 = new[0] - f[0], new[1] - f[1], new[2] - f[2]
            # update the displacements of all patches by the change of this force
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
                displaced[k] += along_x[k] * d0 + along_y[k] * d1 + along_z[k] * d2
            f[0], f[1], f[2] = new[0], new[1], new[2]
            change = max(change, abs(d0), abs(d1), abs(d2))
            largest = max(largest, after)
        if change <= tolerance * largest:
            return change / largest if largest > 0.0 else 0.0
    return change / largest if largest > 0.0 else 0.0
