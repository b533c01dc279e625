"""Shear that sticks remembers the pull at which it slid: against Mindlin's contact, and how it forgets."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import PchipInterpolator

from tactiledata.diagnose.touches.friction_history import CubicsOverFriction, remembered_shear

NODES = np.array([0.4, 0.6, 0.85])
STIFFNESS = 4e3
NORMAL = 3.0
OUT, BACK = 10, 12
PATH = np.concatenate([np.linspace(0, 12e-4, OUT), np.linspace(12e-4, 9e-4, 9)[1:], np.linspace(9e-4, 1e-4, 5)[1:]])


def mindlin(way, friction):
    """Shear of two balls, Mindlin 1949: k x at first, the limit from x = 3 mu N / (2 k) on."""
    return friction * NORMAL * (1 - np.maximum(1 - STIFFNESS * way / (1.5 * friction * NORMAL), 0.0) ** 1.5)


def there_and_back(friction):
    """Out until all slides, then back: Masing's rule, twice as wide and twice as high."""
    return np.concatenate(
        [mindlin(PATH[:OUT], friction), friction * NORMAL - 2 * mindlin((PATH[OUT - 1] - PATH[OUT:]) / 2, friction)]
    )


@pytest.fixture(scope="module")
def columns():
    """Along x, with nothing along y."""
    shear = np.array([there_and_back(friction) for friction in NODES])
    values = np.stack([shear, np.zeros_like(shear), np.full_like(shear, NORMAL)], axis=2)
    return CubicsOverFriction(NODES, PchipInterpolator(NODES, values).c)


def remembered(frictions, columns, touching, reach):
    return remembered_shear(frictions, columns, columns.at(frictions), touching, reach)


TOUCHING = np.ones(OUT + BACK, dtype=bool)
REACH = STIFFNESS * np.abs(np.diff(PATH, prepend=0.0))


def test_columns_are_given_back(columns):
    """At a played friction the columns are those of the play, and below the lowest friction those of the lowest."""
    for friction in NODES:
        assert np.allclose(columns.at(np.full(OUT + BACK, friction))[:, 0], there_and_back(friction))
    assert np.array_equal(columns.at(np.full(OUT + BACK, 0.1)), columns.at(np.full(OUT + BACK, NODES[0])))


def test_one_friction_leaves_nothing_to_remember(columns):
    """With one friction in all frames, shear does not depend on earlier frames."""
    assert not remembered(np.full(OUT + BACK, 0.6), columns, TOUCHING, REACH).any()


@pytest.mark.parametrize(("rest", "back"), [(a, b) for a in NODES for b in NODES if a <= b])
def test_on_the_way_back_shear_begins_where_it_rested(columns, rest, back):
    """Slides at one friction, rests at a second, is drawn back at a third: T = T_rest - 2 T(x / 2) of the third."""
    frictions = np.full(OUT + BACK, 0.6)
    frictions[OUT - 2 : OUT], frictions[OUT:] = rest, back
    shear = (columns.at(frictions)[:, :2] + remembered(frictions, columns, TOUCHING, REACH))[:, 0]
    assert shear[OUT - 1] == pytest.approx(rest * NORMAL)
    expected = rest * NORMAL - 2 * mindlin((PATH[OUT - 1] - PATH[OUT:]) / 2, back)
    within = (np.abs(expected) < back * NORMAL) & (there_and_back(back)[OUT:] > -0.8 * back * NORMAL)
    assert within.sum() >= 3
    assert np.allclose(shear[OUT:][within], expected[within])


def test_what_slides_again_forgets(columns):
    """At the end of a way back that is long enough the limit of the time counts, whatever was before."""
    frictions = np.full(OUT + BACK, 0.4)
    frictions[OUT - 2 : OUT] = 0.6
    more = remembered(frictions, columns, TOUCHING, REACH)
    assert more[OUT, 0] > 0.1
    assert abs(there_and_back(0.4)[-1]) > 0.95 * 0.4 * NORMAL
    assert not more[-1].any()


def test_a_limit_that_grows_at_rest_pulls_nothing(columns):
    """What stands keeps its pull, however strong its hold grows; a way on lets it grow as far as a spring would."""
    last = CubicsOverFriction(NODES, columns.coefficients[:, :, OUT - 2 : OUT])
    frictions = np.array([0.4, 0.85])
    for way, gain in ((0.0, 0.0), (2e-5, STIFFNESS * 2e-5), (1.0, (0.85 - 0.4) * NORMAL)):
        more = remembered(frictions, last, TOUCHING[:2], np.array([0.0, STIFFNESS * way]))
        standing = there_and_back(0.85)[OUT - 1] - there_and_back(0.85)[OUT - 2]
        shear = last.at(frictions)[:, 0] + more[:, 0]
        assert shear[0] == pytest.approx(0.4 * NORMAL)
        assert shear[1] == pytest.approx(min(0.4 * NORMAL + standing + gain, 0.85 * NORMAL))


def test_air_forgets(columns):
    """A frame without contact ends the dependence of shear on earlier frames."""
    frictions = np.full(OUT + BACK, 0.6)
    frictions[OUT - 2 : OUT] = 0.4
    touching = TOUCHING.copy()
    touching[OUT + 2] = False
    more = remembered(frictions, columns, touching, REACH)
    assert (more[OUT : OUT + 2, 0] < 0).all()
    assert not more[OUT + 2 :].any()


@given(st.lists(st.floats(0.35, 0.9), min_size=OUT + BACK, max_size=OUT + BACK), st.integers(0, OUT + BACK - 1))
def test_it_stays_within_the_limit_and_depends_smoothly_on_friction(columns, frictions, row):
    """Shear stays within the larger of friction limit and played shear, and varies smoothly with friction."""
    frictions = np.array(frictions)
    own = columns.at(frictions)[:, :2]
    shear = own + remembered(frictions, columns, TOUCHING, REACH)
    limits = np.maximum(frictions * NORMAL, np.abs(own[:, 0]))
    assert (np.hypot(*shear.T) <= limits * (1 + 1e-12)).all()
    nudged = frictions.copy()
    nudged[row] += 1e-7
    there = columns.at(nudged)[:, :2] + remembered(nudged, columns, TOUCHING, REACH)
    assert np.abs(there - shear).max() < 1e-4
