"""Powers of a covariance of noise and a few unknowns of each trajectory."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tactiledata.nuisance.low_rank import low_rank_power
from tactiledata.nuisance.tare import without_tare

STARTS, COUNTS = np.array([0, 5, 6]), np.array([5, 1, 7])
ROWS, COMPONENTS = int(COUNTS.sum()), 6


def drawn(seed, unknowns=4, size=0.3, columns=2):
    """Rows (13, 6, c) and fields (13, 6, r) of three trajectories, of 5, 1 and 7 frames."""
    chance = np.random.default_rng(seed)
    return (
        chance.normal(size=(ROWS, COMPONENTS, columns)),
        size * chance.normal(size=(ROWS, COMPONENTS, unknowns)),
    )


def dense_power(rows, fields, power):
    """The power by the whole matrix of each trajectory."""
    found = np.empty_like(rows)
    for start, count in zip(STARTS, COUNTS, strict=True):
        part = slice(start, start + count)
        tall = fields[part].reshape(count * COMPONENTS, -1)
        values, axes = np.linalg.eigh(np.eye(len(tall)) + tall @ tall.T)
        flat = axes * values**power @ axes.T @ rows[part].reshape(count * COMPONENTS, -1)
        found[part] = flat.reshape(count, COMPONENTS, -1)
    return found


@given(
    seed=st.integers(0, 2**32 - 1),
    unknowns=st.integers(1, 9),
    size=st.sampled_from([1e-3, 0.3, 10.0]),
    power=st.sampled_from([-1.0, -0.5, 0.5, 1.0]),
)
def test_it_is_the_power_of_the_whole_matrix(seed, unknowns, size, power):
    """The power is that of the whole matrix, also if unknowns outnumber rows or are far larger than the noise."""
    rows, fields = drawn(seed, unknowns, size)
    expected = dense_power(rows, fields, power)
    np.testing.assert_allclose(
        low_rank_power(rows, fields, STARTS, power), expected, atol=1e-9 * np.abs(expected).max()
    )


@given(seed=st.integers(0, 2**32 - 1), size=st.sampled_from([1e-3, 0.3, 10.0]))
def test_half_a_power_undoes_minus_half(seed, size):
    """The powers 1/2 and -1/2 undo each other in either order."""
    rows, fields = drawn(seed, size=size)
    for power in (0.5, -0.5):
        there = low_rank_power(rows, fields, STARTS, power)
        np.testing.assert_allclose(low_rank_power(there, fields, STARTS, -power), rows, atol=1e-8)


@given(seed=st.integers(0, 2**32 - 1))
def test_squares_sum_to_the_deviance(seed):
    """The squares of rows at power -1/2 are those that the inverse covariance weighs."""
    rows, fields = drawn(seed)
    white, weighed = (low_rank_power(rows, fields, STARTS, power) for power in (-0.5, -1.0))
    for start, count in zip(STARTS, COUNTS, strict=True):
        part = slice(start, start + count)
        assert (white[part] ** 2).sum(axis=(0, 1)) == pytest.approx((rows[part] * weighed[part]).sum(axis=(0, 1)))


@pytest.mark.parametrize("power", [-0.5, 0.5])
def test_trajectories_do_not_mix(power):
    """What another trajectory measured changes nothing in this one, bit for bit."""
    rows, fields = drawn(1)
    other_rows, other_fields = rows.copy(), fields.copy()
    other_rows[:5], other_fields[:5] = 7.0, 3.0
    before, after = (low_rank_power(*one, STARTS, power) for one in ((rows, fields), (other_rows, other_fields)))
    assert np.array_equal(before[5:], after[5:])
    assert not np.allclose(before[:5], after[:5])


def test_an_unknown_takes_off_what_it_can_imitate():
    """Of rows along a field much larger than the noise next to nothing is left; of rows at right angles, all."""
    _, fields = drawn(2, unknowns=1, size=1e4)
    along = fields / np.sqrt(np.repeat(np.add.reduceat((fields**2).sum(axis=(1, 2)), STARTS), COUNTS))[:, None, None]
    rows, _ = drawn(3, columns=1)
    inside = np.repeat(np.add.reduceat((rows * along).sum(axis=(1, 2)), STARTS), COUNTS)[:, None, None]
    across = rows - along * inside
    assert np.abs(low_rank_power(along, fields, STARTS, -0.5)).max() < 1e-3
    np.testing.assert_allclose(low_rank_power(across, fields, STARTS, -0.5), across, atol=1e-9)


def test_a_zero_alone_is_as_without_tare():
    """Six unknowns, one for each component and of the same size in every frame, are the zero of the force sensor."""
    chance = np.random.default_rng(4)
    weights, rows, variance = chance.uniform(0.2, 1.0, ROWS), chance.normal(size=(ROWS, 6)), np.array([0.2, 0.1, 0.05])
    fields = (weights * np.sqrt(np.repeat(variance, COUNTS)))[:, None, None] * np.eye(6)
    found = low_rank_power(rows[:, :, None], fields, STARTS, -0.5)[:, :, 0]
    np.testing.assert_allclose(found, without_tare(rows, STARTS, variance, weights), atol=1e-12)


@pytest.mark.parametrize("power", [-0.5, 0.5])
def test_a_trajectory_of_which_nothing_is_known_stays_as_it_is(power):
    """Fields of 0 change nothing and divide nothing by 0."""
    rows, fields = drawn(5)
    fields[:5] = 0.0
    found = low_rank_power(rows, fields, STARTS, power)
    assert np.array_equal(found[:5], rows[:5])
    assert np.isfinite(found).all()
