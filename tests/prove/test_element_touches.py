"""Touches of the world of elements: Hertz, Coulomb, symmetry, release, steps, and contacts from its bank."""

from dataclasses import replace
from functools import partial
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from tactiledata.indenters import make_indenter
from tactiledata.prove.element_world import bank as element_bank
from tactiledata.prove.element_world.bank import APART, ElementBank, offset_nodes
from tactiledata.prove.element_world.bodies import BODIES, body_of
from tactiledata.prove.element_world.grid import contact_box, grid_lines
from tactiledata.prove.element_world.pad import BrickPad
from tactiledata.prove.element_world.steps import Stepper
from tactiledata.prove.element_world.surface import Pose, SpringSurface
from tactiledata.prove.element_world.touch import GelPad, Solved, Travel, solve_touch, solved_moments
from tactiledata.rig.contact.contact import TouchSetup, contact_times
from tactiledata.rig.contact.footprint import GelGrid, make_footprint
from tactiledata.rig.motion import motion
from tactiledata.rig.motion.touch import Step, TouchPlan
from tactiledata.rig.scenario.scenario import Gel, Material

SIZES = {
    "sphere": {"radius": 0.003},
    "cylinder_flat": {"radius": 0.002},
    "cylinder_side": {"radius": 0.003, "width": 0.008},
    "box": {"width": 0.005, "breadth": 0.006, "length": 0.008},
    "cone": {"half_angle": 1.0, "tip_radius": 0.001},
    "dome": {"curvature_radius": 0.010, "radius": 0.004},
}


def pressed(shape, sizes, tips, friction, spacing, thickness=4.0, outline=(14.0, 14.0), nu=0.48, rotation=None):
    """States of a pad after each of some tips (x, y, z), mm, of a body that comes from where it just touches."""
    turned = np.eye(3) if rotation is None else rotation
    body = body_of(shape, sizes)
    box, _ = contact_box(body, turned, np.array(tips))
    pad = BrickPad(grid_lines(outline, thickness, box, spacing), nu)
    stepper = Stepper(pad, SpringSurface(pad, friction, spacing))
    states = [stepper.rest(Pose(body, turned, np.array(tips[0]) * [1.0, 1.0, 0.0]))]
    for tip in tips:
        states.append(stepper.move(states[-1], Pose(body, turned, np.array(tip))))
    assert states[-1].unsettled == 0
    return states[1:]


@pytest.mark.parametrize("shape", SIZES)
def test_bodies_are_those_that_scenarios_state(shape):
    """Near the tip, distances are those of the package's indenter of that shape, found by other formulas."""
    chance = np.random.default_rng(3)
    points = chance.uniform([-6, -6, -2], [6, 6, 3], (12000, 3))
    told = 1e3 * make_indenter({"shape": shape, **SIZES[shape]}, Path(), shape).signed_distance(1e-3 * points)
    body = body_of(shape, SIZES[shape])
    found = body.distance(points)
    assert (np.sign(found) == np.sign(told))[points[:, 2] < 0.8].all()
    # beside a rim, and inside, where a rim's depth fades, other formulas count
    near = (told > 0.0) & (told < 0.5) & (points[:, 2] < 0.3)
    if shape == "dome":
        near &= np.hypot(points[:, 0], points[:, 1]) < 3.5
    assert near.sum() > 5
    assert np.abs(found - told)[near].max() < 1e-9
    inside = (told < 0.0) & (points[:, 2] < 0.8)
    assert inside.sum() > 10
    assert (found[inside] >= np.minimum(-points[inside, 2], told[inside]) - 1e-9).all()
    growth, push = body.directions(points[near], found[near])
    assert np.linalg.norm(growth, axis=1) == pytest.approx(1.0, abs=1e-3)
    assert np.linalg.norm(push, axis=1) == pytest.approx(1.0)


@pytest.mark.slow
def test_a_ball_on_a_thick_pad_presses_as_hertz_says():
    """Without friction and with what Dimitriadis (2002) adds for a bonded layer's thickness: within 4 %."""
    radius, depth, nu, thickness = 4.0, 0.15, 0.48, 8.0
    (state,) = pressed(
        "sphere", {"radius": 4e-3}, [(0.0, 0.0, -depth)], 0.0, 0.24, thickness=thickness, outline=(24.0, 24.0), nu=nu
    )
    hertz = 4.0 / 3.0 / (1.0 - nu**2) * np.sqrt(radius) * depth**1.5
    narrow = np.sqrt(radius * depth) / thickness
    first = -(1.2876 - 1.4678 * nu + 1.3442 * nu**2) / (1.0 - nu)
    second = (0.6387 - 1.0277 * nu + 1.5164 * nu**2) / (1.0 - nu)
    a, b = first / np.pi, second
    terms = (1.0, -2 * a, 4 * a**2, -8 * (a**3 + 4 * np.pi**2 / 15 * b / np.pi), 16 * a * (a**3 + 0.6 * np.pi * b))
    assert sum(term * narrow**power for power, term in enumerate(terms)) == pytest.approx(1.12, abs=0.02)
    hertz *= sum(term * narrow**power for power, term in enumerate(terms))
    assert state.wrench[2] == pytest.approx(hertz, rel=0.04)
    assert np.abs(state.wrench[:2]).max() < 1e-3 * hertz


@pytest.mark.slow
def test_a_box_that_slides_pulls_with_its_friction():
    """Shear never exceeds friction times the normal force, and has that size and way once all slides."""
    friction, way = 0.3, np.array([0.6, 0.8])
    places = [(0.0, 0.0, -0.1), (0.0, 0.0, -0.2)]
    places += [(*(far * way), -0.2) for far in (0.03, 0.1, 0.25, 0.4, 0.55)]
    states = pressed("box", {"width": 5e-3, "breadth": 5e-3}, places, friction, 0.7)
    for state in states:
        assert np.hypot(*state.wrench[:2]) <= friction * state.wrench[2] * 1.01
    assert not states[2].is_slipping
    assert states[-1].wrench[:2] == pytest.approx(-friction * states[-1].wrench[2] * way, rel=0.02)


@pytest.mark.slow
def test_a_lifted_body_leaves_nothing_behind():
    """After a press, a slide and a lift the pad is as flat as before, and pulls at nothing."""
    states = pressed("sphere", {"radius": 3e-3}, [(0, 0, -0.15), (0.1, 0, -0.15), (0.1, 0, 0.02)], 0.6, 0.4)
    assert states[1].wrench[0] < -0.02
    assert np.abs(states[-1].wrench).max() < 1e-6
    assert np.abs(states[-1].displacements).max() < 1e-3 * np.abs(states[1].displacements).max()


@pytest.mark.slow
def test_a_reversal_turns_the_shear():
    """A body that comes back by the way it went pulls the other way before it is where it began."""
    places = [(0, 0, -0.3), (0.1, 0, -0.3), (0.25, 0, -0.3), (0.4, 0, -0.3), (0.3, 0, -0.3), (0.15, 0, -0.3)]
    shear = [state.wrench[0] for state in pressed("sphere", {"radius": 3e-3}, places, 0.4, 0.45)]
    assert shear[1] < -0.05
    assert shear[2] < shear[1]
    assert shear[4] > shear[3]
    assert shear[5] > 0.0


def tilted(angles):
    """A rotation by small angles about x and y, rad."""
    turn = motion.gel_from_indenter_rotation(TouchPlan("t", "s", "i", (), tilt=tuple(angles)))
    return np.asarray(turn)


@pytest.mark.slow
def test_a_mirrored_touch_has_the_mirrored_wrench():
    """Mirrored in the plane x = 0, a tilted punch that slides gives forces and torques that are mirrored."""
    tips = np.array([(0.5, 0.3, -0.1), (0.5, 0.3, -0.2), (0.6, 0.35, -0.2)])
    one = pressed("cylinder_flat", {"radius": 2e-3}, tips, 0.6, 0.5, rotation=tilted((0.02, 0.03)))
    other = pressed("cylinder_flat", {"radius": 2e-3}, tips * [-1, 1, 1], 0.6, 0.5, rotation=tilted((0.02, -0.03)))
    for here, there in zip(one, other, strict=True):
        mirrored = there.wrench * [-1, 1, 1, 1, -1, -1]
        assert mirrored == pytest.approx(here.wrench, abs=0.01 * np.abs(here.wrench).max())


def travel_of(corners, shape="sphere", sizes=None, rotation=None):
    """A way through corners (x, y, depth), mm, in 60 even moments each, with a rest of 20 at each."""
    corners = np.asarray(corners, dtype=float)
    rows, ends = [corners[:1]], [0]
    for here, there in pairwise(corners):
        rows.append(here + np.linspace(0, 1, 61)[1:, None] * (there - here))
        rows.append(np.repeat(there[None], 20, axis=0))
        ends += [ends[-1] + 60, ends[-1] + 80]
    body = body_of(shape, sizes or {"radius": 3e-3})
    return Travel(body, np.eye(3) if rotation is None else rotation, 0.0, np.concatenate(rows), np.array(ends))


def test_a_way_is_solved_at_its_corners_and_in_between():
    """Solved are all corners, both ends of the touch, and moves that are no longer than a step."""
    travel = travel_of([(0, 0, -0.5), (0, 0, 0.4), (0.5, 0, 0.4), (0.5, 0, 0.1), (0.5, 0, -0.5)])
    rows = solved_moments(travel)
    assert set(travel.corners) <= set(rows)
    inside = rows[travel.positions[rows, 2] > 1e-3]
    assert travel.positions[inside[0], 2] < 0.05
    moves = np.linalg.norm(np.diff(travel.positions[inside], axis=0), axis=1)
    assert moves.max() < 0.25
    assert len(solved_moments(travel, 2.0)) > len(rows)


@pytest.mark.slow
def test_forces_between_solved_moments_follow_the_way():
    """Along a whole touch: nothing in the air, rising while pressed, constant at rest, shear against the way."""
    travel = travel_of([(0, 0, -0.3), (0, 0, 0.2), (0.1, 0, 0.2), (0.1, 0, -0.3)])
    found = solve_touch(GelPad((12.0, 12.0), 4.0, 0.47, 0.6), travel)
    force, depth = found.wrench[:, 2], travel.positions[:, 2]
    assert found.unsettled == 0
    assert found.steps < 14
    assert not found.wrench[depth <= 0].any()
    down, rest, along = slice(0, 61), slice(61, 81), slice(81, 141)
    assert (np.diff(force[down]) >= 0).all()
    assert np.ptp(force[rest]) == 0.0
    assert force[60] > 0.2
    assert (np.diff(found.wrench[along, 0]) <= 1e-9).all()
    assert np.abs(found.wrench[along, 1]).max() < 1e-3


GEL = Gel()
TOUCH = TouchPlan("touch", "unit", "ball", (Step("press", depth=3e-4, step=3e-4, settle=0.05, speed=3e-3),))


def setup_of(offset=(0.0, 0.0, 0.0), modulus=1e6):
    """A touch of a ball on the rig's gel."""
    indenter, rotation = make_indenter({"shape": "sphere", "radius": 0.003}, Path(), "ball"), np.eye(3)
    footprint = make_footprint(indenter, rotation, TOUCH.position, GelGrid.of(GEL))
    plan = partial(motion.plan, TOUCH)
    material = Material(modulus, 0.47, 0.6)
    return TouchSetup(TOUCH, indenter, rotation, footprint, np.array(offset), GEL.thickness, material, plan)


@pytest.fixture
def counted(tmp_path, monkeypatch):
    """A bank, and the number of touches that it has solved, by a law in place of the elements."""
    done = []

    def law(gel, setup, path, moved, finer):
        done.append(moved)
        depth = np.maximum((path.at(contact_times(path)) + moved)[:, 2], 0.0)
        wrench = np.zeros((len(depth), 6))
        wrench[:, 2] = depth**1.5 * 0.06
        return Solved(wrench, np.zeros(len(depth), dtype=bool), 0, 1)

    monkeypatch.setattr(element_bank, "_solved", law)
    return ElementBank(tmp_path), done


NEAR = (0.0, 0.0, 3e-5)


def test_a_bank_solves_three_offsets_once(counted):
    """A touch is solved at three depth offsets and then kept; another modulus or place along the gel asks for none."""
    bank, done = counted
    first = bank.contact(GEL, setup_of(NEAR))
    assert len(done) == 3
    second = ElementBank(bank.folder).contact(GEL, setup_of(NEAR, modulus=2e6))
    aside = bank.contact(GEL, setup_of((1e-4, -2e-4, 3e-5)))
    assert len(done) == 3
    assert second.wrench == pytest.approx(2 * first.wrench, rel=1e-5)
    moved = np.cross([1e-4, -2e-4, 0.0], first.wrench[:, :3])
    assert aside.wrench[:, 3:] - first.wrench[:, 3:] == pytest.approx(moved, abs=1e-9)
    bank.contact(GEL, replace(setup_of(NEAR), thickness=0.003))
    assert len(done) == 6


def test_an_offset_that_is_solved_asks_for_no_other(counted):
    """Without an offset, as where another friction is asked for, a touch is solved once, and is that solution."""
    bank, done = counted
    found = bank.contact(GEL, setup_of())
    assert [float(moved[0, 2]) for moved in done] == [0.0]
    depth = np.maximum(found.path.at(contact_times(found.path))[:, 2], 0.0)
    np.testing.assert_allclose(found.wrench[:, 2], 0.06 * depth**1.5 * 1e6, rtol=1e-6)


def test_a_bank_interpolates_the_offset_and_solves_what_moves_along(counted):
    """Between offsets forces are off by 3 % of the largest at most; a deviation along the gel is solved as it is."""
    bank, done = counted
    between = bank.contact(GEL, setup_of((0.0, 0.0, 4e-5)))
    depth = np.maximum(between.path.at(contact_times(between.path))[:, 2] + 4e-5, 0.0)
    exact = 0.06 * depth**1.5 * 1e6
    off = np.abs(between.wrench[:, 2] - exact) / exact.max()
    assert off.max() < 0.03
    assert off[np.argmax(depth)] < 0.003
    drifting = np.zeros((len(depth), 3))
    drifting[:, 2] = np.linspace(0, -1e-4, len(depth))
    assert bank.contact(GEL, setup_of(), None, drifting).deviation is drifting
    assert len(done) == 3
    drifting = drifting[:, [2, 1, 0]]
    bank.contact(GEL, setup_of(), None, drifting)
    assert len(done) == 4
    assert done[-1] is not drifting
    assert np.array_equal(done[-1], drifting)


def test_offsets_are_solved_as_far_as_they_reach():
    """Offsets beyond the usual three are solved as well."""
    assert offset_nodes(np.array([-2.7, 0.0]) * APART).tolist() == [-3, -2, -1, 0, 1]


def test_an_unknown_shape_is_refused():
    """A shape that the generator lacks is named, with those that it knows."""
    with pytest.raises(ValueError, match=r"torus.*sphere"):
        body_of("torus", {})
    assert set(BODIES) == set(SIZES)


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("shape", "sizes", "depth", "bound"),
    [("sphere", {"radius": 3e-3}, 0.6, 0.014), ("cylinder_flat", {"radius": 2e-3}, 0.4, 0.028)],
)
def test_forces_are_converged(shape, sizes, depth, bound):
    """Forces of a ball change by at most 1.4 %, those of a punch by at most 2.8 %, on a grid 1.25 times as fine.

    Of an error in proportion to the spacing that is as much as 2 % and 4 % on a grid 1.4 times as fine.
    """
    travel = travel_of([(0, 0, -0.2), (0, 0, depth), (0.2, 0, depth)], shape, sizes)
    gel = GelPad((12.0, 12.0), 4.1, 0.476, 0.62)
    usual, fine = (solve_touch(gel, travel, finer).wrench for finer in (1.0, 1.25))
    for row, column in ((140, 2), (-1, 2), (-1, 0)):
        assert usual[row, column] == pytest.approx(fine[row, column], rel=bound)
