"""The engine against solvers of scikit-fem that share nothing with it but the equations."""

import numpy as np
import pytest
from axisymmetric import Layer
from pressing import forces_at, poses, pressed, slab
from scipy.sparse.linalg import splu
from skfem import Basis, BilinearForm, ElementHex0, ElementHex1, ElementVector, MeshHex, condense, solve
from skfem.helpers import ddot, div, sym_grad

from tactiledata.gel.engines.fem import FemEngine
from tactiledata.gel.mesh.pad import PadMesh
from tactiledata.indenters.cylinder_flat import CylinderFlat
from tactiledata.indenters.sphere import Sphere

LEVELS = (0, 0.3, 0.52, 0.68, 0.8, 0.88, 0.94, 1)
DEPTHS = (2e-4, 5e-4, 1e-3)


def mixed_solution(mesh: PadMesh, poisson_ratio, held, places):
    """Nodal forces (v, 3) and displacements (v, 3) where nodes ``held`` are put at displacements ``places``.

    Linear, Young's modulus 1: trilinear displacement and a pressure for each cell, solved together.
    """
    order = [0, 1, 3, 4, 2, 5, 7, 6]  # scikit-fem's order of a brick's corners
    grid = MeshHex(np.ascontiguousarray(mesh.vertices.T), np.ascontiguousarray(mesh.cells.T[order]), sort_t=False)
    shear = 1 / (2 * (1 + poisson_ratio))
    bulk = 1 / (3 * (1 - 2 * poisson_ratio))
    moved, pressure = Basis(grid, ElementVector(ElementHex1()), intorder=2), Basis(grid, ElementHex0(), intorder=2)
    stiffness = BilinearForm(
        lambda u, v, w: 2 * shear * (ddot(sym_grad(u), sym_grad(v)) - div(u) * div(v) / 3)
    ).assemble(moved)
    coupling = BilinearForm(lambda u, q, w: div(u) * q).assemble(moved, pressure)
    volumes = BilinearForm(lambda p, q, w: p * q / bulk).assemble(pressure)
    whole = stiffness + coupling.T @ _inverse(volumes) @ coupling
    dofs = moved.nodal_dofs.T
    prescribed = np.zeros(moved.N)
    prescribed[dofs[held]] = places
    solution = solve(*condense(whole, x=prescribed, D=dofs[held].ravel()), solver=_solved)
    return (whole @ solution)[dofs], solution[dofs]


def _solved(matrix, vector):
    """Solution of a symmetric system, in an order for such: its factor has a fraction of the usual one's entries."""
    options = {"SymmetricMode": True}
    return splu(matrix.tocsc(), "MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options).solve(vector)


def _inverse(diagonal):
    inverse = diagonal.copy()
    inverse.data = 1 / inverse.data
    return inverse


@pytest.mark.parametrize("poisson_ratio", [0.3, 0.495])
def test_contact_nodes_at_prescribed_places(poisson_ratio):
    """Where the loaded nodes are put where the engine left them, another solver finds its force and surface."""
    engine = FemEngine(slab(), poisson_ratio, "linear")
    history = pressed(engine, Sphere(4e-3), poses((0, 0, -0.3), (0.2, 0, -0.5)), 0.4)
    mesh = engine.mesh
    loaded = mesh.surface[np.abs(history.node_forces[-1]).max(axis=1) > 0]
    held = np.concatenate([mesh.base, loaded])
    places = np.zeros((len(held), 3))
    places[len(mesh.base) :] = history.displacement[-1, loaded]
    forces, moved = mixed_solution(mesh, poisson_ratio, held, places)
    np.testing.assert_allclose(
        1e6 * forces[mesh.base].sum(axis=0), history.wrench[-1, :3], atol=1e-3 * history.wrench[-1, 2]
    )
    np.testing.assert_allclose(moved, history.displacement[-1], atol=1e-3 * np.abs(moved).max())


@pytest.fixture(scope="module")
def layer():
    return Layer(12e-3, 4e-3, 2e-4, 2.4e-3)


@pytest.fixture(scope="module")
def fine():
    return slab(0.24e-3, 16, 2.4e-3, LEVELS, 3.2e-3)


@pytest.mark.nightly
@pytest.mark.parametrize("fidelity", ["linear", "finite-strain"])
def test_ball_on_a_layer(layer, fine, fidelity):
    """Force is within 2 % and the surface within 3 % of the depth of an axisymmetric solution with its own contact."""
    expected, shapes = layer.balled(4e-3, DEPTHS, 0.47, fidelity == "linear")
    engine = FemEngine(fine, 0.47, fidelity)
    history = pressed(
        engine, Sphere(4e-3), poses(*[(0, 0, -1e3 * depth) for depth in (1e-4, 2e-4, 3.5e-4, 5e-4, 7.5e-4, 1e-3)])
    )
    frames = [1, 3, 5]
    np.testing.assert_allclose(history.wrench[frames, 2], 1e6 * expected, rtol=0.02)
    points = fine.vertices[fine.surface]
    away = np.linalg.norm(points[:, :2], axis=1)
    for frame, depth, (radii, outward, upward) in zip(frames, DEPTHS, shapes, strict=True):
        moved = history.displacement[frame, fine.surface].astype(float)
        assert np.abs(moved[:, 2] - np.interp(away, radii, upward)).max() < 0.03 * depth
        radial = (moved[:, :2] * points[:, :2]).sum(axis=1) / np.maximum(away, 1e-9)
        assert np.abs(radial - np.interp(away, radii, outward)).max() < 0.03 * depth


@pytest.mark.nightly
def test_no_locking(layer):
    """Up to nu = 0.495 the force follows a solution of quadratic cells: it grows smoothly, and by no more."""
    ratios = (0.45, 0.48, 0.495)
    expected = [1e6 * layer.balled(4e-3, [3e-4], nu, True)[0][0] for nu in ratios]
    mesh = slab(0.3e-3, 11, 1.5e-3, LEVELS, 1.8e-3)
    found = [forces_at(mesh, nu, "linear", Sphere(4e-3), [3e-4])[0] for nu in ratios]
    np.testing.assert_allclose(found, expected, rtol=0.03)
    relative = np.array(found) / expected
    assert np.ptp(relative) < 0.003


@pytest.mark.slow
@pytest.mark.parametrize(("friction", "is_glued"), [(0.0, False), (50.0, True)])
def test_flat_punch_on_a_bonded_layer(friction, is_glued):
    """A punch of 3 mm, sliding freely or glued, has the force of the axisymmetric solution within 3 %."""
    yardstick = Layer(12e-3, 4e-3, 1e-4, 3.8e-3).punched(3e-3, 3e-4, 0.47, True, is_glued, 1)
    mesh = slab(0.3e-3, 15, 3.3e-3, LEVELS, 3.5e-3)
    force = forces_at(mesh, 0.47, "linear", CylinderFlat(radius=3e-3), [1.5e-4, 3e-4], friction)[-1]
    assert force == pytest.approx(1e6 * yardstick, rel=0.03)


@pytest.mark.nightly
def test_refinement_converges(layer):
    """Halving the cells cuts the ball's error by half or more; at a punch's rim, which cuts patches, it stays small."""
    coarse = slab(0.6e-3, 8, 3.0e-3, (0, 0.5, 0.8, 1), 3.7e-3)
    halved = slab(0.3e-3, 15, 3.0e-3, (0, 0.25, 0.5, 0.65, 0.8, 0.9, 1), 3.7e-3)
    ball = 1e6 * layer.balled(4e-3, [5e-4], 0.47, True)[0][0]
    errors = [forces_at(mesh, 0.47, "linear", Sphere(4e-3), [5e-4])[0] / ball - 1 for mesh in (coarse, halved)]
    assert abs(errors[1]) < abs(errors[0]) / 2
    punch = 1e6 * Layer(12e-3, 4e-3, 5e-5, 3.4e-3).punched(3e-3, 3e-4, 0.47, True, False, 1)
    for mesh in (coarse, halved):
        assert forces_at(mesh, 0.47, "linear", CylinderFlat(radius=3e-3), [3e-4])[0] == pytest.approx(punch, rel=0.03)
