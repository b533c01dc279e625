"""The pad's material against closed forms: what no mesh may spoil."""

from dataclasses import replace

import numpy as np
import pytest
from pressing import block
from scipy.spatial.transform import Rotation

from tactiledata.gel.elasticity.internal_forces import LANES, ElasticPad, internal_forces
from tactiledata.gel.elasticity.stiffness import linear_stiffness
from tactiledata.gel.mesh.cells import cell_quadrature
from tactiledata.gel.mesh.pad import PadMesh
from tactiledata.gel.mesh.tetrahedra import boundary_of, ten_node_cells

NU = 0.47
SHEAR = 1 / (2 * (1 + NU))
LAME = NU / ((1 + NU) * (1 - 2 * NU))
SIDE, HEIGHT = 4e-3, 3e-3


def distorted(kind):
    """A block 4 x 4 x 3 mm of crooked cells, its six sides plane."""
    mesh = block(SIDE / 2, HEIGHT, 2, 1.0, 1.0, (0, 0.4, 0.7, 1), 1.0)
    inner = np.ones(len(mesh.vertices), dtype=bool)
    for axis in range(3):
        place = mesh.vertices[:, axis]
        inner &= (place > place.min() + 1e-9) & (place < place.max() - 1e-9)
    points = mesh.vertices.copy()
    points[inner] += np.random.default_rng(1).uniform(-1.5e-4, 1.5e-4, (inner.sum(), 3))
    if kind == "hexahedron8":
        return PadMesh("crooked", kind, points, mesh.cells, mesh.base, mesh.faces)
    sixths = np.array([[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]])
    cells = mesh.cells[:, sixths].reshape(-1, 4)
    flip = np.linalg.det(points[cells[:, 1:]] - points[cells[:, :1]]) < 0
    cells[flip] = cells[flip][:, [1, 0, 2, 3]]
    faces = boundary_of(cells).faces
    vertices, ten, six = ten_node_cells(points, cells, faces)
    base = np.flatnonzero(vertices[:, 2] < -HEIGHT + 1e-9)
    outer = ~np.isin(six, base).all(axis=1)
    return PadMesh("crooked", kind, vertices, ten, base, six[outer])


@pytest.fixture(scope="module", params=["hexahedron8", "tetrahedron10"])
def crooked(request):
    mesh = distorted(request.param)
    quadrature = cell_quadrature(mesh)
    return mesh, quadrature, ElasticPad.of(mesh, quadrature)


def nodal_forces(crooked, displacement, nu=NU):
    return internal_forces(crooked[2], displacement[None], nu)[0]


def stretched(mesh, deformation):
    return mesh.vertices @ (np.asarray(deformation) - np.eye(3)).T


def on_top(mesh, forces):
    """Traction (3,), on the undeformed area, over the top of the block."""
    return forces[mesh.vertices[:, 2] > -1e-9].sum(axis=0) / SIDE**2


def inside(mesh):
    low, high = mesh.vertices.min(axis=0) + 1e-9, mesh.vertices.max(axis=0) - 1e-9
    return ((mesh.vertices > low) & (mesh.vertices < high)).all(axis=1)


def piola(deformation):
    """First Piola-Kirchhoff stress over Young's modulus, by hand from W of ``GelMaterial``."""
    back = np.linalg.inv(deformation).T
    return SHEAR * (deformation - back) + LAME * np.log(np.linalg.det(deformation)) * back


@pytest.mark.parametrize("volume", [1.0, 0.2, 3.0])
def test_patch(crooked, volume):
    """A uniform deformation is in equilibrium inside crooked cells, and its stress is that of the law.

    Where the volume changes much, a root is found in another way.
    """
    mesh = crooked[0]
    deformation = np.eye(3) + np.array([[0.1, 0.05, -0.02], [0.0, -0.07, 0.04], [0.03, 0.0, 0.06]])
    deformation *= volume ** (1 / 3)
    forces = nodal_forces(crooked, stretched(mesh, deformation))
    assert np.abs(forces[inside(mesh)]).max() < (1e-13 if volume == 1 else 1e-11) * SIDE
    np.testing.assert_allclose(on_top(mesh, forces), piola(deformation)[:, 2], rtol=1e-9, atol=1e-12)


def test_linear_patch(crooked):
    """The linear law passes the same test with Hooke's stress."""
    mesh, quadrature, _ = crooked
    strain = 1e-3 * np.array([[1.0, 0.5, -0.2], [0.5, -0.7, 0.4], [-0.2, 0.4, 0.6]])
    forces = (linear_stiffness(mesh, quadrature, NU) @ (mesh.vertices @ strain).ravel()).reshape(-1, 3)
    assert np.abs(forces[inside(mesh)]).max() < 1e-15
    stress = 2 * SHEAR * strain + LAME * np.trace(strain) * np.eye(3)
    np.testing.assert_allclose(on_top(mesh, forces), stress[:, 2], rtol=1e-9)


def test_rigid_motion_costs_nothing(crooked):
    """A turn and a shift of any size leave the pad without force; the linear law holds for shifts."""
    mesh, quadrature, _ = crooked
    turn = Rotation.from_rotvec([0.4, -0.9, 1.3]).as_matrix()
    forces = nodal_forces(crooked, stretched(mesh, turn) + np.array([1e-3, 2e-3, -3e-3]))
    assert np.abs(forces).max() < 1e-12 * SIDE**2
    stiffness = linear_stiffness(mesh, quadrature, NU)
    assert np.abs(stiffness @ np.ones(stiffness.shape[0])).max() < 1e-12 * abs(stiffness).max()


def test_forces_and_moments_of_any_deformation_balance(crooked):
    """Nodal forces sum to nothing, and so do their moments about the deformed places."""
    mesh = crooked[0]
    displacement = np.random.default_rng(2).uniform(-1e-4, 1e-4, mesh.vertices.shape)
    forces = nodal_forces(crooked, displacement)
    scale = np.abs(forces).sum()
    assert np.abs(forces.sum(axis=0)).max() < 1e-12 * scale
    moments = np.cross(mesh.vertices + displacement, forces)
    assert np.abs(moments.sum(axis=0)).max() < 1e-12 * scale * SIDE


def test_tangent_at_rest_is_the_linear_stiffness(crooked):
    """A central difference of the forces about rest is the linear stiffness times the direction."""
    mesh, quadrature, _ = crooked
    direction = np.random.default_rng(3).uniform(-1, 1, mesh.vertices.shape)
    step = 1e-8
    slope = (nodal_forces(crooked, step * direction) - nodal_forces(crooked, -step * direction)) / (2 * step)
    expected = (linear_stiffness(mesh, quadrature, NU) @ direction.ravel()).reshape(-1, 3)
    np.testing.assert_allclose(slope, expected, atol=1e-6 * np.abs(expected).max())


def test_forces_derive_from_an_energy(crooked):
    """The tangent of a deformed pad is symmetric, and a closed path of deformations does no work."""
    mesh = crooked[0]
    draw = np.random.default_rng(4)
    start, first, second = (draw.uniform(-1, 1, mesh.vertices.shape) for _ in range(3))
    start, step = 8e-5 * start, 1e-8

    def slope(direction):
        ahead, behind = (nodal_forces(crooked, start + sign * step * direction) for sign in (1, -1))
        return (ahead - behind) / (2 * step)

    one, other = (slope(first) * second).sum(), (slope(second) * first).sum()
    assert one == pytest.approx(other, rel=1e-6)
    turns = np.linspace(0, 2 * np.pi, 401)
    path = [start + 4e-5 * (np.sin(turn) * first + np.cos(turn) * second) for turn in turns]
    forces = [nodal_forces(crooked, place) for place in path]
    works = [(0.5 * (forces[i] + forces[i + 1]) * (path[i + 1] - path[i])).sum() for i in range(400)]
    assert abs(sum(works)) < 1e-3 * np.abs(works).sum()


@pytest.mark.parametrize("stretch", [0.6, 0.9, 1.2])
def test_oedometric_compression(crooked, stretch):
    """Squeezed between walls, the pad pushes as mu (s - 1/s) + lambda ln s / s."""
    mesh = crooked[0]
    traction = on_top(mesh, nodal_forces(crooked, stretched(mesh, np.diag([1, 1, stretch]))))
    expected = SHEAR * (stretch - 1 / stretch) + LAME * np.log(stretch) / stretch
    np.testing.assert_allclose(traction, [0, 0, expected], rtol=1e-9, atol=1e-12)


def test_simple_shear(crooked):
    """Sheared by g, the pad pulls back with mu g, and its top without normal traction on the undeformed area."""
    mesh = crooked[0]
    deformation = np.eye(3)
    deformation[0, 2] = 0.7
    traction = on_top(mesh, nodal_forces(crooked, stretched(mesh, deformation)))
    np.testing.assert_allclose(traction, [SHEAR * 0.7, 0, 0], rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("at_once", [1, 7])
def test_cells_do_not_know_which_others_are_computed_with_them(at_once):
    """Forces of 180 cells, in groups of which the last is not full, are the sums of those of few cells each.

    One cell is squeezed to a fifteenth of its volume, so that its group finds the root in another way.
    """
    mesh = block(SIDE / 2, HEIGHT, 3, 1.0, 1.0, (0, 0.2, 0.4, 0.6, 0.8, 1), 1.0)
    count = len(mesh.cells)
    assert count > LANES
    assert count % LANES
    displacement = np.random.default_rng(5).uniform(-1e-4, 1e-4, mesh.vertices.shape)
    squeezed = mesh.cells[0]
    displacement[squeezed] = -0.6 * (mesh.vertices[squeezed] - mesh.vertices[squeezed].mean(axis=0))
    found = internal_forces(ElasticPad.of(mesh, cell_quadrature(mesh)), displacement[None], NU)[0]
    expected = np.zeros_like(found)
    for first in range(0, count, at_once):
        part = replace(mesh, cells=mesh.cells[first : first + at_once])
        expected += internal_forces(ElasticPad.of(part, cell_quadrature(part)), displacement[None], NU)[0]
    np.testing.assert_allclose(found, expected, atol=1e-12 * np.abs(expected).max())
