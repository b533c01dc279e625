"""Effects on where the indenter is: balance of springs, beams, offsets."""

import dataclasses
import math

import numpy as np
import pytest
from scipy.optimize import brentq

from tactiledata.effects import EFFECTS
from tactiledata.effects.base import CONTACT_SLOTS
from tactiledata.effects.closed_form.ball_on_layer import BallOnLayer
from tactiledata.effects.pose.stem_bending import stem_stiffness
from tactiledata.effects.simulate.setting import EffectSetting
from tactiledata.effects.simulate.simulator import CLOSE, with_effects
from tactiledata.effects.touch.state import TouchState
from tactiledata.errors import UsageError
from tactiledata.indenters.sphere import Sphere


def normal_force(touch, moved, depth):
    """N at one depth, of the base alone."""
    still = moved(touch, np.arange(2.0), np.full(2, depth))
    return TouchState.start(still, BallOnLayer(still)).contact.wrench[0, 2]


@pytest.mark.parametrize("compliance", [3e-6, 3e-5, 1e-4])
def test_arm_and_gel_share_the_depth(touch, play, moved, compliance):
    """The force solves F = F_gel(d - c F), as a root finder does frame by frame; even where the arm is the softer."""
    depths = np.linspace(-2e-4, 1e-3, 13)
    press = moved(touch, np.arange(13.0), depths)
    found = play("arm_compliance", on=press, translation=compliance).wrench[:, 2]
    for depth, force in zip(depths, found, strict=True):
        rigid = normal_force(touch, moved, depth)
        wanted = brentq(lambda f, d=depth: normal_force(touch, moved, d - compliance * f) - f, -1e-9, rigid + 1e-9)
        assert force == pytest.approx(wanted, abs=1e-6)


def test_wrist_and_stem_are_springs_in_series(touch, play, moved):
    """While it sticks, shear stiffness is that of gel and springs one after the other; the normal force is rigid."""
    depth = np.concatenate([np.linspace(0.0, 8e-4, 9), np.full(11, 8e-4)])
    slide = moved(touch, np.arange(20.0), depth, x=np.concatenate([np.zeros(9), np.linspace(0.0, 1e-4, 11)]))
    rigid = play(on=slide).wrench
    stiffness = -rigid[-1, 0] / 1e-4
    for effect, values, compliance in (
        ("stem_bending", {"compliance": 2e-4}, 2e-4),
        ("arm_compliance", {"rotation": 1e-3, "lever": 0.2}, 1e-3 * 0.2**2),
    ):
        soft = play(effect, on=slide, **values).wrench
        assert -soft[-1, 0] / 1e-4 == pytest.approx(1.0 / (1.0 / stiffness + compliance), rel=1e-6)
        np.testing.assert_allclose(soft[:, 2], rigid[:, 2], rtol=1e-12)


def test_a_stem_on_a_wedge_bends_across_its_own_axis(touch):
    """A stem that leans by 0.1 rad yields across itself: pressed straight, its tip moves aside, and less deep."""
    lean, compliance = 0.1, 2e-4
    turned = touch.poses.copy()
    turned[:, :3, :3] = np.array([[np.cos(lean), 0, np.sin(lean)], [0, 1, 0], [-np.sin(lean), 0, np.cos(lean)]])
    state = with_effects(BallOnLayer, [EffectSetting("stem_bending", {"compliance": compliance})]).play(
        dataclasses.replace(touch, poses=turned)
    )
    moved = np.column_stack([state.shift, -state.offset])
    along, across = turned[:, :3, 2], np.cross(turned[:, :3, 2], [0.0, 1.0, 0.0])
    np.testing.assert_allclose((moved * along).sum(axis=1), 0.0, atol=1e-15)
    for way in (across, np.broadcast_to([0.0, 1.0, 0.0], across.shape)):
        pull = (state.felt[:, :3] * way).sum(axis=1)
        np.testing.assert_allclose((moved * way).sum(axis=1), compliance * pull, rtol=1e-12, atol=1e-18)
    deepest = int(np.argmax(state.felt[:, 2]))
    assert state.offset[deepest] < -1e-7


def test_stems_bend_as_beams():
    """Stems of 4 mm and 10 mm of printed plastic, 30 mm long, bend by 3 E I / L^3."""
    assert stem_stiffness(0.004, 0.03) == pytest.approx(3 * 2.5e9 * math.pi * 0.002**4 / 4 / 0.03**3)
    assert stem_stiffness(0.010, 0.03) == pytest.approx(1.4e5, rel=0.05)
    assert stem_stiffness(0.004, 0.03) == stem_stiffness(0.004, 0.03, 2.5e9)
    assert stem_stiffness(0.004, 0.03, 5e9) == pytest.approx(2 * stem_stiffness(0.004, 0.03))


def test_an_offset_is_another_path(touch, play):
    """Deeper and further on gives what a recording there gives, and says where the indenter was."""
    poses = touch.poses.copy()
    poses[:, :3, 3] += [2e-4, -3e-4, -1e-4]
    there = dataclasses.replace(touch, poses=poses)
    state = play("mount_offset", deeper=1e-4, x=2e-4, y=-3e-4)
    np.testing.assert_allclose(state.wrench, play(on=there).wrench, atol=1e-9)
    np.testing.assert_allclose(state.moved_poses, poses, atol=1e-15)


@pytest.mark.parametrize(("error", "tolerance"), [(0.03, 1e-9), (-0.03, 1e-9), (0.015, 2e-3)])
def test_a_radius_error_is_another_ball(touch, play, error, tolerance):
    """A radius error gives the wrench of another ball: exactly at the design points, to second order between them."""
    other = dataclasses.replace(touch, indenter=Sphere(touch.indenter.radius * (1.0 + error)))
    change = play(on=other).wrench - play().wrench
    found = play("mount_offset", radius_error=error).wrench - play().wrench
    pressed = play().contact.depth > 1e-4
    np.testing.assert_allclose(found[pressed, 2], change[pressed, 2], rtol=tolerance, atol=1e-9)


def test_a_setting_may_hold_for_one_mounting_only(touch, play):
    """A setting for one of two mountings displaces that one only."""
    here = EffectSetting("mount_offset", {"deeper": 1e-4}, {"mount": "first"})
    simulator = with_effects(BallOnLayer, [here])
    elsewhere = dataclasses.replace(touch, mount="second")
    assert simulator.play(elsewhere).wrench.tobytes() == play().wrench.tobytes()
    assert simulator.play(touch).wrench.tobytes() == play("mount_offset", deeper=1e-4).wrench.tobytes()


def test_springs_and_what_stiffens_the_gel_find_one_balance(touch, moved):
    """The arm yields to the force of the warm gel, not to that of the cold one."""
    press = moved(touch, np.arange(5.0), np.linspace(0.0, 8e-4, 5), powered=np.full(5, 1e9))
    settings = [
        EffectSetting("heating", {"change": 0.1}),
        EffectSetting("arm_compliance", {"translation": 3e-5}),
    ]
    force = with_effects(BallOnLayer, settings).play(press).wrench[-1, 2]
    assert force == pytest.approx(1.1 * normal_force(touch, moved, 8e-4 - 3e-5 * force), rel=1e-6)


SOFTEST = [
    # what may be negative is a direction, no softness
    EffectSetting(name, {p.name: p.bounds[1] for p in EFFECTS[name].parameters if p.bounds[0] >= 0})
    for name in ("arm_compliance", "stem_bending")
]


def test_the_softest_springs_find_their_balance(touch):
    """With all compliances at their bounds, playing the state again with what it felt hardly changes it."""
    state = with_effects(BallOnLayer, SOFTEST).play(touch)
    again = dataclasses.replace(TouchState.start(touch, BallOnLayer(touch)), felt=state.wrench)
    for setting in SOFTEST:
        again = setting.apply(again)
    near = CLOSE * np.abs(state.wrench).max()
    np.testing.assert_allclose(again.contact.wrench, state.wrench, rtol=0, atol=2 * near)


def test_no_balance_is_said(touch, monkeypatch):
    """An error is raised, and no number given, if the rounds do not suffice."""
    monkeypatch.setattr("tactiledata.effects.simulate.simulator.MOST_ROUNDS", 3)
    with pytest.raises(UsageError, match="no balance"):
        with_effects(BallOnLayer, SOFTEST).play(touch)


@pytest.mark.parametrize(("away", "is_said"), [(5e-6, False), (5e-5, True)])
def test_contact_that_comes_and_goes_at_its_edge_is_no_error(touch, moved, away, is_said):
    """A force that begins with a jump at the surface has no balance there; deeper, it is an error."""
    arm = EffectSetting("arm_compliance", {"translation": 2e-5})
    press = moved(touch, np.arange(3.0), np.array([0.0, 8e-4, away]))

    class Beginning(BallOnLayer):
        def respond(self, offset, shift, friction):
            answer = super().respond(offset, shift, friction)
            jumps = (answer.depth > away - 2e-6) & (np.arange(3) == 2)
            return dataclasses.replace(
                answer, wrench=answer.wrench + np.where(jumps[:, None], [0, 0, 0.2, 0, 0, 0], 0.0)
            )

    if is_said:
        with pytest.raises(UsageError, match="no balance"):
            with_effects(Beginning, [arm]).play(press)
    else:
        found = with_effects(Beginning, [arm]).play(press).wrench[:, 2]
        assert found[1] > 1.0
        assert found[2] < 0.25


@pytest.mark.parametrize(("jump", "is_said"), [(0.004, False), (0.04, True)])
def test_what_jumps_a_little_is_no_error(touch, moved, jump, is_said):
    """A force that jumps where springs and gel would meet leaves no balance: the nearest is taken, unless far off."""
    arm = EffectSetting("arm_compliance", {"translation": 2e-5})
    press = moved(touch, np.arange(3.0), np.array([0.0, 8e-4, 8e-4]))
    plain = with_effects(BallOnLayer, [arm]).play(press).contact
    meets = plain.depth[-1] - 2e-5 * 0.5 * jump * plain.wrench[-1, 2]

    class Jumping(BallOnLayer):
        def respond(self, offset, shift, friction):
            answer = super().respond(offset, shift, friction)
            share = np.where(answer.depth > meets, 1.0 + jump, 1.0)
            return dataclasses.replace(answer, wrench=answer.wrench * share[:, None])

    if is_said:
        with pytest.raises(UsageError, match="no balance"):
            with_effects(Jumping, [arm]).play(press)
    else:
        state = with_effects(Jumping, [arm]).play(press)
        np.testing.assert_allclose(state.felt[-1, 2], state.contact.wrench[-1, 2], rtol=jump)


@pytest.mark.parametrize("name", [name for name in EFFECTS if EFFECTS[name].slot in CONTACT_SLOTS[1:]])
def test_springs_find_a_balance_with_every_effect(touch, medium, name):
    """No effect in contact jumps with the force in a way that leaves springs without a balance."""
    full = {key: 2 * value for key, value in medium(name).items()}
    springs = [EffectSetting("arm_compliance", medium("arm_compliance"))]
    springs.append(EffectSetting("stem_bending", medium("stem_bending")))
    state = with_effects(BallOnLayer, [*springs, EffectSetting(name, full)]).play(touch)
    assert np.isfinite(state.wrench).all()


def test_an_arm_leans_as_the_indenter_stands(touch):
    """A push moves the tip along the indenter's own axes: with it turned by a quarter, along y instead of x."""
    turned = touch.poses.copy()
    turned[:, :3, :3] = turned[:, :3, :3] @ np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    lean = [EffectSetting("arm_compliance", {"lean_x": 1e-5})]
    straight = with_effects(BallOnLayer, lean).play(touch)
    across = with_effects(BallOnLayer, lean).play(dataclasses.replace(touch, poses=turned))
    deepest = int(np.argmax(straight.wrench[:, 2]))
    assert straight.shift[deepest, 0] == pytest.approx(1e-5 * straight.felt[deepest, 2], rel=1e-6)
    assert straight.shift[deepest, 1] == pytest.approx(0.0, abs=1e-12)
    assert across.shift[deepest, 1] == pytest.approx(1e-5 * across.felt[deepest, 2], rel=1e-6)
