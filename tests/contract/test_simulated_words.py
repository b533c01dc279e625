"""The words for simulated recordings, in every number, and what counts as stated."""

import pytest

from tactiledata.contract.simulated import NOTHING_STATED, SimulatedCount, recording_kind


@pytest.mark.parametrize(
    ("recorder", "kind"),
    [
        ({"contact": "simulated"}, "simulated"),
        ({"contact": "  Simulated\n"}, "simulated"),
        ({"contact": "REAL"}, "real"),
        ({"contact": "really"}, "not stated"),
        ({"contact": ""}, "not stated"),
        ({"contact": None}, "not stated"),
        ({"contact": ["simulated"]}, "not stated"),
        ({}, "not stated"),
        ("simulated", "not stated"),
        (None, "not stated"),
    ],
)
def test_only_the_two_words_state_anything(recorder, kind):
    """Only simulated and real state anything, in any case and with spaces around."""
    assert recording_kind({"recorded_by": recorder}) == kind
    assert recording_kind({}) == "not stated"


@pytest.mark.parametrize(
    ("count", "sentence"),
    [
        ((0, 4, 2), ""),
        ((1, 0, 0), "Simulated recordings: 1 recording."),
        ((2, 0, 0), "Simulated recordings: all 2 recordings."),
        ((1, 1, 0), "Simulated recordings: 1 of 2 recordings; 1 is real."),
        ((1, 2, 0), "Simulated recordings: 1 of 3 recordings; 2 are real."),
        ((1, 0, 1), "Simulated recordings: 1 of 2 recordings; 1 does not state it."),
        ((3, 0, 2), "Simulated recordings: 3 of 5 recordings; 2 do not state it."),
        ((1, 3, 2), "Simulated recordings: 1 of 6 recordings; 3 are real; 2 do not state it."),
    ],
)
def test_the_sentence_agrees_in_number(count, sentence):
    """One is, several are; one does not, several do not; one alone is not all."""
    assert SimulatedCount(*count).sentence == sentence


def test_titles_and_captions_carry_the_label():
    """The label follows a title in brackets and a caption as a sentence; where nothing is simulated there is none."""
    some, none = SimulatedCount(1, 2), SimulatedCount(0, 2)
    assert some.titled("Forces") == "Forces (simulated recordings: 1 of 3)"
    assert some.captioned("Forces.") == "Forces. Simulated recordings: 1 of 3."
    assert some.heading == "Simulated recordings: 1 of 3"
    assert (none.titled("Forces"), none.captioned("Forces."), none.heading) == ("Forces", "Forces.", "")


def test_counts_as_json_and_by_default():
    """Three numbers, whether or not anything is simulated; where nobody was asked, zeros of recordings."""
    count = SimulatedCount.of(["real", "real", "not stated", "simulated", "real"], "trajectory")
    assert count.document() == {"simulated": 1, "real": 3, "not_stated": 1}
    assert count.sentence.startswith("Simulated recordings: 1 of 5 trajectories")
    assert NOTHING_STATED.document() == {"simulated": 0, "real": 0, "not_stated": 0}
    assert (SimulatedCount.of(["real"]).noun, SimulatedCount().total) == ("recording", 0)
