"""How far turned solids reach below their tips: closed forms of a box, a cylinder and a ball."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tactiledata.indenters.base.turned import reach_below_tip
from tactiledata.indenters.box import Box
from tactiledata.indenters.cylinder_flat import CylinderFlat
from tactiledata.indenters.sphere import Sphere

ANGLES = np.radians([0.0, 1.0, 5.0, 20.0])


def poses(axis, angles=ANGLES):
    """Poses (n, 4, 4) turned about one axis of the gel, each at another place."""
    found = np.tile(np.eye(4), (len(angles), 1, 1))
    found[:, :3, :3] = Rotation.from_rotvec(np.outer(angles, np.eye(3)["xyz".index(axis)])).as_matrix()
    found[:, :3, 3] = np.random.default_rng(0).normal(0.0, 1e-2, (len(angles), 3))
    return found


@pytest.mark.parametrize(("axis", "size"), [("y", 8e-3), ("x", 5e-3)])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_box_reaches_down_by_half_its_width_times_the_sine(axis, size, sign):
    """Turned either way, by the side that is across the axis."""
    box = Box(width=8e-3, breadth=5e-3)
    found = reach_below_tip(box, poses(axis, sign * ANGLES))
    np.testing.assert_allclose(found, size / 2 * np.sin(ANGLES), atol=1e-9)


def test_a_flat_cylinder_reaches_down_by_its_radius_times_the_sine():
    """Whichever way it is turned: its mesh is a polygon, so that up to one per cent of it is missing."""
    for axis in ("x", "y"):
        found = reach_below_tip(CylinderFlat(radius=3e-3), poses(axis))
        np.testing.assert_allclose(found, 3e-3 * np.sin(ANGLES), rtol=0.01, atol=1e-12)


def test_a_ball_reaches_down_by_what_its_middle_sinks():
    """The tip is a point of its surface: r (1 - cos), within the chord of its mesh."""
    radius = 4e-3
    found = reach_below_tip(Sphere(radius), poses("x"))
    np.testing.assert_allclose(found, radius * (1.0 - np.cos(ANGLES)), atol=2e-3 * radius)
    assert found[-1] > 0.05 * radius


def test_a_turn_about_the_normal_reaches_no_lower():
    """Nor does any upright solid, nor a pose that is not known."""
    found = reach_below_tip(Box(), poses("z"))
    np.testing.assert_allclose(found, 0.0, atol=1e-12)
    unknown = poses("y")
    unknown[1] = np.nan
    found = reach_below_tip(Box(), unknown)
    assert found[1] == 0.0
    assert (found[2:] > 0).all()
