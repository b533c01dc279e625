"""Creep after each step of a held covariate: found, sized, told from drifts and relaxations, and never made up."""

import re

import numpy as np
import pytest
from held_loads import LAWS, held_loads
from tables import presses

from tactiledata.diagnose.formula.explain import explain
from tactiledata.diagnose.formula.open_form import open_form
from tactiledata.diagnose.formula.terms import atoms
from tactiledata.diagnose.locate.locate import LocateOptions
from tactiledata.diagnose.residuals.residuals import Covariate
from tactiledata.diagnose.table_input.held_steps import times_since_steps
from tactiledata.diagnose.table_input.residuals_of import residuals_of

SINCE = "time since the last step of load"


def terms(**planted):
    read = residuals_of(held_loads(**planted))
    return list(open_form(read.residuals, time=read.columns.time).terms)


@pytest.mark.slow
@pytest.mark.parametrize("law", LAWS)
def test_a_creep_after_each_step_is_named_with_its_rate(law):
    """A creep of 0.1 N/min in 11 groups gives one term, in plain words, off by at most two half widths."""
    for seed in range(5):
        (term,) = terms(seed=seed, law=law, creep=0.1)
        assert re.match(r"fz creeps by \(0\.\d+ ± 0\.0\d+ N/min\) after each step of load, chosen", term.words)
        assert abs(term.coefficient - 0.1) <= 2.0 * term.half_width


@pytest.mark.slow
def test_intervals_hold_the_rate_of_creep():
    """36 of 40 or more, where 38 are meant."""
    found = [terms(seed=seed, law=law, creep=0.1)[0] for law in LAWS for seed in range(10)]
    assert sum(abs(one.coefficient - 0.1) <= one.half_width for one in found) >= 36


def test_a_creep_downwards_has_its_sign():
    """A creep of -0.1 N/min has its sign."""
    (term,) = terms(creep=-0.1)
    assert term.words.startswith("fz creeps by -(0.1")
    assert term.coefficient == pytest.approx(-0.1, abs=0.015)


@pytest.mark.slow
@pytest.mark.parametrize("law", LAWS)
def test_no_creep_is_made_of_noise(law):
    """No formula is found in 12 tables of held steps and noise under each law, though no locator is asked before."""
    for seed in range(12):
        read = residuals_of(held_loads(100 + seed, law=law))
        assert SINCE in read.residuals.covariates
        form = open_form(read.residuals, time=read.columns.time)
        assert not [term for term in form.terms if SINCE in term.term]


@pytest.mark.parametrize("law", LAWS)
def test_a_drift_of_the_whole_recording_is_no_creep(law):
    """0.1 N/min from a group's first row on goes with the time."""
    (term,) = terms(seed=1, law=law, drift=0.1)
    assert term.term.startswith("time/(")


@pytest.mark.parametrize("law", LAWS)
def test_what_relaxes_to_an_end_is_no_creep(law):
    """An exponential of 0.3 N with 20 s, or of a tenth of the load with 10 s, is no creep."""
    (end, *_) = terms(seed=2, law=law, relaxes=0.3)
    assert end.term == f"exp(-{SINCE}/(30 s))"
    (memory, *_) = terms(seed=2, law=law, remembers=0.1)
    assert memory.term == "load remembered for 10 s/(10 N)"


def test_a_slow_relaxation_is_told_from_a_creep():
    """A relaxation by 0.4 N with 100 s, in holds of up to 180 s, is written as an exponential of that time."""
    table = held_loads(1)
    minutes = residuals_of(table).residuals.covariates[SINCE].values
    table["fz_observed_N"] -= 0.4 * (1 - np.exp(-minutes * 0.6))
    (term,) = open_form(residuals_of(table).residuals, time="time").terms
    assert term.term == f"exp(-{SINCE}/(100 s))"
    assert abs(term.coefficient - 0.4) <= 1.5 * term.half_width


def test_a_load_that_is_taken_off_need_not_creep_back():
    """The words restrict the creep to loads that are not 0 if nothing creeps in the holds at 0."""
    table = held_loads(3, creep=0.1)
    is_off = (table.load_N > 1.0) & (table.load_N < 6.5)
    table.loc[is_off, "fz_observed_N"] = table.fz_predicted_N + np.random.default_rng(0).normal(0, 0.05, len(table))
    table.loc[is_off, "load_N"] -= table.fz_predicted_N
    read = residuals_of(table)
    (term,) = open_form(read.residuals, time="time").terms
    assert term.words.startswith("fz creeps by (0.1")
    assert " N/min) after each step of load while it is not 0, chosen" in term.words


def test_the_time_since_a_step_can_be_computed_from_its_definition():
    """Row by row, with the size that is printed; a group's first row counts as a step."""
    table = held_loads(0)
    read = residuals_of(table)
    (atom,) = (one for one in atoms(read.residuals, time="time") if one.name == f"{SINCE}/(1 min)")
    size = float(re.search(r"load lies more than ([\d.]+) N from its mean", atom.definition).group(1))
    assert "the first row of a group counts as a step" in atom.definition
    assert 4 * 0.02 < size < 3.0
    since, steps = [], 0
    for _, rows in table.groupby("group"):
        load, minutes = rows.load_N.to_numpy(), rows.time_s.to_numpy() / 60
        last = 0
        for row in range(len(rows)):
            if row > last and abs(load[row] - load[last:row].mean()) > size:
                last, steps = row, steps + 1
            since.append(minutes[row] - minutes[last])
    np.testing.assert_allclose(atom.values, since, atol=1e-9)
    assert steps == 3 * 11


@pytest.mark.slow
def test_a_diagnosis_says_creep_and_what_it_is_counted_from():
    """The first sentence has the rate, the next two the formula and its definition; nothing else is left."""
    read = residuals_of(held_loads(creep=0.1))
    told = explain(read.residuals, LocateOptions(draws=199), read.columns.time)
    assert told.answer == "explained"
    first, formula, meant = told.sentences()[:3]
    assert "a formula explains it: fz creeps by (0.1" in first or "a formula explains it: fz creeps by (0.09" in first
    assert f" N × {SINCE}/(1 min)" in formula
    (atom,) = (one for one in atoms(read.residuals, time="time") if one.name == f"{SINCE}/(1 min)")
    assert meant == f"Here {atom.definition}."


def offered(values, unit="s", time="time", groups=11):
    rows = len(values)
    covariates = {
        "load": Covariate(np.tile(values, groups), "N"),
        "time": Covariate(np.tile(np.arange(float(rows)), groups), unit),
    }
    return times_since_steps(covariates, np.arange(groups) * rows, time)


HELD = np.repeat([2.0, 5.0, 3.0], 30)


@pytest.mark.parametrize(
    ("values", "unit", "time"),
    [
        (HELD, "s", None),
        (HELD, "?", "time"),
        (HELD, "mm", "time"),
        (np.sin(np.linspace(0, np.pi, 90)), "s", "time"),
        (np.linspace(0, 1, 2000), "s", "time"),
        (np.random.default_rng(0).normal(size=90), "s", "time"),
        (np.ones(90), "s", "time"),
    ],
)
def test_what_is_not_held_or_not_timed_has_no_time_since_a_step(values, unit, time):
    """Loads that are not held, and times that are missing, without unit or lengths, give no time since a step."""
    assert offered(values, unit, time) == {}


@pytest.mark.parametrize(("unit", "longest"), [("s", 29.0), ("ms", 0.029), ("min", 29.0)])
def test_times_are_in_seconds_or_minutes(unit, longest):
    """Holds of 30 rows: 29 s, 29 ms, and 29 min; a ramp of four rows ends in one step."""
    (held,) = offered(HELD, unit).values()
    assert held.values.max() == pytest.approx(longest)
    assert held.unit == ("min" if unit == "min" else "s")
    ramp = np.concatenate([np.full(30, 2.0), [3.0, 4.0, 5.0, 6.0], np.full(30, 6.0)])
    (ramped,) = offered(ramp).values()
    np.testing.assert_array_equal(ramped.values[:65], [*range(30), 0, 0, 0, *range(31), 0])


def test_presses_have_no_holds():
    """A half sine in depth: a table of them is diagnosed as before."""
    assert set(residuals_of(presses()).residuals.covariates) == {"time", "depth", "speed", "index"}
