"""Answers from estimated plays beside answers from plays that are all made: what counts as the same."""

from estimated_answers import compare, print_named

from tactiledata.prove.score.scored_case import ScoredCase

SAME = {"verdict": "nothing found", "set": [], "nearest": ["lag"], "zeros": [], "before": [0.9e6, 0.47, 0.6]}


def answers(**changed):
    """Two cases by both ways; the second case differs by what is given."""
    made = {("all made", name): SAME for name in "ab"}
    return made | {("estimated", "a"): SAME, ("estimated", "b"): {**SAME, **changed}}


def test_equal_answers_are_counted_and_not_listed(capsys):
    """Verdict, names and what readings show make an answer; the nearest candidate does not."""
    compare(answers(nearest=["dome"]), {"a": "nothing", "b": "lag"})
    told = capsys.readouterr().out
    assert "the same answer: 2 of 2" in told
    assert "nearest" not in told


def test_another_verdict_or_name_is_listed_with_what_is_hidden(capsys):
    """Each of verdict, names and what readings show makes another answer, which is told both ways."""
    for changed in ({"verdict": "below detection"}, {"set": ["lag"]}, {"zeros": ["dead_band"]}):
        compare(answers(**changed), {"a": "nothing", "b": "lag"})
        told = capsys.readouterr().out
        assert "the same answer: 1 of 2" in told
        assert "b (lag): all made: nothing found: - (nearest lag); estimated: " in told


def test_parameters_are_apart_in_per_cent_of_the_answer_that_was_made(capsys):
    """E twice as large in one of two cases: 100 % at most, 50 % in the median."""
    compare(answers(before=[1.8e6, 0.47, 0.6]), {"a": "nothing", "b": "nothing"})
    told = capsys.readouterr().out
    assert "E of the plain fit apart: median 50.00 %, largest 100.00 %" in told
    assert "nu of the plain fit apart: median 0.00 %, largest 0.00 %" in told


def test_visible_effects_and_nulls_that_are_named_are_counted_both_ways(capsys):
    """What a fit or the readings name counts; a name in a world that hides nothing counts by itself."""
    label = {"a": {"kind": "nulls", "truth": []}, "b": {"kind": "visible", "truth": ["lag"]}}
    cases = {name: ScoredCase(name, label[name], {}, 1.0) for name in "ab"}
    print_named(answers(zeros=["lag"]), cases)
    told = capsys.readouterr().out
    assert "all made: 0 of 1 visible effects named, 0 of 1 nulls" in told
    assert "estimated: 1 of 1 visible effects named, 0 of 1 nulls" in told
    print_named({**answers(), ("all made", "a"): {**SAME, "set": ["dome"]}}, cases)
    assert "all made: 0 of 1 visible effects named, 1 of 1 nulls" in capsys.readouterr().out
