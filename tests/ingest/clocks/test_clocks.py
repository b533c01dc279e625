"""The right one of three clocks is taken, and the choice is said."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from tactiledata.contract.records import Stamps
from tactiledata.ingest.clocks.clocks import choose_clock, time_order

START = 1_700_000_000_000_000_000
LOG = START + np.arange(100) * 10_000_000


def test_a_usable_header_wins():
    """A header in order and near the log time is taken as it is."""
    header = LOG - 3_000_000
    choice = choose_clock("wrench", Stamps(LOG, None, header))
    assert choice.clock == "header"
    assert (choice.t_ns == header).all()
    assert choice.findings == ()


def test_a_header_on_another_clock_is_shifted_and_said():
    """A clock that started at zero is shifted by the median distance; int64 keeps every nanosecond."""
    header = np.arange(100, dtype=np.int64) * 10_000_000 + 5
    choice = choose_clock("wrench", Stamps(LOG, None, header))
    assert choice.clock == "header+shift"
    assert (choice.t_ns == header + (START - 5)).all()
    assert [finding.code for finding in choice.findings] == ["clock-shifted"]


def test_unusable_headers_fall_back_to_log_time():
    """Unset, backward, repeated or wandering headers are refused, each with its reason."""
    unset, backward, wandering = LOG.copy(), LOG.copy(), LOG + np.arange(100) * 50_000_000
    unset[3] = 0
    backward[10] -= 50_000_000
    reasons = {
        "not set": unset,
        "backwards": backward,
        "repeat": np.full(100, START),
        "wanders": wandering,
    }
    for reason, header in reasons.items():
        choice = choose_clock("tcp", Stamps(LOG, None, header))
        assert choice.clock == "log"
        assert (choice.t_ns == LOG).all()
        assert reason in choice.findings[0].message


def test_a_stated_offset_wins_over_the_estimate():
    """An offset that the recording states is applied, whatever clock is taken."""
    choice = choose_clock("wrench", Stamps(LOG, None, LOG - 2_000_000_000), "auto", 2_000_000_123)
    assert (choice.t_ns == LOG + 123).all()


def test_a_stated_offset_is_not_added_to_the_hosts_own_log_time():
    """An offset is of the stream's clock: the log time beside other stamps is the host's, and stays as it is."""
    unset = np.zeros(100, dtype=np.int64)
    for stamps in (Stamps(LOG, LOG - 7, unset), Stamps(LOG, None, unset), Stamps(LOG, LOG - 7)):
        for preference in ("auto", "log"):
            choice = choose_clock("wrench", stamps, preference, -2_000_000_000)
            assert (choice.clock, choice.shift_ns) == ("log", 0)
            assert (choice.t_ns == LOG).all()
        said = choose_clock("wrench", stamps, "auto", -2_000_000_000).findings
        assert "offset of -2.000 s" in said[0].message


def test_a_stated_offset_is_added_to_the_only_clock():
    """Samples with one stamp have the stream's own clock, and the stated offset brings it to the host's."""
    for preference in ("auto", "log", "publish"):
        choice = choose_clock("wrench", Stamps(LOG), preference, -2_000_000_000)
        assert choice.shift_ns == -2_000_000_000
        assert (choice.t_ns == LOG - 2_000_000_000).all()


def test_an_explicit_preference_is_obeyed():
    """Log and publish are taken when asked for."""
    stamps = Stamps(LOG, LOG - 1, LOG - 2)
    assert (choose_clock("a", stamps, "log").t_ns == LOG).all()
    assert (choose_clock("a", stamps, "publish").t_ns == LOG - 1).all()
    assert (choose_clock("a", stamps, "header").t_ns == LOG - 2).all()


@given(st.lists(st.integers(0, 50), min_size=1, max_size=40))
def test_sorting_is_said_exactly_when_needed(times):
    """A sorted stream gets no order; any other comes out sorted, with a finding."""
    t_ns = np.array(times, dtype=np.int64)
    order, findings = time_order("x", t_ns)
    codes = {finding.code for finding in findings}
    assert ("time-order" in codes) == (order is not None) == bool((np.diff(t_ns) < 0).any())
    assert (np.diff(t_ns if order is None else t_ns[order]) >= 0).all()
    assert ("duplicate-stamps" in codes) == (len(set(times)) < len(times))
