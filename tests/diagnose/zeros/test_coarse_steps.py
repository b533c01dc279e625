"""Coarse steps of a force sensor are read from its readings; fine ones, and loads of any kind, are not."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from test_dead_band import ARM, SCALE, presses, read_through

from tactiledata.diagnose.zeros.coarse_steps import find_coarse_steps
from tactiledata.diagnose.zeros.dead_band import find_dead_band

FAR = np.array([300.0, 120.0, 300.0, 0.0, 0.0, 0.0])
"""Offset of a sensor that was not tared, N and N m."""


@pytest.mark.parametrize("kind", [np.float64, np.float32])
@pytest.mark.parametrize(("step", "noise"), [(0.05, 0.04), (0.12, 0.1), (0.5, 0.1)])
def test_a_planted_step_is_found_with_its_size(step, noise, kind):
    """Steps of 0.05 to 0.5 N, also in numbers of single precision; the rounding's size follows from the step."""
    found = find_coarse_steps([read_through(presses(seed, noise), step=step).astype(kind) for seed in range(3)])
    assert found.step == pytest.approx(step, rel=1e-4)
    assert list(found.steps) == ["fx", "fy", "fz"]
    assert found.error == pytest.approx(step / 12**0.5, rel=1e-4)


def test_words_and_document_have_the_numbers():
    """A user reads step and rounding; the document names the effect of the catalogue."""
    found = find_coarse_steps([read_through(presses(), step=0.12)])
    assert "fx, fy and fz in steps of 0.12 N" in found.words
    assert "0.035 N in the root mean square" in found.words
    assert found.document["effect"] == "quantisation"
    assert found.document["values"] == {"step": found.step}


@pytest.mark.parametrize("held", [1, 2, 10])
@pytest.mark.parametrize(("step", "noise"), [(0.01, 0.1), (0.03, 0.0), (0.05, 0.1), (0.05, 1.0)])
def test_steps_that_do_not_matter_are_no_finding(step, noise, held):
    """Below 0.035 N, or with less than a twentieth of the variance, however often a log repeats each reading."""
    assert find_coarse_steps([np.repeat(read_through(presses(noise=noise), step=step), held, axis=0)]) is None


@pytest.mark.parametrize("held", [2, 10])
def test_a_step_is_found_however_often_a_log_repeats_readings(held):
    """Its size does not change (the positive control of the repeated readings)."""
    found = find_coarse_steps([np.repeat(read_through(presses(), step=0.12), held, axis=0)])
    assert found.step == pytest.approx(0.12, rel=1e-4)


@pytest.mark.parametrize(
    ("logged", "tolerance"),
    [
        (lambda rows: np.round(rows, 3), 1e-3),
        (lambda rows: np.round(rows, 2), 2e-2),
        (lambda rows: (rows + FAR).astype(np.float32), 1e-3),
    ],
    ids=["three digits", "two digits", "single precision far from zero"],
)
def test_a_step_is_found_in_numbers_that_a_log_has_rounded(logged, tolerance):
    """No distance of two numbers is the step then; it shows over many of them."""
    for step in (0.12, 0.1221) if tolerance < 0.01 else (0.5,):
        found = find_coarse_steps([logged(read_through(presses(), step=step))])
        assert found.step == pytest.approx(step, rel=tolerance)


def test_components_with_steps_of_their_own_are_told_apart():
    """The largest step decides how far readings are off."""
    readings = presses()
    readings[:, :2] = 0.2 * np.round(readings[:, :2] / 0.2)
    readings[:, 2] = 0.5 * np.round(readings[:, 2] / 0.5)
    found = find_coarse_steps([readings])
    assert found.step == pytest.approx(0.5)
    assert found.error == pytest.approx(0.5 / 12**0.5)
    assert "fz in steps of 0.50 N" in found.words
    assert "0.14 N in the root mean square" in found.words


@given(st.integers(0, 1000), st.sampled_from([0.0, 0.02, 0.1]), st.sampled_from([1, 3]))
def test_readings_without_steps_have_none(seed, noise, held):
    """Whatever the noise, and where each reading is logged three times."""
    readings = np.repeat(presses(seed, noise, 3), held, axis=0)
    assert find_coarse_steps([readings]) is None


def test_strays_between_the_steps_are_allowed_and_other_lattices_are_not():
    """Half a per cent of other numbers changes nothing; with a twentieth the readings are not those of a step."""
    readings = read_through(presses(), step=0.12)
    rng = np.random.default_rng(0)
    for share, is_found in ((0.005, True), (0.05, False)):
        stray = rng.random(readings.shape) < share
        mixed = np.where(stray, readings + SCALE * rng.uniform(0.02, 0.1, readings.shape), readings)
        assert (find_coarse_steps([mixed]) is not None) == is_found


def test_one_component_alone_may_be_broken():
    """Two of three forces have to show a step; torques are not asked."""
    readings = presses()
    for columns, is_found in ((1, False), (2, True)):
        mixed = readings.copy()
        mixed[:, :columns] = 0.12 * np.round(mixed[:, :columns] / 0.12)
        assert (find_coarse_steps([mixed]) is not None) == is_found
    torques = np.hstack([readings[:, :3], 0.12 * ARM * np.round(readings[:, 3:] / (0.12 * ARM))])
    assert find_coarse_steps([torques]) is None


def test_few_or_no_readings_show_nothing():
    """99 readings are too few, none are none, and what is not finite is left out."""
    readings = read_through(presses(), step=0.12)
    assert find_coarse_steps([]) is None
    assert find_coarse_steps([readings[:99]]) is None
    assert find_coarse_steps([row[None] for row in readings]) is None
    broken = readings.copy()
    broken[::7] = np.nan
    assert find_coarse_steps([broken]).step == pytest.approx(0.12)


def test_a_band_within_half_a_step_shows_as_a_step_only():
    """Rounding hides it: no numbers beside 0 are missing."""
    readings = read_through(presses(), 0.05, 0.12)
    assert find_dead_band([readings]) is None
    assert find_coarse_steps([readings]).step == pytest.approx(0.12)
