"""What a calibration says that it knows: by its intervals, and of friction by whether anything could slide."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tactiledata.calibrate.bounds import NAMES, find_bounds
from tactiledata.calibrate.intervals import Intervals
from tactiledata.calibrate.knowledge import ADVICE, MOVED, TURNED, WIDE, Knowledge, known_parameters, may_slide
from tactiledata.calibrate.touches import MeasuredTouch
from tactiledata.gel.contact.history import GelTouch
from tactiledata.indenters import make_indenter

BOX = find_bounds("wide")


def intervals(*shares, is_open=((False, False),) * 3):
    """Intervals whose ends are shares of the way through the box."""
    ends = np.array([[BOX.low[k] + share * BOX.span[k] for share in pair] for k, pair in enumerate(shares)])
    return Intervals(ends, np.array(is_open), np.eye(3), np.ones(3))


def touch(sideways=0.0, turn=0.0, presses=True):
    """Down in two frames, then 1 s of force while it goes along x and turns, or lifts off before it does."""
    poses = np.tile(np.eye(4), (6, 1, 1))
    poses[3:, 0, 3] = sideways * np.array([0.5, 0.8, 1.0])
    poses[3:, :3, :3] = Rotation.from_rotvec(turn * np.array([0.3, 0.6, 1.0])[:, None] * [0.0, 0.0, 1.0]).as_matrix()
    force = np.array([0.0, 2.0, 3.0, 3.0, 3.0, 3.0]) if presses else np.array([0.0, 2.0, 3.0, 0.0, 0.0, 0.0])
    wrench = np.zeros((6, 6))
    wrench[:, 2] = force
    indenter = make_indenter({"shape": "sphere", "radius": 0.003}, None, "here")
    return MeasuredTouch("u", "t", "s", "ball", GelTouch(indenter, poses), wrench, np.arange(6.0), 50.0)


def verdicts(found):
    return [found[name].verdict for name in NAMES]


def test_narrow_intervals_inside_the_box_are_identified():
    """E, nu and mu with such intervals are identified, and no further touch is asked for."""
    found = known_parameters(intervals((0.4, 0.5), (0.2, 0.9), (0.3, 0.4)), BOX, True)
    assert verdicts(found) == ["identified"] * 3
    assert {one.record for one in found.values()} == {""}


def test_an_interval_that_ends_at_a_bound_says_at_least_or_at_most():
    """E at most so large, mu at least so large."""
    at_bounds = ((True, False), (False, False), (False, True))
    found = known_parameters(intervals((0.0, 0.3), (0.4, 0.5), (0.7, 1.0), is_open=at_bounds), BOX, True)
    assert verdicts(found) == ["bounded", "identified", "bounded"]
    assert found["youngs_modulus"].record == ADVICE["youngs_modulus"]


@pytest.mark.parametrize(("width", "verdict"), [(WIDE - 0.01, "bounded"), (WIDE + 0.01, "not told by these data")])
def test_an_interval_that_fills_the_box_tells_nothing(width, verdict):
    """An interval over more than 80 % of the box is not told; one just below that only bounds the parameter."""
    at_bounds = ((False, False), (False, True), (False, False))
    found = known_parameters(intervals((0.4, 0.5), (1 - width, 1.0), (0.3, 0.4), is_open=at_bounds), BOX, True)
    assert verdicts(found) == ["identified", verdict, "identified"]
    assert found["poisson_ratio"].record == ADVICE["poisson_ratio"]


def test_presses_alone_never_tell_friction():
    """However narrow its interval; E and nu are told all the same."""
    found = known_parameters(intervals((0.4, 0.5), (0.4, 0.5), (0.3, 0.31)), BOX, False)
    assert verdicts(found) == ["identified", "identified", Knowledge.NOT_TOLD.value]
    assert "turn the indenter" in found["friction"].record


@pytest.mark.parametrize(
    ("sideways", "turn", "presses", "slides"),
    [
        (0.0, 0.0, True, False),
        (1.2 * MOVED, 0.0, True, True),
        (0.8 * MOVED, 0.0, True, False),
        (0.0, 1.2 * TURNED, True, True),
        (0.0, -1.2 * TURNED, True, True),
        (0.0, 0.8 * TURNED, True, False),
        (10 * MOVED, 10 * TURNED, False, False),
    ],
)
def test_a_touch_may_slide_where_it_moves_or_turns_while_it_presses(sideways, turn, presses, slides):
    """Moves and turns just above their limits may slide, just below not, nor moves in free air; one touch is enough."""
    assert may_slide([touch(sideways, turn, presses)]) is slides
    assert may_slide([touch(), touch(sideways, turn, presses)]) is slides


def test_nothing_slides_without_touches_or_forces():
    """No touch at all, and one whose forces are not known."""
    lost = touch(10 * MOVED)
    lost.wrench[:] = np.nan
    assert may_slide([]) is False
    assert may_slide([lost]) is False
