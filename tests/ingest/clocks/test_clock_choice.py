"""Where each rule of the choice of a clock begins and ends: just below it and just above it."""

import numpy as np
import pytest

from tactiledata.contract.records import Stamps
from tactiledata.errors import BrokenLog
from tactiledata.ingest.clocks.clocks import AROUND, NEAR, STEADY, choose_clock, time_order

START = 1_700_000_000_000_000_000
MS, SECOND = 1_000_000, 1_000_000_000
LOG = START + np.arange(100) * 10 * MS


def by_lag(lag, step=10 * MS, origin=START, log=None):
    """Stamps of which the log time is ``lag`` (n,) ns after the header."""
    log = origin + np.arange(len(lag)) * step if log is None else log
    return Stamps(log, None, log - np.asarray(lag))


def test_the_rules_of_clocks_in_numbers():
    """A header within a second is the host's; one is steady within 0.2 s; a jump is judged by ten messages a side."""
    assert (NEAR, STEADY, AROUND) == (SECOND, 200 * MS, 10)


def test_no_samples_have_the_log_time():
    """Nothing is chosen and nothing is said, whatever offset is stated."""
    none = np.zeros(0, np.int64)
    choice = choose_clock("wrench", Stamps(none, none, none), "header", 5)
    assert (len(choice.t_ns), choice.clock, choice.shift_ns, choice.findings) == (0, "log", 0, ())


@pytest.mark.parametrize("lag", [0, 7 * MS])
def test_a_single_sample_keeps_its_header(lag):
    """One message is neither backward, nor repeated, nor wandering."""
    choice = choose_clock("wrench", by_lag([lag]))
    assert (choice.clock, choice.shift_ns, choice.t_ns[0]) == ("header", 0, START - lag)


@pytest.mark.parametrize(
    ("preference", "stamps", "offset", "clock", "shift", "first"),
    [
        ("log", Stamps(LOG, LOG - 1, LOG - 2), 7, "log", 0, START),
        ("log", Stamps(LOG), 7, "log", 7, START + 7),
        ("publish", Stamps(LOG, LOG - 1, LOG - 2), 7, "publish", 7, START + 6),
        ("publish", Stamps(LOG, LOG - 1, LOG - 2), None, "publish", 0, START - 1),
        ("publish", Stamps(LOG, None, LOG - 2), 7, "publish", 0, START),
        ("header", Stamps(LOG, LOG - 1, LOG - 2), 7, "header", 7, START + 5),
        ("header", Stamps(LOG, LOG - 1), None, "log", 0, START),
        ("auto", Stamps(LOG, LOG - 1, LOG - 2), 7, "header", 7, START + 5),
        ("auto", Stamps(LOG, LOG - 1, LOG - 2), 0, "header", 0, START - 2),
        ("auto", Stamps(LOG), 7, "log", 7, START + 7),
    ],
)
def test_each_preference_takes_its_stamps_and_adds_the_offset(preference, stamps, offset, clock, shift, first):
    """The times, the name of the clock and what was added are those of the preference."""
    choice = choose_clock("wrench", stamps, preference, offset)
    assert (choice.clock, choice.shift_ns, int(choice.t_ns[0])) == (clock, shift, first)
    assert choice.findings == ()


def test_a_header_that_is_asked_for_is_taken_though_it_runs_backwards():
    """Only a stamp that is not set keeps a header that was asked for from being taken."""
    backward, unset = np.arange(100, 0, -1), np.arange(100)
    assert choose_clock("wrench", Stamps(LOG, None, backward), "header").clock == "header"
    refused = choose_clock("wrench", Stamps(LOG, None, unset), "header")
    assert (refused.clock, refused.shift_ns) == ("log", 0)
    assert "1 of 100 header stamps are not set" in refused.findings[0].message


def test_a_header_may_begin_at_one_nanosecond():
    """Only 0 and less mean that a stamp is not set."""
    header = 1 + np.arange(100) * 10 * MS
    assert choose_clock("wrench", Stamps(LOG, None, header)).clock == "header+shift"
    assert choose_clock("wrench", Stamps(LOG, None, header), "header").clock == "header"
    assert choose_clock("wrench", Stamps(LOG, None, header - 1)).clock == "log"


def test_a_nanosecond_backwards_is_backwards():
    """A header that stands is in order; one that goes back by 1 ns is not."""
    header = LOG.copy()
    header[50] = header[49]
    assert choose_clock("wrench", Stamps(LOG, None, header)).clock == "header"
    header[50] -= 1
    [said] = choose_clock("wrench", Stamps(LOG, None, header)).findings
    assert "run backwards at 1 of 100 samples" in said.message


def test_half_of_the_header_stamps_may_repeat():
    """100 stamps of 50 moments are taken, of 49 moments refused."""
    half = np.repeat(LOG[::2], 2)
    assert choose_clock("wrench", Stamps(LOG, None, half)).clock == "header"
    half[98:] = half[97]
    assert choose_clock("wrench", Stamps(LOG, None, half)).clock == "log"


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(("few", "clock"), [(5, "header"), (6, "log")])
def test_a_twentieth_of_the_messages_may_be_late(sign, few, clock):
    """Of 101 messages five may lie 0.3 s beside the others, on either side; six may not."""
    lag = np.zeros(101, np.int64)
    lag[10 : 10 + few] = sign * 300 * MS
    assert choose_clock("wrench", by_lag(lag, SECOND)).clock == clock


@pytest.mark.parametrize("distance", [0, START - 5 * SECOND])
@pytest.mark.parametrize(("spread", "is_steady"), [(STEADY, True), (STEADY + 1, False)])
def test_a_steady_header_spreads_by_a_fifth_of_a_second(spread, is_steady, distance):
    """A header is steady up to a spread of 0.2 s to the nanosecond, also in another epoch."""
    lag = distance + np.where(np.arange(101) < 50, 0, spread)
    choice = choose_clock("wrench", by_lag(lag, SECOND))
    assert (choice.clock != "log") == is_steady


def test_a_wandering_header_is_said_in_milliseconds():
    """A spread of 4000 s is 4000000 ms."""
    lag = 7 * SECOND + np.where(np.arange(101) < 50, 4000 * SECOND, 0)
    [said] = choose_clock("wrench", by_lag(lag, 5000 * SECOND)).findings
    assert "wanders 4000000 ms against" in said.message


@pytest.mark.parametrize(
    ("distance", "clock", "shift"),
    [
        (NEAR - 1, "header", 0),
        (NEAR, "header+shift", NEAR),
        (1 - NEAR, "header", 0),
        (-NEAR, "header+shift", -NEAR),
    ],
)
def test_a_header_within_a_second_is_the_hosts(distance, clock, shift):
    """A second away and more, on either side, it is another clock and is shifted by the distance."""
    choice = choose_clock("wrench", by_lag(np.full(100, distance)))
    assert (choice.clock, choice.shift_ns) == (clock, shift)
    assert (choice.t_ns == LOG - distance + shift).all()


def test_the_shift_is_the_middle_distance():
    """Of the distances 2, 3, 4, 5 and 9 s and more it is 4 s, of six the fourth; it is said in seconds."""
    lag = 10**6 * SECOND + np.array([9, 2, 5, 3, 4]) * MS
    choice = choose_clock("wrench", by_lag(lag))
    assert choice.shift_ns == 10**6 * SECOND + 4 * MS
    assert "is 1000000.004 s from the host's" in choice.findings[0].message
    assert (choice.findings[0].count, choice.findings[0].stream) == (5, "wrench")
    assert choose_clock("wrench", by_lag([*lag, lag[0]])).shift_ns == 10**6 * SECOND + 5 * MS
    many = np.random.default_rng(0).permutation(1001) * 1000
    assert choose_clock("wrench", by_lag(10**6 * SECOND + many)).shift_ns == 10**6 * SECOND + 500_000


def test_a_stated_offset_that_was_not_added_is_said():
    """Its size is in seconds, and the reason for the log time stands before it."""
    offset = 10**6 * SECOND
    [alone] = choose_clock("wrench", Stamps(LOG, LOG), "auto", offset).findings
    assert "log time taken, there are no header stamps; the stated offset of +1000000.000 s" in alone.message
    [unset] = choose_clock("wrench", Stamps(LOG, None, np.zeros(100, np.int64)), "auto", offset).findings
    assert "100 of 100 header stamps are not set; the stated offset of +1000000.000 s" in unset.message
    assert choose_clock("wrench", Stamps(LOG), "auto", offset).findings == ()


def jump_of(lag, log=None):
    """The finding of a header clock that jumps; empty where the header is taken."""
    return "".join(finding.message for finding in choose_clock("wrench", by_lag(lag, log=log)).findings)


@pytest.mark.parametrize("row", [1, 500, 999])
def test_a_header_that_jumps_for_good_is_refused(row):
    """A header that jumps by over 0.2 s and two messages is refused, before the last message or after the first."""
    lag = np.full(1000, 3 * MS)
    lag[row:] -= 300 * MS
    few = np.full(1000, 3 * MS)
    if row == 500:
        few[500:505] -= 500 * MS
        # the log has a pause where the header comes back
        log = START + np.arange(1000) * 10 * MS + np.where(np.arange(1000) >= 505, 500 * MS, 0)
        assert "jumps by +0.250 s" in jump_of(few, log)
        return
    assert "jumps by +0.300 s" in jump_of(lag)


def test_a_jump_that_is_taken_back_soon_is_none():
    """Of the ten messages after it, five come back: by half of 0.3 s the header stays ahead, which is no jump."""
    lag = np.full(1000, 3 * MS)
    lag[500:505] -= 300 * MS
    log = START + np.arange(1000) * 10 * MS + np.where(np.arange(1000) >= 505, 300 * MS, 0)
    assert jump_of(lag, log) == ""


@pytest.mark.parametrize(("ahead", "is_jump"), [(STEADY + 20 * MS, False), (STEADY + 20 * MS + 1, True)])
def test_a_jump_is_larger_than_two_messages_and_what_is_steady(ahead, is_jump):
    """Of messages every 10 ms, 220 ms ahead at once are no jump, and a nanosecond more is one."""
    lag = np.zeros(1000, np.int64)
    lag[990:] -= ahead
    assert bool(jump_of(lag)) == is_jump


@pytest.mark.parametrize(("stays", "is_jump"), [(STEADY, False), (STEADY + 1, True)])
def test_a_jump_stays_by_more_than_what_is_steady(stays, is_jump):
    """Ahead by 0.3 s at once, and by 0.2 s from the next message on, is no jump; a nanosecond more is one."""
    lag = np.zeros(1000, np.int64)
    lag[990:] -= stays
    lag[990] = -300 * MS
    log = START + np.arange(1000) * 10 * MS + np.where(np.arange(1000) > 990, 100 * MS, 0)
    assert bool(jump_of(lag, log)) == is_jump


def test_a_large_jump_is_said_in_seconds():
    """A million seconds are a million seconds, to the millisecond."""
    lag = np.zeros(1000, np.int64)
    lag[990:] -= 10**6 * SECOND
    assert "jumps by +1000000.000 s" in jump_of(lag)


def test_two_messages_of_a_slow_header_do_not_jump():
    """A header whose steps are 0.21 s may be 0.21 s ahead of a log that wrote two messages at once."""
    log = np.array([START, START])
    assert choose_clock("wrench", Stamps(log, None, log + np.array([0, 210 * MS]))).clock == "header"


@pytest.mark.parametrize("preference", ["auto", "header", "publish", "log"])
@pytest.mark.parametrize("offset_ns", [9 * 10**18, -9 * 10**18])
def test_an_offset_beyond_64_bits_is_refused(preference, offset_ns):
    """Times of today with such an offset would wrap into another millennium; of a clock that began at 0 they do not."""
    t_ns = np.sign(offset_ns) * (START + np.arange(5) * MS)
    only = Stamps(t_ns, None, None)
    with pytest.raises(BrokenLog, match=f"wrench: its stated offset of {offset_ns} ns .* 64 bits"):
        choose_clock("wrench", only, preference, offset_ns)
    boot = Stamps(np.arange(5) * MS, None, None)
    assert (choose_clock("wrench", boot, preference, offset_ns).t_ns == boot.log + offset_ns).all()


def test_what_is_said_of_the_order_of_times():
    """Counts of repeated and of backward samples, and the largest step back in milliseconds.

    Times that stand twice are counted in order, also where they stood apart.
    """
    order, said = time_order("wrench", START + np.array([0, 5, 5, 4 * 10**15, 0, 0, 3]))
    assert order.tolist() == [0, 4, 5, 6, 1, 2, 3]
    assert [(one.code, one.count, one.stream, one.severity) for one in said] == [
        ("duplicate-stamps", 3, "wrench", "warning"),
        ("time-order", 1, "wrench", "warning"),
    ]
    assert "3 of 7 samples have the time of the sample before" in said[0].message
    assert "by up to 4000000000.0 ms; sorted" in said[1].message
    assert time_order("wrench", START + np.array([1, 0]))[1][0].count == 1
