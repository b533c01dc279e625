"""Touches played on a coarse pad answer as the engine itself does."""

import numpy as np
import pytest

from tactiledata.calibrate.bounds import find_bounds
from tactiledata.calibrate.touches import MeasuredTouch
from tactiledata.diagnose.play_touches import play_touches
from tactiledata.diagnose.touch_plays import PlayedFamily
from tactiledata.effects.touch import Touch
from tactiledata.gel.fem import FemEngine
from tactiledata.gel.history import GelTouch
from tactiledata.gel.material import GelMaterial
from tactiledata.gel.structured_pad import GridPlan, structured_pad
from tactiledata.indenters.sphere import Sphere
from tactiledata.sensors.digit import DIGIT

PAD = structured_pad("coarse", DIGIT.gel, GridPlan(7, 9, 0.8e-3, (2.4e-3, 2.4e-3), (0.0, 0.5, 0.8, 1.0)))
FRAMES = 8
MATERIAL = GelMaterial(9e5, 0.47, 0.65)


def measured(place):
    poses = np.tile(np.eye(4), (FRAMES, 1, 1))
    poses[:, :2, 3] = place
    poses[:, 2, 3] = -np.array([-0.5, 0.1, 0.25, 0.4, 0.5, 0.5, 0.5, 0.5]) * 1e-3
    poses[:, 0, 3] += np.array([0, 0, 0, 0, 0, 0.1, 0.3, 0.6]) * 1e-3
    touch = GelTouch(Sphere(radius=4e-3), poses)
    return MeasuredTouch("u", "t", "D1", "ball", touch, np.zeros((FRAMES, 6)), np.arange(FRAMES) / 5, 40.0)


@pytest.fixture(scope="module")
def played(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TACTILEDATA_CACHE", str(tmp_path_factory.mktemp("cache")))
        touches = [measured((0.0, 0.0)), measured((1e-3, -2e-3))]
        yield touches, play_touches(PAD, "linear", touches, find_bounds("paper"))


def engine_wrench(touch, deeper=0.0, friction=MATERIAL.friction):
    poses = touch.touch.poses.copy()
    poses[:, 2, 3] -= deeper
    engine = FemEngine(PAD, MATERIAL.poisson_ratio, "linear")
    material = GelMaterial(MATERIAL.youngs_modulus, MATERIAL.poisson_ratio, friction)
    _, history = next(engine.play([GelTouch(touch.touch.indenter, poses)], material, "none"))
    return np.nan_to_num(history.wrench)


@pytest.mark.parametrize(("deeper", "friction"), [(0.0, 1.0), (3e-5, 1.0), (0.0, 1.2)])
def test_it_answers_as_the_engine(played, deeper, friction):
    for measured_touch, plays in zip(*played, strict=True):
        touch = Touch(
            measured_touch.seconds, measured_touch.touch.poses, measured_touch.touch.indenter, MATERIAL, DIGIT.gel
        )
        answer = PlayedFamily([touch], [plays])(MATERIAL)(touch).respond(
            np.full(FRAMES, deeper), np.zeros((FRAMES, 2)), np.full(FRAMES, friction)
        )
        expected = engine_wrench(measured_touch, deeper, MATERIAL.friction * friction)
        assert np.abs(answer.wrench - expected)[:, :3].max() < 0.03 * np.abs(expected).max()
        assert not answer.wrench[0].any()
        assert answer.area[0] == 0 < answer.area[2] < answer.area[4]
        on_top = answer.touching
        assert np.abs(answer.centre[on_top] - touch.tips[on_top, :2]).max() < 5e-4
        assert answer.depth[4] == pytest.approx(0.5e-3 + deeper + plays.height[4], abs=1e-9)


def test_a_frame_without_a_pose_is_not_known(played, tmp_path, monkeypatch):
    monkeypatch.setenv("TACTILEDATA_CACHE", str(tmp_path))
    touch = measured((0.0, 0.0))
    touch.touch.poses[3] = np.nan
    (plays,) = play_touches(PAD, "linear", [touch], find_bounds("paper"))
    assert np.isnan(plays.level[:, :, 3]).all()
    assert np.isfinite(plays.level[:, :, [1, 2, 4]]).all()
