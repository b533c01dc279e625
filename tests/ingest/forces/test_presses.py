"""Whether something presses the force sensor at the end of a stretch of readings, by how its force rose."""

import numpy as np
from load_levels import MS, made

from tactiledata.ingest.forces.tare import _was_pressed


def pressed(levels, step=10 * MS, gaps=None, zero=0.0):
    """Whether something presses at the end of a stretch; gaps (ns) before rows make a pause."""
    t_ns, load = made(levels, step)
    for row, gap in (gaps or {}).items():
        t_ns[row:] += gap - step
    return _was_pressed(t_ns, load, np.array([0, 0, zero, 9, 9, 9.0]), 0.0)


def test_what_rose_from_free_air_presses():
    """A force that rose from free air presses until the end; what was always there, or let go again, does not."""
    assert pressed([(0, 10), (3, 5)])
    assert pressed([(0, 10), (3, 1)])
    assert pressed([(1, 10), (-2, 5)], zero=1.0)
    assert pressed([(0, 5), (3, 5), (0, 5), (3, 5)])
    assert not pressed([(0, 10), (3, 5), (0, 1)])
    assert not pressed([(3, 10)])
    assert not pressed([(0, 10), (0.5, 5)])
    assert not pressed([(0, 0)])
    assert not pressed([(0, 10), (3, 5), (np.nan, 1)])
    assert not pressed([(np.nan, 10), (3, 5)])


def test_free_air_is_below_half_of_the_threshold():
    """A press that begins at 0.25 N was never seen free."""
    assert not pressed([(0.25, 10), (3, 5)])
    assert pressed([(0.24, 10), (3, 5)])
    assert pressed([(0.24, 1), (0.4, 10), (3, 5)])


def test_a_press_rises_within_five_seconds():
    """A press rises from the last free air to the threshold within 5 s; how long the free air was does not matter."""
    assert pressed([(0, 100), (0.3, 24), (3, 5)], 200 * MS, {124: 200 * MS - 1})
    assert not pressed([(0, 100), (0.3, 24), (3, 5)], 200 * MS)
    assert pressed([(0, 100), (3, 5), (0.3, 1), (0, 1), (3, 9)], 200 * MS)


def test_over_a_pause_nothing_was_seen_to_rise():
    """Longer than a quarter of a second between free air and the threshold; elsewhere a pause does not matter."""
    levels = [(0, 10), (0.3, 2), (3, 5)]
    for row in (10, 11, 12):
        assert pressed(levels, gaps={row: 250 * MS}), row
        assert not pressed(levels, gaps={row: 250 * MS + 1}), row
    for row in (1, 5, 9, 13, 16):
        assert pressed(levels, gaps={row: 4000 * MS}), row
