"""Less noise at a frame counts as more information about it, in every sum that is made over frames."""

from dataclasses import replace

import numpy as np
import pytest
from touch_worlds import START, World, world_cases

from tactiledata.diagnose.touches.own_errors import OwnErrors
from tactiledata.diagnose.touches.whitened import WhitenedTouches
from tactiledata.diagnose.unseen.errors import zero_shares
from tactiledata.errors import UsageError

EXACT = OwnErrors(0.0, 0.02, 0.0, 0.0, 0.0, 0.0)


@pytest.fixture(scope="module")
def touches():
    return world_cases(World(), trajectories=8)


def with_factor(touches, factor):
    """Return the trajectories with this factor on the deviation of the noise in every second frame."""
    cases = []
    for case in touches.touches:
        factors = np.ones(len(case.touch))
        factors[::2] = factor
        cases.append(replace(case, factors=factors, free_samples=1e12))
    return replace(touches, touches=cases)


def squares(touches):
    """Whitened squares (N,) of the residual of the plain simulation in frames of free air, where nothing scatters."""
    white = WhitenedTouches.of(touches, own=EXACT)
    residual = white.residual(touches.play(START, []))
    return (residual**2).sum(axis=1)[white.free_air]


def test_half_the_deviation_is_four_times_the_square(touches):
    """A frame in free air with half the noise has four times the squared residual; other frames keep theirs."""
    plain, halved = squares(with_factor(touches, 1.0)), squares(with_factor(touches, 0.5))
    ratios = halved / plain
    is_halved = np.isclose(ratios, 4.0, rtol=1e-6)
    assert is_halved.any()
    assert np.allclose(ratios[~is_halved], 1.0, rtol=1e-6)


def test_frames_with_less_noise_say_more_of_the_zero(touches):
    """Two frames of half the deviation say as much of a zero as eight frames of the whole one."""
    few, many = (
        WhitenedTouches.of(replace(touches, touches=[replace(case, factors=np.full(len(case.touch), factor))
                                                     for case in touches.touches]))
        for factor in (1.0, 0.5)
    )  # fmt: skip
    odds_few, odds_many = (zero_shares(white) / (1 - zero_shares(white)) for white in (few, many))
    # frames in contact scatter by the simulation, too: there the noise is not all
    assert (odds_many > 1.5 * odds_few).all()
    assert (odds_many <= 4.0 * odds_few + 1e-9).all()


def test_another_number_of_factors_is_refused(touches):
    """A factor belongs to a frame."""
    with pytest.raises(UsageError, match="factors on the noise"):
        replace(touches.touches[0], factors=np.ones(3))


def test_precision_is_that_of_the_frames_in_contact(touches):
    """Half of the deviation everywhere is four times the precision, once it is above the usual one."""

    def precision(deviation):
        cases = [replace(case, factors=np.full(len(case.touch), deviation)) for case in touches.touches]
        return WhitenedTouches.of(replace(touches, touches=cases)).precision

    assert precision(0.05) == pytest.approx(4.0 * precision(0.1))
    assert precision(100.0) == 1.0
