"""Other methods on a proof's cases: what counts as right, and how differences are paired."""

import numpy as np
import pytest
from proof_rivals import METHODS, difference, exact_case, is_right, judged, show
from rival_methods import Case
from sealed_proofs import answered_proof
from touch_worlds import PLANTS, START, world_cases

from tactiledata.prove.cases.configuration import Configuration, played_plan
from tactiledata.prove.cases.drawn_world import DrawnWorld
from tactiledata.prove.cases.oracle import refit
from tactiledata.prove.score.scored_case import ScoredCase
from tactiledata.prove.seal.verify import scored_cases


def test_names_are_right_by_the_rules_of_the_proof():
    """Silence is right of nulls and of what no catalogue holds; else what is hidden is among the first two names."""
    truth = frozenset(["lag"])
    assert is_right("nulls", frozenset(), ())
    assert not is_right("nulls", frozenset(), ("lag",))
    assert is_right("outside", frozenset(), ())
    assert is_right("visible", truth, ("dome", "lag"))
    assert not is_right("visible", truth, ("dome", "skin", "lag"))
    assert not is_right("visible", truth, ())
    assert is_right("pairs", frozenset(["lag", "dome"]), ("lag", "dome"))
    assert not is_right("pairs", frozenset(["lag", "dome"]), ("lag",))


def test_what_readings_show_counts_for_every_method():
    """A dead-band that readings show is right where it is hidden, whatever is named first, and wrong of a null."""
    assert is_right("visible", frozenset(["dead_band"]), (), ("dead_band",))
    assert is_right("visible", frozenset(["dead_band"]), ("dome", "skin"), ("dead_band",))
    assert is_right("pairs", frozenset(["lag", "dead_band"]), ("lag",), ("dead_band",))
    assert not is_right("nulls", frozenset(), (), ("dead_band",))
    assert not is_right("visible", frozenset(["lag"]), (), ("dead_band",))


@pytest.mark.slow
def test_differences_are_those_of_the_same_cases():
    """Two methods that err in the same cases do not differ at all; the interval covers a planted difference."""
    same = [True, False] * 10
    assert difference(same, same) == (0.0, 0.0, 0.0)
    chance, covered = np.random.default_rng(1), 0
    for seed in range(100):
        ours, other = chance.random(80) < 0.8, chance.random(80) < 0.5
        _, low, high = difference(ours, other, seed)
        covered += low <= 0.3 <= high
    assert covered >= 88


@pytest.mark.slow
def test_the_table_has_our_answers_to_the_same_cases(tmp_path, capsys):
    """Six nulls and six effects, one of which ours missed: a method that says nothing is right of the nulls alone."""
    cases = scored_cases(answered_proof(tmp_path / "proof"))
    kept = [{"case": case.name, "method": "nothing (recalibration)", "said": []} for case in cases]
    found = judged(cases, kept)
    assert sum(right for _, right, _ in found["nothing (recalibration)"]) == 6
    assert sum(ours for _, _, ours in found["nothing (recalibration)"]) == 11
    show(found)
    (row,) = [line for line in capsys.readouterr().out.splitlines() if "nothing (recalibration)" in line]
    assert "6 (6) of 6" in row
    assert "0 (5) of 6" in row
    assert "+42" in row


@pytest.mark.slow
@pytest.mark.parametrize("said", [[], ["lag"]])
def test_a_method_is_judged_by_its_own_names(tmp_path, said):
    """The answer of another method is right or wrong by its own names, whatever our answer to the case is."""
    case = next(one for one in scored_cases(answered_proof(tmp_path / "proof")) if one.truth)
    ((_, right, _),) = judged([case], [{"case": case.name, "method": "m", "said": said}])["m"]
    assert right == bool(said)


@pytest.mark.nightly
def test_an_exact_simulation_leaves_what_is_hidden_and_nothing_else(tmp_path):
    """Readings without noise, less the generator's error: a fit leaves next to nothing of a null, and a lag stays."""
    configuration = Configuration("analytic", "coarse-0", 2.0, 7)
    played = played_plan("coarse-0", tmp_path, False)
    world = DrawnWorld(played, configuration, 100_001)
    left = {}
    for hidden in ([], [{"effect": "lag", "parameters": {"delay": 0.2, "period": 0.0}}]):
        touches = played.maker.cases(played.maker.observed(world.recorded(hidden).exact), played.family)
        case = ScoredCase("", world.case("drawn", hidden).document, {}, 0.0)
        exact = exact_case(case, played, touches, ())
        for what, found in (("as it is", touches), ("exact", exact.cases)):
            wrenches = np.concatenate([one.measured for one in found.touches])
            left[what, len(hidden)] = refit(world.touch_set, wrenches).cost
    # what stays of a null is what its contact offsets cost
    assert left["exact", 0] < 0.05 * left["as it is", 0]
    assert left["exact", 1] > 20 * left["exact", 0]


@pytest.mark.nightly
def test_each_method_answers_and_the_ladder_finds_a_planted_effect():
    """Touches that relax: each method gives names that were asked for, or none; a BIC ladder begins with relaxation."""
    effects = ("relaxation", "lag")
    case = Case(world_cases(PLANTS["relaxation"], 0, trajectories=24), START, effects)
    said = {name: method(case) for name, method in METHODS.items()}
    assert all(set(names) <= set(effects) for names in said.values())
    assert said["BIC ladder"][0] == "relaxation"
    assert said["nothing (recalibration)"] == ()
