"""Rates and gaps: a repeated reading, a robot at rest and a pause between touches are told apart."""

import numpy as np
import pytest

from tactiledata.ingest.clocks.rates import gap_findings, measure_rate, rate_findings

STEP = 8_000_000
FORCE = ("fx", "fy", "fz", "tx", "ty", "tz")


def times(count):
    return 1_700_000_000_000_000_001 + np.arange(count) * STEP


def noise(count, every=1):
    return np.repeat(np.random.default_rng(0).normal(size=(count // every, 6)), every, axis=0)


@pytest.mark.parametrize("every", [1, 2, 4])
def test_a_value_read_several_times_is_one_measurement(every):
    """At 125 Hz with each value ``every`` times, values change at 125 / every Hz; said where it is less."""
    rate = measure_rate(times(400), noise(400, every))
    assert rate.nominal == pytest.approx(125)
    assert rate.effective == pytest.approx(125 / every)
    said = rate_findings("wrench", FORCE, rate)
    assert bool(said) == (every > 1)
    if said:
        assert f"new values at {125 * (1 - rate.repeated / 399):.1f} Hz" in said[0].message


def test_rest_does_not_lower_the_rate():
    """A robot that stands for most of a recording changes at its rate while it moves; one that never moves at 0."""
    values = noise(2000, 2)
    values[300:1800] = values[300]
    assert measure_rate(times(2000), values).effective == pytest.approx(62.5, rel=0.02)
    assert measure_rate(times(2000), np.zeros((2000, 6))).effective == 0
    assert rate_findings("joints", ("q0",), measure_rate(times(2000), values)) == []


def test_a_gap_counts_where_it_lies_in_a_trajectory():
    """Samples missing inside a touch are a gap; a pause between touches is none, even with its edges a sample off."""
    t_ns = times(1000)
    spans = [(int(t_ns[0]), int(t_ns[300]) + STEP // 2), (int(t_ns[600]) - STEP // 2, int(t_ns[999]))]
    pause = np.r_[t_ns[:301], t_ns[600:]]
    assert gap_findings("wrench", pause, spans) == []
    assert gap_findings("wrench", np.r_[t_ns[:299], t_ns[602:]], spans) == []
    [gap] = gap_findings("wrench", np.r_[pause[:100], pause[150:]], spans)
    assert (gap.start_ns, gap.end_ns, gap.count) == (t_ns[99], t_ns[150], 1)


def test_a_gap_that_reaches_into_a_trajectory_counts_that_part():
    """Of a stream that fails before a touch ends, the part inside the touch is what is missing."""
    t_ns = times(1000)
    spans = [(int(t_ns[0]), int(t_ns[300])), (int(t_ns[600]), int(t_ns[999]))]
    [gap] = gap_findings("wrench", np.r_[t_ns[:201], t_ns[600:]], spans)
    assert (gap.start_ns, gap.end_ns) == (t_ns[200], t_ns[300])
