"""A matrix scaled by its diagonal: the usual numbers to the bit, and zeros where there is no information."""

import warnings

import numpy as np
import pytest

from tactiledata.diagnose.naming.metric import RandomEffects, best_imitation
from tactiledata.diagnose.residuals.scaled_matrix import scaled_matrix


@pytest.fixture(autouse=True)
def _no_warning():
    """Every warning of NumPy is a failure."""
    with warnings.catch_warnings(), np.errstate(over="raise", invalid="raise", divide="raise"):
        warnings.simplefilter("error")
        yield


def some_matrix(seed, size=6, zeros=()):
    """A positive matrix of parameters whose units differ by 1e12, with rows of zeros."""
    rng = np.random.default_rng(seed)
    rows = rng.normal(size=(size + 2, size)) * 10.0 ** rng.uniform(-6, 6, size)
    rows[:, list(zeros)] = 0.0
    return rows.T @ rows


@pytest.mark.parametrize("zeros", [(), (2,), (0, 5)])
@pytest.mark.parametrize("seed", range(5))
def test_ordinary_matrices_give_the_same_bits(seed, zeros):
    """A matrix with information everywhere is scaled as division by its diagonal does it; rows of zeros stay zeros."""
    matrix = some_matrix(seed, zeros=zeros)
    scale = np.sqrt(np.maximum(np.diag(matrix), 1e-300))
    divided = matrix / np.outer(scale, scale)
    inverse = np.linalg.pinv(divided, rcond=1e-10, hermitian=True) / np.outer(scale, scale)
    found = scaled_matrix(matrix)
    np.testing.assert_array_equal(found.values, divided)
    known = np.ix_(found.has_information, found.has_information)
    assert np.flatnonzero(~found.has_information).tolist() == list(zeros)
    np.testing.assert_array_equal(found.pseudo_inverse(1e-10)[known], inverse[known])
    assert not found.pseudo_inverse(1e-10)[~found.has_information].any()
    if not zeros:
        assert found.log_determinant == float(np.linalg.slogdet(divided)[1] + 2.0 * np.log(scale).sum())


@pytest.mark.parametrize("left", [5e-324, 1e-310, 1e-300, 0.0, -1e-300, -1e-12])
def test_a_direction_without_information_is_zero(left):
    """A diagonal that is denormal, 0 or negative by rounding, beside large entries in its row, leaves the others."""
    matrix = some_matrix(0)
    matrix[3, :] = matrix[:, 3] = 1e15
    matrix[3, 3] = left
    found = scaled_matrix(matrix)
    others = [0, 1, 2, 4, 5]
    assert found.has_information.tolist() == [True, True, True, False, True, True]
    inverse = found.pseudo_inverse(1e-12)
    assert (inverse[3] == 0).all()
    alone = scaled_matrix(matrix[np.ix_(others, others)])
    np.testing.assert_allclose(inverse[np.ix_(others, others)], alone.pseudo_inverse(1e-12), rtol=1e-9)
    assert found.log_determinant == pytest.approx(alone.log_determinant)


def test_denormal_matrices_have_no_information():
    """A matrix of denormal numbers has an inverse of zeros."""
    found = scaled_matrix(np.full((2, 2), 1e-312))
    assert (found.pseudo_inverse(1e-10) == 0).all()
    assert found.log_determinant == 0.0


@pytest.mark.parametrize("size", [1e-155, 1e-160, 1e-170, 0.0])
def test_a_metric_with_a_field_next_to_nothing_weighs_as_without_it(size):
    """A shared parameter whose fields have denormal squares is as one that changes nothing."""
    rng = np.random.default_rng(1)
    shared = rng.normal(size=(4, 6, 2))
    shared[:, :, 1] *= size
    field, starts = rng.normal(size=(4, 6, 1)), np.array([0, 2])
    metric = RandomEffects(np.zeros((4, 6)), shared, np.zeros(2), starts)
    plain = RandomEffects(np.zeros((4, 6)), shared[:, :, :1], np.zeros(1), starts)
    np.testing.assert_allclose(metric.weigh(field), plain.weigh(field), rtol=1e-12)
    imitated = best_imitation(plain, field[:, :, 0], np.concatenate([field * 2, shared[:, :, 1:]], axis=2))
    assert imitated == pytest.approx(1.0)
