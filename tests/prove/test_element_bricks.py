"""The bricks of the world of elements: stresses by hand, derivatives, no locking, and their linear systems."""

import ast
from pathlib import Path

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.linalg import spsolve

from tactiledata.prove.element_world.bodies import body_of
from tactiledata.prove.element_world.pad import BrickPad
from tactiledata.prove.element_world.slices import Slices
from tactiledata.prove.element_world.steps import Stepper
from tactiledata.prove.element_world.surface import Pose, SpringSurface

FOLDER = Path(__file__).resolve().parents[2] / "tactiledata" / "prove" / "element_world"
ALLOWED = {
    "tactiledata.contract.atomic",
    "tactiledata.contract.program",
    "tactiledata.rig.contact.contact",
    "tactiledata.rig.motion.motion",
    "tactiledata.rig.scenario.scenario",
}
"""What it takes of the package: how files are written and digested, and the records of its interface to the rig."""


def lines(counts, sides):
    """Even grid lines of a pad of some sides, mm, whose outer surface is at 0."""
    x, y, z = (np.linspace(0.0, side, count + 1) for count, side in zip(counts, sides, strict=True))
    return x - sides[0] / 2, y - sides[1] / 2, z - sides[2]


def test_it_shares_nothing_with_the_simulation_and_the_other_generators():
    """The world of elements imports from the package only the interface to the rig and how files are kept."""
    found = set()
    for source in FOLDER.glob("*.py"):
        for node in ast.walk(ast.parse(source.read_text("utf-8"))):
            if isinstance(node, ast.ImportFrom):
                found.add(node.module)
            elif isinstance(node, ast.Import):
                found.update(name.name for name in node.names)
    of_package = {name for name in found if name.startswith("tactiledata")}
    assert {name for name in of_package if not name.startswith("tactiledata.prove.element_world")} == ALLOWED
    assert "skfem" in found


def test_an_even_deformation_has_the_forces_of_the_law():
    """BrickForces of an even deformation do the work of the energy's derivative, and none is left at inner nodes."""
    pad = BrickPad(lines((3, 3, 2), (3.0, 2.0, 1.5)), 0.48)
    change = np.array([[1.1, 0.0, 0.3], [0.05, 0.95, -0.1], [0.0, 0.02, 0.93]])
    forces = np.zeros_like(pad.places)
    np.add.at(forces, pad.bricks, pad.respond(pad.places @ (change - np.eye(3)).T).force)

    def energy(f):
        """G/2 (J^(-2/3) I1 - 3) + K/4 (J² - 1 - 2 ln J) of a modulus of 1 and Poisson's ratio 0.48."""
        j = np.linalg.det(f)
        return (j ** (-2 / 3) * np.sum(f * f) - 3) / 5.92 + (j * j - 1 - 2 * np.log(j)) / 0.48

    for place in np.ndindex(3, 3):
        step = np.zeros((3, 3))
        step[place] = 1e-5
        rate = (energy(change + step) - energy(change - step)) / 2e-5
        assert np.sum(forces * (pad.places @ step.T)) / 1e-5 == pytest.approx(9.0 * rate, abs=1e-6)
    inner = (np.abs(pad.places - [0.0, 0.0, -0.75]) < [1.49, 0.99, 0.74]).all(axis=1)
    assert inner.any()
    assert np.abs(forces[inner]).max() < 1e-12


def test_stiffness_is_the_derivative_of_the_forces():
    """A small change of the displacements changes each brick's forces by its stiffness times the change."""
    pad = BrickPad(lines((2, 2, 1), (2.0, 2.0, 0.8)), 0.48)
    chance = np.random.default_rng(1)
    u, step = 0.08 * chance.normal(size=(2, *pad.places.shape))
    change = (pad.respond(u + 1e-4 * step).force - pad.respond(u - 1e-4 * step).force) / 2e-4
    told = np.einsum("eaibj,ebj->eai", pad.respond(u).stiffness, step[pad.bricks])
    assert np.abs(told - change).max() < 1e-5 * np.abs(change).max()


def test_slices_solve_as_a_sparse_matrix_does():
    """Elimination by slices gives the solution of the same sparse system, to single precision."""
    pad = BrickPad(lines((3, 2, 2), (3.0, 2.0, 1.0)), 0.48)
    slices = Slices(pad)
    stiffness = pad.respond(np.zeros_like(pad.places)).stiffness.astype(float)
    mine = slices.unknown[pad.bricks].reshape(len(pad.bricks), 24)
    row, column = (part.ravel() for part in np.broadcast_arrays(mine[:, :, None], mine[:, None, :]))
    kept = (row >= 0) & (column >= 0)
    whole = coo_array((stiffness.ravel()[kept], (row[kept], column[kept]))).tocsc()
    right = np.random.default_rng(2).normal(size=whole.shape[0])
    expected = spsolve(whole, right)
    assert np.abs(slices.factor(stiffness).solve(right) - expected).max() < 1e-3 * np.abs(expected).max()


@pytest.mark.slow
@pytest.mark.parametrize("poisson_ratio", [0.48, 0.499])
def test_a_bonded_square_is_as_stiff_as_kelly_says(poisson_ratio):
    """A square under a plate that holds it has the modulus E (1 + 2.25 S²), in series with the bulk modulus.

    S is the loaded area over the free one; Gent and Lindley (1959), for a square Kelly (1993): 6.75 G S². Bricks that
    lock would be several times as stiff.
    """
    side, thickness = 16.0, 2.0
    pad = BrickPad(lines((20, 20, 5), (side, side, thickness)), poisson_ratio)
    stepper = Stepper(pad, SpringSurface(pad, 1e3, 0.1))
    plate = body_of("box", {"width": 0.04, "breadth": 0.04})
    state, forces, depths = stepper.rest(Pose(plate, np.eye(3), np.array([0.0, 0.0, 0.01]))), [], (4e-4, 4e-3, 2e-2)
    for depth in depths:
        state = stepper.move(state, Pose(plate, np.eye(3), np.array([0.0, 0.0, -depth])))
        forces.append(state.wrench[2])
    assert state.unsettled == 0
    shape = 1.0 + 2.25 * (side / (4.0 * thickness)) ** 2
    modulus = 1.0 / (1.0 / shape + 3.0 * (1.0 - 2.0 * poisson_ratio))
    # the contact's springs set in 2 µm early, so that the rise between two depths counts
    rise = (forces[2] - forces[1]) / (depths[2] - depths[1])
    assert rise == pytest.approx(modulus * side**2 / thickness, rel=0.05)
