"""Rates and gaps in numbers worked out by hand, and where their rules begin."""

import numpy as np
import pytest

from tactiledata.ingest.clocks.rates import Rate, gap_findings, measure_rate, rate_findings

START = 1_700_000_000_000_000_000
MS = 1_000_000
FORCE = ("fx", "fy")


def column(*values):
    return np.array(values, dtype=float)[:, None]


@pytest.mark.parametrize("times", [[], [5], [5, 5], [5, 5, 5]])
def test_no_time_no_rate(times):
    """No samples, one, or all at one moment have no rate."""
    assert measure_rate(np.array(times, np.int64), np.zeros((len(times), 1))) == Rate(0.0, 0.0, 0, 0, 0)


def test_two_samples_have_a_rate():
    """1/8 ms is 125 Hz exactly; values that change once tell no rate of change."""
    assert measure_rate(START + np.array([0, 8 * MS]), column(0, 1)) == Rate(125.0, 0.0, 0, 1, 8 * MS)


def test_rates_by_hand():
    """Values that change at every second of 8 ms steps change at 62.5 Hz; the largest gap is the longest step."""
    t_ns = START + np.array([0, 8, 16, 24, 32, 40, 50]) * MS
    assert measure_rate(t_ns, column(0, 0, 1, 1, 2, 2, 3)) == Rate(125.0, 62.5, 3, 6, 10 * MS)


def test_repeated_times_do_not_count_for_the_rate():
    """Most samples written twice: the distance of those that differ is 10 ms."""
    t_ns = START + np.repeat(np.arange(4), 3) * 10 * MS
    assert measure_rate(t_ns, np.arange(12.0)[:, None]).nominal == 100.0


@pytest.mark.parametrize(("rest", "effective"), [(500 * MS, 10 * 2 / 51), (500 * MS + 1, 10.0)])
def test_a_rest_is_longer_than_half_a_second(rest, effective):
    """Between two changes half a second apart the signal still moves; a nanosecond longer it rests."""
    # changes at rows 1, 2 and 52; each sample is nominally 100 ms after the one before
    steps = np.full(54, 100 * MS)
    steps[2:52] = 10 * MS
    steps[51] += rest - 500 * MS
    values = np.zeros(55)
    values[1], values[2:52], values[52:] = 1, 2, 3
    rate = measure_rate(START + np.concatenate([[0], np.cumsum(steps)]), values[:, None])
    assert rate.nominal == pytest.approx(100.0, rel=1e-12)
    assert rate.effective == pytest.approx(10 * effective, rel=1e-12)


def test_a_rate_as_json_values():
    """Rates to the mHz, counts as they are; how many steps there were is left out."""
    assert Rate(124.98765, 62.43219, 3, 7, 5).document() == {
        "rate_hz": 124.988,
        "effective_rate_hz": 62.432,
        "repeated_samples": 3,
        "largest_gap_ns": 5,
    }


def test_a_twentieth_of_repeats_is_said():
    """5 of 100 steps are said, 4 are not; nor is a signal without steps."""
    assert rate_findings("wrench", FORCE, Rate(100.0, 100.0, 4, 100, 0)) == []
    assert rate_findings("wrench", FORCE, Rate(0.0, 0.0, 0, 0, 0)) == []
    [said] = rate_findings("wrench", FORCE, Rate(100.0, 100.0, 5, 100, 0))
    assert (said.code, said.severity, said.count, said.stream) == ("repeated-samples", "info", 5, "wrench")
    assert "recorded at 100.0 Hz, new values at 95.0 Hz" in said.message
    assert rate_findings("joints", ("q0",), Rate(100.0, 100.0, 50, 100, 0)) == []


def gaps(steps_ms, spans_ms=((0, 10**9),), **options):
    t_ns = START + np.concatenate([[0], np.cumsum(np.asarray(steps_ms) * MS)]).astype(np.int64)
    spans = [(START + int(start * MS), START + int(end * MS)) for start, end in spans_ms]
    return gap_findings("wrench", t_ns, spans, **options)


def test_a_gap_is_ten_times_the_usual_distance():
    """A gap is ten times the usual distance, or as asked for: 100 ms between samples every 10 ms are none."""
    assert gaps([10, 10, 10, 100]) == []
    [gap] = gaps([10, 10, 10, 100 + 1e-6])
    assert (gap.code, gap.severity, gap.stream, gap.count) == ("gap", "warning", "wrench", 1)
    assert (gap.start_ns - START, gap.end_ns - START) == (30 * MS, 130 * MS + 1)
    assert gaps([10, 10, 10, 31], factor=3.0)
    assert gaps([10, 10, 10, 31], factor=4.0) == []


def test_three_samples_may_have_a_gap():
    """Two samples do not tell what is usual, three do."""
    assert gaps([10], factor=0.5) == []
    assert len(gaps([10, 30], factor=1.0)) == 1


def test_a_gap_is_longer_than_a_millisecond():
    """Of a signal of 100 kHz, 1 ms is no gap, and a nanosecond more is one; nor is there any where time stands."""
    assert gaps([0.01] * 9 + [1]) == []
    assert len(gaps([0.01] * 9 + [1 + 1e-6])) == 1
    assert gaps([0, 0, 0]) == []


def test_repeated_times_do_not_make_gaps():
    """Samples written three times at 10 ms: 50 ms are no gap."""
    assert gaps([10, 0, 0] * 5 + [50]) == []


def test_the_smallest_step_of_repeated_times_counts():
    """A single step of a nanosecond is what is usual, so that the limit is a millisecond."""
    assert gap_findings("wrench", START + np.array([0, 0, 1, 1]), [(START, START + 10)]) == []


def test_a_gap_counts_by_its_part_in_a_trajectory():
    """Exactly the limit inside is none; the longest of several is named, and all are counted."""
    steps = [10] * 10 + [300] + [10] * 10 + [400_000_000] + [10] * 10
    assert gaps(steps, [(0, 200)]) == []
    assert len(gaps(steps, [(0, 201)])) == 1
    [gap] = gaps(steps, [(0, 10**9)])
    assert gap.count == 2
    assert (gap.start_ns - START, gap.end_ns - START) == (500 * MS, 400_000_500 * MS)
    assert gap.message == "wrench: 2 gaps inside trajectories, the largest 400000000 ms"
    [gap] = gaps(steps[:-11], [(0, 10**9)])
    assert gap.message == "wrench: 1 gap inside trajectories, the largest 300 ms"


def test_a_force_sensor_that_never_changes_was_not_read():
    """All samples equal: a warning of its own; one that differs leaves the sentence about repeated samples."""
    t_ns = START + np.arange(50) * MS
    values = np.zeros((50, 2))
    (finding,) = rate_findings("wrench", FORCE, measure_rate(t_ns, values))
    assert (finding.code, finding.severity, finding.count) == ("force-stuck", "warning", 50)
    assert finding.message.startswith("wrench: all 50 samples are the same,")
    values[-1] = 1
    (finding,) = rate_findings("wrench", FORCE, measure_rate(t_ns, values))
    assert finding.code == "repeated-samples"
    assert rate_findings("tcp", ("x", "y"), measure_rate(t_ns, np.zeros((50, 2)))) == []
