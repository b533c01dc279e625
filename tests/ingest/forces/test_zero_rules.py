"""The zero of a force sensor in readings of a few levels, at the borders of its rules."""

import itertools

import numpy as np
import pytest
from load_levels import MS, START, made

from tactiledata.ingest.forces.onset import component_noise, touch_threshold, touching
from tactiledata.ingest.forces.tare import find_zero, half_sample_mode
from tactiledata.ingest.forces.tare_events import locate_tares


def zeroed(levels, spans=(), tares=(), step=10 * MS, change=None):
    """The zero along z (n,), and the findings by code; spans and tares in rows."""
    t_ns, load = made(levels, step)
    if change is not None:
        change(load)
    named = [(f"t{number}", START + first * step, START + last * step) for number, (first, last) in enumerate(spans)]
    zero = find_zero(t_ns, load, named, [START + row * step for row in tares])
    return zero.bias[:, 2], {finding.code: finding for finding in zero.findings}


def runs(values):
    """A sequence of numbers as (value, count)."""
    values = np.round(values, 9)
    borders = [0, *(np.flatnonzero(np.diff(values)) + 1), len(values)]
    return [(float(values[a]), b - a) for a, b in itertools.pairwise(borders)]


@pytest.mark.parametrize(
    ("samples", "mode"),
    [
        ([], 0.0),
        ([np.nan], 0.0),
        ([5.0], 5.0),
        ([4.0, 1.0], 2.5),
        ([4.0, 1.0, 7.0], 4.0),
        ([9.0, 0.0, 1.0, 8.0], 0.5),
        ([0.0, 9.0, 8.0, np.inf, 4.0], 8.5),
        ([0, 10, 11, 12, 20], 11.0),
        ([0, 1, 10, 11, 11.5, 30], (10 + 11 + 11.5) / 3),
        ([0, 5, 6, 7, 7.25, 11, 20, 30], 7.125),
    ],
)
def test_the_densest_half_of_the_densest_half(samples, mode):
    """Worked out by hand: half of the samples, rounded up, that lie closest together, until three or fewer are left."""
    assert half_sample_mode(np.array(samples, float)) == pytest.approx(mode, rel=1e-12)


def test_noise_is_the_median_step_of_a_component():
    """Scaled to a standard deviation, and by the root of 2 of a difference; repeats and torques do not count."""
    load = np.zeros((4, 6))
    load[:, 0] = [0, 1, 1, 0]
    load[:, 1] = [0, 2, 2, 0]
    load[:, 2] = [0, 3, 3, 0]
    load[:, 4] = [0, 50, 9, 8]
    assert component_noise(load) == pytest.approx(2 / 0.6745 / np.sqrt(2), rel=1e-12)
    assert component_noise(np.zeros((4, 6))) == 0.0
    assert component_noise(np.zeros((0, 6))) == 0.0
    one_axis = np.zeros((3, 6))
    one_axis[:, 1] = [0, -4, 0]
    assert component_noise(one_axis) == 0.0


def test_the_threshold_of_touching():
    """The threshold is six standard deviations of a norm, and at least half a newton."""
    assert touch_threshold(0.0) == 0.5
    assert touch_threshold(1.0) == pytest.approx(6 * np.sqrt(3), rel=1e-12)


def test_contact_begins_above_the_threshold_and_ends_below_its_half():
    """At the threshold it does not begin, at its half it does not end; before any word there is none."""
    assert touching(np.array([0.3, 1.0, 1.1, 0.5, 0.49, 0.9, 1.1]), 1.0).tolist() == [
        False, False, True, True, False, False, True,
    ]  # fmt: skip
    assert touching(np.array([1.1, 0.6]), 1.0).tolist() == [True, True]
    assert touching(np.zeros(0), 1.0).tolist() == []


def test_the_zero_of_a_trajectory_is_its_free_air():
    """The median of the first half of what comes before the touch, for the trajectory alone; elsewhere the mode."""
    bias, said = zeroed([(1, 40), (1.1, 40), (9, 40), (1, 80)], [(0, 120)])
    assert runs(bias) == [(1.0, 200)]
    assert set(said) == {"zero-from-free-air"}
    bias, _ = zeroed([(0, 300), (1, 10), (1.2, 32), (9, 40), (1, 8), (0, 300)], [(300, 390)])
    assert runs(bias) == [(0.0, 300), (1.2, 90), (0.0, 300)]


def test_half_of_the_free_air_is_surely_free():
    """Of 40 samples 20 are taken, and of 12 the least that there may be, 10."""
    bias, _ = zeroed([(1, 11), (1.2, 29), (9, 60), (1, 200)], [(0, 100)])
    assert bias[0] == 1.0
    bias, _ = zeroed([(1, 9), (1.2, 31), (9, 60), (1, 200)], [(0, 100)])
    assert bias[0] == 1.2
    bias, _ = zeroed([(1, 6), (1.2, 6), (9, 60), (1, 200)], [(0, 72)])
    assert bias[0] == pytest.approx(1.0)


@pytest.mark.parametrize(("count", "is_free"), [(9, False), (10, True)])
def test_ten_samples_of_free_air_are_needed(count, is_free):
    """With nine the trajectory takes another zero, and it is said."""
    bias, said = zeroed([(0, 100), (2, count), (9, 30), (0, 100)], [(100, 130 + count)])
    assert bias[110] == (2.0 if is_free else 0.0)
    assert ("no-free-air" in said) == (not is_free)


@pytest.mark.parametrize(("begin", "is_free"), [(5.0, True), (5.01, False), (-5.01, False)])
def test_a_start_more_than_five_newtons_off_is_in_contact(begin, is_free):
    """A start more than 5 N off the zero of the recording is in contact."""
    bias, said = zeroed([(0, 300), (begin, 50), (begin + 9, 50), (0, 300)], [(300, 400)])
    assert bias[350] == (begin if is_free else 0.0)
    assert ("no-free-air" in said) == (not is_free)


def test_a_single_touch_far_from_the_zero_is_warned_of_with_its_distance():
    """A touch that begins pressed is warned of, not refused: it may be sound, and one alone cannot tell a moved zero.

    What it would be off by is said, and what to state.
    """
    bias, said = zeroed([(0, 300), (12.5, 50), (20, 50), (12.5, 50), (0, 300)], [(300, 450)])
    assert bias[350] == 0.0
    assert said["no-free-air"].severity == "warning"
    assert "It begins 12.50 N off it: if nothing was touched then, its forces" in said["no-free-air"].message
    assert "wrench.tare_ns" in said["no-free-air"].message


@pytest.mark.parametrize(("level", "is_said"), [(4.9, False), (8.0, True), (-8.0, True)])
def test_two_touches_at_one_level_far_from_the_zero_are_said(level, is_said):
    """Their level counts as free air (decision 0042); beyond 5 N from the usual reading a person is asked to look."""
    levels = [(0, 600), (level, 50), (level + 9, 50), (level, 100), (level + 9, 50), (level, 50), (0, 600)]
    bias, said = zeroed(levels, [(600, 750), (750, 900)])
    assert (bias[650], bias[800]) == (level, level)
    assert ("zero-far" in said) == is_said
    if is_said:
        assert (said["zero-far"].severity, said["zero-far"].count) == ("warning", 2)
        assert "(t0, t1) begin up to 8.00 N from what the sensor reads most of the time" in said["zero-far"].message


@pytest.mark.parametrize(("level", "distance"), [(6.0, None), (-4.0, None), (7.5, "6.50"), (-5.5, "6.50")])
def test_how_far_a_level_is_counts_from_the_zero_of_the_recording(level, distance):
    """Just 5 N from a usual reading of 1 N are not said; torques do not count, and the farthest level is named."""
    touch = [(level, 50), (level + 9, 50), (level, 50)]
    levels = [(1, 600), *touch, *touch, (1, 50), (9, 50), (1, 600)]

    def change(load):
        load[600:900, 3:] += 40

    bias, said = zeroed(levels, [(600, 750), (750, 900), (900, 1000)], change=change)
    assert (bias[650], bias[800], bias[950]) == (level, level, 1.0)
    assert ("zero-far" in said) == (distance is not None)
    if distance:
        assert said["zero-far"].count == 2
        assert f"2 trajectories (t0, t1) begin up to {distance} N from" in said["zero-far"].message


def test_a_zero_far_off_is_that_of_the_beginning():
    """Where a stated tare inside moves the reading back, the level before it is the one that is said."""
    levels = [(1, 600), *[(9, 50), (18, 50), (9, 50)] * 2, (9, 30), (0, 30), (11, 50), (0, 640)]
    bias, said = zeroed(levels, [(600, 750), (750, 900), (900, 1050)], [930])
    assert (bias[910], bias[1000]) == (9.0, 0.0)
    assert said["zero-far"].count == 3
    assert "(t0, t1, t2) begin up to 8.00 N from" in said["zero-far"].message


def test_what_is_pressed_all_the_time_is_no_free_air():
    """Two neighbours that read 8 N throughout, and no touch, have no free air of their own."""
    bias, said = zeroed([(0, 600), (8, 300), (0, 600)], [(600, 750), (750, 900)])
    assert (bias[650], bias[800]) == (0.0, 0.0)
    assert (said["no-free-air"].count, "zero-far" in said) == (2, False)


def test_how_far_a_beginning_is_off_is_told_of_the_farthest_that_is_known():
    """Of its first ten sound samples, after the zero that was taken, forces alone; nothing is known of NaN."""

    def change(load):
        load[100:110, 2] = np.nan
        load[100:190, 4] = 30
        load[300:400] = np.nan

    levels = [(1, 100), (13.5, 20), (20, 70), (1, 110), (2, 100), (1, 200)]
    bias, said = zeroed(levels, [(100, 190), (300, 400)], change=change)
    assert (bias[150], bias[350]) == (1.0, 1.0)
    assert said["no-free-air"].count == 2
    assert "begin in free air (t0); free air cannot be seen in 1 trajectory (t1)" in said["no-free-air"].message
    assert "It begins 12.50 N off it: if nothing was touched then, its forces" in said["no-free-air"].message


def test_a_trajectory_without_a_sound_sample_is_off_by_nothing_that_is_known():
    """Its samples are there and all NaN: no free air, and no newtons to name."""

    def change(load):
        load[100:200] = np.nan

    _, said = zeroed([(1, 100), (5, 100), (1, 200)], [(100, 200)], change=change)
    assert said["no-free-air"].count == 1
    assert "free air cannot be seen in 1 trajectory (t0)" in said["no-free-air"].message
    assert " N off" not in said["no-free-air"].message


def test_samples_that_are_not_known_are_no_free_air():
    """A sample that lacks one component counts neither for the ten nor for the median."""

    def change(load):
        load[100:105, 5] = np.nan
        load[100:105, 2] = 4

    bias, said = zeroed([(0, 100), (2, 15), (9, 30), (0, 100)], [(100, 145)], change=change)
    assert (bias[100], set(said)) == (2.0, {"zero-from-free-air"})
    bias, said = zeroed([(0, 100), (2, 14), (9, 30), (0, 100)], [(100, 144)], change=change)
    assert (bias[100], "no-free-air" in said) == (0.0, True)


def test_a_trajectory_without_samples_changes_nothing():
    """Trajectories after one without samples get their own zeros; one that begins earlier comes first in any order."""
    bias, said = zeroed([(1, 50), (9, 50), (2, 50), (9, 50), (1, 300)], [(800, 900), (100, 200), (0, 100)])
    assert runs(bias) == [(1.0, 100), (2.0, 100), (1.0, 300)]
    assert "no-free-air" not in said
    bias, _ = zeroed([(1, 50), (9, 50), (2, 50), (9, 50), (1, 300)], [(100, 200), (-90, -50), (0, 100)])
    assert runs(bias) == [(1.0, 100), (2.0, 100), (1.0, 300)]


def test_where_two_trajectories_overlap_the_later_one_counts():
    """The trajectory with the later start counts, whatever their names are."""
    levels = [(1, 100), (1.4, 50), (9, 50), (1, 300)]
    assert runs(zeroed(levels, [(100, 200), (0, 150)])[0]) == [(1.0, 100), (1.4, 100), (1.0, 300)]
    assert runs(zeroed(levels, [(0, 150), (100, 200)])[0]) == [(1.0, 100), (1.4, 100), (1.0, 300)]


def test_the_nearest_known_zero_is_taken():
    """The nearest zero is taken by rows from where a trajectory begins; at most five without free air are named."""
    levels = [(1, 50), (20, 50)] + [(20, 50)] * 6 + [(2, 50), (20, 30), (2, 20), (0, 600)]
    spans = [(0, 100), *((first, first + 50) for first in range(100, 400, 50)), (400, 500)]
    bias, said = zeroed(levels, spans)
    # 200 rows are as far from the first as from the last that is known
    assert runs(bias) == [(1.0, 250), (2.0, 250), (0.0, 600)]
    assert said["no-free-air"].count == 6
    assert "(t1, t2, t3, t4, t5 …)" in said["no-free-air"].message
    assert "6 trajectories do not begin" in said["no-free-air"].message
    _, said = zeroed(levels, [*spans[:6], spans[-1]])
    assert said["no-free-air"].count == 5
    assert "(t1, t2, t3, t4, t5);" in said["no-free-air"].message


def test_touches_without_a_whole_reading_are_said_to_be_unseen():
    """A touch whose readings are all NaN is said to be unseen, without newtons; newtons are those of other touches."""

    def lost(load):
        load[350:450] = np.nan

    _, said = zeroed([(0, 800)], [(350, 450)], change=lost)
    text = said["no-free-air"].message
    assert "free air cannot be seen in 1 trajectory (t0) without a whole reading" in text
    assert " N off" not in text
    assert "do not begin" not in text
    levels = [(0, 500), (12.5, 50), (20, 50), (12.5, 50), (0, 300)]
    _, said = zeroed(levels, [(350, 450), (500, 650)], change=lost)
    text = said["no-free-air"].message
    assert "1 trajectory does not begin in free air (t1)" in text
    assert "seen in 1 trajectory (t0) without" in text
    assert "It begins 12.50 N off it" in text
    assert said["no-free-air"].count == 2


def test_zeros_that_move_are_said():
    """Zeros that move by more than 0.2 N in a component are said; one trajectory alone does not move."""
    _, said = zeroed([(1, 50), (9, 50), (1.19, 50), (9, 50), (1, 300)], [(0, 100), (100, 200)])
    assert "zero-drift" not in said
    _, said = zeroed(
        [(1, 50), (9, 50), (1.21, 50), (9, 50), (1, 50), (9, 50), (1, 300)], [(0, 100), (100, 200), (200, 300)]
    )
    assert (said["zero-drift"].severity, said["zero-drift"].count) == ("info", 3)
    assert "its zero moves by 0.21 N over 3 trajectories" in said["zero-drift"].message
    _, said = zeroed([(1, 50), (9, 50), (1, 300)], [(0, 100)])
    assert "zero-drift" not in said
    _, said = zeroed([(1, 50), (9, 50), (1.21, 50), (9, 50), (1, 300)], [(0, 100), (100, 200)])
    assert said["zero-drift"].count == 2

    def change(load):
        load[100:200, 4] += 5

    _, said = zeroed([(1, 50), (9, 50), (1, 50), (9, 50), (1, 300)], [(0, 100), (100, 200)], change=change)
    assert "zero-drift" not in said


def test_a_tare_jumps_from_the_level_before_to_zero():
    """What was read before the event, and zero after it, each for its rows; pressed with 2 N at the next, by -2 N."""
    bias, said = zeroed([(4, 100), (0, 100)], tares=[100])
    assert runs(bias) == [(4.0, 100), (0.0, 100)]
    assert said == {}
    bias, _ = zeroed([(4, 100), (0, 60), (2, 20), (0, 100)], tares=[100, 180])
    assert runs(bias) == [(4.0, 100), (0.0, 80), (-2.0, 100)]


def test_a_tare_while_something_presses_moves_the_zero_by_its_step():
    """Pressed with 6 N over a zero of 1, the reading is set to zero: the zero is then -6."""
    ramp = [(1 + k * 0.5, 5) for k in range(1, 12)]
    bias, _ = zeroed([(1, 100), *ramp, (7, 50), (0, 50), (-6, 100)], tares=[205])
    assert runs(bias) == [(1.0, 205), (-6.0, 150)]


def test_the_drift_of_trajectories_with_tares_is_that_of_their_last_zeros():
    """One that was zeroed inside ends where the next one begins: nothing has moved."""
    levels = [(3, 40), (0, 20), (9, 60), (0, 60), (9, 60), (0, 60)]
    _, said = zeroed(levels, [(0, 120), (120, 240)], [40])
    assert "zero-drift" not in said
    _, said = zeroed([(3, 40), (9, 60), (3, 20), (3, 20), (0, 20), (9, 60), (0, 60)], [(0, 120), (120, 240)], [140])
    assert "its zero moves by 3.00 N over 2" in said["zero-drift"].message


def test_before_the_first_of_two_tares_the_mode_is_that_of_its_rows():
    """What is read between the two does not count."""
    bias, _ = zeroed([(4, 60), (0, 20), (2, 200), (0, 100)], tares=[60, 280])
    assert bias[0] == 4.0


def test_a_drift_is_no_press():
    """A load that needs five seconds and more from free air to the threshold is drift: then the tare sets zero."""
    for step, last in ((10 * MS, -6.0), (2000 * MS, 0.0)):
        ramp = [(1 + k * 0.05, 1) for k in range(1, 121)]
        bias, _ = zeroed([(1, 100), *ramp, (7, 50), (0, 50), (-6, 100)], tares=[270], step=step)
        assert runs(bias)[-1][0] == last


def test_before_the_first_tare_a_long_press_is_no_zero():
    """What rose from the first samples pressed: the zero is theirs, and jumps with the reading."""
    bias, _ = zeroed([(1, 20), (5, 100), (0, 20), (-4, 100)], tares=[120])
    assert runs(bias) == [(1.0, 120), (-4.0, 120)]
    bias, _ = zeroed([(1, 20), (1.4, 100), (0, 120)], tares=[120])
    assert runs(bias) == [(1.4, 120), (0.0, 120)]

    def change(load):
        load[:20, 3] = 50

    bias, _ = zeroed([(1, 20), (1.4, 100), (0, 120)], tares=[120], change=change)
    assert runs(bias) == [(1.4, 120), (0.0, 120)]


def test_before_the_first_tare_a_drift_ends_at_the_jump():
    """A load that drifted from 1 N to 6 N, most of the time at 5 N: the zero is what the event took off."""
    ramp = [(1 + k * 0.01, 1) for k in range(1, 501)]
    levels = [(1, 12), *ramp[:400], (5, 1000), *ramp[400:], (6, 15), (0, 50), (2, 10), (0, 50)]
    bias, _ = zeroed(levels, tares=[1527, 1587], step=200 * MS)
    assert runs(bias)[0] == (6.0, 1527)


def test_a_tare_in_the_first_samples_takes_off_what_was_read():
    """Of fewer than ten samples no mode is known: the jump tells the zero before it."""
    t_ns, load = made([(4, 9), (0, 50)])
    load[:3, 2] = 6
    bias = find_zero(t_ns, load, [], [int(t_ns[9])]).bias
    tare = locate_tares(t_ns, load, [int(t_ns[9])], np.zeros((1, 6)), component_noise(load))[0][0]
    assert bias[0] == pytest.approx(-tare.step)
    assert bias[0, 2] != 4.0
    t_ns, load = made([(4, 10), (0, 50)])
    load[:3, 2] = 6
    assert find_zero(t_ns, load, [], [int(t_ns[10])]).bias[0, 2] == 4.0


def far_off(*levels, tares=(340,)):
    """The zero of a trajectory that begins after 300 samples of air at 0, and whether it is said that it has none."""
    bias, said = zeroed([(0, 300), *levels], [(300, 300 + sum(count for _, count in levels))], tares)
    return runs(bias), "no-free-air" in said


def test_a_start_far_off_is_free_air_where_the_end_is():
    """A start far off is free air with a tare inside, a touch, and air at the end; else the zero is another one's."""
    assert far_off((8, 40), (0, 60), (9, 60), (0, 40)) == ([(0.0, 300), (8.0, 40), (0.0, 160)], False)
    assert far_off((8, 40), (0, 60), (9, 60), (0, 1)) == ([(0.0, 300), (8.0, 40), (0.0, 121)], False)
    assert far_off((8, 40), (0, 60), (9, 60))[1]
    assert far_off((8, 40), (0, 160))[1]
    assert far_off((8, 100), (17, 60), (8, 40), tares=())[1]


def test_torques_are_no_touch_and_no_drift():
    """They neither end the free air of a trajectory nor keep it from being its zero."""

    def change(load):
        load[320:, 3] += 50

    bias, said = zeroed([(0, 300), (1, 20), (1.2, 60), (9, 40)], [(300, 420)], change=change)
    assert bias[300] == pytest.approx(1.1)

    def begin(load):
        load[300:, 3] += 50

    bias, said = zeroed([(0, 300), (1, 40), (9, 40)], [(300, 380)], change=begin)
    assert (bias[300], "no-free-air" in said) == (1.0, False)


def test_noise_is_measured_where_all_is_known():
    """Steps down count as steps up."""
    load = np.zeros((5, 6))
    load[:, 0] = load[:, 1] = load[:, 2] = [8, 6, 4, 2, 0]
    assert component_noise(load) == pytest.approx(2 / 0.6745 / np.sqrt(2), rel=1e-12)


def test_the_press_that_is_undecided_follows_the_last_word():
    """With a threshold of 2 N, 1 N is undecided, and less is air."""
    force = np.array([1.5, 3.0, 1.0, 0.9, 1.5, 2.5, 1.5])
    assert touching(force, 2.0).tolist() == [False, True, True, False, False, True, True]


def test_stated_tares_say_nothing_of_free_air():
    """Without any it is said that the zero comes from free air; with one inside a trajectory that is named."""
    _, said = zeroed([(1, 50), (9, 50)], [(0, 100)])
    assert said["zero-from-free-air"].severity == "info"
    levels = [(1, 50), (0, 50), (9, 50), (0, 50)]
    _, said = zeroed(levels, [(0, 200)], [50])
    assert set(said) == {"tare-in-trajectory"}
    assert (said["tare-in-trajectory"].severity, said["tare-in-trajectory"].count) == ("info", 1)
    assert "inside 1 trajectory (t0);" in said["tare-in-trajectory"].message
    _, said = zeroed(levels, [(0, 50), (50, 200)], [50])
    assert said == {} or set(said) == {"zero-drift"}
    bias, _ = zeroed(levels, [(0, 200)], [50])
    assert runs(bias) == [(1.0, 50), (0.0, 150)]


def test_many_trajectories_with_tares_are_named_by_five():
    """A sixth is a sign."""
    for count, ending in ((5, "t4);"), (6, "t4 …);")):
        levels = [(1, 20), (0, 20), *[(0, 20), (0, 20)] * (count - 1)]
        spans = [(40 * number, 40 * number + 40) for number in range(count)]
        _, said = zeroed(levels, spans, [40 * number + 20 for number in range(count)])
        assert ending in said["tare-in-trajectory"].message
        assert said["tare-in-trajectory"].count == count


def test_each_piece_of_a_trajectory_has_the_zero_of_its_own_free_air():
    """A tare in the free air before a touch: both sides have their own level; without enough, that of the other."""
    bias, said = zeroed([(3, 40), (0, 60), (9, 60), (0, 40)], [(0, 200)], [40])
    assert runs(bias) == [(3.0, 40), (0.0, 160)]
    assert "no-free-air" not in said
    bias, _ = zeroed([(3, 5), (0, 60), (9, 60), (0, 40)], [(0, 165)], [5])
    assert runs(bias) == [(3.0, 5), (0.0, 160)]


def test_a_trajectory_whose_first_samples_are_far_off_may_be_tared_inside():
    """Begun 8 N off the zero, and set to zero in its free air, it ends in free air: that is its own level."""
    bias, said = zeroed([(8, 40), (0, 60), (9, 60), (0, 40)], [(0, 200)], [40])
    assert runs(bias) == [(8.0, 40), (0.0, 160)]
    assert "no-free-air" not in said
