"""Yeoh's terms and cells of their own stiffness: by hand, and where they must change nothing."""

import numpy as np
import pytest
from test_elasticity import NU, SHEAR, distorted, inside, on_top, piola, stretched

from tactiledata.errors import UsageError
from tactiledata.gel.contact.history import GelTouch
from tactiledata.gel.elasticity.compliance import FactorisedPad, surface_response
from tactiledata.gel.elasticity.internal_forces import ElasticPad, internal_forces
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.gel.elasticity.stiffening import Stiffening
from tactiledata.gel.engines.fem import FemEngine
from tactiledata.gel.mesh.cells import cell_quadrature
from tactiledata.gel.mesh.structured_pad import GridPlan, structured_pad
from tactiledata.gel.mesh.surface import contact_surface
from tactiledata.indenters.sphere import Sphere
from tactiledata.sensors.digit import DIGIT

PLAN = GridPlan(7, 9, 0.8e-3, (2.4e-3, 2.4e-3), (0.0, 0.5, 0.8, 1.0))
DEFORMATION = np.eye(3) + np.array([[0.2, 0.05, -0.02], [0.0, -0.15, 0.04], [0.03, 0.0, 0.06]])


@pytest.fixture(scope="module")
def pad():
    return structured_pad("coarse", DIGIT.gel, PLAN)


@pytest.mark.parametrize("kind", ["hexahedron8", "tetrahedron10"])
@pytest.mark.parametrize(("c20", "c30"), [(0.2, 0.0), (-0.05, 0.05)])
def test_stress_is_the_law_s(kind, c20, c30):
    """The stress of a uniform deformation is neo-Hooke's with the derivative of Yeoh's terms, by differences."""
    mesh = distorted(kind)
    forces = internal_forces(
        ElasticPad.of(mesh, cell_quadrature(mesh)),
        stretched(mesh, DEFORMATION)[None],
        NU,
        stiffening=Stiffening(c20, c30),
    )[0]

    def further(f):
        strain = np.linalg.det(f) ** (-2 / 3) * (f * f).sum() - 3
        return SHEAR / 2 * (c20 * strain**2 + c30 * strain**3)

    step = 1e-6
    slope = np.array(
        [
            [
                (further(DEFORMATION + step * unit) - further(DEFORMATION - step * unit)) / (2 * step)
                for unit in (np.outer(np.eye(3)[i], np.eye(3)[j]) for j in range(3))
            ]
            for i in range(3)
        ]
    )
    assert np.abs(slope).max() > 1e-3
    assert on_top(mesh, forces) == pytest.approx((piola(DEFORMATION) + slope)[:, 2], rel=1e-6)
    assert np.abs(forces[inside(mesh)]).max() < 1e-12


def test_no_terms_change_no_bit(pad):
    """Yeoh's terms of 0 change no bit of the forces."""
    elastic = ElasticPad.of(pad, cell_quadrature(pad))
    moved = np.random.default_rng(0).normal(0, 2e-5, (2, *pad.vertices.shape))
    plain = internal_forces(elastic, moved, NU)
    assert np.array_equal(internal_forces(elastic, moved, NU, stiffening=Stiffening(0.0, 0.0)), plain)


def pressed(engine):
    poses = np.tile(np.eye(4), (3, 1, 1))
    poses[:, 2, 3] = [-0.2e-3, -0.4e-3, -0.6e-3]
    _, history = next(engine.play([GelTouch(Sphere(radius=4e-3), poses)], GelMaterial(1.0, engine.poisson_ratio, 0.5)))
    return history.wrench[:, 2]


@pytest.mark.slow
@pytest.mark.parametrize("fidelity", ["linear", "finite-strain"])
def test_a_gel_twice_as_stiff_pushes_twice_as_hard(pad, fidelity):
    """A gel whose cells are all twice as stiff pushes twice as hard, linear and at finite strain."""
    plain = pressed(FemEngine(pad, 0.47, fidelity))
    double = pressed(FemEngine(pad, 0.47, fidelity, modulus=np.full(len(pad.cells), 2.0)))
    assert double == pytest.approx(2 * plain, rel=2e-3)


def test_a_stiff_skin_is_felt_and_is_not_read_from_another_gel_s_cache(pad):
    """A stiff skin raises forces, and its compliance is not that which the cache holds for a gel without it."""
    skin = np.where(pad.vertices[pad.cells, 2].max(axis=1) > -0.4e-3, 3.0, 1.0)
    assert (skin > 1).any()
    assert (pressed(FemEngine(pad, 0.47, "linear", modulus=skin)) > 1.1 * pressed(FemEngine(pad, 0.47, "linear"))).all()
    surface = contact_surface(pad)
    plain, stiff = (
        surface_response(FactorisedPad(pad, quadrature, 0.47), surface)
        for quadrature in (cell_quadrature(pad), cell_quadrature(pad).stiffened(skin))
    )
    assert np.abs(stiff - plain).max() > 0.1 * np.abs(plain).max()


def test_the_same_gel_is_kept_once(pad, tmp_path, monkeypatch):
    """A Poisson's ratio from an array is the same number: its compliance is read from the same file."""
    monkeypatch.setenv("TACTILEDATA_CACHE", str(tmp_path))
    for ratio in (0.47, np.float64(0.47)):
        surface_response(FactorisedPad(pad, cell_quadrature(pad), ratio), contact_surface(pad))
    assert len(list(tmp_path.rglob("*.npy"))) == 1


@pytest.mark.slow
def test_stiffening_grows_with_depth(pad):
    """Yeoh's terms raise the force by a share that grows with depth."""
    plain = pressed(FemEngine(pad, 0.47))
    share = pressed(FemEngine(pad, 0.47, stiffening=Stiffening(c20=0.2))) / plain - 1
    assert (share > 0).all()
    assert share[2] > 2 * share[0]


def test_wrong_factors_are_refused(pad):
    """Refused are factors other than one positive number for each cell, and terms that are not finite."""
    for wrong in (np.ones(3), np.zeros(len(pad.cells)), np.full(len(pad.cells), np.nan)):
        with pytest.raises(UsageError, match="positive numbers"):
            cell_quadrature(pad).stiffened(wrong)
    with pytest.raises(UsageError, match="c20"):
        Stiffening(c20=float("nan"))
