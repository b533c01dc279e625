"""What a touch accepts, and what it computes from its poses."""

import dataclasses

import numpy as np
import pytest

from tactiledata.effects.touch.last_move import WAYS
from tactiledata.effects.touch.moved_until import moved_until
from tactiledata.effects.touch.state import torque_of, wrench_at
from tactiledata.errors import UsageError


@pytest.fixture
def walk(touch, moved):
    """Steps of 3, 0 and 5 mm along the gel, half a second, two and a quarter of a second long; depth does not count."""
    seconds = np.array([1.0, 1.5, 3.5, 3.75])
    return moved(touch, seconds, np.array([0.0, 1e-3, 2e-3, 3e-3]), x=[0.0, 3e-3, 3e-3, 6e-3], y=[0.0, 0.0, 0.0, -4e-3])


def test_speed_is_the_way_along_the_gel_over_the_time_since_the_frame_before(walk):
    """The speed is 6, 0 and 20 mm/s, and 0 at the first frame."""
    np.testing.assert_allclose(walk.lateral_steps, [0.0, 3e-3, 0.0, 5e-3], atol=1e-15)
    assert walk.time_steps.tolist() == [0.0, 0.5, 2.0, 0.25]
    np.testing.assert_allclose(walk.lateral_speed, [0.0, 6e-3, 0.0, 20e-3], atol=1e-15)
    assert len(walk) == 4
    np.testing.assert_allclose(walk.tips[3], [6e-3, -4e-3, -3e-3])


@pytest.mark.parametrize(
    ("name", "shape"),
    [
        ("poses", (4, 4)),
        ("gravity", (3,)),
        ("joints", (6,)),
        ("powered", ()),
        ("earlier_depth", ()),
        ("tare", ()),
        ("pace", ()),
        ("rest", ()),
        ("last_ways", (6,)),
        ("felt_accelerations", (39, 3)),
        ("gel_from_sensor", (4, 4)),
        ("sensor_weight", (6,)),
    ],
)
def test_arrays_have_a_row_for_each_frame(walk, name, shape):
    """The shape that is told is accepted; one row too many, or one column too few, is refused by name."""
    dataclasses.replace(walk, **{name: np.zeros((4, *shape))})
    wrong = [(5, *shape), *([(4, shape[0] - 1, *shape[1:])] if shape else [(4, 1)])]
    for other in wrong:
        with pytest.raises(UsageError, match=f"{name} of a touch has shape"):
            dataclasses.replace(walk, **{name: np.zeros(other)})


@pytest.mark.parametrize("last", [3.5, 3.4])
def test_times_ascend(walk, last):
    """A moment twice, or an earlier one after a later, is no touch."""
    with pytest.raises(UsageError, match="do not ascend"):
        dataclasses.replace(walk, seconds=np.array([1.0, 1.5, 3.5, last]))


def test_a_force_at_a_point_has_the_torque_of_its_lever():
    """Each pair of axes by hand, r x F; points of two coordinates lie on the plane z = 0."""
    at = np.array([[2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0], [1.0, 2.0, 3.0]])
    force = np.array([[0.0, 5.0, 0.0], [0.0, 0.0, 5.0], [5.0, 0.0, 0.0], [4.0, 5.0, 6.0]])
    wanted = [[0.0, 0.0, 10.0], [10.0, 0.0, 0.0], [0.0, 10.0, 0.0], [-3.0, 6.0, -3.0]]
    assert torque_of(force, at).tolist() == wanted
    assert wrench_at(force, at).tolist() == np.hstack([force, wanted]).tolist()
    assert wrench_at(force[3:], at[3:, :2]).tolist() == [[4.0, 5.0, 6.0, 12.0, -6.0, -3.0]]


def test_motion_until_a_frame_is_along_the_gel_but_felt_in_all_axes():
    """Down at 2 mm/s has no pace and no way, and is felt along z as its start is; along y it has both."""
    seconds = np.arange(0.0, 2.0, 0.002)
    way = 2e-3 * np.maximum(seconds - 0.5, 0.0)
    frames = np.array([0.52, 1.0, 1.9])
    down = moved_until(frames, seconds, np.outer(way, [0.0, 0.0, -1.0]))
    along = moved_until(frames, seconds, np.outer(way, [0.0, 1.0, 0.0]))
    assert set(down) == {"pace", "rest", "last_ways", "felt_accelerations", "earlier_places"}
    assert not down["pace"].any()
    np.testing.assert_allclose(along["pace"][1:], 2e-3, rtol=1e-6)
    np.testing.assert_allclose(along["last_ways"][2], np.array(WAYS) / 2e-3, atol=5e-3)
    np.testing.assert_allclose(down["felt_accelerations"][..., 2], -along["felt_accelerations"][..., 1], atol=1e-12)
    assert np.abs(down["felt_accelerations"][0, :, 2]).max() > 0.01
    assert not down["felt_accelerations"][..., :2].any()
