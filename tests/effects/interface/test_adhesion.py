"""Adhesion against Johnson, Kendall and Roberts, and Kendall."""

import numpy as np
import pytest

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
