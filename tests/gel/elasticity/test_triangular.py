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
    return FactorisedPad.of(mesh, cell_quadrature(mesh), request.param)


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
