"""Touches played on a coarse pad answer as the engine itself does."""

import numpy as np
import pytest

from tactiledata.calibrate.bounds import find_bounds
from tactiledata.calibrate.plays.kept_plays import Play
from tactiledata.calibrate.touches import MeasuredTouch
from tactiledata.diagnose.touches.play_grid import play_touches
from tactiledata.diagnose.touches.played_response import PlayedFamily
from tactiledata.diagnose.touches.variant_plays import is_solvable, variants_of
from tactiledata.effects.touch.response import GelVariant
from tactiledata.effects.touch.touch import Touch
from tactiledata.gel.contact.history import FrameStatus, GelTouch
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.gel.engines.fem import FemEngine
from tactiledata.gel.mesh.structured_pad import GridPlan, structured_pad
from tactiledata.indenters.sphere import Sphere
from tactiledata.sensors.digit import DIGIT

pytestmark = pytest.mark.slow

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
    """Interpolated plays give the force of the gel engine within 3 %, deeper and with more friction too."""
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


@pytest.mark.parametrize(("friction", "most"), [(0.08, 0.06), (0.25, 0.05), (0.5, 0.04), (1.3, 0.06)])
def test_shear_at_a_friction_that_was_not_played_is_the_engines(played, friction, most):
    """Below, between and beyond the played frictions shear is that of the engine within some per cent of the load."""
    for measured_touch, plays in zip(*played, strict=True):
        touch = Touch(
            measured_touch.seconds, measured_touch.touch.poses, measured_touch.touch.indenter, MATERIAL, DIGIT.gel
        )
        factor = np.full(FRAMES, friction / MATERIAL.friction)
        answer = PlayedFamily([touch], [plays])(MATERIAL)(touch).respond(
            np.zeros(FRAMES), np.zeros((FRAMES, 2)), factor
        )
        expected = engine_wrench(measured_touch, 0.0, friction)
        assert np.abs(answer.wrench - expected)[:, :2].max() < most * expected[:, 2].max()


def test_a_frame_without_a_pose_is_not_known(played, tmp_path, monkeypatch):
    """A frame without a pose is NaN in every play, and frames beside it are not."""
    monkeypatch.setenv("TACTILEDATA_CACHE", str(tmp_path))
    touch = measured((0.0, 0.0))
    touch.touch.poses[3] = np.nan
    (plays,) = play_touches(PAD, "linear", [touch], find_bounds("paper"))
    assert np.isnan(plays.level[:, :, 3]).all()
    assert np.isfinite(plays.level[:, :, [1, 2, 4]]).all()


def test_variants_are_played_and_kept(tmp_path, monkeypatch):
    """Thinner gels, larger indenters and thicker skins push harder; a second run reads all variants from the cache."""
    monkeypatch.setenv("TACTILEDATA_CACHE", str(tmp_path))
    touch = measured((0.0, 0.0))
    variants = variants_of(["thickness", "mount_offset", "skin"])
    assert len(variants) == 6

    def differences():
        (plays,) = play_touches(PAD, "linear", [touch], find_bounds("paper"), variants=variants)
        return plays.variants

    first = differences()
    thinner, thicker = GelVariant(thickness=0.85), GelVariant(thickness=1.15)
    smaller, larger = GelVariant(indenter_scale=0.97), GelVariant(indenter_scale=1.03)
    for softer, stiffer in ((thicker, thinner), (smaller, larger), (GelVariant(), GelVariant(skin=6e-4))):
        less = first.get(softer, np.zeros((FRAMES, 6)))
        assert (first[stiffer][2:, 2] > less[2:, 2]).all()
    assert not first[thinner][0].any()
    files = set(tmp_path.rglob("*.npz"))
    again = differences()
    assert files == set(tmp_path.rglob("*.npz"))
    assert all(np.array_equal(first[variant], again[variant]) for variant in variants)


def test_a_variant_that_cannot_be_solved_costs_no_frames():
    """A variant is given up that loses more than a tenth of the frames that the nominal gel solves."""

    def play(unsolved):
        status = np.full(20, FrameStatus.SOLVED, dtype=np.int8)
        status[:unsolved] = FrameStatus.NOT_CONVERGED
        return Play(np.zeros((20, 6)), status, np.zeros(20))

    plain = [play(0)]
    assert [is_solvable([play(unsolved)], plain) for unsolved in (0, 2, 3, 5)] == [True, True, False, False]
    # what the nominal gel cannot solve either does not count
    assert is_solvable([play(5)], [play(5)])


@pytest.fixture(scope="module")
def at_finite_strain(tmp_path_factory):
    """Two touches, every node and two variants played at finite strain; estimated, in part in full, roughly."""
    variants = (GelVariant(thickness=0.9), GelVariant(c20=0.2))
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TACTILEDATA_CACHE", str(tmp_path_factory.mktemp("cache")))
        touches = [measured((0.0, 0.0)), measured((1e-3, -2e-3))]
        made = [
            play_touches(PAD, "finite-strain", touches, find_bounds("paper"), variants=variants, **how)
            for how in ({"estimates": "none"}, {}, {"full": variants[:1]}, {"estimates": "rough"})
        ]
    return variants, made


@pytest.mark.nightly
def test_estimated_plays_are_near_full_ones(at_finite_strain):
    """Forces are within 1 % of the largest one at every node, and slopes over the offset within 10 %."""
    _, (all_played, estimated, *_) = at_finite_strain
    for full, quick in zip(all_played, estimated, strict=True):
        force = full.level[..., :3]
        assert np.abs(quick.level[..., :3] - force).max() < 0.01 * np.abs(force).max()
        assert not np.array_equal(quick.level, full.level)
        for name in ("by_ratio", "by_friction"):
            slope, near = (getattr(plays, name)[:, 0, :, :3] for plays in (full, quick))
            assert np.abs(near - slope).max() < 0.1 * np.abs(slope).max()


@pytest.mark.nightly
def test_rough_estimates_know_the_middle_and_friction(at_finite_strain):
    """Friction is as well known as by other estimates; nu is off by a third of its change, and laws are left out."""
    (_, stiffening), (all_played, estimated, _, rough) = at_finite_strain
    for full, quick, one in zip(all_played, estimated, rough, strict=True):
        assert np.array_equal(one.level[1], quick.level[1], equal_nan=True)
        assert set(one.variants) == set(quick.variants) - {stiffening}
        change = full.level[::2, 1, :, :3] - full.level[1, 1, :, :3]
        off = np.abs(one.level[::2, 1, :, :3] - full.level[::2, 1, :, :3]).max()
        assert 0.0 < off < 0.4 * np.abs(change).max()


@pytest.mark.nightly
def test_what_is_asked_for_and_what_the_linear_engine_does_not_know_is_played_in_full(at_finite_strain):
    """A stiffening law where touches are few, a thickness where it is asked for; estimates are off by some per cent."""
    (thinner, stiffening), (all_played, estimated, asked, _) = at_finite_strain
    for full, quick, closer in zip(all_played, estimated, asked, strict=True):
        for plays, variant in ((quick, stiffening), (closer, stiffening), (closer, thinner)):
            assert np.array_equal(plays.variants[variant], full.variants[variant], equal_nan=True)
        change = np.linalg.norm(full.variants[thinner][:, :3])
        off = np.linalg.norm((quick.variants[thinner] - full.variants[thinner])[:, :3])
        assert 0.0 < off < 0.3 * change


@pytest.mark.parametrize(("place", "most"), [(0, 1e-9), (1, 1e-9), (None, 5e-3)])
def test_a_part_is_the_same_frames(played, place, most):
    """Plays cut to some frames answer as the whole plays do at a played friction, and within 5 mN between two."""
    touches, (first, _) = played
    rows = np.array([True, False, True, True, True, False, True, True])
    touch = touches[0]
    whole = Touch(touch.seconds, touch.touch.poses, touch.touch.indenter, MATERIAL, DIGIT.gel)
    part = Touch(touch.seconds[rows], touch.touch.poses[rows], touch.touch.indenter, MATERIAL, DIGIT.gel)
    friction = MATERIAL.friction if place is None else first.plan.frictions[place]
    asked = np.zeros(FRAMES), np.zeros((FRAMES, 2)), np.full(FRAMES, friction / MATERIAL.friction)
    expected = PlayedFamily([whole], [first])(MATERIAL)(whole).respond(*asked).wrench[rows]
    found = PlayedFamily([part], [first.part(rows)])(MATERIAL)(part).respond(*(one[rows] for one in asked))
    assert found.wrench == pytest.approx(expected, abs=most)
