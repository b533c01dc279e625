"""Pauses and jumps of a clock at the borders of their rules."""

import numpy as np
import pytest

from tactiledata.ingest.clocks.clock_steps import (
    BLOCK,
    CROWDED,
    MOST_BLOCKS,
    MOST_STEPS,
    _displaced_blocks,
    _displacement,
    _runs_again,
    judge_steps,
)
from tactiledata.ingest.clocks.witnesses import (
    AGREE,
    IMAGES,
    LEAST_STEP,
    PERIODS,
    SIGNAL,
    STAMPS,
    SURE,
    TRAJECTORIES,
    Witness,
    _is_beyond,
    _returning,
    jumps_by_vote,
    pauses_of,
    shares_pause,
    usual_distance,
)

START = 1_700_000_000_000_000_000
MS, SECOND = 1_000_000, 1_000_000_000


def times(*steps_ms):
    """Times from steps in ms."""
    return START + np.concatenate([[0], np.cumsum(np.rint(np.array(steps_ms) * MS).astype(np.int64))]).astype(np.int64)


def values(count):
    return np.arange(count, dtype=float)[:, None]


def stretch(*pieces):
    """Times (n,) in ms, every 10 ms from the first to before the last of each piece."""
    return START + np.concatenate([np.arange(first, last, 10) for first, last in pieces]) * MS


def witness(rank, first_ms, last_ms, pauses=()):
    return Witness(rank, START + first_ms * MS, START + last_ms * MS, tuple(pauses))


def judged(t_ns, *witnesses):
    """Rows that are left out, and the findings."""
    found = judge_steps("wrench", t_ns, values(len(t_ns)), witnesses)
    return np.flatnonzero(~found.kept).tolist(), found.findings


def test_the_rules_in_numbers():
    """Steps are 0.3 s and 20 periods, of the 8 largest pauses and 64 largest steps; stretches have 10 samples."""
    assert (LEAST_STEP, PERIODS, MOST_STEPS, MOST_BLOCKS, BLOCK) == (300 * MS, 20, 8, 64, 10)
    assert (AGREE, SURE, CROWDED) == (250 * MS, SECOND, 1.5)
    assert (STAMPS, SIGNAL, IMAGES, TRAJECTORIES) == (0, 1, 2, 3)


def test_the_usual_distance_is_of_samples_in_order():
    """The median of steps forward, down to a nanosecond; 0 where there is none."""
    assert usual_distance(times(10, 0, 0, 0, -50, 30, 20)) == 20 * MS
    assert usual_distance(np.array([5, 6, 7])) == 1
    assert usual_distance(times(0, -10)) == usual_distance(times()) == 0
    assert usual_distance(times()[:0]) == 0


def test_pauses_are_longer_than_the_limit():
    """0.3 s, or 20 periods; with their place, in the order of the stream; steps back are none."""
    assert pauses_of(times(10, 10, 300, 10)) == ()
    assert pauses_of(times(10, 10, 300 + 1e-6, 10, 400)) == (
        (START + 20 * MS, 300 * MS + 1), (START + 330 * MS + 1, 400 * MS),
    )  # fmt: skip
    assert pauses_of(times(50, 50, 50, 1000)) == ()
    assert pauses_of(times(50, 50, 50, 1000 + 1e-6)) == ((START + 150 * MS, SECOND + 1),)
    assert pauses_of(times(10, 10, 10, -5000)) == ()


@pytest.mark.parametrize(("step", "is_jump"), [(300, False), (300 + 1e-6, True)])
def test_a_jump_is_longer_than_the_limit(step, is_jump):
    """A step of 0.3 s is none, and a nanosecond more that no other stream has is one."""
    t_ns = times(*[10] * 100, step, *[10] * 100)
    off, said = judged(t_ns, witness(SIGNAL, 0, 2010))
    # what is off by less than 0.3 s is kept: the jump is said, and loses nothing
    assert off == []
    assert [one.code for one in said] == (["clock-jump"] if is_jump else [])
    assert all((one.start_ns, one.end_ns, one.count) == (None, None, 0) for one in said)


@pytest.mark.parametrize(("step", "is_jump"), [(1000, False), (1000 + 1e-6, True)])
def test_a_jump_of_a_slow_stream_is_longer_than_twenty_periods(step, is_jump):
    """Of samples every 50 ms a second is none."""
    t_ns = times(*[50] * 100, step, *[50] * 100)
    off, _ = judged(t_ns, witness(SIGNAL, 0, 10_050))
    assert off == (list(range(101, 202)) if is_jump else [])


def test_what_is_said_of_jumps():
    """Sizes and places in seconds, five of them; how many samples are lost, and where they belong."""
    t_ns = times(*([10] * 200 + [2010]) * 6, *[10] * 200)
    off, [finding] = judged(t_ns, witness(SIGNAL, 0, int((t_ns[-1] - START) // MS) - 12_000))
    assert off == list(range(201, len(t_ns)))
    assert (finding.code, finding.severity, finding.stream, finding.count) == ("clock-jump", "damage", "wrench", 1206)
    assert "(+2.000 s after 2.000 s, +2.000 s after 6.010 s, " in finding.message
    assert finding.message.count("s after") == 5
    assert "the 1206 samples whose time is off were left out" in finding.message
    assert (finding.start_ns, finding.end_ns) == (t_ns[201] - 2000 * MS, t_ns[-1] - 12_000 * MS)
    far = times(*[10] * 200, 10 + 10**9, *[10] * 200)
    assert "(+1000000.000 s after 2.000 s)" in judged(far, witness(SIGNAL, 0, 4010))[1][0].message
    early = times(*[10**7] * 200, 10**9 + 10**7, *[10**7] * 200)
    assert "(+1000000.000 s after 2000000.000 s)" in judged(early, witness(SIGNAL, 0, 401 * 10**7))[1][0].message


def test_a_pause_that_cannot_be_judged_is_said_with_its_place():
    """The largest of several, with how many there are; nothing is left out."""
    t_ns = times(*[10**7] * 50, 10**9, *[10**7] * 50, 10**9 + 10**7, *[10**7] * 50)
    off, [finding] = judged(t_ns)
    assert off == []
    assert (finding.code, finding.severity, finding.stream, finding.count) == ("pause-or-jump", "warning", "wrench", 2)
    assert "no samples for 1000000.000 s, 2000000.000 s after its start" in finding.message
    assert (finding.start_ns, finding.end_ns) == (t_ns[101], t_ns[102])


def test_of_many_pauses_the_largest_eight_are_judged():
    """A jump among nine pauses is found where it is one of the eight largest."""
    for lengths in ([400] * 8 + [5000], [5000] + [400] * 8, [400] * 4 + [5000] + [400] * 4):
        t_ns = times(*[step for length in lengths for step in (*[10] * 50, 10 + length)], *[10] * 50)
        last = int((t_ns[-1] - START) // MS) - 5000
        off, _ = judged(t_ns, witness(SIGNAL, 0, last))
        row = 51 * (lengths.index(5000) + 1)
        assert off == list(range(row, len(t_ns)))


@pytest.mark.parametrize("beside", [295, -295], ids=["a little longer", "a little shorter"])
def test_pauses_that_another_shares_are_looked_at_last(beside):
    """Nine pauses of 3 s that a signal shares, and a jump of 1 s that it does not: the jump is among the eight.

    A pause is shared where its length agrees within 0.3 s, whatever the distance of samples is.
    """
    steps = np.full(2000, 10)
    for row in range(100, 1000, 100):
        steps[row] = 3000
    t_ns = times(*steps)
    pauses = [(int(t_ns[row]), (2990 + beside) * MS) for row in range(100, 1000, 100)]
    jumped = t_ns + np.where(np.arange(2001) > 1500, SECOND, 0)
    alone = witness(SIGNAL, 0, int(t_ns[-1] - START) // MS, pauses)
    assert judged(jumped, alone)[0] == list(range(1501, 2001))
    assert judged(t_ns, alone)[0] == []


def test_a_stretch_that_stands_elsewhere():
    """A stretch of ten samples and more is found, forward or back, by rows where the clock goes away and comes home."""
    for away in (5000, -5000):
        for count, found in ((10, {99, 109}), (9, set())):
            t_ns = stretch((0, 4000))
            t_ns[100 : 100 + count] += away * MS
            assert _displaced_blocks(t_ns, 300 * MS, 10 * MS) == found, (away, count)


def test_the_hole_of_a_stretch_is_as_long_as_it():
    """Within three periods or a tenth: a stretch of 1 s in a hole of 1.1 s stands elsewhere, in one of 1.2 s not."""
    for longer, found in ((0, {99, 200}), (100, {99, 200}), (101, set()), (-100, {99, 200}), (-101, set())):
        t_ns = stretch((0, 4010))
        t_ns[100:201] += 60_000 * MS
        t_ns[201:] += longer * MS
        assert _displaced_blocks(t_ns, 300 * MS, 10 * MS) == found, longer
    for longer, found in ((30, {99, 119}), (31, set())):
        t_ns = stretch((0, 4000))
        t_ns[100:120] += 60_000 * MS
        t_ns[120:] += longer * MS
        assert _displaced_blocks(t_ns, 300 * MS, 10 * MS) == found, longer


def test_a_stretch_in_a_hole_of_its_stream_came_late():
    """Up to two samples may stand at its time; three, or a place beyond the stream, mean that its clock was off."""
    for there, found in ((0, set()), (2, set()), (3, {99, 199})):
        # rows of 1000 to 1990 ms stand at 3000 to 3990 ms, where nearly nothing else stands
        t_ns = stretch((0, 1000), (3000, 4000), (2000, 3000), (3000, 3000 + 10 * there), (4000, 5000))
        assert _displaced_blocks(t_ns, 300 * MS, 10 * MS) == found, there
    assert _displaced_blocks(stretch((0, 1000), (7000, 8000), (2000, 3000)), 300 * MS, 10 * MS) == {99, 199}
    assert _displaced_blocks(stretch((5000, 6000), (2000, 3000), (7000, 8000)), 300 * MS, 10 * MS) == {99, 199}


def test_small_steps_and_steps_of_one_direction_make_no_stretch():
    """Two pauses around a stretch, or two steps back, make no stretch."""
    assert _displaced_blocks(stretch((0, 1000), (3000, 4000), (6000, 7000)), 300 * MS, 10 * MS) == set()
    assert _displaced_blocks(stretch((6000, 7000), (3000, 4000), (0, 1000)), 300 * MS, 10 * MS) == set()
    assert _displaced_blocks(stretch((0, 1000)), 300 * MS, 10 * MS) == set()


def test_all_stretches_are_found():
    """One after another, whatever lies between them."""
    t_ns = stretch((0, 9000))
    for first in (100, 300, 500):
        t_ns[first : first + 50] += 60_000 * MS
    assert _displaced_blocks(t_ns, 300 * MS, 10 * MS) == {99, 149, 299, 349, 499, 549}
    t_ns[200:203] -= 60_000 * MS
    assert _displaced_blocks(t_ns, 300 * MS, 10 * MS) == {99, 149, 299, 349, 499, 549}


def test_of_many_stretches_those_of_the_largest_steps_are_found():
    """Of 33 stretches the one that is nearest to its place is not looked at."""
    t_ns = stretch((0, 33 * 800))
    for number in range(33):
        t_ns[80 * number + 40 : 80 * number + 60] += (2000 if number == 7 else 5000) * MS
    borders = [80 * number + row for number in range(33) if number != 7 for row in (39, 59)]
    assert sorted(_displaced_blocks(t_ns, 300 * MS, 10 * MS)) == borders


def runs(t_ns, row, held=None):
    return _runs_again(t_ns, values(len(t_ns)) if held is None else held, row, 10 * MS)


def test_a_stretch_of_time_that_stands_twice():
    """Behind a step back by 1 s the second stands twice; rows that come late into a hole stand once."""
    assert runs(stretch((0, 3000), (2000, 5000)), 299)
    assert not runs(stretch((0, 1000), (2000, 3000), (1000, 2000), (3000, 4000)), 199)
    # half of the stretch twice: 1.5 times the samples
    assert runs(stretch((0, 3000), (1990, 2490), (2990, 3500)), 299)
    assert not runs(stretch((0, 3000), (1990, 2430), (2990, 3500)), 299)
    assert not runs(stretch((0, 10), (0, 10)), 0)


def test_copies_of_rows_do_not_stand_twice():
    """Rows with equal times and values, of more than nine tenths of what comes after, were written twice."""
    t_ns = stretch((0, 3000), (2000, 3000))
    held = np.concatenate([np.arange(300), np.arange(200, 300)])[:, None].astype(float)
    assert not runs(t_ns, 299, held)
    held[250] = np.nan
    assert runs(t_ns, 299, held)
    held[350] = np.nan
    assert not runs(t_ns, 299, held)
    shifted = t_ns.copy()
    shifted[389:] += 1
    assert runs(shifted, 299, held)
    shifted = t_ns.copy()
    shifted[390:] += 1
    assert not runs(shifted, 299, held)


def test_a_pause_at_the_same_moment_is_shared():
    """A pause is shared if place and length agree within 0.3 s."""
    one = Witness(SIGNAL, 0, 10**12, ((5 * SECOND, SECOND), (9 * SECOND, 3 * SECOND)))
    near = 300 * MS - 1
    for place, step, is_shared in (
        (0, 0, True), (near, 0, True), (-near, near, True), (near, -near, True), (near + 1, 0, False),
        (-near - 1, 0, False), (0, near + 1, False), (0, -near - 1, False), (4 * SECOND, 2 * SECOND, True),
        (4 * SECOND, 0, False),
    ):  # fmt: skip
        assert shares_pause(one, 5 * SECOND + place, SECOND + step) == is_shared, (place, step)
    assert not shares_pause(Witness(SIGNAL, 0, 10**12), 5 * SECOND, SECOND)


def test_steps_back_take_the_step_forward_before_them_back():
    """The last one before it that is as large within 0.25 s; none behind it."""
    size = {10: 5 * SECOND, 20: 5 * SECOND, 30: -5 * SECOND, 40: 5 * SECOND}
    assert _returning(size, [10, 20, 40], [30]) == {20, 30}
    for off, found in ((250 * MS - 1, {10, 30}), (250 * MS, {30}), (1 - 250 * MS, {10, 30}), (-250 * MS, {30})):
        assert _returning({10: 5 * SECOND + off, 30: -5 * SECOND}, [10], [30]) == found
    assert _returning(size, [40], [30]) == {30}
    assert _returning(size, [10], []) == set()


def test_what_is_off_is_so_from_the_jump_on():
    """A stream is off from the jump on, or before it if only its end fits the first witness that tells."""
    t_ns = stretch((0, 10_000))
    ahead = _displacement(t_ns, {499: 2 * SECOND}, [witness(SIGNAL, 0, 7990)])
    assert (ahead // SECOND).tolist() == [0] * 500 + [2] * 500
    behind = _displacement(t_ns, {499: 2 * SECOND}, [witness(SIGNAL, 2000, 9990)])
    assert (behind // SECOND).tolist() == [-2] * 500 + [0] * 500
    two = _displacement(t_ns, {299: 2 * SECOND, 599: -SECOND}, [])
    assert (two // SECOND).tolist() == [0] * 300 + [2] * 300 + [1] * 400
    # both ends fit, or none: the next witness tells
    undecided = [witness(STAMPS, 0, 9990), witness(STAMPS, 50_000, 90_000)]
    late = [witness(IMAGES, 0, 7990), witness(SIGNAL, 2000, 9990)]
    assert _displacement(t_ns, {499: 2 * SECOND}, [*late, *undecided])[0] == -2 * SECOND


@pytest.mark.parametrize(("total", "tolerance"), [(2000, 250), (2500, 250), (4000, 400)])
def test_ends_fit_within_a_quarter_second_or_a_tenth(total, tolerance):
    """Ends fit within a quarter of a second or a tenth of the whole displacement."""
    t_ns = stretch((0, 10_000))
    for sign in (1, -1):
        for off, first in ((tolerance, -total), (tolerance + 1, 0)):
            found = _displacement(t_ns, {499: total * MS}, [witness(SIGNAL, 50_000, 9990 + sign * off)])
            assert found[0] == first * MS
            found = _displacement(t_ns, {499: -total * MS}, [witness(SIGNAL, sign * off, 50_000)])
            assert found[0] == 0
    assert _displacement(t_ns, {499: total * MS}, [witness(SIGNAL, tolerance + 1, 9990)])[0] == -total * MS
    assert _displacement(t_ns, {499: total * MS}, [witness(SIGNAL, tolerance, 9990)])[0] == 0


def jumps(witnesses, steps=(5000,), back=()):
    """Numbers of the steps that are jumps, and whether that is known."""
    row, t, moments, size, forward, backward = 0, 0, [], {}, [], []
    for number, step in enumerate((*steps, None)):
        moments += range(t, t + 1000, 10)
        t += 1000
        if step is not None:
            row = 100 * (number + 1) - 1
            size[row] = step * MS
            (backward if number in back else forward).append(row)
            t += step
    found, is_known = jumps_by_vote(START + np.array(moments) * MS, size, forward, backward, witnesses)
    return sorted(row // 100 for row in found), is_known


def test_the_length_of_a_witness_tells_a_jump():
    """A stream that lasts 5 s longer jumped, one that lasts as long paused, anything else cannot be told."""
    assert jumps([witness(SIGNAL, 0, 1990)]) == ([0], True)
    assert jumps([witness(SIGNAL, 0, 6990)]) == ([], True)
    assert jumps([witness(SIGNAL, 0, 4000)]) == ([], False)
    assert jumps([]) == ([], False)
    assert jumps([witness(SIGNAL, 0, 1990), witness(SIGNAL, 0, 1990)], (5000, 2000)) == ([], False)
    assert jumps([witness(SIGNAL, 0, 2990 + 2000)], (5000, 2000)) == ([0], True)
    assert jumps([witness(SIGNAL, 0, 2990 + 5000)], (5000, 2000)) == ([1], True)
    assert jumps([witness(SIGNAL, 0, 2990)], (5000, 2000)) == ([0, 1], True)


@pytest.mark.parametrize(("step", "tolerance"), [(2000, 250), (5000, 500)])
def test_lengths_agree_within_a_quarter_second_or_a_tenth_of_the_largest_step(step, tolerance):
    """The lengths of a stream that jumped and of one that paused agree within these limits."""
    for off, is_known in ((tolerance, True), (tolerance + 1, False)):
        assert jumps([witness(SIGNAL, 0, 1990 + off)], (step,)) == ([0][: int(is_known)], is_known)
        assert jumps([witness(SIGNAL, 0, 1990 + step + off)], (step,)) == ([], is_known)


def test_a_step_back_is_never_a_pause():
    """It counts in every length, and where nobody can tell it takes the step before it back."""
    assert jumps([witness(SIGNAL, 0, 2990)], (5000, -5000), back=[1]) == ([0, 1], True)
    assert jumps([], (5000, -5000), back=[1]) == ([0, 1], False)
    assert jumps([], (2000, -5000), back=[1]) == ([1], False)
    assert jumps([witness(SIGNAL, 0, 4990)], (2000, -5000), back=[1]) == ([1], True)


def test_the_first_kind_of_witness_that_can_tell_decides():
    """Stamps before signals, those before images; among equals the most, and where those are half nobody."""
    jumped, paused, other = (0, 1990), (0, 6990), (0, 4000)
    assert jumps([witness(SIGNAL, *paused), witness(STAMPS, *jumped)]) == ([0], True)
    assert jumps([witness(IMAGES, *jumped), witness(SIGNAL, *paused)]) == ([], True)
    assert jumps([witness(SIGNAL, *jumped), witness(SIGNAL, *other)]) == ([0], True)
    assert jumps([witness(SIGNAL, *one) for one in (jumped, paused, jumped)]) == ([0], True)
    assert jumps([witness(SIGNAL, *one) for one in (paused, jumped, paused)]) == ([], True)
    assert jumps([witness(SIGNAL, *one) for one in (jumped, paused)]) == ([], False)
    assert jumps([witness(STAMPS, *other), witness(SIGNAL, *jumped)]) == ([0], True)


def test_a_witness_that_pauses_too_cannot_tell():
    """Where all signals halt together none is displaced; where one does, it is not asked about that step."""
    shared = ((START + 990 * MS, 5000 * MS),)
    assert jumps([witness(SIGNAL, 0, 6990, shared)]) == ([], True)
    assert jumps([witness(SIGNAL, 0, 6990, shared), witness(SIGNAL, 0, 4000)]) == ([], False)
    assert jumps([witness(SIGNAL, 0, 6990, shared)], (5000, 2000)) == ([], False)
    assert jumps([witness(SIGNAL, 0, 2990 + 5000, shared)], (5000, 2000)) == ([1], True)
    assert jumps([witness(SIGNAL, 0, 2990 + 7000, shared)], (5000, 2000)) == ([], True)


def test_a_pause_that_another_signal_shares_is_none_by_the_length_of_a_third():
    """The third signal may have been stopped early; where no signal shares the pause, its length tells a jump."""
    steps = np.full(1000, 10)
    steps[500] = 2010
    t_ns = times(*steps)
    pause = [(int(t_ns[500]), 2010 * MS)]
    shares, early = witness(SIGNAL, 0, 12_000, pause), witness(SIGNAL, 0, 10_000)
    assert judged(t_ns, shares, early)[0] == []
    assert judged(t_ns, early)[0] == list(range(501, 1001))


def test_stamps_and_signals_tell_of_every_step():
    """What does not begin and end when it likes is never beyond telling."""
    t_ns = stretch((0, 10_000))
    for rank in (STAMPS, SIGNAL):
        assert not _is_beyond(witness(rank, 0, 50_000), t_ns, 499, 100 * MS, [])


def test_trajectories_tell_of_steps_of_a_second():
    """Trajectories tell of steps of a second and of no shorter ones."""
    t_ns = stretch((0, 10_000))
    assert not _is_beyond(witness(TRAJECTORIES, 0, 50_000), t_ns, 499, SURE, [])
    assert _is_beyond(witness(TRAJECTORIES, 0, 50_000), t_ns, 499, SURE - 1, [])


def halted(step_ms, *others):
    """Whether images from a first to a last moment (ms) tell of a step at which all signals halt."""
    t_ns = stretch((0, 10_000))
    together = witness(SIGNAL, 0, 9990, [(int(t_ns[499]), step_ms * MS)])
    signals = [together, *others]
    return lambda first, last: not _is_beyond(witness(IMAGES, first, last), t_ns, 499, step_ms * MS, signals)


def test_images_tell_of_a_step_that_a_signal_does_not_share():
    """Whenever they begin and end."""
    assert halted(500, witness(SIGNAL, 0, 9990))(3000, 50_000)
    t_ns = stretch((0, 10_000))
    assert not _is_beyond(witness(IMAGES, 3000, 50_000), t_ns, 499, 500 * MS, [])
    assert not halted(500)(3000, 50_000)


@pytest.mark.parametrize(("step", "within"), [(500, 50), (999, 99), (1000, 250), (4000, 400)])
def test_images_tell_of_a_common_step_by_ends_that_fit(step, within):
    """They begin with the signals and end earlier by the step, or end with them and begin later by it."""
    tells = halted(step)
    end = 9990
    for sign in (1, -1):
        near, far = sign * within, sign * (within + 1)
        assert tells(near, end - step - near)
        assert not tells(far, end - step)
        assert not tells(0, end - step + far)
        assert tells(step + near, end - near)
        assert not tells(step + far, end)
        assert not tells(step, end + far)
    assert not tells(0, end)
