"""Effects on gel and contact geometry, against closed forms and slow twins."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import erf

from tactiledata.effects.closed_form.ball_on_layer import BallOnLayer
from tactiledata.effects.design import null_exact_weights
from tactiledata.effects.material.heating import swelling
from tactiledata.effects.simulate.reference_touch import contact_stiffness
from tactiledata.effects.touch.response import GelVariant
from tactiledata.effects.touch.state import TouchState


def with_thickness(touch, factor):
    geometry = dataclasses.replace(touch.geometry, thickness=touch.geometry.thickness * factor)
    return dataclasses.replace(touch, geometry=geometry)


@given(st.floats(-3, 3), st.floats(-3, 3), st.floats(-1, 1))
def test_weights_are_exact_for_parabolas_through_null(slope, bend, value):
    """Two design points carry any parabola that is 0 at 0; at 0 the weights are exactly 0."""
    places = np.array([-0.5, 0.8])
    differences = slope * places + bend * places**2
    assert null_exact_weights(places, value) @ differences == pytest.approx(slope * value + bend * value**2, abs=1e-12)
    assert (null_exact_weights(places, 0.0) == 0.0).all()


def test_design_points_are_met_exactly(touch, play):
    """At a design point the wrench is the base's plus its difference."""
    difference = BallOnLayer(touch).difference(GelVariant(c20=0.2))
    found = play("strain_stiffening", c20=0.2).wrench
    np.testing.assert_allclose(found, play().wrench + difference, rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize("error", [-0.08, 0.05, 0.12])
def test_thickness_follows_dimitriadis(touch, play, error):
    """Between the design points the change of the closed form is met within 4 %."""
    change = play(on=with_thickness(touch, 1 + error)).wrench[:, 2] - play().wrench[:, 2]
    found = play("thickness", error=error).wrench[:, 2] - play().wrench[:, 2]
    np.testing.assert_allclose(found, change, rtol=0.04, atol=1e-4)


def test_a_dome_falls_away_from_the_middle(touch, play, moved):
    """A press off the middle meets the surface h kappa r^2 later; one in the middle hardly changes."""
    depth = np.linspace(0.0, 1e-3, 11)
    middle, aside = (moved(touch, np.arange(11.0), depth, x=x) for x in (0.0, 3e-3))
    fall = touch.geometry.thickness * 1e3 * 3e-3**2
    change = {
        name: play("dome", on=on, curvature=1e3).wrench[-1, 2] - play(on=on).wrench[-1, 2]
        for name, on in (("middle", middle), ("aside", aside))
    }
    stiffness = np.gradient(play(on=aside).wrench[:, 2], depth)[-1]
    # half a per cent of the stiffness is curvature that the ball sees: 2 h kappa R of 1
    assert change["aside"] - change["middle"] == pytest.approx(-fall * stiffness, rel=0.1)
    assert abs(change["middle"]) < 0.03 * play(on=middle).wrench[-1, 2]


def test_strain_stiffening_follows_strain_and_skin_the_inverse_of_the_radius(touch, play, moved):
    """The relative change grows with depth for Yeoh's terms, and falls with it for a coating."""
    press = moved(touch, np.arange(10.0), np.linspace(1e-4, 1e-3, 10))
    plain = play(on=press).wrench[:, 2]
    yeoh = play("strain_stiffening", on=press, c20=0.1, c30=0.01).wrench[:, 2] / plain - 1
    coat = play("skin", on=press, excess=2e-4).wrench[:, 2] / plain - 1
    assert (np.diff(yeoh) > 0).all()
    assert (yeoh > 0).all()
    assert (np.diff(coat) < 0).all()
    assert (coat > 0).all()


def test_a_soft_spot_is_a_mean_over_the_energy(touch, play, moved):
    """Loss and shift of the centre of pressure equal those of a quadrature over spot and energy."""
    press = moved(touch, np.arange(3.0), np.array([0.0, 4e-4, 8e-4]), x=1e-3, y=-5e-4)
    values = {"normal_loss": 0.4, "x": 2.5e-3, "y": 0.5e-3, "radius": 1.5e-3}
    plain, state = play(on=press), play("soft_region", on=press, **values)
    radius, thickness = plain.contact.radius[2], touch.geometry.thickness
    spread = 0.6 * radius**2 + 0.03 * thickness**2
    line = np.linspace(-0.02, 0.02, 801)
    x, y = np.meshgrid(line, line, indexing="ij")

    def kept(centre):
        energy = np.exp(-((x - centre[0]) ** 2 + (y - centre[1]) ** 2) / (2 * spread))
        spot = np.exp(-((x - 2.5e-3) ** 2 + (y - 0.5e-3) ** 2) / (2 * 1.5e-3**2))
        return 1 - 0.4 * (energy * spot).sum() / energy.sum()

    centre, step = np.array([1e-3, -5e-4]), 1e-6
    force = state.wrench[2, 2]
    assert force == pytest.approx(plain.wrench[2, 2] * kept(centre), rel=1e-4)
    slope = [
        (np.log(kept(centre + step * axis)) - np.log(kept(centre - step * axis))) / (2 * step) for axis in np.eye(2)
    ]
    pressure_centre = np.array([-state.wrench[2, 4], state.wrench[2, 3]]) / force
    np.testing.assert_allclose(pressure_centre, centre + radius**2 / 5 * np.array(slope), rtol=1e-3)


def test_a_soft_spot_is_not_felt_far_away_nor_by_a_slide(touch, play):
    """15 mm beside it nothing changes; a spot that lost shear stiffness leaves the slide's plateau."""
    far = play("soft_region", normal_loss=0.5, shear_loss=0.5, x=0.015, y=0.015).wrench
    np.testing.assert_allclose(far, play().wrench, rtol=1e-5, atol=1e-8)
    plain, state = play(), play("soft_region", shear_loss=0.5)
    sliding = plain.contact.sliding & state.contact.sliding
    assert sliding.any()
    np.testing.assert_allclose(state.wrench[sliding], plain.wrench[sliding], atol=1e-12)
    loaded = play("soft_region", normal_loss=0.3)
    shear, normal = np.hypot(*loaded.wrench[:, :2].T), loaded.wrench[:, 2]
    np.testing.assert_allclose(shear[loaded.contact.sliding], 0.8 * normal[loaded.contact.sliding], rtol=1e-9)
    sticks = (np.diff(plain.wrench[:, 0], append=0.0) < -0.01) & ~plain.contact.sliding
    assert (np.abs(state.wrench[sticks, 0]) < 0.95 * np.abs(plain.wrench[sticks, 0]))[1:].all()
    beyond = play("soft_region", shear_loss=0.5, onset=1e6)
    np.testing.assert_array_equal(beyond.wrench, plain.wrench)


def test_the_edge_is_felt_within_a_radius(touch, play, moved):
    """The factor is 1 - drop exp(-b / a), with the distance b of the nearest side."""
    half = touch.geometry.outline[0] / 2
    for distance in (0.0, 1e-3, 5e-3):
        press = moved(touch, np.arange(2.0), np.array([0.0, 8e-4]), x=-(half - distance))
        plain, state = play(on=press), play("pad_edge", on=press, drop=0.3)
        wanted = 1 - 0.3 * np.exp(-distance / plain.contact.radius[1])
        assert state.wrench[1, 2] / plain.wrench[1, 2] == pytest.approx(wanted)


def test_the_housing_pushes_where_the_body_reaches_it(touch, play, moved):
    """The push is stiffness times overlap at the rim, with a torque about the border, and 0 in the middle."""
    half, rim = touch.geometry.outline[0] / 2, touch.geometry.thickness - touch.geometry.edge_thickness
    press = moved(touch, np.arange(2.0), np.array([0.0, rim + 5e-4]), x=half - 1e-3)
    plain, state = play(on=press).wrench[1], play("pad_edge", on=press, housing=1e4).wrench[1]
    overlap = 5e-4 - (0.004 - np.sqrt(0.004**2 - 1e-3**2))
    assert state[2] - plain[2] == pytest.approx(1e4 * overlap)
    assert state[4] - plain[4] == pytest.approx(-half * 1e4 * overlap)
    assert play("pad_edge", housing=1e5).wrench.tobytes() == play().wrench.tobytes()


def test_a_warm_gel_stands_higher(touch, play, moved):
    """Expansion of 10 K on 4 mm is 12 um; the force it adds is that times the stiffness, on its time constant."""
    rise = swelling(10.0, 0.004)
    assert rise == pytest.approx(12e-6)
    powered = np.array([0.0, 900.0, 9e5])
    press = moved(touch, np.arange(3.0), np.full(3, 8e-4), powered=powered)
    plain = play(on=press).wrench[:, 2]
    gained = play("heating", on=press, rise=rise, time=900.0).wrench[:, 2] - plain
    stiffness = (play("mount_offset", on=press, deeper=1e-6).wrench[0, 2] - plain[0]) / 1e-6
    assert gained[2] == pytest.approx(rise * stiffness, rel=0.02)
    # a layer adds to the 3/2 F / d of a half space
    assert 1.0 < stiffness / contact_stiffness(plain[0], 8e-4) < 1.5
    assert gained[0] == 0
    assert gained[1] / gained[2] == pytest.approx(1 - np.exp(-1), rel=0.01)
    softened = play("heating", on=press, change=-0.1, time=900.0).wrench
    np.testing.assert_allclose(softened[:, 2] / plain, [1, 1 - 0.1 * (1 - np.exp(-1)), 0.9], rtol=1e-9)


def test_wear_follows_the_contacts_of_the_spot(touch, play, moved):
    """63 % of the change after the stated number of touches, in stiffness and friction alike."""
    press = moved(touch, np.arange(3.0), np.full(3, 8e-4), earlier_contacts=np.array([0.0, 500.0, 1e9]))
    found = play("wear", on=press, stiffness_change=-0.1, contacts=500.0).wrench[:, 2] / play(on=press).wrench[:, 2]
    np.testing.assert_allclose(found, [1, 1 - 0.1 * (1 - np.exp(-1)), 0.9], rtol=1e-9)
    state = play("wear", on=press, friction_change=0.2)
    np.testing.assert_allclose(state.friction, [1, 1 + 0.2 * (1 - np.exp(-1)), 1.2])


def test_mullins_softens_below_the_largest_depth(touch, play, moved):
    """Fresh loading is untouched; unloading and loading again follow one softer path; earlier touches count."""
    up = np.linspace(0.0, 8e-4, 9)
    depth = np.concatenate([up, up[-2::-1], up[1:]])
    path = moved(touch, np.arange(float(len(depth))), depth)
    plain = play(on=path).wrench[:, 2]
    soft = play("mullins", on=path, softening=0.2, beta=0.3).wrench[:, 2]
    np.testing.assert_array_equal(soft[:9], plain[:9])
    np.testing.assert_allclose(soft[17:], soft[15:7:-1], rtol=1e-12)
    for frame in range(9, len(depth)):
        energy = (depth[frame] / 8e-4) ** 2.5
        assert soft[frame] == pytest.approx(plain[frame] * (1 - 0.2 * erf((1 - energy) / 0.3)))
    used = dataclasses.replace(path, earlier_depth=np.full(len(depth), 8e-4))
    again = play("mullins", on=used, softening=0.2, beta=0.3).wrench[:9, 2]
    np.testing.assert_allclose(again[1:], soft[17:], rtol=1e-12)


def test_base_scales_as_hertz_on_a_thick_layer(touch, moved):
    """The base of these tests is Hertz's ball where the layer is thick."""
    thick = with_thickness(moved(touch, np.arange(2.0), np.array([0.0, 5e-4])), 1e4)
    force = TouchState.start(thick, BallOnLayer(thick)).contact.wrench[1, 2]
    modulus = touch.material.youngs_modulus / (1 - touch.material.poisson_ratio**2)
    assert force == pytest.approx(4 / 3 * modulus * np.sqrt(0.004) * 5e-4**1.5, rel=1e-3)
