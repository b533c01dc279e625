"""The reference touch is the one that its description tells, and sizes on it are those of one effect at a time."""

import numpy as np
import pytest

from tactiledata.effects import EFFECTS
from tactiledata.effects.closed_form.ball_on_layer import BallOnLayer
from tactiledata.effects.simulate.catalogue import catalogue
from tactiledata.effects.simulate.reference_touch import RIG, RigScales, largest_changes, reference_touch
from tactiledata.effects.simulate.setting import EffectSetting
from tactiledata.effects.simulate.simulator import with_effects
from tactiledata.sensors.digit import DIGIT


def test_its_path_is_a_press_a_slide_and_half_of_it_back(touch):
    """Depths and ways at the ends of its parts, 0.5, 2, 1, 4, 2, 1, 2 and 0.5 s long, from 1 mm off the middle."""
    seconds = touch.seconds - 300.0
    assert seconds[0] == 0.0
    np.testing.assert_allclose(np.diff(seconds), 0.05)
    assert seconds[-1] == pytest.approx(13.0, abs=0.051)
    corners = [0.0, 0.5, 2.5, 3.5, 7.5, 9.5, 10.5, 12.5, 12.95]
    depth = np.interp(corners, seconds, -touch.tips[:, 2])
    np.testing.assert_allclose(depth / RIG.depth, [-0.2, -0.2, 1, 1, 1, 1, 1, -0.2, -0.2], atol=1e-9)
    way = np.interp(corners, seconds, touch.tips[:, :2] @ [0.8, 0.6])
    np.testing.assert_allclose(way, 1e-3 + 2e-3 * np.array([0, 0, 0, 0, 1, 0.5, 0.5, 0.5, 0.5]), atol=1e-9)
    np.testing.assert_allclose(touch.tips[:, :2] @ [-0.6, 0.8], 0.0, atol=1e-12)
    # half a millimetre per second, there and back
    np.testing.assert_allclose(touch.lateral_speed[(seconds > 3.6) & (seconds < 9.4)], RIG.speed, rtol=1e-6)


def test_what_it_states_is_what_its_description_tells(touch):
    """It is ten minutes after power-on, after 200 touches 1 mm deep, at half a radian, with gravity down."""
    np.testing.assert_allclose(touch.powered - touch.seconds, 300.0)
    assert touch.powered[0] == 600.0
    assert set(touch.earlier_contacts) == {200.0}
    assert set(touch.earlier_depth) == {1e-3}
    assert touch.joints[[0, -1], 5].tolist() == [0.0, 0.5]
    assert not touch.joints[:, :5].any()
    assert (touch.gravity == [0.0, 0.0, -9.81]).all()
    assert touch.selection == (1.0, 13.0)
    assert touch.geometry == DIGIT.gel
    assert (touch.poses[:, :3, :3] == np.eye(3)).all()


def test_the_rig_is_that_of_the_paper():
    """The touch is a 4 mm ball, 0.8 mm deep, on 0.88 MPa, with a slide of 2 mm at half a millimetre per second."""
    assert (RIG.youngs_modulus, RIG.poisson_ratio, RIG.friction) == (0.88e6, 0.48, 0.8)
    assert (RIG.radius, RIG.depth, RIG.slide, RIG.speed, RIG.noise) == (4e-3, 0.8e-3, 2e-3, 0.5e-3, 0.1)


def test_other_scales_are_another_touch():
    """Each enters where it belongs."""
    other = reference_touch(RigScales(1e6, 0.45, 0.5, 0.003, 1e-3, 1e-3, 1e-3))
    assert other.indenter.radius == 0.003
    assert (other.material.youngs_modulus, other.material.poisson_ratio, other.material.friction) == (1e6, 0.45, 0.5)
    assert -other.tips[:, 2].min() == pytest.approx(1e-3)
    assert np.ptp(other.tips[:, :2] @ [0.8, 0.6]) == pytest.approx(1e-3)
    assert other.seconds[-1] - other.seconds[0] == pytest.approx(8.5, abs=0.051)


def test_the_size_of_an_effect_is_the_largest_change_of_its_force():
    """The size is the largest change of the force by each strength alone, at its farther end; torques do not count."""
    effect = EFFECTS["heating"]()
    other = reference_touch(RigScales(depth=4e-4))
    plain = with_effects(BallOnLayer, []).play(other).wrench
    found = largest_changes(effect, other)
    assert list(found) == ["change", "rise"]
    for name, value in (("change", -0.15), ("rise", 2e-5)):
        away = with_effects(BallOnLayer, [EffectSetting("heating", {name: value})]).play(other).wrench - plain
        assert found[name] == pytest.approx(np.sqrt((away[:, :3] ** 2).sum(axis=1)).max())
    assert largest_changes(effect)["rise"] > found["rise"]


def test_the_list_of_effects_states_their_parameters():
    """Everything that a page needs, as values for JSON."""
    (entry,) = catalogue([EFFECTS["thickness"]()])
    assert entry["slot_title"] == "contact geometry"
    assert entry["played_by_gel_engine"] == ["error"]
    assert entry["parameters"][0]["bounds"] == (-0.4, 0.4)
    assert entry["look_alikes"] == list(EFFECTS["thickness"].look_alikes)
