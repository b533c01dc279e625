"""The flat punch of the effects' previews against the rig's, which shares no line with it."""

import dataclasses

import numpy as np
import pytest

from tactiledata.effects.closed_form.punch_on_layer import PunchOnLayer
from tactiledata.effects.simulate.reference_touch import reference_touch
from tactiledata.effects.touch.response import GelVariant
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.indenters.cylinder_flat import CylinderFlat
from tactiledata.rig.contact.closed_form import punch_stiffness
from tactiledata.rig.scenario.scenario import Material

MATERIAL = GelMaterial(0.9e6, 0.4999, 0.6)


@pytest.fixture
def touch():
    return dataclasses.replace(reference_touch(), indenter=CylinderFlat(0.003), material=MATERIAL)


def played(touch, variant=None):
    n = len(touch)
    punch = PunchOnLayer(touch)
    plain = punch.respond(np.zeros(n), np.zeros((n, 2)), np.ones(n))
    return plain if variant is None else plain.wrench + punch.difference(variant)


def test_stiffness_is_that_of_the_rigs_punch(touch):
    """Linear in depth, with the layer's factor, where the rubber is incompressible; nothing in free air."""
    answer = played(touch)
    pressed = answer.depth > 0
    wanted = punch_stiffness(np.array([0.003]), touch.geometry.thickness, Material(0.9e6, 0.4999))[0]
    assert answer.wrench[pressed, 2] == pytest.approx(wanted * answer.depth[pressed], rel=2e-3)
    assert not answer.wrench[~pressed].any()


def test_shear_stays_within_friction_and_slides(touch):
    """Coulomb's limit is reached in the slide of 2 mm, and never passed."""
    answer = played(touch)
    shear, normal = np.linalg.norm(answer.wrench[:, :2], axis=1), answer.wrench[:, 2]
    assert (shear <= 0.6 * normal + 1e-9).all()
    assert answer.sliding.any()


def test_variants_act_in_their_direction(touch):
    """A thinner gel and a coating are stiffer; the null changes nothing."""
    plain = played(touch).wrench[:, 2].max()
    assert played(touch, GelVariant(thickness=0.9))[:, 2].max() > plain
    assert played(touch, GelVariant(skin=3e-4))[:, 2].max() > plain
    assert not PunchOnLayer(touch).difference(GelVariant()).any()


@pytest.fixture
def still(touch, moved):
    """Above the gel, at its surface, and half a millimetre deep, at (3, -2) mm."""
    path = moved(touch, np.arange(3.0), np.array([-5e-4, 0.0, 5e-4]), x=3e-3, y=-2e-3)
    return dataclasses.replace(path, material=GelMaterial(1e6, 0.4, 0.6))


def on_layer(depth, thickness, radius=0.003):
    """2 E* a d (1 + 1.133 x + 1.283 x^2 + 0.598 x^3 - 0.291 x^4), x = a / h."""
    x = radius / thickness
    layer = 1 + 1.133 * x + 1.283 * x**2 + 0.598 * x**3 - 0.291 * x**4
    return 2 * 1e6 / (1 - 0.4**2) * radius * depth * layer


def pressed(touch, variant):
    """N at the last frame, with a variant of the gel."""
    return played(touch, variant)[-1, 2]


def test_area_and_spring_are_those_of_the_whole_punch(still):
    """Pi a^2 and 8 G a / (2 - nu) once it touches, at its place; the surface itself is free air."""
    answer = played(still)
    assert answer.wrench[:, 2] == pytest.approx([0.0, 0.0, on_layer(5e-4, still.geometry.thickness)], rel=1e-12)
    assert answer.area == pytest.approx([0.0, 0.0, np.pi * 0.003**2])
    assert answer.spring == pytest.approx([0.0, 0.0, 8 * 1e6 / 2.8 * 0.003 / 1.6])
    assert answer.depth == pytest.approx([-5e-4, 0.0, 5e-4])
    np.testing.assert_allclose(answer.centre, np.tile([3e-3, -2e-3], (3, 1)))
    assert not answer.sliding.any()


def test_variants_enter_the_closed_form(still):
    """Height, size and fall of a dome; Yeoh's terms at a strain of d / (3 a) + d / (3 h); a coating by 0.3 e / a."""
    h, d, a = still.geometry.thickness, 5e-4, 0.003
    assert pressed(still, GelVariant(thickness=1.2)) == pytest.approx(on_layer(d, 1.2 * h), rel=1e-12)
    assert pressed(still, GelVariant(indenter_scale=1.1)) == pytest.approx(on_layer(d, h, 1.1 * a), rel=1e-12)
    assert pressed(still, GelVariant(dome=2000.0)) == pytest.approx(on_layer(d - h * 2000.0 * 13e-6, h), rel=1e-12)
    invariant = 3 * (d / (3 * a) + d / (3 * h)) ** 2
    yeoh = 1 + 2 * 0.2 * invariant + 3 * 0.1 * invariant**2
    assert pressed(still, GelVariant(c20=0.2, c30=0.1)) == pytest.approx(yeoh * on_layer(d, h), rel=1e-12)
    assert pressed(still, GelVariant(skin=3e-4)) == pytest.approx((1 + 0.3 * 0.1) * on_layer(d, h), rel=1e-12)


def test_torque_is_that_of_the_force_at_the_punch(touch):
    """About the origin of the gel, r x F at (x, y, -d); shear that sticks is spring times way."""
    answer = played(touch)
    bottom = np.column_stack([answer.centre, -np.maximum(answer.depth, 0.0)])
    np.testing.assert_allclose(answer.wrench[:, 3:], np.cross(bottom, answer.wrench[:, :3]), atol=1e-12)
    onset = int(np.argmax(np.hypot(*answer.wrench[:, :2].T) > 0))
    way = answer.centre[onset] - answer.centre[onset - 1]
    np.testing.assert_allclose(answer.wrench[onset, :2], -answer.spring[onset] * way)
    assert not answer.sliding[~answer.touching].any()
