"""Contact surface of a pad: patches that carry tractions, and the points over which gaps are averaged."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array, diags_array

from tactiledata.arrays import Array, Indices
from tactiledata.gel.mesh.pad import PadMesh

POINTS_A_SIDE = 6
"""Contact points along each side of a face; they are finer than the nodes, so that edges are resolved."""


@dataclass(frozen=True)
class ContactSurface:
    """Faces, patches and contact points of a pad's outer surface.

    A *patch* belongs to a corner node: the points of the faces around it, weighted by its shape function. Tractions are
    linear (bilinear) between the m corner nodes, and contact is integrated over the points.

    Parameters
    ----------
    nodes : (s,)
        Surface nodes, as numbers in the mesh.
    corners : (m,)
        Nodes that carry tractions, as positions in ``nodes``.
    faces : (f, k), face_corners : (f, c)
        Nodes and corners of each face, as positions in ``nodes`` and in ``corners``.
    shapes : (q, k), corner_shapes : (q, c)
        Shape functions of displacement and of traction at the q points of a face.
    areas : (f, q) m^2
        Undeformed area of each point.
    patch_areas : (m,) m^2
        Undeformed area of each patch.
    averaging : (m, s)
        Matrix from displacements of nodes to mean displacements of patches; its transpose distributes patch forces to
        nodes.
    """

    nodes: Indices
    corners: Indices
    faces: Indices
    face_corners: Indices
    shapes: Array
    corner_shapes: Array
    areas: Array
    patch_areas: Array
    averaging: csr_array


def contact_surface(mesh: PadMesh) -> ContactSurface:
    """Return the whole outer surface of a mesh on which a contact may press, with its patches.

    A patch is the surroundings of one corner node: the integration points of its faces, each by the corner's shape
    function. Areas are those of the undeformed pad, m^2.

    Parameters
    ----------
    mesh : PadMesh
        Mesh with its outer faces, hexahedra or tetrahedra.
    """
    nodes = mesh.surface
    faces = np.searchsorted(nodes, mesh.faces)
    corner_count = 4 if mesh.kind == "hexahedron8" else 3
    corners = np.unique(faces[:, :corner_count])
    face_corners = np.searchsorted(corners, faces[:, :corner_count])
    if mesh.kind == "hexahedron8":
        shapes, slopes, point_area = _square(POINTS_A_SIDE)
        corner_shapes = shapes
    else:
        shapes, slopes, corner_shapes, point_area = _triangle(POINTS_A_SIDE)
    # undeformed area of each point and each patch
    tangents = np.einsum("qnk,fni->fqki", slopes, mesh.vertices[mesh.faces], optimize=True)
    areas = np.linalg.norm(np.cross(tangents[:, :, 0], tangents[:, :, 1]), axis=-1) * point_area
    weighted = areas[:, :, None] * corner_shapes
    patch_areas = np.zeros(len(corners))
    np.add.at(patch_areas, face_corners, weighted.sum(axis=1))
    # mean of a node's shape function over each patch
    coupling = np.einsum("fqc,qn->fcn", weighted, shapes, optimize=True)
    rows = np.broadcast_to(face_corners[:, :, None], coupling.shape)
    columns = np.broadcast_to(faces[:, None, :], coupling.shape)
    sums = csr_array((coupling.ravel(), (rows.ravel(), columns.ravel())), shape=(len(corners), len(nodes)))
    averaging = csr_array(diags_array(1.0 / patch_areas) @ sums)
    return ContactSurface(nodes, corners, faces, face_corners, shapes, corner_shapes, areas, patch_areas, averaging)


def _square(side: int) -> tuple[Array, Array, float]:
    """Bilinear shape functions (q, 4), their slopes (q, 4, 2) and the area of each point in the square [-1, 1]^2."""
    steps = (np.arange(side) + 0.5) / side * 2.0 - 1.0
    a, b = (grid.ravel() for grid in np.meshgrid(steps, steps, indexing="ij"))
    signs = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], dtype=float)
    along_a, along_b = 1.0 + signs[:, 0] * a[:, None], 1.0 + signs[:, 1] * b[:, None]
    slopes = np.stack([signs[:, 0] * along_b, signs[:, 1] * along_a], axis=-1) / 4.0
    return along_a * along_b / 4.0, slopes, 4.0 / side**2


def _triangle(side: int) -> tuple[Array, Array, Array, float]:
    """Shape functions (q, 6), slopes (q, 6, 2), corner shapes (q, 3) and the area of a point in a six-node triangle.

    The points are the centres of side^2 equal small triangles; corner shapes are linear.
    """
    points = []
    for i in range(side):
        for j in range(side - i):
            points.append(((i + 1 / 3) / side, (j + 1 / 3) / side))
            if i + j < side - 1:
                points.append(((i + 2 / 3) / side, (j + 2 / 3) / side))
    # quadratic shape functions in barycentric coordinates
    b, c = np.array(points).T
    corner = np.stack([1.0 - b - c, b, c], axis=1)
    slope = np.array([[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]])
    pairs = ((0, 1), (1, 2), (2, 0))
    shapes = np.concatenate(
        [corner * (2.0 * corner - 1.0), np.stack([4.0 * corner[:, i] * corner[:, j] for i, j in pairs], axis=1)],
        axis=1,
    )
    slopes = np.concatenate(
        [
            (4.0 * corner - 1.0)[:, :, None] * slope,
            np.stack([4.0 * (corner[:, i, None] * slope[j] + corner[:, j, None] * slope[i]) for i, j in pairs], axis=1),
        ],
        axis=1,
    )
    return shapes, slopes, corner, 0.5 / side**2
