"""The response between plays: exact at the plays, smooth between, and quiet in the air."""

import numpy as np
import pytest

from tactiledata.calibrate.bounds import find_bounds
from tactiledata.calibrate.plan import ResponsePlan
from tactiledata.diagnose.touches.grid_answer import TouchPlays
from tactiledata.diagnose.touches.played_response import PlayedFamily
from tactiledata.effects.touch.response import GelVariant
from tactiledata.effects.touch.touch import Touch
from tactiledata.errors import UsageError
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.indenters.sphere import Sphere
from tactiledata.sensors.digit import DIGIT

PLAN = ResponsePlan.of(find_bounds("paper"))
FRAMES = 9
DEPTH = np.concatenate([[-1e-3], np.linspace(1e-4, 6e-4, 5), np.full(3, 6e-4)])
WAY = np.concatenate([np.zeros(6), [1e-4, 3e-4, 6e-4]])


def columns(ratio, friction, offset, shift=0.0):
    """A Hertz-like answer (n, 7) in closed form: sticks as a spring, slides at mu N."""
    depth = np.maximum(DEPTH + offset, 0.0) * (DEPTH > 0)
    normal = 4e-2 / (1 - ratio**2) * depth**1.5
    shear = -np.minimum(friction * normal, 0.1 * (WAY + shift) * np.sqrt(depth))
    x, z = WAY + shift, -depth
    out = np.zeros((FRAMES, 7))
    out[:, 0], out[:, 2] = shear, normal
    out[:, 4] = z * shear - x * normal
    out[:, 6] = np.pi * 4e-3 * depth
    return out


@pytest.fixture(scope="module")
def plays():
    def bend(ratio, friction):
        less, none, more = (columns(ratio, friction, z) for z in (-PLAN.offset, 0.0, PLAN.offset))
        return [(more - less) / (2 * PLAN.offset), (more + less - 2 * none) / (2 * PLAN.offset**2)]

    i, j = PLAN.middle
    nu, mu = PLAN.ratios[i], PLAN.frictions[j]
    step = 1e-5
    along = (columns(nu, mu, 0, step) - columns(nu, mu, 0, -step)) / (2 * step)
    return TouchPlays(
        PLAN,
        np.array([[columns(ratio, friction, 0) for friction in PLAN.frictions] for ratio in PLAN.ratios]),
        np.array([bend(ratio, mu) for ratio in PLAN.ratios]),
        np.array([bend(nu, friction) for friction in PLAN.frictions]),
        np.stack([along, np.zeros_like(along)]),
        np.zeros(FRAMES),
        {GelVariant(c20=0.2): np.ones((FRAMES, 6)) * 1e-9},
    )


@pytest.fixture(scope="module")
def touch():
    poses = np.tile(np.eye(4), (FRAMES, 1, 1))
    poses[:, 0, 3], poses[:, 2, 3] = WAY, -DEPTH
    return Touch(np.arange(FRAMES) / 10, poses, Sphere(radius=4e-3), GelMaterial(9e5, 0.47, 0.7), DIGIT.gel)


def asked(offset=0.0, friction=1.0, x=0.0):
    shift = np.zeros((FRAMES, 2))
    shift[:, 0] = x
    return np.full(FRAMES, offset), shift, np.full(FRAMES, friction)


def test_plays_are_given_back(plays, touch):
    """At the nu and mu of a play its wrench is given back, times E."""
    for ratio in PLAN.ratios:
        for friction in PLAN.frictions:
            answer = PlayedFamily([touch], [plays])(GelMaterial(9e5, ratio, friction))(touch).respond(*asked())
            assert answer.wrench == pytest.approx(9e5 * columns(ratio, friction, 0)[:, :6], abs=1e-9)


def test_between_plays_it_is_near(plays, touch):
    """Between plays the wrench is that of the closed form within 2 %, with the depth and the centre of pressure."""
    base = PlayedFamily([touch], [plays])(GelMaterial(9e5, 0.468, 0.62))(touch)
    answer = base.respond(*asked(offset=3e-5))
    expected = 9e5 * columns(0.468, 0.62, 3e-5)[:, :6]
    assert np.abs(answer.wrench - expected).max() < 0.02 * np.abs(expected).max()
    assert not answer.wrench[0].any()
    assert answer.area[0] == 0
    assert answer.depth == pytest.approx(DEPTH + 3e-5)
    assert answer.centre[-1] == pytest.approx([WAY[-1], 0], abs=3e-5)


def test_friction_of_single_frames(plays, touch):
    """Less friction in one frame lowers its shear in proportion, and changes no other frame."""
    base = PlayedFamily([touch], [plays])(touch.material)(touch)
    friction = np.ones(FRAMES)
    friction[-1] = 0.8
    plain, changed = base.respond(*asked()), base.respond(*asked()[:2], friction)
    assert np.array_equal(plain.wrench[:-1], changed.wrench[:-1])
    assert changed.wrench[-1, 0] == pytest.approx(0.8 * plain.wrench[-1, 0], rel=0.02)
    assert plain.sliding.tolist() == [False] * 7 + [True] * 2


def test_only_what_was_played_is_answered(plays, touch):
    """A variant of the gel or a touch that was not played is refused."""
    base = PlayedFamily([touch], [plays])(touch.material)(touch)
    assert not base.difference(GelVariant()).any()
    assert base.difference(GelVariant(c20=0.2)) == pytest.approx(9e-4)
    with pytest.raises(UsageError, match="not played"):
        base.difference(GelVariant(c20=0.1))
    elsewhere = Touch(touch.seconds, touch.poses + 1e-3, touch.indenter, touch.material, touch.geometry)
    with pytest.raises(UsageError, match="not played"):
        PlayedFamily([touch], [plays])(touch.material)(elsewhere)
