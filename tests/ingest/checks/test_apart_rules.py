"""Streams that do not meet the trajectories, in times of a few nanoseconds."""

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
