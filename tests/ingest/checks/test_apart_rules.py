"""Streams that do not meet the trajectories, in times of a few nanoseconds."""

import numpy as np
import pytest

from tactiledata.ingest.checks.apart import apart_findings
from tests.ingest.made_takes import frames, signal, take, told, touch

TOUCHES = [touch("a", 100, 200), touch("b", 300, 400)]


def said(t_ns, **attributes):
    made = take(None, TOUCHES, {"joints": signal("joints", t_ns, [[0] * 6] * len(t_ns), **attributes)})
    return apart_findings(made)


@pytest.mark.parametrize(
    ("t_ns", "where"),
    [
        ([400, 500, 600], "all 3 samples lie 0 s after"),
        ([10, 100], "all 2 samples lie 0 s before"),
        ([399, 500], ""),
        ([10, 101], ""),
        ([200, 250], ""),
        ([400 + 3 * 10**15, 5 * 10**15], "all 2 samples lie 3e+06 s after"),
        ([100 - 2 * 10**9], "all 1 samples lie 2 s before"),
    ],
)
def test_a_signal_that_meets_no_trajectory_is_said(t_ns, where):
    """One that touches the time from the first start to the last end says nothing, also in a pause."""
    found = said(t_ns)
    assert told(found) == ([("signal-elsewhere", "warning", "joints", len(t_ns))] if where else [])
    assert all(where in one.message for one in found)


def test_large_distances_are_in_seconds():
    """1234570 s are said to six digits."""
    assert "lie 1.23457e+06 s after" in said([400 + 1_234_570 * 10**9])[0].message
    assert "lie 999999 s after" in said([400 + 999_999 * 10**9])[0].message


def test_derived_and_empty_signals_are_left():
    """What was derived from another signal lies where that lies, and no samples lie nowhere."""
    assert said([500], derived_from="wrench") == []
    assert said([]) == []
    assert apart_findings(take(None, [], {"joints": signal("joints", [5], [[0] * 6])})) == []


SEC = 10**9


def lacking(first, last, step=SEC // 100, touches=None, **attributes):
    """What is said of a signal from the first to the last moment (s), beside touches of 4 s every 5 s."""
    t_ns = np.arange(round(first * SEC), round(last * SEC) + 1, step)
    touches = (
        [touch(name, 5 * k * SEC, (5 * k + 4) * SEC) for k, name in enumerate("abc")] if touches is None else touches
    )
    made = take(None, touches, {"joints": signal("joints", t_ns, np.zeros((len(t_ns), 6)), **attributes)})
    return apart_findings(made)


@pytest.mark.parametrize(
    ("first", "last", "words"),
    [
        (0, 14, ""),
        (0.5, 13.5, ""),
        (-3, 20, ""),
        (0, 13.49, "1 of 3 trajectories (c), up to 0.51 s"),
        (0.51, 14, "1 of 3 trajectories (a), up to 0.51 s"),
        (0, 6.5, "2 of 3 trajectories (b, c), up to 4.00 s"),
        (0, 4.2, "2 of 3 trajectories (b, c), up to 4.00 s"),
        (9.2, 14, "2 of 3 trajectories (a, b), up to 4.00 s"),
        (6, 8, "3 of 3 trajectories (a, b, c), up to 4.00 s"),
        (3, 3, "3 of 3 trajectories (a, b, c), up to 4.00 s"),
    ],
)
def test_a_signal_that_ends_before_the_trajectories_do_is_said(first, last, words):
    """More than half a second of a touch before its first sample or behind its last: a recorder stopped."""
    found = lacking(first, last)
    assert told(found) == ([("signal-incomplete", "warning", "joints", int(words[0]))] if words else [])
    assert all(f"joints begins or ends inside or beside {words} of them" in one.message for one in found)


@pytest.mark.parametrize(
    ("segmented", "names"), [("log", "a, c"), ("contact onset and release", ""), ("whole recording", "")]
)
def test_touches_that_were_found_end_with_the_recording(segmented, names):
    """A touch that was cut with a margin lacks nothing beyond all streams; what a log states does."""
    rows = [touch("a", 0, 4 * SEC), touch("b", 5 * SEC, 9 * SEC), touch("c", 10 * SEC, 14 * SEC)]
    t_ns = np.arange(SEC, 13 * SEC + 1, SEC // 100)
    signals = {"joints": signal("joints", t_ns, np.zeros((len(t_ns), 6)))}
    found = apart_findings(take(None, [{**row, "segmented": segmented} for row in rows], signals))
    assert [one.message.partition("(")[2].partition(")")[0] for one in found] == ([names] if names else [])


@pytest.mark.parametrize("other", ["images", "tcp"])
def test_a_found_touch_lacks_what_another_stream_has(other):
    """Where images or another signal go on, a signal that ended is said of touches that were found, too."""
    t_ns = np.arange(0, 8 * SEC + 1, SEC // 100)
    signals = {"joints": signal("joints", t_ns, np.zeros((len(t_ns), 6)))}
    table = None
    if other == "images":
        table = frames(5, t_ns=3 * SEC * np.arange(5))
    else:
        signals["tcp"] = signal("tcp", [0, 12 * SEC], np.zeros((2, 7)))
    rows = [touch("a", -SEC, 4 * SEC), touch("b", 9 * SEC, 14 * SEC)]
    found = apart_findings(take(table, [{**row, "segmented": "contact onset and release"} for row in rows], signals))
    assert told(found) == [("signal-incomplete", "warning", "joints", 1)]
    assert "(b), up to 3.00 s" in found[0].message


def test_a_slow_signal_may_end_ten_samples_earlier():
    """Of a temperature every 0.2 s, two seconds are not missed, and a sample more is."""
    assert lacking(0, 12, SEC // 5) == []
    assert told(lacking(0, 11.8, SEC // 5)) == [("signal-incomplete", "warning", "joints", 1)]


def test_five_trajectories_that_lack_a_signal_are_named():
    """A sixth is a sign; a signal that was derived, or that lies elsewhere, is not said to be incomplete."""
    for count, ending in ((5, "(t1, t2, t3, t4, t5),"), (6, "(t1, t2, t3, t4, t5 …),")):
        touches = [touch(f"t{k}", 5 * k * SEC, (5 * k + 4) * SEC) for k in range(count + 1)]
        (found,) = lacking(0, 4, touches=touches)
        assert (found.count, ending in found.message) == (count, True)
    assert lacking(0, 4, derived_from="wrench") == []
    for first, last in ((14, 20), (15, 20), (-5, 0), (-5, -1)):
        assert [one.code for one in lacking(first, last)] == ["signal-elsewhere"]


@pytest.mark.parametrize(("lack", "is_said"), [(SEC // 2, False), (SEC // 2 + 1, True)])
def test_half_a_second_may_be_missing(lack, is_said):
    """A nanosecond more is said, at the beginning and at the end."""
    for t_ns in (np.append(np.arange(0, 13 * SEC, SEC // 100), 14 * SEC - lack), np.arange(lack, 15 * SEC, SEC // 100)):
        touches = [touch(name, 5 * k * SEC, (5 * k + 4) * SEC) for k, name in enumerate("abc")]
        found = apart_findings(take(None, touches, {"joints": signal("joints", t_ns, np.zeros((len(t_ns), 6)))}))
        assert len(found) == is_said


def test_every_signal_is_held_against_the_trajectories():
    """Behind one that was derived, one that lies elsewhere, one without samples and one that lacks nothing."""
    whole, short, away = (
        np.arange(first * SEC, last * SEC + 1, SEC // 10) for first, last in ((0, 14), (0, 8), (50, 60))
    )
    times = {"a": short, "b": away, "c": np.zeros(0, np.int64), "d": whole, "e": short}
    signals = {
        name: signal(
            name, t_ns, np.zeros((len(t_ns), 1)), ("temperature",), **({"derived_from": "x"} if name == "a" else {})
        )
        for name, t_ns in times.items()
    }
    found = apart_findings(take(None, [touch("t", 0, 14 * SEC)], signals))
    assert [(one.code, one.stream) for one in found] == [("signal-elsewhere", "b"), ("signal-incomplete", "e")]


def test_a_long_lack_is_told_to_the_hundredth_of_a_second():
    """Of a trajectory of four months a signal has one second."""
    (found,) = lacking(0, 1, touches=[touch("long", 0, 10**7 * SEC)])
    assert "up to 9999999.00 s of them" in found.message


def others(trajectory=-1, touches=(), **columns):
    return apart_findings(take(frames(4, t_ns=[99, 100, 199, 200], trajectory=trajectory, **columns), touches))


def test_images_of_another_sensor_in_a_trajectory_without_images():
    """The interval is half-open; images of the same sensor, or that belong to a trajectory, say nothing."""
    empty = [touch("a", 100, 200, 0, 0), touch("b", 150, 250, 2, 2, sensor="")]
    [finding] = others(sensor=["D2", "D3", "D2", "D1"], touches=empty[:1])
    assert told([finding]) == [("images-of-another-sensor", "warning", "", 2)]
    assert "2 images lie in the time of 1 trajectories" in finding.message
    assert "(for example D2, D3 in 'a' of D1)" in finding.message
    [both] = others(sensor="D2", touches=empty)
    assert "4 images lie in the time of 2 trajectories" in both.message
    assert "of no sensor" in others(sensor="D2", touches=empty[1:])[0].message
    assert others(sensor="D1", touches=empty[:1]) == []
    assert others(sensor="D2", touches=[touch("a", 100, 200, 0, 1)]) == []
    assert others(trajectory=0, sensor="D2", touches=empty[:1]) == []
    assert len(others(sensor="D2", touches=[touch("full", 0, 50, 0, 1), *empty[:1]])) == 1
