"""Closed forms of effects against the gel engine itself, linear: what they approximate, and how well."""

import dataclasses

import numpy as np
import pytest

from tactiledata.effects.design import null_exact_weights
from tactiledata.effects.geometry.thickness import Thickness
from tactiledata.effects.interface.partial_slip import slip_levels
from tactiledata.effects.touch.response import ContactResponse
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.indenters.sphere import Sphere
from tactiledata.sensors.digit import DIGIT

pytestmark = pytest.mark.slow
pytest.importorskip("numba")
MATERIAL = GelMaterial(0.88e6, 0.48, 0.8)


@pytest.fixture
def gel(monkeypatch, tmp_path):
    """gel(poses, geometry, modulus): wrenches on a 4 mm ball; modulus: a factor over places (c, 3), cell by cell."""
    from tactiledata.gel.contact.history import GelTouch
    from tactiledata.gel.engines import fem
    from tactiledata.gel.mesh.cells import cell_quadrature
    from tactiledata.gel.mesh.structured_pad import pad_mesh

    def play(poses, geometry=DIGIT.gel, modulus=None):
        mesh = pad_mesh("test", geometry)
        middles = mesh.vertices[mesh.cells].mean(axis=1)
        factor = np.ones(len(middles)) if modulus is None else modulus(middles)

        def weighted(mesh):
            plain = cell_quadrature(mesh)
            return dataclasses.replace(plain, weights=plain.weights * factor[:, None])

        monkeypatch.setattr(fem, "cell_quadrature", weighted)
        # responses are kept by mesh, which does not know of the factor
        monkeypatch.setenv("TACTILEDATA_CACHE", str(tmp_path / f"{hash(factor.tobytes())}"))
        engine = fem.FemEngine(mesh, MATERIAL.poisson_ratio, "linear")
        ((_, history),) = engine.play([GelTouch(Sphere(0.004), poses)], MATERIAL, "none")
        return history.wrench

    return play


def press(depths, x=0.0):
    poses = np.tile(np.eye(4), (len(depths), 1, 1))
    poses[:, 0, 3], poses[:, 2, 3] = x, -np.asarray(depths)
    return poses


@pytest.mark.nightly
def test_a_parabola_carries_the_thickness(gel):
    """Between and beyond the design points, the change is met within 4 %."""
    poses = press([-1e-4, 3e-4, 6e-4, 1e-3])

    def thick(error):
        factor = Thickness().variant({"error": error}).thickness
        height = DIGIT.gel.thickness * factor
        rim = height - (DIGIT.gel.thickness - DIGIT.gel.edge_thickness)
        return gel(poses, dataclasses.replace(DIGIT.gel, thickness=height, edge_thickness=rim))[1:, 2]

    plain = gel(poses)[1:, 2]
    places = Thickness.designs["error"]
    designs = np.array([thick(place) - plain for place in places])
    for error in (0.08, -0.2):
        np.testing.assert_allclose(null_exact_weights(places, error) @ designs, thick(error) - plain, rtol=0.04)


@pytest.mark.nightly
def test_a_soft_spot_is_met_to_first_order(gel, touch, play):
    """Loss of force is met within a quarter and 0.01, the centre of pressure within 20 um, over and beside the spot."""
    spot = {"normal_loss": 0.3, "radius": 2e-3}
    for x in (0.0, 2e-3, 4e-3):
        poses = press([-1e-4, 4e-4, 1e-3], x)
        plain = gel(poses)[1:]
        soft = gel(poses, modulus=lambda at: 1 - 0.3 * np.exp(-(at[:, :2] ** 2).sum(axis=1) / (2 * 2e-3**2)))[1:]

        class Base:
            """The gel's own answer, with the area of Hertz' ball."""

            def __init__(self, touch, wrench=plain, x=x):
                self.wrench, self.x = wrench, x

            def respond(self, offset, shift, friction):
                depth = np.array([4e-4, 1e-3])
                centre = np.column_stack([np.full(2, self.x), np.zeros(2)])
                return ContactResponse(
                    self.wrench, np.pi * 0.004 * depth, centre, depth, np.zeros(2, dtype=bool), np.zeros(2)
                )

        fields = dict.fromkeys(("gravity", "joints", "powered", "earlier_depth", "earlier_contacts"))
        two = dataclasses.replace(touch, seconds=np.arange(2.0), poses=poses[1:], **fields)
        found = play("soft_region", on=two, base=Base, **spot).wrench
        np.testing.assert_allclose(1 - found[:, 2] / plain[:, 2], 1 - soft[:, 2] / plain[:, 2], rtol=0.25, atol=0.01)
        centres = [-wrench[:, 4] / wrench[:, 2] for wrench in (found, soft)]
        np.testing.assert_allclose(*centres, atol=2e-5)


def test_the_gel_has_mindlins_knee_already(gel):
    """Sheared until it slides, the node-by-node contact follows the curve within 2.5 % of mu N."""
    poses = press(np.concatenate([np.linspace(-1e-4, 8e-4, 6), np.full(14, 8e-4)]))
    poses[6:, 0, 3] = np.linspace(0.0, 1.3e-3, 14)
    wrench = gel(poses)[6:]
    limit = MATERIAL.friction * wrench[:, 2]
    stiffness = -wrench[1, 0] / poses[7, 0, 3]
    stretch = stiffness * poses[6:, 0, 3] / limit
    sticks = stretch < 1.2
    assert stretch[sticks].max() > 1.0
    curve = np.minimum(stretch[:, None], slip_levels(200)).mean(axis=1)
    np.testing.assert_allclose((-wrench[:, 0] / limit)[sticks], curve[sticks], atol=0.025)
