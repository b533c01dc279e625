"""The trial that is proposed: the right one for planted ties, none for two names of one thing, one that plays."""

import dataclasses
import json

import jsonschema
import numpy as np
import pytest
from tied_worlds import START, effect, fitted, recorded

from tactiledata.contract.schema import load_schema
from tactiledata.diagnose.answer.next_trial_words import next_trial_sentences, next_trials_document
from tactiledata.diagnose.naming.name_effects import name_effects
from tactiledata.diagnose.naming.options import NamingOptions
from tactiledata.diagnose.next_trial.bench import TrialBench
from tactiledata.diagnose.next_trial.cases import trial_cases
from tactiledata.diagnose.next_trial.distance import Recorded, TrialRows, error_probability, square_with
from tactiledata.diagnose.next_trial.kinds import TRIALS, hold, slides
from tactiledata.diagnose.next_trial.propose import SEPARATED, propose_trials, ranked_trials
from tactiledata.diagnose.next_trial.rivals import NO_CLAIM, NOTHING, Pair, Rival, Rivals, rivals_of
from tactiledata.diagnose.next_trial.scenario import trial_scenario
from tactiledata.diagnose.touches.touch_case import TouchSet
from tactiledata.diagnose.touches.whitened import WhitenedTouches
from tactiledata.diagnose.verdict import Verdict
from tactiledata.rig.record import record
from tactiledata.rig.scenario.scenario import load_scenario

pytestmark = pytest.mark.slow


def proposals(cases, starts, both_ways=True, trials=TRIALS):
    """Proposals for explanations fitted from starts, the first of them true."""
    members = tuple(
        Rival(start[0] if start else NOTHING, fit) for start, fit in zip(starts, fitted(cases, starts), strict=True)
    )
    bench = TrialBench.of(cases, START)
    return ranked_trials(Rivals(members, (Pair(0, 1, both_ways),)), WhitenedTouches.of(cases), bench, trials=trials)


@pytest.fixture(scope="module")
def sluggish():
    """Relaxation in touches without a dwell, and a lag that would do nearly as well."""
    cases = recorded(effect("relaxation", share=0.12, time=8.0), touches=6, pace=3.0)
    return proposals(cases, [("relaxation", {"share": 0.06, "time": 5.0}), ("lag", {"delay": 0.01})], both_ways=False)


def test_a_dwell_tells_relaxation_from_lag(sluggish):
    """A change at zero motion is no lag: the long dwell is the first proposal, and it settles the question."""
    best = sluggish[0]
    assert best.trial.name == "hold"
    (apart,) = best.separations
    assert apart.error_before > 0.1
    assert apart.error_after < 1e-3
    assert best.separates == best.separations
    assert best.gain == max(one.gain for one in sluggish)


def test_slides_tell_rates_from_rest():
    """Friction that follows speed and friction that follows rest: slides at three speeds, then holds before slides."""
    cases = recorded(effect("rate_friction", beta=0.2), touches=6, slide=3e-3)
    found = proposals(cases, [("rate_friction", {"beta": 0.1}), ("static_friction", {"excess": 0.1})], both_ways=False)
    assert [one.trial.name for one in found[:2]] == ["slides", "hold_then_slide"]
    assert found[0].separations[0].error_after < 1e-3
    others = [one.separations[0] for one in found[2:]]
    assert all(one.after < one.before + 0.5 for one in others)


def test_turns_in_free_air_tell_weight_from_drift():
    """Only where gravity goes around the two differ; no press tells them apart."""
    cases = recorded(effect("tool_weight", mass=0.03), touches=6, turned=True)
    found = proposals(cases, [("tool_weight", {"mass": 0.02}), ("sensor_drift", {"fx": 0.1})], both_ways=False)
    assert found[0].trial.name == "turns"
    assert found[0].separations[0].error_after < 1e-3
    assert all(one.gain < 0.01 for one in found[1:])


def test_two_names_of_one_thing_are_told_apart_by_no_trial():
    """The same effect, fitted from two starts: the chance to confuse them stays, and is said to."""
    cases = recorded(effect("relaxation", share=0.1, time=1.0), touches=8)
    starts = [("relaxation", {"share": 0.05, "time": 3.0}), ("relaxation", {"share": 0.02, "time": 0.3})]
    found = proposals(cases, starts)
    assert all(one.separations[0].error_after > 0.25 for one in found)
    assert not any(one.separates for one in found)
    said = next_trial_sentences(found)
    assert said[0].startswith("None of the trials tells viscoelastic relaxation from viscoelastic relaxation")


def test_thickness_beside_poissons_ratio_stays_open():
    """E and nu imitate another thickness: no trial claims to settle it, and E that never slid is no news of it."""
    cases = recorded(effect("thickness", error=-0.1), touches=8)
    found = proposals(cases, [("thickness", {"error": -0.05}), None])
    assert all(one.separations[0].error_after > SEPARATED for one in found)
    assert next_trial_sentences(found)[0].startswith("None of the trials would show")


def test_distances_are_those_of_a_joint_fit_of_all_data():
    """A refit to recorded and new data at once, to the truth without noise, leaves what was reckoned beforehand."""
    cases = recorded(effect("rate_friction", beta=0.15), touches=6, slide=3e-3)
    truth, other = fitted(cases, [("rate_friction", {"beta": 0.1}), None])
    bench = TrialBench.of(cases, START)
    trial = trial_cases(slides(bench), bench)
    rows = TrialRows.of(trial, WhitenedTouches.of(cases))
    left = rows.residual(rows.model(truth, rows.vector(truth)))
    reckoned = square_with(rows, Recorded(truth, other), left)

    settings = truth.model.settings
    told = cases.play(truth.model.material, settings, truth.model.offsets)
    new = trial.play(truth.model.material, settings)
    both = [*cases.touches, *trial.touches]
    wrench = np.split(np.concatenate([told, new]), np.cumsum([len(case.touch) for case in both])[:-1])
    played = [dataclasses.replace(case, measured=rows) for case, rows in zip(both, wrench, strict=True)]
    (plain,) = fitted(TouchSet(played, cases.base), [None])
    assert reckoned == pytest.approx(plain.cost, rel=0.2)


def test_more_data_never_bring_two_nearer(sluggish):
    """Whatever the trial, distances grow and chances fall."""
    for one in sluggish:
        assert all(each.after >= each.before for each in one.separations)
        assert one.gain >= 0.0
    assert error_probability(0.0) == 0.5
    assert error_probability(4.0) == pytest.approx(0.1587, abs=1e-4)


def test_the_best_proposal_is_recorded_by_the_rig(sluggish, tmp_path):
    """Its scenario is valid, plays, and the log holds the dwell; two runs of the planner give the same document."""
    best = sluggish[0]
    document = trial_scenario(best.trial, best.bench)
    assert document == trial_scenario(hold(best.bench), best.bench)
    document["images"] = {"capture": "video", "rate": 0.1}
    path = tmp_path / "next.json"
    path.write_text(json.dumps(document))
    (log,) = record(load_scenario(path), tmp_path / "out", "folder")
    truth = json.loads((tmp_path / "out" / "truth" / f"{log.name}.json").read_text())
    phases = truth["trajectories"]["hold-1"]["phases"]
    held = [(start, end) for start, end, name in phases if name == "dwell"]
    assert (held[-1][1] - held[0][0]) * 1e-9 == pytest.approx(60.0, abs=1e-3)


@pytest.fixture(scope="module")
def named():
    cases = recorded(effect("relaxation", share=0.12, time=0.4), touches=10)
    return name_effects(cases, START, NamingOptions(effects=("relaxation", "lag"), profile=False, pairs=False))


def test_a_naming_is_followed_by_a_document(named):
    """What an answer leaves open is planned for, and the document fits its schema."""
    found = propose_trials(named)
    assert {one.trial.name for one in found} == {make.__name__ for make in TRIALS}
    document = json.loads(json.dumps(next_trials_document(found)))
    schema = load_schema("diagnosis")
    jsonschema.validate(document, {"$ref": "#/$defs/next_trials", "$defs": schema["$defs"]})
    assert document["in_closed_form"]
    assert all(entry["scenario"]["title"] == entry["title"] for entry in document["proposals"])
    assert [one.separations for one in propose_trials(named)] == [one.separations for one in found]


def test_what_could_be_there_unseen_is_sought():
    """Where nothing is missing, a ball's adhesion is hidden by the noise, and a flat punch is proposed to show it."""
    options = NamingOptions(effects=("adhesion", "rate_friction"), profile=False)
    naming = name_effects(recorded(touches=10), START, options)
    assert naming.decision.verdict is Verdict.NOTHING_FOUND
    rivals = rivals_of(naming)
    assert rivals.members[0].name == NOTHING
    assert {one.name for one in rivals.members[1:]} == set(naming.identifiable.undetectable)
    (place,) = [place for place, pair in enumerate(rivals.pairs) if rivals.members[pair.first].name == "adhesion"]
    found = propose_trials(naming)
    shown = {one.trial.name: one.separations[place].after for one in found}
    assert max(shown, key=shown.get) == "flat_punch"
    assert shown["flat_punch"] > 5.0 > 2.0 > shown["three_radii"]
    assert any(line.startswith("Press a flat punch") and "adhesion" in line for line in next_trial_sentences(found))


def test_what_was_nearly_found_is_sought_first(named):
    """The next trial is for effects with enough evidence that another rule keeps from a claim, and for no others."""
    nothing = dataclasses.replace(named.decision, verdict=Verdict.NOTHING_FOUND, ties=())
    kept = dataclasses.replace(named, decision=nothing)
    enough = {one.label for one in named.scored if len(one.names) == 1 and one.evidence >= one.needed(named.thresholds)}
    rivals = rivals_of(kept)
    assert enough
    assert rivals.members[0].name == NO_CLAIM
    assert {one.name for one in rivals.members[1:]} == enough
    # no effect is a part of each effect: only the effect may be true, and the data so far do not count
    assert all(pair.ways == ((pair.first, 0),) for pair in rivals.pairs)
    found = propose_trials(kept)
    assert {pair.before for pair in found[0].separations} == {0.0}
    assert found[0].separates
    (line, *_) = next_trial_sentences(found)
    assert line.startswith(found[0].trial.title)
    assert "as it was fitted would stand out by" in line
    assert next_trials_document(found)["proposals"][0]["trial"] == found[0].trial.name
    # a control: where errors of the simulation could bring that evidence, none is nearly found
    weak = [dataclasses.replace(one, error_size=100.0 * one.error_size) for one in named.scored]
    unseen = rivals_of(dataclasses.replace(kept, scored=weak)).members[1:]
    assert {one.name for one in unseen} == set(named.identifiable.undetectable)


def test_what_leaves_no_trace_is_sought_where_it_would():
    """At one orientation the zero hides a tool's weight: the page says so, and proposes turns in free air."""
    options = NamingOptions(effects=("tool_weight", "lag"), profile=False)
    naming = name_effects(recorded(touches=10), START, options)
    assert naming.identifiable.without_trace == ("tool_weight",)
    assert "tool_weight" in naming.identifiable.undetectable
    best = propose_trials(naming)[0]
    assert best.trial.name == "turns"
    weight = next(one for one in best.separations if one.first == "tool_weight")
    assert weight.before == pytest.approx(0.0, abs=1e-6)
    assert weight.after > 5.0


def test_what_the_data_say_counts_where_it_is_less_than_was_planned():
    """Two that should differ, and hardly do in what was really measured, are not called told apart."""
    cases = recorded(effect("rate_friction", beta=0.2), touches=8, slide=3e-3)
    members = [
        Rival(fit.names[0], fit)
        for fit in fitted(cases, [("rate_friction", {"beta": 0.1}), ("static_friction", {"excess": 0.1})])
    ]
    bench, white = TrialBench.of(cases, START), WhitenedTouches.of(cases)
    surprised, told = (
        ranked_trials(Rivals.around(members, supports), white, bench, trials=[slides])[0].separations[0]
        for supports in ((20.0, 19.5), (20.0, 0.0))
    )
    assert surprised.before == pytest.approx(1.0)
    assert surprised.before < told.before
    assert surprised.after < told.after


def test_an_abstention_asks_for_what_separates_the_strongest(named):
    """Refitted or only screened, the best two are told apart; a part of a pair is no truth beside the pair."""
    unknown = dataclasses.replace(named.decision, verdict=Verdict.NOT_EXPLAINED, ties=())
    refitted = rivals_of(dataclasses.replace(named, decision=unknown))
    assert [one.name for one in refitted.members] == ["relaxation", "lag"]
    screened = rivals_of(dataclasses.replace(named, decision=unknown, scored=[]))
    assert {one.name for one in screened.members} == {"relaxation", "lag"}
    first, second = (one.fit for one in refitted.members)
    both = dataclasses.replace(
        first, model=dataclasses.replace(first.model, settings=(*first.model.settings, *second.model.settings))
    )
    nested = Rivals.around([Rival("relaxation + lag", both), Rival("lag", second)], (30.0, 29.0))
    assert [pair.both_ways for pair in nested.pairs] == [False]


def test_where_nothing_is_left_there_is_no_trial(named):
    """One explanation alone needs none."""
    alone = dataclasses.replace(named, scored=named.scored[:1], screened=[])
    alone = dataclasses.replace(
        alone, decision=dataclasses.replace(alone.decision, best=alone.scored[0], ties=(), verdict=Verdict.EXPLAINED)
    )
    assert propose_trials(alone) == []
    assert next_trials_document([])["proposals"] == []


def told_apart(proposals, before, after):
    """The proposals, with these distances of every pair, in standard deviations, before and after."""
    return [
        dataclasses.replace(
            one,
            separations=tuple(dataclasses.replace(pair, before=before, after=after) for pair in one.separations),
        )
        for one in proposals
    ]


def test_no_trial_is_promised_for_what_is_in_no_catalogue(named):
    """Explanations that are told apart, with structure left: that is said, and not that nothing is needed."""
    clear = told_apart(propose_trials(named), 8.0, 9.0)
    assert next_trials_document(clear)["proposals"] == []
    assert "no trial is proposed" in next_trial_sentences(clear)[0]
    (said,) = next_trial_sentences(clear, is_more_left=True)
    assert said.endswith("none of these explains what is left.")


def test_sentences_and_listed_trials_agree(named):
    """Explanations that are told apart, but not surely: the trials that are listed are the ones that are told."""
    nearly = told_apart(propose_trials(named), 3.7, 6.0)
    assert 0.02 < nearly[0].separations[0].error_before < 0.05
    listed = [one["title"] for one in next_trials_document(nearly)["proposals"]]
    assert listed
    for is_more_left in (False, True):
        (said,) = next_trial_sentences(nearly, is_more_left)
        assert said.endswith(f" They would be told apart more surely with a further trial: {' or '.join(listed)}.")
        assert "no trial is proposed" not in said
