"""The whole diagnosis on arrays: one error rate over all locators, and answers in words."""

from dataclasses import replace

import numpy as np
import pytest
from planted import MODULUS, modulus_over, planted

from tactiledata.diagnose.answer.locator_rows import dependence
from tactiledata.diagnose.formula.explain import explain
from tactiledata.diagnose.locate.drifts import parameter_drifts
from tactiledata.diagnose.locate.gate import NoiseModel
from tactiledata.diagnose.locate.leading_drifts import leading_drifts
from tactiledata.diagnose.locate.locate import LocateOptions, locate
from tactiledata.diagnose.residuals.gap import Gap
from tactiledata.diagnose.residuals.projection import project
from tactiledata.diagnose.residuals.wording import quantity, rounded, signed_change, with_interval


@pytest.mark.slow
def test_all_locators_together_keep_the_level():
    """The locators together call at most 5 % and three standard errors of 40 nulls structured."""
    alarms = [
        locate(planted(seed + 500, 24, 10), LocateOptions(seed=seed, draws=299)).is_structured for seed in range(40)
    ]
    assert np.mean(alarms) <= 0.05 + 3 * np.sqrt(0.05 * 0.95 / 40)


def test_echoes_are_not_said():
    """E drifts with speed; once it may, nothing else drifts, and speed is said first."""
    projection = project(planted(1, 60, plant=modulus_over("speed", 0.5, 0.1, 10.0, True)))
    drifts = parameter_drifts(projection, draws=499)
    leading = leading_drifts(projection, drifts, draws=499)
    assert [(one.parameter, one.covariate) for one in leading] == [("E", "speed")]


def test_two_drifts_are_both_said():
    """Both drifts are said if E follows speed and mu follows the clock."""

    def plant(world):
        minutes = world.covariates["minutes"].values / 90
        return modulus_over("speed", 0.5, 0.1, 10.0, True)(world) + world.slopes[:, :, 1] * (0.3 * minutes)[:, None]

    projection = project(planted(4, 80, plant=plant))
    leading = leading_drifts(projection, parameter_drifts(projection, draws=499), draws=499)
    said = {(one.parameter, one.covariate) for one in leading}
    assert ("E", "speed") in said
    assert said & {("mu", "minutes"), ("mu", "index")}


@pytest.mark.slow
def test_what_is_planted_is_explained_and_what_is_left_is_quiet():
    """The sentences name the planted formula, the share of the gap that it closes, and the ceiling."""
    world = planted(5, 60, plant=modulus_over("speed", 0.6, 0.1, 10.0, True))
    found = explain(world, LocateOptions(), signatures={"rate": modulus_over("speed", 1, 0.1, 10.0, True)(world)})
    assert found.answer == "explained"
    sentences = found.sentences()
    assert sentences[0].startswith("Something is missing, and a formula explains it: E (1 + (0.3")
    assert "behaves like rate" in sentences[0]
    assert sentences[-1] == "After the formula no structure is left."
    grown = replace(found, gap=Gap(0.12, 0.2, 0.1, -1.5, (-2.5, -0.5))).sentences()
    assert (
        "On groups that had no part in it the formula does not hold: the gap between the error and the scatter from row"
        " to row grows by 150 % (50 % to 250 %)."
    ) in grown


@pytest.mark.slow
def test_a_shape_without_a_formula_is_not_explained_away():
    """A bump in two covariates: a short formula takes a part of it at most, and that is said."""

    def bump(world):
        depth, speed = world.covariates["depth"].values, np.log10(world.covariates["speed"].values)
        values = np.zeros_like(world.values)
        values[:, 0] = 8.0 * np.exp(-0.5 * (((depth - 0.6) / 0.15) ** 2 + (speed / 0.3) ** 2))
        return values

    found = explain(planted(6, 80, plant=bump), LocateOptions())
    assert found.answer in ("partly explained", "not explained")
    assert any("do not extrapolate" in sentence for sentence in found.sentences())


def test_the_dependence_is_sloped_before_and_flat_after():
    """Bins of the speed: E rises with it; with the field that was planted it does not."""
    world = planted(7, 80, plant=modulus_over("speed", 0.5, 0.1, 10.0, True))
    before = dependence(project(world), "E", "speed")
    field = modulus_over("speed", 1.0, 0.1, 10.0, True)(world)
    after = dependence(project(world.with_fields({"rate": field})), "E", "speed")
    assert np.corrcoef(np.log(before.places), before.departures)[0, 1] > 0.9
    assert np.ptp(after.departures) < 0.3 * np.ptp(before.departures)
    assert (np.abs(after.departures) < 4 * after.errors).all()


@pytest.mark.slow
def test_days_are_exchanged_where_they_are_given():
    """A modulus of each recording day's own is found as steps between trajectories, and is chance between days."""
    from dataclasses import replace

    world = planted(8, 96, 8, random_effects=False)
    day = world.trajectory // 8
    moduli = np.random.default_rng(0).normal(0, 0.3 * MODULUS, 12)[day]
    moved = world.with_values(world.values + world.slopes[:, :, 0] * moduli[:, None])
    assert locate(moved, LocateOptions(draws=299)).is_structured
    by_day = locate(replace(moved, blocks=day), LocateOptions(draws=299))
    assert "steps" not in by_day.p
    assert not by_day.is_structured


@pytest.mark.slow
def test_the_gate_is_one_of_the_locators():
    """It takes part where the noise is known, and only there."""
    world = planted(8, 20, 10, heavy=False, random_effects=False)
    assert "size of the residual" in locate(world, LocateOptions(noise=NoiseModel(0.5))).p
    assert "size of the residual" not in locate(world, LocateOptions()).p


@pytest.mark.slow
def test_progress_is_told():
    """Every step is told, in order, up to the last."""
    told = []
    explain(planted(9, 16, 8), LocateOptions(), progress=lambda done, total, what="": told.append((done, total)))
    assert told[-1] == (5, 5)
    assert told == sorted(told)


@pytest.mark.parametrize(
    ("value", "text"), [(0.0, "0"), (0.0123, "0.012"), (123.4, "123"), (0.00001, "1.0e-05"), (5.0, "5.0")]
)
def test_numbers_are_said_shortly(value, text):
    """Two digits that count, whole numbers whole."""
    assert rounded(value) == text


def test_changes_are_said_as_people_do():
    """Both numbers to the digits that the interval leaves."""
    assert signed_change("E", -11.234, 2.1, "%") == "E falls by 11 ± 2 %"
    assert with_interval(0.0812, 0.0102, "1") == "0.081 ± 0.010"
    assert with_interval(2.0, float("inf"), "N") == "2.0 N"
    assert quantity(0.3, "mm") == "0.30 mm"
    assert quantity(0.3, "?") == "0.30"


def test_what_is_said_to_drift_has_a_slope_that_is_told():
    """An offset that goes with speed: nothing is said to change by less than its interval, echoes included."""
    residuals = planted(2, 60, plant=lambda world: 0.4 * world.covariates["speed"].values[:, None] * np.ones(3))
    located = locate(residuals, LocateOptions(draws=499))
    assert located.is_structured
    assert all(one.change.sharpness > 1.0 for one in located.leading[1:])
    assert not [one for one in located.drifts if " by 0 ± " in one.words and one.p <= 0.05]


def test_a_bump_without_a_trend_is_said_without_a_slope():
    """E a third higher in the middle of the speeds: it is not the same below and above, and no slope is made up."""

    def plant(world):
        speed = world.covariates["speed"].values
        low, high = np.quantile(speed, [0.4, 0.6])
        inside = (speed > low) & (speed < high)
        return world.slopes[:, :, 0] * (0.6 * MODULUS * (inside - inside.mean()))[:, None]

    drifts = [
        one for one in parameter_drifts(project(planted(3, 80, plant=plant)), draws=499) if one.covariate == "speed"
    ]
    bent = [one for one in drifts if one.at != "all along" and one.change.sharpness <= 1.0]
    assert bent
    for one in bent:
        assert "without a steady trend" in one.words
        assert "±" not in one.words
