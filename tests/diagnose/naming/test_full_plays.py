"""Gels are played in full where an answer could rest on their estimate: by stubs that count what is played."""

from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest
from candidates import along, candidate

from tactiledata.diagnose.naming import full_plays
from tactiledata.diagnose.naming.full_plays import ALIKE, MOST_ROUNDS, OF_A_PAIR, named_with_full_plays
from tactiledata.diagnose.naming.thresholds import DEFAULT_THRESHOLDS
from tactiledata.diagnose.naming.ties import Tie
from tactiledata.diagnose.touches.variant_plays import variants_of

T = DEFAULT_THRESHOLDS
THICKNESS = frozenset(variants_of(["thickness"]))
ALL = frozenset(variants_of(["thickness", "skin", "dome", "mount_offset", "strain_stiffening"]))


@dataclass(frozen=True)
class Touches:
    """Plays of one touch whose changes are 1 where they are played in full, and more where they are estimated."""

    full: frozenset
    by_estimate: frozenset = ALL
    shared: float = 1.0

    @property
    def plays(self):
        def change(variant):
            return np.ones((4, 6)) * np.where(np.arange(6) < 3, 1.0 if variant in self.full else 1.2, 50.0)

        variants = {variant: change(variant) for variant in THICKNESS}
        shared = dict.fromkeys(ALIKE, self.shared * np.ones((4, 7)))
        return [SimpleNamespace(variants=variants, by_estimate=self.by_estimate - self.full, **shared)]


def naming(scored, claimed=(), ties=()):
    decision = SimpleNamespace(claimed=claimed, ties=ties)
    return SimpleNamespace(scored=list(scored), decision=decision, thresholds=T)


def run(answers):
    """What was played, and the result, where naming gives these answers one after the other, the last one for ever."""
    asked = []

    def play(full):
        asked.append(full)
        return Touches(full)

    told = []
    played, found, closer = named_with_full_plays(
        play, lambda *_: answers[min(len(asked), len(answers)) - 1], told.append
    )
    # the first answer is told once, if and only if it is not the last one
    assert told == (answers[:1] if len(asked) > 1 else [])
    return asked, played, found, closer


def of_thickness(share):
    """Evidence of the thickness, as a share of what is enough for a trace."""
    return candidate("thickness", share * T.trace_share)


def test_a_thickness_with_evidence_for_a_trace_is_played_in_full():
    """Once; the answer is the second one, and the estimate was off by a fifth of the force."""
    first, second = naming([of_thickness(1.1)]), naming([of_thickness(0.4)])
    asked, played, found, (closer,) = run([first, second])
    assert asked == [frozenset(), THICKNESS]
    assert (played.full, found) == (THICKNESS, second)
    assert (closer.effect, closer.error) == ("thickness", pytest.approx(0.2))
    assert closer.estimated_evidence == pytest.approx(1.1 * T.trace_share * T.claim("thickness"))
    assert closer.evidence == pytest.approx(0.4 * T.trace_share * T.claim("thickness"))


def test_less_than_a_trace_and_effects_without_other_gels_cost_no_play():
    """A lag, however certain, needs no gel; a thickness below a trace is not worth one."""
    answer = naming([of_thickness(0.9), candidate("lag", 5.0)], claimed=("lag",))
    asked, _, found, closer = run([answer])
    assert (asked, found, closer) == ([frozenset()], answer, ())


@pytest.mark.parametrize("more", [0.9, 1.1])
def test_beside_large_errors_of_the_simulation_a_trace_needs_more(more):
    """Errors of three times the usual size raise by their third power what a thickness needs to be worth full plays."""
    one = replace(of_thickness(27.0 * more), error_size=3.0 * T.usual_size)
    asked, *_ = run([naming([one])])
    assert asked == ([frozenset(), THICKNESS] if more > 1 else [frozenset()])


@pytest.mark.parametrize("more", [0.9, 1.1])
@pytest.mark.parametrize(("times", "size"), [(1.0, 1.0), (1.0, 1.5), (1000.0, 1.0)])
def test_in_a_pair_counts_what_an_effect_adds_to_the_other(times, size, more):
    """Beside a lag, a thickness is worth full plays where it adds half of what a claim of the pair needs, no less.

    Large errors of the simulation raise what is needed, and so does a lag with much evidence of its own.
    """
    lag = candidate("lag", times)
    claim = T.with_errors(size).claim("thickness")
    needs = max(claim, T.second_share * lag.evidence)
    assert (needs == claim) == (times == 1.0)
    pair = replace(candidate(("lag", "thickness")), evidence=lag.evidence + more * OF_A_PAIR * needs, error_size=size)
    answer = naming([lag, of_thickness(-0.5), pair], claimed=("lag",))
    asked, *_ = run([answer])
    assert asked == ([frozenset(), THICKNESS] if more > 1 else [frozenset()])


@pytest.mark.parametrize("how", ["named", "tied"])
def test_what_an_answer_names_is_played_in_full_whatever_its_evidence(how):
    """A claim, and an effect that could stand in its place."""
    tie = Tie("thickness", "lag", "thickness", 0.97, 0.0, 1.0)
    claim = {"named": {"claimed": ("thickness",)}, "tied": {"claimed": ("lag",), "ties": (tie,)}}[how]
    asked, *_ = run([naming([of_thickness(0.1)], **claim)])
    assert asked == [frozenset(), THICKNESS]


def test_one_full_play_may_call_for_another_and_rounds_end():
    """Skin after thickness; effects that come up again and again do not go on for ever."""
    skin = candidate("skin", T.trace_share, change=along(1))
    asked, *_, closer = run([naming([of_thickness(1.0)]), naming([skin])])
    assert asked == [frozenset(), THICKNESS, THICKNESS | frozenset(variants_of(["skin"]))]
    assert [one.effect for one in closer] == ["thickness", "skin"]
    assert np.isnan(closer[0].evidence)
    endless = [naming([candidate(name, 2.0)]) for name in ("thickness", "skin", "dome", "mount_offset", "thickness")]
    assert len(run(endless)[0]) <= MOST_ROUNDS + 1


def test_a_stiffening_law_is_played_in_full_where_it_is_named():
    """It is learned from a few touches, which is no more than an estimate."""
    asked, *_, (closer,) = run([naming([candidate("strain_stiffening", 2.0)], claimed=("strain_stiffening",))])
    assert asked == [frozenset(), frozenset(variants_of(["strain_stiffening"]))]
    assert closer.effect == "strain_stiffening"


def test_what_was_played_already_is_not_played_again():
    """The first answer stands where no play is estimated, as by the linear engine or with few touches."""
    asked = []

    def play(full):
        asked.append(full)
        return Touches(full, by_estimate=frozenset())

    answer = naming([of_thickness(5.0)], claimed=("thickness",))
    _, found, closer = named_with_full_plays(play, lambda *_: answer)
    assert (asked, found, closer) == ([frozenset()], answer, ())


@dataclass
class Forgotten:
    """Stands for the kept fits: what was to be forgotten, in turn."""

    asked: list

    def forget(self, effects=None):
        self.asked.append(effects)


@pytest.mark.parametrize(("shared", "forgotten"), [(1.0, {"thickness"}), (1.01, None)])
def test_fits_of_what_was_played_anew_are_forgotten_and_no_others(shared, forgotten, monkeypatch):
    """Thickness alone, where its gels alone are other plays; everything, where all effects rest on other plays."""
    kept, given = Forgotten([]), []
    monkeypatch.setattr(full_plays, "KeptFits", lambda: kept)
    answers = iter([naming([of_thickness(1.1)]), naming([of_thickness(0.4)])])

    def play(full):
        return Touches(full, shared=shared if full else 1.0)

    def name(played, fits):
        given.append(fits)
        return next(answers)

    named_with_full_plays(play, name)
    assert kept.asked == [forgotten]
    assert given == [kept, kept]


def test_a_variant_that_only_some_touches_have_is_compared_where_it_is():
    """Skin is played in the second touch alone, the same both times: nothing has changed there."""
    (skin,) = variants_of(["skin"])[:1]
    both = [Touches(frozenset()).plays[0], Touches(frozenset()).plays[0]]
    both[1].variants[skin] = np.ones((4, 6))
    again = [Touches(frozenset()).plays[0], Touches(frozenset()).plays[0]]
    again[1].variants[skin] = np.ones((4, 6))
    assert full_plays._changed(both, again) == set()
    again[1].variants[skin] = np.zeros((4, 6))
    assert full_plays._changed(both, again) == {"skin"}
    del again[1].variants[skin]
    assert full_plays._changed(both, again) == {"skin"}
