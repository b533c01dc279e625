"""Variances of scores after a refit to flipped signs, against the units' scores written out one by one."""

import numpy as np
import pytest

from tactiledata.diagnose.residuals.scores import Refit


def written_out(refit, signs, size, by_unit, information):
    """Change of the sums of squares: every unit's score less what the refit moves, squared and summed."""
    change = np.zeros((len(signs), by_unit.shape[1]))
    for draw, flips in enumerate(signs):
        moved = refit.inverse @ (refit.scores.T @ flips)
        for alternative in range(by_unit.shape[1]):
            before = flips * by_unit[:, alternative] - size[draw, alternative] * information[:, alternative]
            after = before - refit.together[:, :, alternative] @ moved
            change[draw, alternative] = (after**2).sum() - (before**2).sum()
    return change


@pytest.mark.parametrize("shared", [3, 12, 40])
def test_it_is_the_sum_of_squares_of_the_units_scores(shared):
    """The change is the written-out sum, with fewer, as many and more shared parameters than the twelve units."""
    rng = np.random.default_rng(shared)
    units, alternatives, draws = 12, 5, 7
    root = rng.normal(size=(shared, shared))
    together = rng.normal(size=(units, shared, alternatives))
    refit = Refit(rng.normal(size=(units, shared)), root @ root.T / shared, together - together.mean(axis=0))
    signs = rng.choice([-1.0, 1.0], size=(draws, units))
    size, by_unit = rng.normal(size=(draws, alternatives)), rng.normal(size=(units, alternatives))
    information = rng.uniform(size=(units, alternatives))
    found = refit.change_of_variance(signs, size, by_unit, information)
    expected = written_out(refit, signs, size, by_unit, information)
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())
