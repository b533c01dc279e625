"""The factor in dense blocks, against the factor that it was made from."""

import numpy as np
import pytest

from tactiledata.gel.elasticity.compliance import FactorisedPad
from tactiledata.gel.mesh.cells import cell_quadrature
from tactiledata.gel.mesh.structured_pad import GridPlan, structured_pad
from tactiledata.sensors.digit import DIGIT

PLAN = GridPlan(7, 9, 0.8e-3, (2.4e-3, 2.4e-3), (0.0, 0.5, 0.8, 1.0))


@pytest.fixture(scope="module", params=[0.46, 0.495])
def pad(request):
    mesh = structured_pad("coarse", DIGIT.gel, PLAN)
    return FactorisedPad(mesh, cell_quadrature(mesh), request.param)


def loads(pad, count):
    forces = np.random.default_rng(0).standard_normal((count, len(pad.mesh.vertices), 3))
    forces[:, pad.mesh.base] = 0.0
    return forces


def off(found, expected):
    return np.abs(found - expected).max() / np.abs(expected).max()


@pytest.mark.parametrize("count", [1, 5, 8, 21])
def test_solutions_agree(pad, count):
    """Single-precision and refined solutions agree with the exact one, for every number of load cases."""
    forces = loads(pad, count)
    expected = pad.solve(forces)
    assert off(pad.solve_roughly(forces), expected) < 2e-5
    assert off(pad.solve_refined(forces), expected) < 1e-9


@pytest.mark.parametrize("lanes", [1, 3, 48])
def test_any_number_of_lanes_gives_the_solutions(pad, lanes):
    """Groups of 1, 3 and 48 right-hand sides; 21 fill none of the last two evenly."""
    right = loads(pad, 21).reshape(21, -1)[:, pad.mesh.free]
    expected = pad.factor.solve(np.asfortranarray(right.T)).T
    assert off(pad.blocks.solve(right, lanes=lanes), expected) < 2e-5


@pytest.mark.slow
def test_blocks_hold_the_factor(pad):
    """Put together again, triangles and rectangles are SciPy's lower factor, and each triangle's inverse is its own."""
    blocks, lower = pad.blocks, pad.factor.L.toarray()
    found = np.zeros_like(lower)
    for block, (first, end) in enumerate(zip(blocks.starts, blocks.starts[1:], strict=False)):
        width = end - first
        rows = blocks.rows[blocks.row_starts[block] : blocks.row_starts[block + 1]]
        below = blocks.below[blocks.below_starts[block] : blocks.below_starts[block + 1]]
        corner = blocks.corners[blocks.corner_starts[block] : blocks.corner_starts[block + 1]].reshape(width, width)
        found[first:end, first:end] = np.linalg.inv(corner.astype(float))
        found[rows, first:end] = below.reshape(len(rows), width)
    assert np.diff(blocks.starts).max() > 10
    np.testing.assert_allclose(found, lower, atol=1e-5)
    np.testing.assert_allclose(1.0 / blocks.inverse_diagonal, pad.factor.U.diagonal(), rtol=1e-6)


def test_company_changes_no_bit(pad):
    """A load case has bit for bit the same solution alone and beside others."""
    forces = loads(pad, 11)
    together = pad.solve_roughly(forces)
    for number in (0, 3, 7, 10):
        assert np.array_equal(pad.solve_roughly(forces[number : number + 1])[0], together[number])


def test_the_base_stays(pad):
    """The base of the pad does not move under loads."""
    forces = loads(pad, 2)
    assert not pad.solve_roughly(forces)[:, pad.mesh.base].any()
