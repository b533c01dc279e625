"""Springs with sliders: the closed form of their knee, Masing's rule, and planted ones found again."""

import numpy as np
import pytest
from few_examples import few
from hypothesis import given
from hypothesis import strategies as st

from tactiledata.diagnose.touches.sliders import PARTS, Sliders, own_sliders

FRAMES = 201
SPRING, LIMIT = np.full(FRAMES, 4e3), np.full(FRAMES, 2.0)
"""N/m, N: the spring alone would slide after half a millimetre."""


def pulled(sliders, way, limit=LIMIT):
    """Pull along x over a way."""
    path = np.column_stack([way, np.zeros_like(way)])
    return sliders.pull(path, SPRING[: len(way)], limit[: len(way)])[:, 0]


@pytest.mark.parametrize("spread", [0.0, 0.3, 1.0])
def test_the_knee_is_a_parabola(spread):
    """Limits spread evenly over u (1 - s) to u (1 + s) give P = k (u - (u (1 + s) - x)^2 / (4 s u)), and k u beyond."""
    way = np.linspace(0.0, 1.2e-3, FRAMES)
    slides = LIMIT[0] / SPRING[0]
    wanted = np.minimum(way, slides)
    if spread:
        low, high = slides * (1 - spread), slides * (1 + spread)
        knee = slides - (high - way) ** 2 / (4 * spread * slides)
        wanted = np.where(way < low, way, np.where(way < high, knee, slides))
    found = pulled(Sliders(1.0, spread), way)
    np.testing.assert_allclose(found, SPRING[0] * wanted, atol=LIMIT[0] * (1e-9 if not spread else 1 / PARTS**2))


@few(30)
@given(st.floats(0.0, 1.0), st.floats(0.5, 2.0), st.floats(1e-4, 1e-3))
def test_the_way_back_is_twice_the_way_there(spread, factor, turn):
    """Masing's rule P(turn) - P(x) = 2 P0((turn - x) / 2) holds."""
    there = np.linspace(0.0, turn, 101)
    back = np.linspace(turn, -turn, 101)[1:]
    sliders = Sliders(factor, spread)
    found = pulled(sliders, np.concatenate([there, back]))
    first = pulled(sliders, there)
    np.testing.assert_allclose(found[100] - found[101:], 2 * np.interp((turn - back) / 2, there, first), atol=2e-3)


@few(30)
@given(st.floats(0.0, 1.0), st.floats(0, 2 * np.pi), st.integers(0, 10_000))
def test_pull_is_within_the_limit_and_turns_with_the_path(spread, angle, seed):
    """The pull never exceeds the friction limit, and a turned path turns it by the same angle."""
    rng = np.random.default_rng(seed)
    path, limit = np.cumsum(rng.normal(0, 2e-4, (FRAMES, 2)), axis=0), rng.uniform(0.0, 2.0, FRAMES)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    sliders = Sliders(1.1, spread)
    found = sliders.pull(path, SPRING, limit)
    assert (np.hypot(*found.T) <= limit * (1 + 1e-9)).all()
    np.testing.assert_allclose(sliders.pull(path @ turn.T, SPRING, limit), found @ turn.T, atol=1e-9)


@pytest.mark.parametrize(("factor", "spread"), [(0.9, 0.35), (1.1, 0.6), (1.0, 0.0)])
def test_planted_ones_are_found(factor, spread):
    """Stiffness and spread of planted sliders are found within 0.03; without shear, the usual sliders are returned."""
    way = np.interp(np.arange(FRAMES), [0, 100, 200], [0.0, 1e-3, 2e-4])
    path = np.column_stack([0.6 * way, 0.8 * way])
    limit = np.interp(np.arange(FRAMES), [0, 200], [1.5, 2.5])
    pull = Sliders(factor, spread).pull(path, SPRING, limit)
    found = own_sliders(path, pull[None], SPRING, limit[None])
    assert found == pytest.approx((factor, spread), abs=0.03)
    assert own_sliders(path, 0.01 * pull[None], SPRING, limit[None]) == Sliders()
    assert own_sliders(path, np.zeros_like(path)[None], np.zeros(FRAMES), np.zeros((1, FRAMES))) == Sliders()


def test_all_frictions_count():
    """Pulls at a friction at which nothing slides tell the stiffness, those at a low one the spread."""
    way = np.linspace(0.0, 4e-4, FRAMES)
    path = np.column_stack([way, np.zeros_like(way)])
    planted = Sliders(1.2, 0.5)
    limits = np.array([0.5 * LIMIT, 4.0 * LIMIT])
    pulls = np.array([planted.pull(path, SPRING, limit) for limit in limits])
    # the second one alone leaves the spread open, and the first one tells both
    assert own_sliders(path, pulls, SPRING, limits) == pytest.approx(planted, abs=0.03)
    stuck = own_sliders(path, pulls[1:], SPRING, limits[1:])
    assert stuck.factor == pytest.approx(planted.factor, abs=0.01)
    assert abs(stuck.spread - planted.spread) > 0.1
