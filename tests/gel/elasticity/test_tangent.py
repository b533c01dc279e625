"""The tangent stiffness of a deformed pad: what it is a derivative of, and when it is positive definite."""

import numpy as np
import pytest
from scipy.sparse.linalg import splu

from tactiledata.gel.elasticity.compliance import FactorisedPad
from tactiledata.gel.elasticity.deformed import TangentFactory
from tactiledata.gel.elasticity.internal_forces import NEO_HOOKEAN, ElasticPad, internal_forces
from tactiledata.gel.elasticity.stiffening import Stiffening
from tactiledata.gel.elasticity.tangent import TangentAssembly, add_displacement_gradient
from tactiledata.gel.mesh.cells import cell_quadrature
from tactiledata.gel.mesh.structured_pad import GridPlan, structured_pad
from tactiledata.gel.mesh.surface import contact_surface
from tactiledata.sensors.base import GelGeometry

NU = 0.49


@pytest.fixture(scope="module")
def pad():
    mesh = structured_pad(
        "small", GelGeometry((8e-3, 8e-3), 4e-3, 3e-3), GridPlan(3, 3, 1e-3, (2e-3, 2e-3), (0, 0.6, 1))
    )
    return mesh, ElasticPad.of(mesh, cell_quadrature(mesh))


def _deformed(mesh, size, seed=0):
    """Random displacements (v, 3), m, of about ``size``; none at the base."""
    displacement = np.zeros((len(mesh.vertices), 3))
    displacement.ravel()[mesh.free] = np.random.default_rng(seed).normal(size=len(mesh.free)) * size
    return displacement


@pytest.mark.parametrize("law", [NEO_HOOKEAN, Stiffening(0.4, 0.1)])
def test_the_tangent_is_the_derivative_of_the_forces(pad, law):
    """At a crooked deformation it gives the central difference of the forces to 1e-6, and it is symmetric."""
    mesh, elastic = pad
    at, way = _deformed(mesh, 8e-5), _deformed(mesh, 1e-9, seed=1)
    tangent = TangentAssembly(elastic, mesh.free, NU, law).matrix(at)
    after, before = internal_forces(elastic, np.stack([at + way, at - way]), NU, None, law)
    expected = ((after - before) / 2).ravel()[mesh.free]
    np.testing.assert_allclose(tangent @ way.ravel()[mesh.free], expected, atol=1e-6 * np.abs(expected).max())
    assert abs(tangent - tangent.T).max() < 1e-12 * abs(tangent).max()


def test_the_displacement_gradient_is_added_to_what_is_there(pad):
    """Every entry at every point of a cell is the sum over its nodes of displacement times gradient, plus what was."""
    mesh, elastic = pad
    at = _deformed(mesh, 8e-5)
    found = np.arange(9.0 * elastic.gradients.shape[3]).reshape(9, -1)
    expected = found + np.einsum("ni,naq->iaq", at[elastic.cells[5]], elastic.gradients[5]).reshape(9, -1)
    assert np.abs(expected - found).max() > 1e-3
    add_displacement_gradient(at, elastic.cells[5], elastic.gradients[5], found)
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)


def test_filtered_tangents_are_positive_definite(pad):
    """Where a pad is pressed together by 45 % its tangent has negative eigenvalues, and the filtered one has none."""
    mesh, elastic = pad
    at = 0.15 * _deformed(mesh, 1e-3)
    at[:, 2] -= 0.45 * (mesh.vertices[:, 2] - mesh.vertices[:, 2].min())
    assembly = TangentAssembly(elastic, mesh.free, NU)
    lowest = [np.linalg.eigvalsh(assembly.matrix(at, is_filtered).toarray())[0] for is_filtered in (False, True)]
    assert lowest[0] < 0 < lowest[1]
    at_rest = np.zeros_like(at)
    assert abs(assembly.matrix(at_rest) - assembly.matrix(at_rest, is_filtered=True)).max() == 0


def test_members_answer_to_forces_as_the_pad_does(pad):
    """Compliance of some patches, and solutions, are those of the factorised tangent itself to 1e-4."""
    mesh, elastic = pad
    surface, at = contact_surface(mesh), _deformed(mesh, 1e-5)
    factorised = FactorisedPad(mesh, cell_quadrature(mesh), NU)
    members = np.array([3, 17, 24])
    deformed = TangentFactory(factorised, elastic, surface, NEO_HOOKEAN).at(at, members, is_filtered=False)
    assert not deformed.is_filtered
    exact = splu(TangentAssembly(elastic, mesh.free, NU).matrix(at))
    for column, axis in ((0, 0), (2, 1), (1, 2)):
        load = np.zeros((len(mesh.vertices), 3))
        load[surface.nodes, axis] = surface.averaging[members[column]].toarray().ravel()
        moved = np.zeros_like(load)
        moved.ravel()[mesh.free] = exact.solve(load.ravel()[mesh.free])
        largest = np.abs(moved).max()
        np.testing.assert_allclose(deformed.solve(load), moved, atol=1e-4 * largest)
        means = (surface.averaging @ moved[surface.nodes])[members]
        np.testing.assert_allclose(deformed.compliance[:, column, :, axis], means, atol=1e-4 * largest)


def test_a_tangent_that_is_not_positive_definite_is_filtered(pad):
    """Where a factor has negative pivots the filtered tangent is taken, the same one as if it had been asked for."""
    mesh, elastic = pad
    surface = contact_surface(mesh)
    at = 0.15 * _deformed(mesh, 1e-3)
    at[:, 2] -= 0.45 * (mesh.vertices[:, 2] - mesh.vertices[:, 2].min())
    tangents = TangentFactory(FactorisedPad(mesh, cell_quadrature(mesh), NU), elastic, surface, NEO_HOOKEAN)
    members = np.array([3, 17, 24])
    found, asked = (tangents.at(at, members, is_filtered) for is_filtered in (False, True))
    assert found.is_filtered
    assert asked.is_filtered
    np.testing.assert_array_equal(found.compliance, asked.compliance)
