"""Adhesion against Johnson, Kendall and Roberts, and Kendall."""

import numpy as np
import pytest
from scipy.optimize import brentq

from tactiledata.effects.interface.adhesion import AFTER_SHEAR, jkr_force, punch_force, tip_radius
from tactiledata.effects.touch.response import ContactResponse
from tactiledata.effects.touch.state import wrench_at
from tactiledata.indenters import INDENTERS
from tactiledata.indenters.cylinder_flat import CylinderFlat
from tactiledata.indenters.dome import Dome
from tactiledata.indenters.sphere import Sphere

MODULUS, RADIUS, WORK = 1.1e6, 0.004, 0.5


def test_jkr_is_the_branch_of_large_contacts():
    """The force over the depth is that of the parametric curve, from deep down to where it parts."""
    a = np.linspace(5e-5, 2e-3, 20001)
    depth = a**2 / RADIUS - np.sqrt(2 * np.pi * WORK * a / MODULUS)
    force = 4 * MODULUS * a**3 / (3 * RADIUS) - np.sqrt(8 * np.pi * WORK * MODULUS * a**3)
    stable = a >= a[np.argmin(depth)]
    at = np.linspace(depth.min() * 0.99, 4e-4, 50)
    wanted = np.interp(at, depth[stable], force[stable])
    found = jkr_force(at, RADIUS, MODULUS, np.full(50, WORK))
    np.testing.assert_allclose(found, wanted, atol=2e-5)
    assert jkr_force(np.array([depth.min() * 1.01]), RADIUS, MODULUS, np.array([WORK]))[0] == 0


@pytest.mark.slow
@pytest.mark.parametrize("work", [0.02, 0.5, 2.0])
@pytest.mark.parametrize("radius", [0.002, 0.01])
def test_a_ball_lets_go_at_johnsons_force(work, radius):
    """The largest pull is 1.5 pi W R, whatever the modulus."""
    for modulus in (3e5, 3e6):
        depth = np.linspace(-4e-4, 4e-4, 80001)
        least = jkr_force(depth, radius, modulus, np.full(len(depth), work)).min()
        assert least == pytest.approx(-1.5 * np.pi * work * radius, rel=1e-3)


def test_a_flat_punch_lets_go_at_kendalls_force():
    """The largest pull is sqrt(8 pi E* W a^3)."""
    depth = np.linspace(-1e-3, 1e-4, 100001)
    force = punch_force(depth, 0.003, MODULUS, np.full(len(depth), WORK))
    assert force.min() == pytest.approx(-np.sqrt(8 * np.pi * MODULUS * WORK * 0.003**3), rel=1e-3)
    assert (force[depth >= 0] == 0).all()


def there_and_back(touch, moved, deepest=3e-4, frames=400, **fields):
    depth = deepest * np.interp(np.arange(2.0 * frames), [0, frames, 2 * frames - 1], [-0.5, 1.0, -2.0])
    return moved(touch, np.arange(2.0 * frames) / 100, depth, **fields)


def test_it_pulls_only_on_leaving_and_lets_go_once(touch, play, moved):
    """Loading is untouched; leaving is tension up to 1.5 pi W R; then there is free air."""
    path = there_and_back(touch, moved, frames=4000)
    plain, state = play(on=path), play("adhesion", on=path, work=WORK)
    np.testing.assert_array_equal(state.wrench[:4000], plain.wrench[:4000])
    assert (state.wrench[:, 2] <= plain.wrench[:, 2]).all()
    # what the thin layer adds to Hertz at the pull's small depths is some per cent
    assert state.wrench[:, 2].min() == pytest.approx(-1.5 * np.pi * WORK * 0.004, rel=0.05)
    assert (state.wrench[-1000:] == 0).all()
    assert np.abs(np.diff(state.wrench[4000:, 2])).max() < 1.2 * 1.5 * np.pi * WORK * 0.004


def test_shear_takes_most_of_it(touch, play, moved):
    """After a slide the pull is 12 % of what it is without."""
    still = there_and_back(touch, moved, frames=4000)
    slid = there_and_back(touch, moved, frames=4000, x=np.interp(np.arange(8000.0), [3000, 3900], [0.0, 3e-3]))
    pulls = []
    for path in (still, slid):
        state = play("adhesion", on=path, work=WORK)
        pulls.append(state.wrench[:, 2].min())
    assert pulls[1] / pulls[0] == pytest.approx(AFTER_SHEAR, rel=0.1)


class Punch:
    """A flat punch on a half space, without friction."""

    def __init__(self, touch):
        self.touch = touch

    def respond(self, offset, shift, friction):
        depth = offset - self.touch.tips[:, 2]
        pressed, radius = np.maximum(depth, 0), self.touch.indenter.radius
        material = self.touch.material
        modulus = material.youngs_modulus / (1 - material.poisson_ratio**2)
        force = np.column_stack([0 * depth, 0 * depth, 2 * modulus * radius * pressed])
        centre = self.touch.tips[:, :2] + shift
        area = np.where(depth > 0, np.pi * radius**2, 0.0)
        return ContactResponse(
            wrench_at(force, centre), area, centre, depth, np.zeros(len(depth), dtype=bool), 0.0 * area
        )

    def difference(self, variant):
        raise NotImplementedError


def test_a_flat_punch_pulls_hard_and_where_it_stands(touch, play, moved):
    """A 3 mm punch pulls with newtons, at its own place."""
    path = there_and_back(touch, moved, deepest=1e-4, frames=4000, x=2e-3, indenter=CylinderFlat(0.003))
    wrench = play("adhesion", on=path, base=Punch, work=0.1).wrench
    modulus = touch.material.youngs_modulus / (1 - touch.material.poisson_ratio**2)
    least = int(np.argmin(wrench[:, 2]))
    assert wrench[least, 2] == pytest.approx(-np.sqrt(8 * np.pi * modulus * 0.1 * 0.003**3), rel=0.01)
    assert wrench[least, 4] == pytest.approx(-2e-3 * wrench[least, 2])


def test_tips_know_their_curvature():
    """Balls and domes have theirs, flat ones none; every indenter has one."""
    assert tip_radius(Sphere(0.004), 1e-4) == pytest.approx(0.004, rel=1e-3)
    assert tip_radius(Dome(), 1e-4) == pytest.approx(0.010, rel=1e-3)
    assert tip_radius(CylinderFlat(), 1e-4) == np.inf
    assert all(tip_radius(INDENTERS[name](), 1e-4) > 0 for name in INDENTERS)


def test_free_air_is_left_alone(touch, play, moved):
    """A path that never touches has no pull."""
    path = moved(touch, np.arange(9.0), np.linspace(-3e-4, -1e-6, 9))
    assert (play("adhesion", on=path, work=2.0).wrench == 0).all()


class Tip:
    """An indenter of a given height."""

    def __init__(self, height):
        self.height = height


@pytest.mark.parametrize("turn", [0.0, 0.3, np.pi / 2])
def test_a_tip_that_curves_one_way_only_has_half_the_curvature(turn):
    """The mean of x^2 / 2 R over a circle is that of a ball of 2 R, however the ridge lies; a saddle is flat."""
    ridge = Tip(lambda x, y: (x * np.cos(turn) + y * np.sin(turn)) ** 2 / (2 * 0.004))
    assert tip_radius(ridge, 1e-4) == pytest.approx(0.008)
    assert tip_radius(Tip(lambda x, y: (x**2 - y**2) / (2 * 0.004)), 1e-4) == np.inf


def test_where_a_body_ends_its_tip_is_what_is_left_of_it():
    """Directions without a body do not count; a body narrower than the circle is flat."""
    half = Tip(lambda x, y: np.where(x > -1e-9, (x**2 + y**2) / (2 * 0.004), np.inf))
    assert tip_radius(half, 1e-4) == pytest.approx(0.004)
    assert tip_radius(Tip(lambda x, y: np.full_like(x, np.inf)), 1e-4) == np.inf


@pytest.mark.parametrize("depth", [-1.4e-5, 0.0, 1e-5, 5e-4, 2e-3])
def test_jkr_is_exact(depth):
    """The pull is that of JKR to double precision, with the contact radius that gives the depth, found by bisection."""
    pull = np.sqrt(2 * np.pi * WORK / MODULUS)
    a = brentq(lambda a: a**2 / RADIUS - pull * np.sqrt(a) - depth, (RADIUS * pull / 4) ** (2 / 3), 0.05, xtol=1e-18)
    wanted = 4 * MODULUS * a**3 / (3 * RADIUS) - np.sqrt(8 * np.pi * WORK * MODULUS * a**3)
    assert jkr_force(np.array([depth]), RADIUS, MODULUS, np.array([WORK]))[0] == pytest.approx(wanted, rel=1e-10)


def test_twelve_hundredths_of_the_work_are_left_after_shear():
    """After shear 12 % of the work of adhesion is left, as the reference measured."""
    assert AFTER_SHEAR == 0.12


def on_half_space(touch):
    """E* of the touch's gel, and Hertz's force on it by depth, for its ball of 4 mm."""
    modulus = touch.material.youngs_modulus / (1 - touch.material.poisson_ratio**2)
    return modulus, lambda depth: 4 / 3 * modulus * np.sqrt(0.004) * np.maximum(depth, 0.0) ** 1.5


def test_leaving_begins_on_the_line_of_a_contact_that_keeps_its_area(touch, play, moved):
    """After the deepest frame the force falls by 2 E* sqrt(R d) times the way, until it meets the curve of JKR."""
    depth = np.array([0.0, 5e-4, 4.6e-4, 4e-4, 4.8e-4])
    path = moved(touch, np.arange(5.0), depth)
    pull = (play("adhesion", on=path, work=WORK).wrench - play(on=path).wrench)[:, 2]
    modulus, hertz = on_half_space(touch)
    line = hertz(5e-4) - 2 * modulus * np.sqrt(0.004 * 5e-4) * (5e-4 - depth) - hertz(depth)
    curve = jkr_force(depth, 0.004, modulus, np.full(5, WORK)) - hertz(depth)
    np.testing.assert_allclose(pull[:2], 0.0, atol=1e-12)
    np.testing.assert_allclose(pull[2:], np.maximum(line, curve)[2:], rtol=1e-3)
    assert line[2] > curve[2]
    assert line[3] < curve[3]


def test_a_contact_that_has_parted_pulls_again_only_in_the_next_touch(touch, play, moved):
    """Back within reach of the pull, but not in touch, there is none; in a touch of its own the same press pulls."""
    depth = np.array([0.0, 3e-4, -3e-6, -3e-4, -3e-6, 4e-4, 3.9e-4])
    path = moved(touch, np.arange(7.0), depth)
    pull = (play("adhesion", on=path, work=WORK).wrench - play(on=path).wrench)[:, 2]
    assert pull[2] < -1e-3
    assert (pull[3:] == 0).all()
    again = moved(touch, np.arange(3.0), depth[4:])
    assert (play("adhesion", on=again, work=WORK).wrench - play(on=again).wrench)[2, 2] < -1e-4


def test_a_flat_punch_pulls_in_proportion_to_its_height():
    """2 E* a d above the surface, as far as Kendall's force; a smaller work holds less far."""
    depth = np.array([1e-4, 0.0, -1e-6, -1e-5, -1e-3])
    force = punch_force(depth, 0.003, MODULUS, np.full(5, WORK))
    np.testing.assert_allclose(force, [0.0, 0.0, -2e-6 * MODULUS * 0.003, -2e-5 * MODULUS * 0.003, 0.0])
    assert punch_force(depth, 0.003, MODULUS, np.full(5, 1e-9))[3] == 0.0
