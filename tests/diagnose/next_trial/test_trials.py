"""Trials keep to the limits, and what is planned here is what the rig plays."""

import dataclasses

import numpy as np
import pytest
from tied_worlds import START, recorded

from tactiledata.diagnose.next_trial.bench import TrialBench, closed_form
from tactiledata.diagnose.next_trial.cases import duration, trial_cases
from tactiledata.diagnose.next_trial.kinds import TRIALS
from tactiledata.diagnose.next_trial.path import trial_path
from tactiledata.diagnose.next_trial.scenario import trial_scenario
from tactiledata.effects.touch.touch import Touch
from tactiledata.errors import SchemaError, UsageError
from tactiledata.indenters.ring import Ring
from tactiledata.rig.motion import motion
from tactiledata.rig.record import log_groups
from tactiledata.rig.scenario.scenario import load_scenario

BENCH = TrialBench.of(recorded(), START)
STIFF = dataclasses.replace(START, youngs_modulus=3e6)
EACH = pytest.mark.parametrize("make", TRIALS, ids=lambda make: make.__name__)


@EACH
def test_the_rig_moves_as_planned(make):
    """Positions, orientations and frames of every touch are those of the rig, which shares no line with the plan."""
    trial = make(BENCH)
    scenario = load_scenario(trial_scenario(trial, BENCH))
    assert len(scenario.trajectories) == len(trial.touches)
    images = scenario.images
    for one, touch in zip(trial.touches, scenario.trajectories, strict=True):
        ours = trial_path(one, trial.burst)
        theirs = motion.plan(touch, lambda force: 1.0, images.frames_per_step, images.free_air_frames)
        assert ours.duration == pytest.approx(theirs.duration, abs=1e-6)
        assert ours.captures == pytest.approx(theirs.captures, abs=1e-6)
        seconds = np.linspace(0.0, ours.duration, 500)
        places, turned = ours.at(seconds)
        assert places == pytest.approx(theirs.at(seconds), abs=1e-8)
        assert turned == pytest.approx(theirs.turned(seconds), abs=1e-6)


@EACH
@pytest.mark.parametrize("material", [START, STIFF], ids=["soft", "stiff"])
def test_forces_and_places_stay_within_the_limits(make, material):
    """No trial presses harder than the protocol allows or leaves the pad, whatever gel there is."""
    bench = dataclasses.replace(BENCH, material=material)
    trial = make(bench)
    half = np.array(bench.touch.geometry.outline) / 2.0
    cases = trial_cases(trial, bench)
    assert 80 <= cases.counts.sum() <= 400
    for case in cases.touches:
        assert np.linalg.norm(case.measured[:, :3], axis=1).max(initial=0.0) <= 13.0
        pressed = case.touch.tips[:, 2] < 0
        assert (np.abs(case.touch.tips[pressed, :2]) <= half).all()


@EACH
def test_a_trial_has_the_name_of_what_makes_it(make):
    """Names of files are known before any trial is made."""
    assert make(BENCH).name == make.__name__


def test_the_same_bench_gives_the_same_trials():
    """The trials of a bench are the same every time, as nothing is drawn."""
    again = TrialBench.of(recorded(), START)
    assert [make(BENCH) for make in TRIALS] == [make(again) for make in TRIALS]


def test_whatever_a_recorded_touch_tells_the_depth_is_found():
    """Covariates of its frames belong to it alone."""
    n = len(BENCH.touch)
    told = {
        field.name: np.ones((n, *{"gravity": (3,), "joints": (6,), "gel_from_sensor": (4, 4)}.get(field.name, ())))
        for field in dataclasses.fields(Touch)
        if field.name in ("gravity", "joints", "powered", "earlier_depth", "pace", "rest", "gel_from_sensor")
    }
    bench = dataclasses.replace(BENCH, touch=dataclasses.replace(BENCH.touch, **told))
    assert bench.depth(bench.ball) == BENCH.depth(BENCH.ball)


def test_fresh_places_are_away_from_what_was_touched():
    """Farther than any other place, and from one another; a bare gel has room everywhere."""
    spots = np.array(BENCH.fresh(BENCH.ball, 2))
    assert np.linalg.norm(spots[:, None] - BENCH.visited[None], axis=2).min() > 5e-3
    assert np.linalg.norm(spots[0] - spots[1]) > 5e-3
    bare = dataclasses.replace(BENCH, visited=np.zeros((0, 2)))
    assert len(set(bare.fresh(bare.ball, 3))) == 3


def test_what_a_touch_tells_of_the_past_is_counted():
    """First touches find fresh places, then used ones; a pause starts the sensor's clock anew."""
    trials = {make.__name__: make(BENCH) for make in TRIALS}
    before = [case.touch.earlier_contacts[0] for case in trial_cases(trials["first_touches"], BENCH).touches]
    assert before == [0, 1, 2, 0, 1, 2]
    powered = [case.touch.powered[0] for case in trial_cases(trials["from_power_on"], BENCH).touches]
    assert powered[0] == powered[7] < 60.0
    assert np.diff(powered[:7]).min() > 240.0
    assert duration(trials["from_power_on"]) > 1800.0


def test_balls_and_punches_that_are_missing_are_named_as_to_be_made():
    """Radii at hand serve where they are near; a bench without a ball gets one."""
    assert BENCH.ball in BENCH.indenters
    assert len(BENCH.balls) == 3
    bare = dataclasses.replace(BENCH, indenters={"ring": Ring()})
    assert bare.ball not in bare.indenters
    assert bare.indenter(bare.ball).sizes["radius"] == pytest.approx(0.004)
    document = trial_scenario(TRIALS[0](bare), bare)
    assert document["indenters"][bare.ball]["shape"] == "sphere"


def test_entries_of_the_user_are_taken_over():
    """A sensor's own background and an indenter's own entry; a wrong one is refused by its place."""
    trial = TRIALS[0](BENCH)
    mine = trial_scenario(trial, BENCH, {"D7": {"background": "mine.png", "shore_00": 30}})
    assert mine["sensors"]["D7"]["background"] == "mine.png"
    assert mine["sensors"]["D7"]["gel"]["thickness"] == BENCH.touch.geometry.thickness
    assert {touch["sensor"] for touch in mine["trajectories"]} == {"D7"}
    other = trial_scenario(trial, BENCH, indenters={BENCH.ball: {"mesh": "ball.stl", "unit": "mm"}})
    assert other["indenters"][BENCH.ball] == {"mesh": "ball.stl", "unit": "mm"}
    with pytest.raises(SchemaError):
        trial_scenario(trial, BENCH, {"D7": {"colour": "red"}})


def test_a_pause_becomes_a_new_recording():
    """A trial during which the sensor is switched off and on again is written as two logs."""
    trial = next(make for make in TRIALS if make.__name__ == "from_power_on")(BENCH)
    groups = log_groups(load_scenario(trial_scenario(trial, BENCH)))
    assert [len(touches) for _, touches in groups] == [7, 2]


def test_another_shape_has_no_closed_form():
    """It says which have."""
    touch = BENCH.touch
    assert isinstance(touch, Touch)
    with pytest.raises(UsageError, match="sphere"):
        closed_form(START)(dataclasses.replace(touch, indenter=Ring()))
