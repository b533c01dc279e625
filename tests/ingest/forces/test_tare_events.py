"""Stated tare events in readings of a few numbers: where they are, how large, and when they are not believed."""

import numpy as np
import pytest

from tactiledata.ingest.forces.tare_events import (
    LATENCY,
    LONGEST_AGO,
    Tare,
    contradicted_findings,
    locate_tares,
    tares_near,
    without_steps,
)

START = 1_700_000_000_000_000_000
MS = 1_000_000


def made(levels, step=10 * MS):
    """Times and loads whose fz is at a level for so many samples each, and the first rows of the levels."""
    fz = np.concatenate([np.full(count, float(level)) for level, count in levels])
    load = np.zeros((len(fz), 6))
    load[:, 2] = fz
    return START + np.arange(len(fz)) * step, load


def located(t_ns, load, moments, noise=0.0, zeros=None):
    """Row and step along z of the events that are believed, and the moments of the others, ns from the start."""
    moments = [START + int(moment) for moment in moments]
    zeros = np.zeros((len(moments), 6)) if zeros is None else zeros
    tares, contradicted = locate_tares(t_ns, load, moments, zeros, noise)
    return [(tare.row, round(float(tare.step[2]), 9)) for tare in tares], [moment - START for moment in contradicted]


def test_an_event_is_where_the_reading_jumps_to_zero():
    """The stated moment may be 0.1 s before or after; farther from it the reading is not zero, or does not jump."""
    t_ns, load = made([(5, 50), (0, 50)])
    for off in (-100, -50, 0, 50, 90):
        assert located(t_ns, load, [500 * MS + off * MS]) == ([(50, -5.0)], []), off
    assert located(t_ns, load, [500 * MS - LATENCY - 1]) == ([], [399_999_999])
    # without a jump in reach, the first sample after the moment
    assert located(t_ns, load, [500 * MS + LATENCY + 1]) == ([(61, 0.0)], [])
    assert located(t_ns, load, [500 * MS + LATENCY]) == ([(50, -5.0)], [])


def test_events_before_the_first_and_after_the_last_sample():
    """The first holds from row 0 on, whatever is read there; the other says nothing."""
    t_ns, load = made([(5, 20)])
    assert located(t_ns, load, [-1]) == ([(0, 0.0)], [])
    assert located(t_ns, load, [0]) == ([(0, 0.0)], [])
    assert located(t_ns, load, [190 * MS + 1]) == ([], [])
    assert located(t_ns, load, [190 * MS]) == ([], [190 * MS])
    assert located(t_ns[:0], load[:0], [5]) == ([], [])


def test_each_event_has_its_own_zero_and_events_are_sorted():
    """The load of a reading of zero belongs to its moment, however the moments are listed."""
    t_ns, load = made([(5, 50), (1, 50), (-2, 50)])
    zeros = np.zeros((3, 6))
    zeros[:, 2] = [-2, 7, 1]
    tares, contradicted = locate_tares(t_ns, load, [START + 1000 * MS, START - 5, START + 500 * MS], zeros, 0.0)
    assert [(tare.row, tare.zero[2], round(tare.step[2], 9)) for tare in tares] == [
        (0, 7, 0), (50, 1, -4), (100, -2, -3),
    ]  # fmt: skip
    assert contradicted == []
    assert all(tare.zero.shape == tare.step.shape == (6,) for tare in tares)


def test_rows_that_are_not_known_count_in_the_rows_of_events():
    """The row of an event is that of the whole signal."""
    t_ns, load = made([(5, 50), (0, 50)])
    load[[3, 20, 49], 4] = np.nan
    assert located(t_ns, load, [500 * MS]) == ([(50, -5.0)], [])


def test_a_jump_is_larger_than_noise():
    """Six standard deviations of a norm of three components: what is less is where it was stated."""
    t_ns, load = made([(1.05, 50), (0.0, 50)])
    clear = 6 * 0.1 * np.sqrt(3)
    assert 1.03 < clear < 1.05
    assert located(t_ns, load, [530 * MS], 0.1)[0][0][0] == 50
    t_ns, load = made([(1.03, 50), (0.0, 50)])
    assert located(t_ns, load, [530 * MS], 0.1)[0][0][0] == 53


def test_the_largest_jump_towards_zero_is_the_event():
    """The event is the largest jump towards zero, not one away from zero, and not along a torque."""
    t_ns, load = made([(3, 45), (9, 5), (4, 3), (0, 47)])
    load[:40, 3] = 50
    assert located(t_ns, load, [500 * MS])[0][0][0] == 50
    t_ns, load = made([(-3, 45), (-2, 5), (0, 50)])
    assert located(t_ns, load, [450 * MS])[0][0][0] == 50


@pytest.mark.parametrize(
    ("level", "noise", "is_zero"), [(0.5, 0, True), (0.51, 0, False), (0.62, 0.06, True), (0.63, 0.06, False)]
)
def test_a_reading_is_zero_within_half_a_newton(level, noise, is_zero):
    """A reading is zero within half a newton, or within six standard deviations of a norm if those are more."""
    t_ns, load = made([(9, 50), (level, 50)])
    rows, contradicted = located(t_ns, load, [500 * MS], noise)
    assert (len(rows), len(contradicted)) == (int(is_zero), int(not is_zero))


def test_a_jump_is_towards_the_load_of_a_reading_of_zero():
    """A jump from -3 N to 3 N counts if the latter is a reading of zero."""
    t_ns, load = made([(-3, 50), (3, 50)])
    zeros = np.zeros((1, 6))
    zeros[0, 2] = 3
    assert located(t_ns, load, [530 * MS], zeros=zeros) == ([(50, 6.0)], [])


def test_a_reading_that_is_zero_for_a_moment_was_zeroed():
    """The nearest sample within 0.1 s counts, and none after it."""
    t_ns, load = made([(9, 50), (4, 10), (0, 1), (4, 40)])
    assert located(t_ns, load, [400 * MS]) == ([], [400 * MS])
    assert len(located(t_ns, load, [500 * MS])[0]) == 1
    load[60, 2], load[61, 2] = 4, 0
    assert located(t_ns, load, [500 * MS]) == ([], [500 * MS])


def test_where_no_sample_is_near_nobody_knows():
    """Over a pause of more than 0.1 s before the event's sample the event is believed."""
    t_ns, load = made([(9, 50), (4, 50)])
    for pause, is_believed in ((90 * MS, False), (90 * MS + 1, True)):
        times = t_ns + np.where(np.arange(100) >= 50, pause, 0)
        assert bool(located(times, load, [495 * MS])[0]) == is_believed


def test_a_step_by_hand():
    """Ten samples on either side; what happens farther away does not matter."""
    t_ns, load = made([(1, 40), (5, 10), (0, 10), (55, 40)])
    assert located(t_ns, load, [500 * MS]) == ([(50, -5.0)], [])
    for row in (40, 59):
        one = load.copy()
        one[row, 2] += 0.5
        assert located(t_ns, one, [500 * MS])[0][0][1] != -5.0


def test_a_press_on_the_way_is_no_part_of_the_step():
    """A load that rises steadily through the event steps by 5 N; of three samples a side the slope is known."""
    for count in (3, 10):
        t_ns, load = made([(5, count), (0, count)])
        load[:, 2] += 0.1 * (np.arange(2 * count) - count)
        assert located(t_ns, load, [count * 10 * MS])[0] == [(count, -5.0)]


def test_of_two_samples_a_side_only_levels_are_compared():
    """A slope would follow the noise: the step is the difference of the means."""
    for before, after in ((2, 10), (10, 2), (1, 10), (10, 1)):
        t_ns, load = made([(5, before), (0, after)])
        load[:, 2] += 0.1 * (np.arange(before + after) - before)
        expected = -5.0 + 0.1 * ((after - 1) / 2 + (before + 1) / 2)
        assert located(t_ns, load, [before * 10 * MS])[0] == [(before, round(expected, 9))]


@pytest.mark.parametrize(("pause", "is_left_out"), [(240 * MS, False), (240 * MS + 1, True)])
def test_samples_beyond_a_pause_do_not_count(pause, is_left_out):
    """Longer than a quarter of a second before or after the event; the pause at the event itself does not matter."""
    for side in (48, 52):
        t_ns, load = made([(5, 50), (0, 50)])
        load[:48, 2] += 1.5
        load[52:, 2] -= 1.5
        times = t_ns + np.where(np.arange(100) >= side, pause, 0)
        if side == 48:
            load[52:, 2] += 1.5
        else:
            load[:48, 2] -= 1.5
        moment = int(times[50]) - START
        assert (located(times, load, [moment])[0] == [(50, -5.0)]) == is_left_out


def test_of_two_samples_behind_a_pause_only_levels_are_compared():
    """The slope of what lies before the pause is of another time; of several pauses the nearest counts."""
    t_ns, load = made([(5, 50), (0, 50)])
    load[:, 2] += 0.01 * (np.arange(100) - 50)
    for pauses in ((48,), (44, 48), (48, 53), (44, 48, 53, 56)):
        times = t_ns + sum(np.where(np.arange(100) >= row, 300 * MS, 0) for row in pauses)
        after = (53 if 53 in pauses else 60) - 50
        expected = -5.0 + 0.01 * ((after - 1) / 2 + 1.5)
        assert located(times, load, [int(times[50]) - START])[0] == [(50, round(expected, 9))], pauses


def test_a_pause_at_the_event_is_crossed():
    """Rows on both sides of the event count, however far apart they are."""
    t_ns, load = made([(5, 50), (0, 50)])
    times = t_ns + np.where(np.arange(100) >= 50, 10**9, 0)
    assert located(times, load, [int(times[50]) - START]) == ([(50, -5.0)], [])


def test_two_events_do_not_share_a_row():
    """The second begins after the first, and its step is measured from there."""
    t_ns, load = made([(5, 50), (2, 5), (0, 45)])
    zeros = np.zeros((2, 6))
    zeros[0, 2] = 2
    first, second = located(t_ns, load, [400 * MS, 650 * MS], zeros=zeros)[0]
    assert (first[0], second) == (50, (55, -2.0))
    assert [row for row, _ in located(t_ns, load, [650 * MS, 650 * MS])[0]] == [55, 56]


def events(wrong, right):
    """Moments of which some are at readings of 4 N, and the others at jumps to zero or where it is zero."""
    levels = [(4, 30), *[(4, 30)] * wrong]
    for _ in range(right):
        levels += [(6, 30), (0, 30)]
    t_ns, load = made(levels)
    at = [300 * MS * number + 150 * MS for number in range(1, wrong + 1)]
    first = 300 * MS * (wrong + 1)
    return t_ns, load, at, [first + 600 * MS * number + 300 * MS for number in range(right)]


@pytest.mark.parametrize(("wrong", "right", "kept"), [(2, 2, 1), (3, 2, 0), (3, 10, 0), (3, 11, 1), (3, 12, 1)])
def test_a_list_that_is_wrong_often_is_believed_only_where_it_is_seen(wrong, right, kept):
    """From three wrong events, and more than a fifth, on: an event at a zero without a jump is then refused, too."""
    t_ns, load, at, jumps = events(wrong, right)
    quiet = jumps[-1] + 200 * MS
    load[quiet // (10 * MS) :, 3] += 50  # a torque is no jump
    rows, contradicted = located(t_ns, load, [*at, *jumps, quiet])
    assert len(rows) == right + kept
    assert contradicted == [*at, *[quiet] * (not kept)]


@pytest.mark.parametrize(("level", "is_seen"), [(1.03, False), (1.05, True)])
def test_in_a_doubted_list_a_jump_is_larger_than_noise(level, is_seen):
    """Six standard deviations of a norm; those before and after it are judged for themselves."""
    t_ns, load = made([*[(4, 30)] * 4, (0, 30), (level, 30), (0, 30), (5, 30), (0, 30)])
    wrong = [150 * MS, 450 * MS, 750 * MS]
    rows, contradicted = located(t_ns, load, [*wrong, 1800 * MS, 2400 * MS], 0.1)
    assert [row for row, _ in rows] == [180, 240][not is_seen :]
    assert contradicted == [*wrong, *[1800 * MS] * (not is_seen)]


def test_an_event_may_jump_between_the_first_two_samples():
    """And where no sample is within reach of it, it is at the first one after it."""
    t_ns, load = made([(5, 1), (0, 50)])
    assert located(t_ns, load, [20 * MS])[0][0][0] == 1
    t_ns, load = made([(5, 2), (0, 3)], 500 * MS)
    assert located(t_ns, load, [750 * MS])[0][0][0] == 2
    assert located(t_ns, load, [1250 * MS])[0][0][0] == 3


def test_moments_within_a_day_are_near():
    """A day before the first sample and a day after the last; a nanosecond farther they are another's."""
    t_ns = START + np.arange(3) * MS
    stated = [
        START - LONGEST_AGO - 1,
        START - LONGEST_AGO,
        START + 2 * MS + LONGEST_AGO,
        START + 2 * MS + LONGEST_AGO + 1,
    ]
    is_near, [finding] = tares_near(t_ns, stated)
    assert is_near.tolist() == [False, True, True, False]
    assert (finding.code, finding.severity, finding.stream, finding.count) == ("tare-elsewhere", "warning", "wrench", 2)
    assert f"for example {stated[0]}, where the wrench begins at {START})" in finding.message
    assert "look like" not in finding.message
    assert LONGEST_AGO == 24 * 3600 * 10**9
    assert tares_near(t_ns, stated[1:3])[1] == []
    assert tares_near(t_ns[:0], stated)[0].tolist() == [True] * 4
    assert tares_near(t_ns, [])[0].tolist() == []


@pytest.mark.parametrize(("unit", "factor"), [("seconds", 10**9), ("milliseconds", 10**6), ("microseconds", 10**3)])
def test_moments_in_another_unit_are_known(unit, factor):
    """A unit is known if all far moments lie within the day in that unit, and not if one does not."""
    t_ns = START + np.arange(3) * MS
    moments = [START // factor, START // factor + 5]
    assert f"these look like {unit}." in tares_near(t_ns, moments)[1][0].message
    edges = [(START - LONGEST_AGO) // factor, (START + LONGEST_AGO) // factor]
    assert f"these look like {unit}" in tares_near(t_ns, edges)[1][0].message
    assert "look like" not in tares_near(t_ns, [*moments, 5])[1][0].message


def test_steps_are_taken_off_inside_a_trajectory_only():
    """Steps are taken off from the event's row on, for events after the first row and before the end; loads stay."""
    _, load = made([(0, 10)])
    before = load.copy()
    tares = [make_tare(row, step) for row, step in ((2, 9.0), (4, 1.0), (6, 2.0), (8, 9.0))]
    assert without_steps(load, tares, 2, 8)[:, 2].tolist() == [0, 0, -1, -1, -3, -3]
    np.testing.assert_array_equal(load, before)


def make_tare(row, step):
    return Tare(row, np.zeros(6), np.array([0, 0, step, 0, 0, 0]))


def test_events_that_are_not_seen_are_said():
    """Events that are not seen are said with the first and the last of them; none says nothing."""
    assert contradicted_findings([]) == []
    [finding] = contradicted_findings([START + 5, START + 2, START + 9])
    assert (finding.code, finding.severity, finding.stream) == ("tare-not-seen", "warning", "wrench")
    assert (finding.start_ns, finding.end_ns, finding.count) == (START + 2, START + 9, 3)
    assert "3 stated tare events are not seen: the reading is not zero within 0.1 s" in finding.message
