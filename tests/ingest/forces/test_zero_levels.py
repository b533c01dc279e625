"""How trajectories begin and end, and what their neighbours tell of it, in levels worked out by hand."""

import numpy as np
import pytest

from tactiledata.ingest.forces.tare_events import Tare
from tactiledata.ingest.forces.zero_levels import (
    CALM,
    EDGE,
    LOST,
    Ends,
    ends_of,
    free_beginnings,
    moved_findings,
    moved_zeros,
    pressed_beginnings,
)

START = 1_700_000_000_000_000_000
MS = 1_000_000
THRESHOLD = 0.5


def level(newtons):
    return np.array([0, newtons, 0, 77 * newtons, 0, 0], float)


def tare(row, step=0.0):
    return Tare(row, np.zeros(6), np.array([0, step, 0, 0, 0, 0]))


def ends(*levels, lost=(), lost_ends=(), steps=None):
    """Trajectories of rows [0, 100), [200, 300)... that begin and end at these levels (N), named a, b, c..."""
    steps = steps or {}
    made = []
    for number, (begin, end) in enumerate(levels):
        name = "abcdefgh"[number]
        made.append(Ends(
            name, 200 * number, 200 * number + 100, level(begin), level(end), level(end - steps.get(name, 0.0)),
            name in lost, name in lost_ends,
        ))  # fmt: skip
    return made


def pressed(*levels, tares=(), **options):
    return "".join(sorted(pressed_beginnings(ends(*levels, **options), [tare(row) for row in tares], THRESHOLD)))


def moved(*levels, tares=(), begin_pressed="", **options):
    found = moved_zeros(ends(*levels, **options), [tare(row) for row in tares], set(begin_pressed), THRESHOLD)
    return "".join(one.name for one in found)


def test_ends_are_medians_of_ten_samples():
    """Ends are medians of ten known samples, with the jumps of tare events inside taken off, or as they were read."""
    t_ns = START + np.arange(100) * 10 * MS
    load = np.zeros((100, 6))
    load[:, 1] = np.arange(100)
    load[[22, 77], 0] = np.nan
    found = ends_of(t_ns, load, [tare(50, 3.0)], ("t", START + 200 * MS, START + 800 * MS))
    assert (found.name, found.start, found.stop) == ("t", 20, 80)
    # 20, 21, 23 ... 30 and 69 ... 76, 78, 79
    assert (found.begin[1], found.end[1], found.end_as_begin[1]) == (25.5, 73.5, 70.5)
    assert found.moved == 45
    assert (found.is_begin_lost, found.is_end_lost) == (False, False)


def test_torques_do_not_move():
    """The distance of two levels is that of their forces."""
    assert ends((1.0, 1.0))[0].moved == 0
    one = Ends("t", 0, 9, np.zeros(6), np.zeros(6), np.array([3, 4, 0, 9, 9, 9.0]), False, False)
    assert one.moved == 5


@pytest.mark.parametrize(("count", "is_told"), [(9, False), (10, True)])
def test_ten_samples_tell_how_a_trajectory_begins(count, is_told):
    """Nine do not."""
    t_ns = START + np.arange(count) * MS
    found = ends_of(t_ns, np.ones((count, 6)), [], ("t", START, START + 10**9))
    assert (found is not None) == is_told


def test_a_beginning_is_lost_where_its_samples_come_late():
    """The tenth sample lies ten distances and 0.1 s after the start at most; the same holds for the end."""
    t_ns = START + np.arange(100) * 10 * MS
    load = np.zeros((100, 6))
    allowed = 10 * 10 * MS + LOST
    for late, is_lost in ((0, False), (1, True)):
        begins = ends_of(t_ns, load, [], ("t", START + 90 * MS - allowed - late, START + 1000 * MS))
        assert (begins.is_begin_lost, begins.is_end_lost) == (is_lost, False)
        ends_at = ends_of(t_ns, load, [], ("t", START, START + 900 * MS + allowed + late))
        assert (ends_at.is_begin_lost, ends_at.is_end_lost) == (False, is_lost)
    assert (LOST, EDGE, CALM) == (100 * MS, 10, 0.2)


def test_what_ends_as_its_neighbour_began_and_not_as_itself_began_pressed():
    """Such a trajectory began pressed by more than a touch; one that ends as it began did not, nor did the first."""
    assert pressed((0, 0), (3, 0)) == "b"
    assert pressed((0, 0), (3, 0.5)) == "b"
    assert pressed((0, 0), (3, 0.51)) == ""
    assert pressed((0, 0), (0.5, 0)) == ""
    assert pressed((0, 0), (0.51, 0)) == "b"
    assert pressed((0, 0), (0.5, -0.1)) == ""
    assert pressed((0, 0), (3, 2.6)) == ""
    assert pressed((3, 0), (3, 3)) == ""
    assert pressed((0, 0), (3, 0), (0, 0), (-2, 0)) == "bd"


def test_a_tare_between_two_trajectories_parts_them():
    """A tare counts from the end of the one before to the first row of the later one, and not before or after that."""
    for row, found in ((100, ""), (150, ""), (200, ""), (99, "b"), (201, "b")):
        assert pressed((0, 0), (3, 0), tares=[row]) == found, row


def test_jumps_inside_are_taken_off():
    """A trajectory that ends 3 N lower by a tare began as it ended; the one before counts as it reads at its end."""
    assert pressed((0, 0), (3, 0), steps={"b": -3.0}) == ""
    assert pressed((5, 0), (3, 0), steps={"a": -5.0}) == "b"
    assert pressed((0, 5), (8, 5), steps={"a": 5.0}) == "b"


def test_a_lost_beginning_is_believed_where_a_neighbour_or_its_end_agrees():
    """Within 0.2 N of the one before or after, or of its own end where that was recorded."""
    assert pressed((0, 0), (3, 0), (0, 0), lost="b") == "b"
    assert pressed((0, 0), (0.2, 3), (9, 9), lost="b") == ""
    assert pressed((0, 0), (0.21, 3), (9, 9), lost="b") == "b"
    assert pressed((9, 9), (0.2, 3), (0, 0), lost="b") == ""
    assert pressed((9, 9), (3, 3.19), (9, 9), lost="b") == ""
    assert pressed((9, 9), (3, 3.21), (9, 9), lost="b") == "b"
    assert pressed((9, 9), (3, 3), (9, 9), lost="b", lost_ends="b") == "b"
    assert pressed((0, 0), (0, 3), lost="b", lost_ends="b") == ""
    assert pressed((3, 3), lost="a") == ""
    assert pressed((3, 0), lost="a") == "a"
    assert pressed((9, 9), (3, 0), (9, 9), (4, 0), lost="bd") == "bd"


def test_a_neighbour_whose_beginning_was_lost_is_passed_over():
    """The next one on that side counts; a tare on the way ends the search."""
    assert pressed((0, 0), (7, 7), (0.1, 9), lost="bc", tares=[]) == ""
    assert pressed((0, 0), (7, 7), (0.1, 9), lost="bc", tares=[150]) == "c"
    assert pressed((0.1, 9), (7, 7), (0, 0), lost="ab") == ""
    assert pressed((0.1, 9), (7, 7), (0, 0), lost="ab", tares=[350]) == "a"


@pytest.mark.parametrize(("row", "found"), [(200, ""), (201, "b"), (299, "b"), (350, "b"), (400, "b"), (401, "")])
def test_a_tare_inside_parts_a_trajectory_from_the_next(row, found):
    """A tare inside counts from behind a trajectory's first row to the first row of the next one."""
    assert pressed((9, 9), (0.1, 5), (0, 0), lost="b", tares=[row]) == found


def test_a_zero_that_moves_inside_is_found_in_the_next_beginning():
    """It ends more than a touch away from where it began, and the next begins within 0.2 N of that."""
    assert moved((0, 3), (3, 3)) == "a"
    assert moved((0, 3), (3.19, 3)) == "a"
    assert moved((0, 3), (3.21, 3)) == ""
    assert moved((0, 0.51), (0.51, 3)) == "a"
    assert moved((0, 0.5), (0.5, 3)) == ""
    assert moved((0, 3), (0, 0)) == ""
    assert moved((0, 3), (3, 6), (6, 6)) == "ab"
    assert moved((0, 0), (0, 3)) == ""
    assert moved() == ""


def test_where_ends_are_not_known_no_zero_moved():
    """Where one begins pressed or lost its end, or the next one begins so, nothing is said of it, but of the others."""
    last = (6, 6)
    assert moved((0, 3), (3, 6), last, begin_pressed="a") == "b"
    assert moved((0, 3), (3, 6), last, begin_pressed="b") == ""
    assert moved((0, 3), (3, 6), last, lost_ends="a") == "b"
    assert moved((0, 3), (3, 6), last, lost="b") == "b"
    assert moved((0, 3), (3, 6), last, lost="a", lost_ends="c") == "ab"


@pytest.mark.parametrize(("row", "found"), [(99, "ab"), (100, "b"), (200, "b"), (201, "ab")])
def test_a_tare_between_hides_a_moved_zero(row, found):
    """A tare from the end of the one to the first row of the next hides a moved zero."""
    assert moved((0, 3), (3, 6), (6, 6), tares=[row]) == found


def test_a_stated_jump_is_no_moved_zero():
    """A trajectory that ends 3 N higher by a tare has not moved; nor has one that ends as it reads at its beginning."""
    assert moved((0, 3), (3, 3), steps={"a": 3.0}) == ""
    assert moved((0, 0.1), (0.1, 3), steps={"a": -3.0}) == ""


def test_moved_zeros_are_named():
    """Five moved zeros are named, with the farthest way."""
    assert moved_findings([]) == []
    found = ends((0, 1), (0, -7.25), (0, 2), (0, 1), (0, 1), (0, 1))
    [finding] = moved_findings(found[:5])
    assert (finding.code, finding.severity, finding.stream, finding.count) == ("zero-moved", "warning", "wrench", 5)
    assert "by up to 7.25 N inside 5 trajectories (a, b, c, d, e):" in finding.message
    assert "inside 6 trajectories (a, b, c, d, e …):" in moved_findings(found)[0].message


def free(*levels, tares=(), begin_pressed="", **options):
    found = free_beginnings(ends(*levels, **options), [tare(row) for row in tares], set(begin_pressed))
    return "".join(sorted(found))


def test_two_that_return_to_one_level_were_in_free_air():
    """Two neighbours that begin and end at one level, and one after them that begins there; one alone does not."""
    assert free((9, 9), (9, 9)) == "ab"
    assert free((9, 9), (9, 9), (9, 0), (0, 0)) == "abc"
    assert free((9, 9), (0, 0)) == ""
    assert free((0, 9), (9, 9), (9, 9.1)) == "bc"
    assert free((0, 9), (9, 9.3), (9.3, 9.3)) == ""
    assert free((9, 9), (9.2, 9.2)) == "ab"
    assert free((9, 9), (9.21, 9.21)) == ""
    assert free((5, 5), (9, 9), (9, 9)) == "bc"


def test_two_tenths_of_a_newton_are_calm():
    """A zero that moved by exactly the limit, inside a trajectory or to its neighbour, has not moved."""
    assert free((0, 0.2), (0.2, 0.2)) == "ab"
    assert free((0, np.nextafter(0.2, 1)), (0.2, 0.2)) == ""
    assert free((0, 0), (0.2, 0.2)) == "ab"
    assert free((0, 0), (np.nextafter(0.2, 1), 0.3)) == ""


def test_one_neighbour_proves_free_air_only_where_it_is_proved_itself():
    """A touch that returns to its level alone proves nothing of the next; nor does a free one that ends pressed."""
    assert free((9, 9), (9, 0)) == ""
    assert free((9, 9), (9, 9), (9, 5), (5, 0)) == "abc"


def test_what_is_not_known_proves_no_free_air():
    """A lost beginning or end, a beginning that is known to be pressed, and a stated tare between the two."""
    assert free((9, 9), (9, 9), lost="a") == ""
    assert free((9, 9), (9, 9), lost_ends="b") == ""
    assert free((9, 9), (9, 9), begin_pressed="b") == ""
    assert free((9, 9), (9, 9), (9, 0), lost="c") == "ab"
    assert free((9, 9), (9, 9), (9, 0), begin_pressed="c") == "ab"
    for row, found in ((0, "ab"), (1, ""), (100, ""), (200, ""), (201, "ab")):
        assert free((9, 9), (9, 9), tares=[row]) == found, row
