"""A shift of a length: found and named where it was planted, and nowhere else."""

import numpy as np
import pytest
from tables import presses

from tactiledata.diagnose.formula.explain import explain
from tactiledata.diagnose.formula.shifted import shift_carriers, slope_inside
from tactiledata.diagnose.locate.locate import LocateOptions
from tactiledata.diagnose.residuals.residuals import Residuals
from tactiledata.diagnose.table_input.residuals_of import residuals_of


def pressed(seed, observe):
    """Presses whose observation is a function of depth and speed, with white noise of 0.1 N."""
    table = presses(seed, 40, 20, noise=False)
    noise = 0.1 * np.random.default_rng(seed).normal(size=len(table))
    return residuals_of(table.assign(fz_observed_N=observe(table.depth_mm, table.speed_mm_per_s) + noise)).residuals


def terms(residuals):
    form = explain(residuals, LocateOptions(draws=299), "time").form
    return [] if form is None else list(form.terms)


@pytest.mark.slow
@pytest.mark.parametrize("late", [0.05, 0.1])
def test_a_contact_that_is_found_late_is_named_with_its_size(late):
    """Beside k d^n predicted, an observed k (d + d0)^n is named as the depth's shift, with d0 in its interval."""
    (term,) = terms(pressed(1, lambda depth, speed: 8.0 * np.maximum(depth + late, 0) ** 1.5))
    assert (term.carrier, term.term) == ("fz over depth", "1")
    assert abs(term.coefficient - late) < max(term.half_width, 0.2 * abs(late))
    assert term.words.startswith("fz as predicted where depth is (0.")
    assert " mm) larger, chosen" in term.words


@pytest.mark.slow
def test_a_contact_that_is_found_early_is_named_without_an_interval():
    """The slope from a depth on is no measure of what lies below the contact: 0.03 is said as about 0.04."""
    (term,) = terms(pressed(1, lambda depth, speed: 8.0 * np.maximum(depth - 0.03, 0) ** 1.5))
    assert (term.carrier, term.term) == ("fz over depth", "1")
    assert term.words.startswith("fz as predicted where depth is (about 0.04")
    assert " mm) smaller, chosen" in term.words


@pytest.mark.slow
@pytest.mark.parametrize(
    "observe",
    [
        lambda depth, speed: 8.0 * depth**1.5,
        lambda depth, speed: 8.8 * depth**1.5 + 0.3,
        lambda depth, speed: 8.0 * depth**1.5 * (1 + 0.15 * np.log10(speed)),
        lambda depth, speed: 8.0 * depth**1.5 + 3.0 * depth**4,
    ],
)
def test_other_differences_are_no_shift(observe):
    """Noise, a calibration, a rate and a spring that stiffens are no shift of the depth."""
    assert not [term for term in terms(pressed(2, observe)) if term.carrier == "fz over depth"]


def test_the_slope_is_that_of_the_prediction():
    """The slope of a straight line is found exactly; there is none where the prediction goes with something else."""
    depth = np.tile(np.sin(np.linspace(0, np.pi, 15)), 8)
    world = Residuals(np.zeros((120, 1)), ("fz",), np.repeat(np.arange(8), 15))
    np.testing.assert_allclose(slope_inside(3.0 * depth + 1.0, depth, world), 3.0, rtol=1e-6)
    assert slope_inside(np.tile(np.linspace(0, 1, 15), 8), depth, world) is None


def test_only_lengths_that_the_prediction_follows_can_be_shifted():
    """Depth, but neither time, nor speed, nor a width that each group has for itself."""
    table = presses().assign(width_mm=lambda t: 1 + t.trial / 10)
    assert [one.name for one in shift_carriers(residuals_of(table).residuals)] == ["fz over depth"]
