"""A tilted flat indenter touches with an edge before its tip, in the plays of a coarse pad."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tactiledata.calibrate.bounds import find_bounds
from tactiledata.calibrate.touches import MeasuredTouch
from tactiledata.diagnose.touches.play_grid import play_touches
from tactiledata.diagnose.touches.played_response import PlayedFamily
from tactiledata.effects.touch.touch import Touch
from tactiledata.gel.contact.history import GelTouch
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.gel.mesh.structured_pad import GridPlan, structured_pad
from tactiledata.indenters.box import Box
from tactiledata.sensors.digit import DIGIT

pytestmark = pytest.mark.slow

PAD = structured_pad("coarse", DIGIT.gel, GridPlan(7, 9, 0.8e-3, (2.4e-3, 2.4e-3), (0.0, 0.5, 0.8, 1.0)))
MATERIAL = GelMaterial(9e5, 0.47, 0.65)
WIDTH, ANGLE = 4e-3, np.radians(10.0)
REACH = WIDTH / 2 * np.sin(ANGLE)
HEIGHTS = 1e-3 * np.array([0.9, 0.6, 0.45, 0.2, 0.1, 0.05, 0.0])
"""Heights of the tip above the gel, m: the edge is at the gel where the tip is 0.35 mm above it."""
AIR, CONTACT = HEIGHTS > REACH + 5e-5, HEIGHTS < REACH - 1e-4


def measured(angle):
    poses = np.tile(np.eye(4), (len(HEIGHTS), 1, 1))
    poses[:, :3, :3] = Rotation.from_rotvec([0.0, angle, 0.0]).as_matrix()
    poses[:, 2, 3] = HEIGHTS
    touch = GelTouch(Box(WIDTH, WIDTH), poses)
    return MeasuredTouch("u", "t", "D1", "box", touch, np.zeros((len(HEIGHTS), 6)), np.arange(len(HEIGHTS)) / 5, 40.0)


@pytest.fixture(scope="module")
def played(tmp_path_factory):
    """The tilted touch and an upright one along the same path, with their plays."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TACTILEDATA_CACHE", str(tmp_path_factory.mktemp("cache")))
        touches = [measured(ANGLE), measured(0.0)]
        yield list(zip(touches, play_touches(PAD, "linear", touches, find_bounds("paper")), strict=True))


def answer(touch, plays):
    """What the plays answer at one material, without offset and shift."""
    asked = Touch(touch.seconds, touch.touch.poses, touch.touch.indenter, MATERIAL, DIGIT.gel)
    none = np.zeros(len(HEIGHTS))
    return PlayedFamily([asked], [plays])(MATERIAL)(asked).respond(none, np.zeros((len(HEIGHTS), 2)), none + 1.0)


def test_the_edge_meets_the_gel_before_the_tip(played):
    """The height of contact is half the width times the sine; an upright box meets the gel at its tip."""
    (_, tilted), (_, upright) = played
    np.testing.assert_allclose(tilted.height - upright.height, REACH, atol=1e-9)
    np.testing.assert_allclose(upright.height, 0.0, atol=1e-9)


def test_the_edge_presses_while_the_tip_is_above_the_gel(played):
    """No force in free air, force as soon as the edge is in the gel; the upright box has none anywhere on the way."""
    (touch, plays), (other, upright) = played
    assert CONTACT.sum() >= 3
    assert AIR.sum() >= 3
    found = answer(touch, plays)
    assert found.touching.tolist() == CONTACT.tolist()
    assert not found.wrench[AIR].any()
    assert (np.diff(found.wrench[CONTACT, 2]) > 0).all()
    np.testing.assert_allclose(found.depth[CONTACT], REACH - HEIGHTS[CONTACT], atol=1e-9)
    before = HEIGHTS > 1e-5
    assert not answer(other, upright).wrench[before].any()


def test_the_force_is_at_the_lower_edge(played):
    """Turned about y, the edge in positive x is the lower one."""
    (touch, plays), _ = played
    centre = answer(touch, plays).centre[CONTACT]
    assert (centre[:, 0] > 0.25 * WIDTH).all()
    assert (np.abs(centre[:, 1]) < 0.1 * WIDTH).all()
