"""The ball of the effects' previews: each variant of the gel by its closed form, and the spring under it by hand."""

import dataclasses

import numpy as np
import pytest

from tactiledata.effects.closed_form.ball_on_layer import BallOnLayer, stick_and_slip
from tactiledata.effects.touch.response import GelVariant
from tactiledata.effects.touch.state import TouchState
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.indenters.sphere import Sphere

E, NU, MU, R = 1e6, 0.4, 0.5, 0.005
PLACE, DEPTH = (3e-3, -2e-3), 5e-4


@pytest.fixture
def still(touch, moved):
    """Half a millimetre above the gel, at its surface, and half a millimetre deep, at (3, -2) mm."""
    path = moved(touch, np.arange(3.0), np.array([-DEPTH, 0.0, DEPTH]), x=PLACE[0], y=PLACE[1])
    return dataclasses.replace(path, indenter=Sphere(R), material=GelMaterial(E, NU, MU))


def dimitriadis(depth, thickness, radius=R):
    """Hertz's force times 1 + 1.133 chi + 1.283 chi^2 + 0.769 chi^3 + 0.0975 chi^4, chi = sqrt(R d) / h."""
    chi = np.sqrt(radius * depth) / thickness
    layer = 1 + 1.133 * chi + 1.283 * chi**2 + 0.769 * chi**3 + 0.0975 * chi**4
    return 4 / 3 * E / (1 - NU**2) * np.sqrt(radius) * depth**1.5 * layer


def pressed(touch, variant):
    """N at the last frame, with a variant of the gel."""
    plain = TouchState.start(touch, BallOnLayer(touch)).contact.wrench
    return (plain + BallOnLayer(touch).difference(variant))[-1, 2]


def test_the_nominal_gel_answers_as_hertz_on_a_layer(still):
    """Force, area pi R d, radius, spring 8 G a / (2 - nu) and depth, all at its place; the surface is free air."""
    answer = TouchState.start(still, BallOnLayer(still)).contact
    a = np.sqrt(R * DEPTH)
    assert answer.wrench[2, 2] == pytest.approx(dimitriadis(DEPTH, still.geometry.thickness), rel=1e-12)
    assert answer.area == pytest.approx([0.0, 0.0, np.pi * R * DEPTH])
    assert answer.radius == pytest.approx([0.0, 0.0, a])
    assert answer.spring == pytest.approx([0.0, 0.0, 8 * E / (2 * (1 + NU)) * a / (2 - NU)])
    assert answer.depth == pytest.approx([-DEPTH, 0.0, DEPTH])
    np.testing.assert_allclose(answer.centre, np.tile(PLACE, (3, 1)))
    assert answer.touching.tolist() == [False, False, True]
    assert not answer.sliding.any()
    assert not answer.wrench[:2].any()


@pytest.mark.parametrize("factor", [0.8, 1.3])
def test_thickness_and_size_enter_the_layers_factor(still, factor):
    """Another height is another chi; another ball another radius."""
    thickness = still.geometry.thickness
    thick, large = GelVariant(thickness=factor), GelVariant(indenter_scale=factor)
    assert pressed(still, thick) == pytest.approx(dimitriadis(DEPTH, factor * thickness), rel=1e-12)
    assert pressed(still, large) == pytest.approx(dimitriadis(DEPTH, thickness, factor * R), rel=1e-12)


def test_a_dome_lies_lower_and_is_a_second_ball(still):
    """At 13 mm^2 from the middle the surface lies h kappa r^2 lower, and curvatures 1 / R and 2 h kappa add."""
    thickness, kappa = still.geometry.thickness, 2000.0
    fall = thickness * kappa * 13e-6
    radius = 1 / (1 / R + 2 * thickness * kappa)
    found = pressed(still, GelVariant(dome=kappa))
    assert found == pytest.approx(dimitriadis(DEPTH - fall, thickness, radius), rel=1e-12)


def test_yeohs_terms_grow_with_the_strain(still):
    """The terms are 2 C20 (I - 3) and 3 C30 (I - 3)^2 beside C10, with I - 3 = 3 (0.2 a / R + d / (3 h))^2."""
    plain = dimitriadis(DEPTH, still.geometry.thickness)
    invariant = 3 * (0.2 * np.sqrt(DEPTH / R) + DEPTH / (3 * still.geometry.thickness)) ** 2
    assert pressed(still, GelVariant(c20=0.2)) == pytest.approx(plain * (1 + 0.4 * invariant), rel=1e-12)
    assert pressed(still, GelVariant(c30=0.1)) == pytest.approx(plain * (1 + 0.3 * invariant**2), rel=1e-12)
    both = pressed(still, GelVariant(c20=0.2, c30=0.1))
    assert both == pytest.approx(plain * (1 + 0.4 * invariant + 0.3 * invariant**2), rel=1e-12)


def test_a_coating_acts_by_its_share_of_the_contacts_radius(still):
    """1 + 0.3 e / a, which stays at 1.6 where the contact is narrower than half the coating."""
    plain, a = dimitriadis(DEPTH, still.geometry.thickness), np.sqrt(R * DEPTH)
    assert pressed(still, GelVariant(skin=2e-4)) == pytest.approx(plain * (1 + 0.3 * 2e-4 / a), rel=1e-12)
    assert pressed(still, GelVariant(skin=3 * a)) == pytest.approx(1.6 * plain, rel=1e-12)


def test_torque_is_that_of_the_force_at_the_bottom_of_the_contact(touch):
    """About the origin of the gel, r x F at (x, y, -d), shear included; sliding shear is mu N."""
    answer = TouchState.start(touch, BallOnLayer(touch)).contact
    force, torque = answer.wrench[:, :3], answer.wrench[:, 3:]
    bottom = np.column_stack([answer.centre, -np.maximum(answer.depth, 0.0)])
    np.testing.assert_allclose(torque, np.cross(bottom, force), atol=1e-12)
    assert answer.sliding.any()
    assert not answer.sliding[~answer.touching].any()
    slid = answer.sliding
    np.testing.assert_allclose(np.hypot(*force[slid, :2].T), touch.material.friction * force[slid, 2])


def test_friction_is_that_which_is_asked(touch):
    """A factor on mu is a factor on the shear of what slides; where the recorded touch is asked, it is 1."""
    n = len(touch)
    whole, half = (
        BallOnLayer(touch).respond(np.zeros(n), np.zeros((n, 2)), factor * np.ones(n)) for factor in (1.0, 0.5)
    )
    slid = whole.sliding & half.sliding
    shear = [np.hypot(*answer.wrench[slid, :2].T) for answer in (half, whole)]
    np.testing.assert_allclose(shear[0], 0.5 * shear[1])
    softer = GelVariant(thickness=1.3)
    changed = whole.wrench + BallOnLayer(touch).difference(softer)
    both = slid & (np.hypot(*changed[:, :2].T) > 0.79 * changed[:, 2])
    assert both.any()
    np.testing.assert_allclose(np.hypot(*changed[both, :2].T), touch.material.friction * changed[both, 2])


def test_a_spring_sticks_up_to_its_limit_and_slips_beyond():
    """100 N/m, limit 1 N: 4 mm are 0.4 N back, 10 mm exactly the limit, further on 1 N; a lifted spring forgets."""
    x = np.array([7.0, 11.0, 17.0, 20.0, 18.0, 18.0, 19.0]) * 1e-3
    centre = np.column_stack([0.6 * x, 0.8 * x])
    spring = np.array([100.0, 100.0, 100.0, 100.0, 100.0, 0.0, 100.0])
    force, sliding = stick_and_slip(centre, spring, np.array([1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.05]))
    along = np.array([0.0, -0.4, -1.0, -1.0, -0.8, 0.0, -0.05])
    np.testing.assert_allclose(force, np.outer(along, [0.6, 0.8]), atol=1e-12)
    assert sliding[[0, 1, 3, 4, 5, 6]].tolist() == [False, False, True, False, False, True]


def test_a_shear_of_just_the_limit_still_sticks():
    """2 m at 4 N/m is 8 N, and the limit is 8 N."""
    force, sliding = stick_and_slip(np.array([[0.0, 0.0], [2.0, 0.0]]), np.full(2, 4.0), np.full(2, 8.0))
    assert force.tolist() == [[0.0, 0.0], [-8.0, 0.0]]
    assert sliding.tolist() == [False, False]
