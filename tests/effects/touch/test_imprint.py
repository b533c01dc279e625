"""Imprints: closed forms, what is as deep as what, and how places fade."""

import numpy as np
import pytest

from tactiledata.effects.touch.imprint import DEEPEST, SPREAD, ImprintTable, nearness, strongest_imprint
from tactiledata.indenters import INDENTERS, make_indenter
from tactiledata.indenters.cylinder_flat import CylinderFlat
from tactiledata.indenters.sphere import Sphere


@pytest.mark.parametrize("depth", [3e-4, 1e-3, 1.8e-3])
def test_imprint_of_a_ball_and_of_a_punch(depth):
    """A ball's is pi R d^3 2/3 (1 - d / 4 R), from its circle; a punch's its area times the depth's square."""
    ball, punch = ImprintTable.of(Sphere(4e-3)), ImprintTable.of(CylinderFlat(3e-3))
    height = np.linspace(0.0, depth, 20001)
    ring = 2 * np.pi * (4e-3 - height)  # r dr = (R - z) dz on the ball
    assert ball.imprint(depth) == pytest.approx(np.trapezoid(ring * (depth - height) ** 2, height), rel=0.02)
    assert punch.imprint(depth) == pytest.approx(np.pi * 3e-3**2 * depth**2, rel=0.02)


@pytest.mark.parametrize("name", INDENTERS)
def test_depth_is_the_inverse_of_imprint(name):
    """For every indenter, imprint grows with depth, and the table gives back the depth of an imprint."""
    table = ImprintTable.of(make_indenter({"shape": name}, None, name))
    assert (np.diff(table.imprints) >= 0).all()
    for depth in (2e-4, 7e-4, 1.5e-3):
        assert table.depth(table.imprint(depth)) == pytest.approx(depth, abs=1e-6)
    assert table.depth(0.0) == 0.0
    assert table.depth(1.0) == DEEPEST


def test_a_punch_does_more_than_a_ball():
    """To do what a punch has done half a millimetre deep, a ball has to go deeper."""
    ball, punch = ImprintTable.of(Sphere(4e-3)), ImprintTable.of(CylinderFlat(3e-3))
    assert ball.depth(punch.imprint(5e-4)) > 8e-4


def test_places_fade():
    """The weight of an earlier press falls with distance as a Gaussian."""
    assert nearness(np.array(0.0)) == 1.0
    assert nearness(np.array(SPREAD)) == pytest.approx(np.exp(-0.5))
    assert nearness(np.array(5 * SPREAD)) < 1e-5


@pytest.mark.parametrize("half", [(2e-3, 3e-3), (6e-3, 6e-3)])
@pytest.mark.parametrize("depth", [2e-4, 1e-3, 2e-3])
def test_the_grid_integrates_a_brick_to_rounding(depth, half):
    """A flat body has its area times the depth's square, up to one that fills the whole grid of 12 by 12 mm."""

    class Brick:
        def height(self, x, y):
            return np.where((np.abs(x) < half[0]) & (np.abs(y) < half[1]), 0.0, 1.0)

    table = ImprintTable.of(Brick())
    area = 4 * half[0] * half[1]
    assert table.imprint(depth) == pytest.approx(area * depth**2, rel=1e-9)
    assert table.depths[[0, -1]].tolist() == [0.0, DEEPEST]
    assert table.depth(area * depth**2) == pytest.approx(depth, rel=1e-9)
    # straight between 81 depths: half-way between the first two, half of what is at the second
    assert table.imprint(1.25e-5) == pytest.approx(area * 2.5e-5**2 / 2, rel=1e-9)


def test_the_strongest_of_earlier_presses_counts_by_its_distance():
    """At one spread a press counts exp(-1/2); beside a weaker one at the place itself the stronger weight wins."""
    places = np.array([[0.0, 0.0], [SPREAD, 0.0], [0.0, 2 * SPREAD]])
    pressed, imprints = np.array([[0.0, 0.0], [SPREAD, 0.0]]), np.array([1.0, 0.8])
    found = strongest_imprint(places, pressed, imprints)
    np.testing.assert_allclose(found, [1.0, 0.8, np.exp(-2.0)])
    assert strongest_imprint(places, np.zeros((0, 2)), np.zeros(0)).tolist() == [0.0, 0.0, 0.0]
    assert SPREAD == 1.5e-3


def test_a_body_and_its_mirror_image_have_one_imprint():
    """The grid has as many middles on either side of the tip: an edge just beside it counts alike, in x and in y."""

    class Half:
        def __init__(self, low, high, is_along_x):
            self.low, self.high, self.is_along_x = low, high, is_along_x

        def height(self, x, y):
            along = x if self.is_along_x else y
            return np.where((along > self.low) & (along < self.high), 0.0, 1.0)

    for is_along_x in (True, False):
        for edge in (1e-5, 4e-5):
            one, other = Half(-edge, 3e-3, is_along_x), Half(-3e-3, edge, is_along_x)
            found = [ImprintTable.of(body).imprint(1e-3) for body in (one, other)]
            assert found[0] == pytest.approx(found[1], rel=1e-12)
            assert found[0] == pytest.approx(3e-3 * 12e-3 * 1e-6, rel=1e-9)
