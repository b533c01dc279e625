"""How long springs look for their balance, and when they give up, by a gel whose residuals are prescribed."""

import dataclasses

import numpy as np
import pytest

from tactiledata.effects.closed_form.ball_on_layer import BallOnLayer
from tactiledata.effects.simulate.balance import Balance
from tactiledata.effects.simulate.setting import EffectSetting
from tactiledata.effects.simulate.simulator import Simulator, with_effects
from tactiledata.errors import UsageError

COMPLIANCE, LOAD = 1e-6, 8.0
ARM = EffectSetting("arm_compliance", {"translation": COMPLIANCE})


@pytest.fixture
def press(touch, moved):
    """Four frames, half a millimetre deep."""
    return moved(touch, np.arange(4.0), np.full(4, 5e-4))


def missing(residuals, first=True):
    """A base that misses what bends the arm by given shares of ``LOAD``, round by round, and a list of its answers."""
    left = ([None] if first else []) + list(residuals)
    told = []

    class Prescribed(BallOnLayer):
        def respond(self, offset, shift, friction):
            answer = super().respond(offset, shift, friction)
            wrench = np.zeros_like(answer.wrench)
            share = left.pop(0)
            wrench[:, 2] = LOAD if share is None else -offset / COMPLIANCE + LOAD * share
            told.append(wrench)
            return dataclasses.replace(answer, wrench=wrench)

    return Prescribed, told


@pytest.mark.parametrize(
    ("residuals", "rounds", "best"),
    [
        ([0.0], 1, 0),
        ([1e-2, 9e-6], 2, 1),
        ([1e-2, 2e-5, 9e-6], 3, 2),
        # within half a per cent, after eight rounds without a smaller one
        ([1e-2, 1e-3, *[2e-3] * 20], 10, 1),
        ([4.9e-3, *[-6e-3] * 20], 9, 0),
        ([1e-2, 1e-3, *[2e-3] * 6, 9e-4, *[1e-3] * 20], 17, 8),
        # always a smaller one, or none that is near enough: to the end
        ([4e-3 * 0.99**number for number in range(30)], 30, 29),
        ([*[2e-2] * 20, *[4e-3] * 10], 29, 20),
    ],
)
def test_the_smallest_residual_is_taken(press, residuals, rounds, best):
    """The search ends below 1e-5 of the largest load, else after a while without progress, or after 30 rounds."""
    base, told = missing(residuals)
    state = with_effects(base, [ARM]).contact(press)
    assert len(told) == 1 + rounds
    np.testing.assert_array_equal(state.contact.wrench, told[1 + best])
    # every round tries another estimate, the last one too
    tried = [wrench[0, 2] - LOAD * share for wrench, share in zip(told[1:], residuals, strict=False)]
    assert (np.diff(tried) != 0).all()


@pytest.mark.parametrize("share", [5.1e-3, 0.5])
def test_half_a_per_cent_is_no_balance(press, share):
    """After 30 rounds what is left is told, and what to do."""
    base, told = missing([share] * 40)
    with pytest.raises(UsageError, match=r"no balance: .* N are left after 30 rounds") as found:
        with_effects(base, [ARM]).contact(press)
    assert f"{LOAD * share:.2g} N are left" in str(found.value)
    assert "Lessen the compliances" in str(found.value)
    assert len(told) == 31


def near_one():
    """A balance of a similar touch."""
    load = np.zeros((4, 6))
    load[:, 2] = LOAD
    return Balance(load)


@pytest.mark.parametrize(
    ("residuals", "rounds", "best"),
    [
        ([9e-7], 1, 0),
        ([5e-6, 9e-7], 2, 1),
        # eight rounds, the best of which is good enough
        ([9e-6, 5e-6, *[6e-6] * 6], 8, 1),
    ],
)
def test_a_similar_touch_goes_on_from_the_balance_that_was_found(press, residuals, rounds, best):
    """It must come ten times as close, within eight rounds; what was found is left as it was."""
    base, told = missing(residuals, first=False)
    near = near_one()
    state, balance = Simulator(base, (ARM,)).contact_near(press, near)
    assert len(told) == rounds
    np.testing.assert_array_equal(state.contact.wrench, told[best])
    assert balance is not near
    assert near.missed == 0.0
    # the wrench that bent the arm in the last round is the estimate that is handed on
    np.testing.assert_allclose(balance.felt[:, 2], told[-1][:, 2] - LOAD * residuals[-1])


def test_where_the_old_balance_does_not_help_the_search_starts_anew(press):
    """After eight rounds beyond 1e-5 the search starts anew from the touch itself."""
    base, told = missing([*[2e-5] * 8, None, 1e-6], first=False)
    state, balance = Simulator(base, (ARM,)).contact_near(press, near_one())
    assert len(told) == 10
    np.testing.assert_array_equal(state.contact.wrench, told[9])
    assert balance.missed == pytest.approx(1e-6 * LOAD)


def test_a_balance_of_other_frames_is_not_gone_on_from(press):
    """Where the gel answered in other frames than now, the search starts anew, however close it came."""
    load = np.zeros((4, 6))
    load[:, 2] = LOAD
    load[1] = np.nan
    base, told = missing([0.0, None, 0.0], first=False)
    Simulator(base, (ARM,)).contact_near(press, Balance(load))
    assert len(told) == 3


def test_without_springs_nothing_is_searched(press):
    """One answer, and the balance that was handed in."""
    base, told = missing([])
    near = near_one()
    warm = EffectSetting("heating", {"change": 0.1})
    state, balance = Simulator(base, (warm,)).contact_near(press, near)
    np.testing.assert_allclose(state.contact.wrench[:, 2], LOAD * (1.0 - 0.1 * np.expm1(-press.powered / 900.0)))
    assert balance is near
    assert len(told) == 1
