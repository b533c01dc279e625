"""The secant iteration for springs, where the answer of the gel is a straight line."""

import numpy as np
import pytest

from tactiledata.effects.simulate.balance import Balance, bridged

FIRST = np.arange(1.0, 13.0).reshape(2, 6)


def iterated(slope, first=FIRST, rounds=2):
    """A balance after some moves, for a gel that answers ``first`` - slope * felt; solved by first / (1 + slope)."""
    balance = Balance(first)
    for _ in range(rounds):
        balance.measure(first - slope * balance.felt)
        balance.move()
    return balance


def test_it_starts_from_the_answer_while_nothing_bends():
    """The first estimate is the answer while nothing bends; its largest component is the scale."""
    balance = Balance(-FIRST)
    np.testing.assert_array_equal(balance.felt, -FIRST)
    assert balance.largest == 12.0
    assert balance.missed == 0.0


@pytest.mark.parametrize("slope", [-0.4, 0.5, 3.0, 40.0])
def test_a_straight_line_is_solved_in_two_moves(slope):
    """A straight line is solved by one step of the residual and then the secant, each component on its own."""
    slopes = slope * np.linspace(0.8, 1.2, 12).reshape(2, 6)
    balance = iterated(slopes)
    np.testing.assert_allclose(balance.felt, FIRST / (1 + slopes), rtol=1e-12)
    balance.measure(FIRST - slopes * balance.felt)
    assert balance.missed == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(("slope", "step"), [(99.0, 0.02), (-0.75, 2.0)])
def test_a_step_is_a_fiftieth_to_twice_the_residual(slope, step):
    """A step is 0.02 to 2 times the residual, also where the secant's step would be 0.01 or 4."""
    np.testing.assert_allclose(iterated(slope).felt, (1 - slope + step * slope**2) * FIRST, rtol=1e-12)


@pytest.mark.parametrize(("fell", "step"), [(0.0, 1.0), (0.5e-3, 1.0), (2e-3, 2.0), (-2e-3, 0.02)])
def test_a_residual_that_hardly_falls_gives_no_secant(fell, step):
    """Below a thousandth of itself the step is the whole residual; above, the secant's within its limits."""
    balance = Balance(np.ones((1, 6)))
    balance.measure(balance.felt + 1.0 + fell)
    balance.move()
    before = balance.felt
    balance.measure(balance.felt + 1.0)
    balance.move()
    np.testing.assert_allclose(balance.felt - before, step, rtol=1e-9)


def test_what_is_missed_is_the_largest_component_that_is_known():
    """The largest known component of either sign is what is missed; one without an answer misses nothing."""
    balance = Balance(np.zeros((2, 6)))
    answer = np.zeros((2, 6))
    answer[0, 1], answer[1, 4], answer[1, 5] = 0.5, -2.0, np.nan
    balance.measure(answer)
    assert balance.missed == 2.0


def test_it_goes_on_for_a_changed_touch_with_the_step_that_it_learnt():
    """One move solves a touch with another first answer and the same slope; the old iteration stays as it was."""
    old = iterated(3.0)
    felt = old.felt.copy()
    old.measure(FIRST - 3.0 * old.felt + 1e-3)
    missed = old.missed
    new = old.resumed()
    assert new.missed == 0.0
    new.measure(2.0 * FIRST - 3.0 * new.felt)
    new.move()
    np.testing.assert_allclose(new.felt, 2.0 * FIRST / 4.0, rtol=1e-12)
    np.testing.assert_array_equal(old.felt, felt)
    assert old.missed == missed > 0


def test_unknown_frames_are_bridged_in_time_and_known_again_by_their_pattern():
    """Unknown entries lie on a line between known ones, are the nearest beyond them, and 0 without any."""
    wrench = np.tile(np.array([[np.nan], [1.0], [np.nan], [3.0], [np.nan]]), (1, 6))
    wrench[:, 5] = np.nan
    wrench[:, 0] = [5.0, 6.0, 7.0, 8.0, 9.0]
    found = bridged(wrench, np.isfinite(wrench))
    assert found[:, 1].tolist() == [1.0, 1.0, 2.0, 3.0, 3.0]
    assert found[:, 5].tolist() == [0.0] * 5
    assert found[:, 0].tolist() == [5.0, 6.0, 7.0, 8.0, 9.0]
    balance = Balance(wrench)
    np.testing.assert_array_equal(balance.felt, found)
    assert balance.knows(np.where(np.isfinite(wrench), 0.0, np.nan))
    assert not balance.knows(np.zeros((5, 6)))
    balance.measure(wrench + 4.0)
    balance.move()
    np.testing.assert_allclose(balance.felt[:, 1], [5.0, 5.0, 6.0, 7.0, 7.0])
