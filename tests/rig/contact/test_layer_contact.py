"""Laws of the rig's contact."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tactiledata.indenters import INDENTERS, make_indenter
from tactiledata.rig.contact.closed_form import contact_law, press_along, punch_stiffness, sphere_force, stick_slip
from tactiledata.rig.contact.footprint import PITCH, GelGrid, make_footprint
from tactiledata.rig.motion.motion import gel_from_indenter_rotation
from tactiledata.rig.motion.touch import TouchPlan
from tactiledata.rig.scenario.scenario import Gel, Material

GEL = Gel()
GRID = GelGrid.of(GEL)
MATERIAL = Material()
REDUCED = MATERIAL.youngs_modulus / (1 - MATERIAL.poisson_ratio**2)


def law_of(entry, tilt=(0.0, 0.0), yaw=0.0, position=(0.0, 0.0), thickness=GEL.thickness):
    indenter = make_indenter(entry, None, "test")
    rotation = gel_from_indenter_rotation(TouchPlan("t", "s", "i", (), tilt=tilt, yaw=yaw))
    return contact_law(indenter, make_footprint(indenter, rotation, position, GRID), thickness, MATERIAL)


def test_a_ball_on_a_thick_layer_is_hertz():
    """As the layer grows, the force tends to Hertz's law, with an error that falls as 1 over thickness."""
    depth, radius = np.array([1e-4, 5e-4]), 0.004
    hertz = 4 / 3 * REDUCED * np.sqrt(radius) * depth**1.5
    errors = [sphere_force(depth, radius, thickness, MATERIAL) / hertz - 1 for thickness in (0.1, 1.0)]
    assert (errors[0] < 0.02).all()
    np.testing.assert_allclose(errors[0] / errors[1], 10.0, rtol=0.05)


def test_a_punch_on_a_thick_layer_is_boussinesq():
    """As the layer grows, the stiffness of a flat punch tends to 2 E* a."""
    np.testing.assert_allclose(punch_stiffness(np.array([0.003]), 10.0, MATERIAL), 2 * REDUCED * 0.003, rtol=1e-3)


def test_the_general_law_gives_hertz_for_a_ball():
    """The law for any shape, on a thick layer, agrees with Hertz for a dome that is nearly a ball."""
    thick = 1.0
    law = law_of({"shape": "dome"}, thickness=thick)
    radius = make_indenter({"shape": "dome"}, None, "test").sizes["curvature_radius"]
    inside = (law.depth > 1e-4) & (law.depth < 4e-4)
    hertz = 4 / 3 * REDUCED * np.sqrt(radius) * law.depth[inside] ** 1.5
    np.testing.assert_allclose(law.force[inside], hertz, rtol=0.03)


def test_the_flat_punch_agrees_with_a_spectral_solver():
    """A punch of 3 mm at 1 mm on the 4.1 mm pad: 16 N by a spectral layer solver; this first form is within 20 %."""
    law = law_of({"shape": "cylinder_flat", "radius": 0.003})
    assert np.interp(1e-3, law.depth, law.force) == pytest.approx(16.0, rel=0.2)


@pytest.mark.parametrize("shape", list(INDENTERS))
@pytest.mark.parametrize("tilt", [(0.0, 0.0), (0.08, -0.05)])
def test_force_rises_with_depth_for_every_indenter(shape, tilt):
    """The force is zero at first touch and rises ever after, without a jump."""
    law = law_of({"shape": shape}, tilt, yaw=0.4)
    assert law.force[0] == 0.0
    assert (np.diff(law.force) >= 0).all()
    assert law.force[-1] > 1.0
    assert np.diff(law.force).max() < 0.05 * law.force[-1]


@pytest.mark.parametrize("shape", ["sphere", "cylinder_flat", "ring", "box", "hexagon"])
def test_a_symmetric_touch_is_balanced(shape):
    """Head-on in the middle: no sideways force, and a lever below half a grid cell (a face may end on a grid line)."""
    law = law_of({"shape": shape})
    path = np.column_stack([np.zeros(50), np.zeros(50), np.linspace(-1e-4, 8e-4, 50)])
    wrench = press_along(law, path).wrench
    assert np.abs(wrench[:, [0, 1]]).max() == 0.0
    assert np.abs(wrench[:, 3:]).max() < PITCH / 2 * wrench[:, 2].max()


def test_a_tilted_face_touches_on_its_low_side():
    """Turned about gel y, one side of a face comes down, and the centre of pressure moves there."""
    rotation = gel_from_indenter_rotation(TouchPlan("t", "s", "i", (), tilt=(0.0, 0.1)))
    side = np.sign((rotation @ [1.0, 0.0, 0.0])[2])
    law = law_of({"shape": "box"}, tilt=(0.0, 0.1))
    assert law.centre[50, 0] * -side > 1e-3
    assert abs(law.centre[50, 1]) < 1e-4


def test_tracing_agrees_with_the_closed_form_of_a_ball():
    """A turned ball is a ball: the traced heights equal the sphere's own, shifted, to a few micrometres."""
    ball = make_indenter({"shape": "sphere", "radius": 0.004}, None, "test")
    rotation = gel_from_indenter_rotation(TouchPlan("t", "s", "i", (), tilt=(0.2, 0.1)))
    traced = make_footprint(ball, rotation, (0.0, 0.0), GRID)
    centre = rotation @ [0.0, 0.0, 0.004]
    x, y = np.meshgrid(GRID.x - centre[0], GRID.y - centre[1])
    exact = 0.004 - np.sqrt(np.maximum(0.004**2 - x**2 - y**2, 0.0))
    near = exact < 2e-3
    np.testing.assert_allclose(traced.heights[near], exact[near], atol=4e-6)
    assert traced.lowest == pytest.approx(centre[2] - 0.004, abs=2e-6)


def test_no_contact_no_wrench():
    """In the air everything is zero, exactly."""
    history = press_along(law_of({"shape": "sphere"}), np.column_stack([*np.zeros((2, 20)), np.linspace(-1e-3, 0, 20)]))
    assert not history.wrench.any()
    assert not history.drag.any()


def test_the_torque_is_that_of_the_force_at_the_contact():
    """A ball at (x, y): torque about the gel's origin is the lever of the force there."""
    law = law_of({"shape": "sphere"}, position=(0.002, -0.003))
    wrench = press_along(law, np.array([[0.002, -0.003, 5e-4]])).wrench[0]
    assert wrench[3] == pytest.approx(-0.003 * wrench[2], rel=1e-2)
    assert wrench[4] == pytest.approx(-0.002 * wrench[2], rel=1e-2)


@given(
    st.lists(st.tuples(*[st.floats(-1e-3, 1e-3)] * 2, st.floats(0, 5.0)), min_size=2, max_size=40),
    st.floats(0.0, 1.5),
)
def test_friction_stays_inside_its_cone(path, friction):
    """At every moment of any path |Ft| <= mu N holds, and without load there is no friction."""
    steps = np.array(path)
    pull, slipping = stick_slip(steps[:, :2], steps[:, 2], np.full(len(steps), 5e3), friction)
    assert (np.hypot(*pull.T) <= friction * steps[:, 2] * (1 + 1e-12) + 1e-15).all()
    assert not slipping[steps[:, 2] <= 0].any()


def test_friction_sticks_slips_and_depends_on_the_path():
    """Small moves are elastic and undone by going back; large ones slip and leave a pull the other way behind."""
    normal, stiffness = np.full(101, 2.0), np.full(101, 5e3)
    there_and_back = 1.0 - np.abs(np.linspace(-1, 1, 101))
    small = np.column_stack([1e-4 * there_and_back, np.zeros(101)])
    pull, slipping = stick_slip(small, normal, stiffness, 0.8)
    assert not slipping.any()
    assert pull[-1, 0] == pytest.approx(0.0, abs=1e-12)
    pull, slipping = stick_slip(10 * small, normal, stiffness, 0.8)
    assert pull[50, 0] == pytest.approx(1.6)
    assert slipping.any()
    assert pull[-1, 0] == pytest.approx(-1.6)


def test_friction_opposes_the_indenter():
    """An indenter that moves along +x is held back: the gel pulls it along -x."""
    law = law_of({"shape": "sphere"})
    path = np.column_stack([np.linspace(0, 2e-4, 20), np.zeros(20), np.full(20, 5e-4)])
    history = press_along(law, path)
    assert history.wrench[-1, 0] < -0.1
    assert history.drag[-1, 0] > 0


def test_the_response_does_not_depend_on_how_finely_the_path_is_cut():
    """Pressing and shearing in 50 or in 500 steps ends at the same wrench within a percent."""
    law = law_of({"shape": "dots"})
    ends = []
    for count in (50, 500):
        down = np.linspace(0, 5e-4, count)
        path = np.concatenate(
            [
                np.column_stack([np.zeros(count), np.zeros(count), down]),
                np.column_stack([np.linspace(0, 3e-4, count), np.zeros(count), np.full(count, 5e-4)]),
            ]
        )
        ends.append(press_along(law, path).wrench[-1, :3])
    np.testing.assert_allclose(ends[0], ends[1], rtol=0.01, atol=1e-9)
