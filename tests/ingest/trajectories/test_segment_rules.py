"""Touches found by their force, just below and just above each limit of time and force."""

import numpy as np
import pytest

from tactiledata.ingest.trajectories.segment import (
    MARGIN,
    contact_spans,
    segment_by_contact,
    whole_recording,
)
from tests.ingest.made_takes import signal

START = 1_700_000_000_000_000_000
MS = 1_000_000


def forces(*presses, count=4000, height=5.0):
    """A force every millisecond, pressing from the first to the last row of each press."""
    force = np.zeros(count)
    for first, last in presses:
        force[first : last + 1] = height
    return START + np.arange(count) * MS, force


def spans(*presses, **options):
    t_ns, force = forces(*presses, **options)
    return [((start - START) // MS, (end - START) // MS) for start, end in contact_spans(t_ns, force, 0.0)]


def test_a_contact_lasts_from_its_first_to_its_last_sample():
    """A contact lasts from its first to its last sample, also at the first and the last row of a recording."""
    assert spans((100, 180), (900, 1000)) == [(100, 180), (900, 1000)]
    assert spans((0, 99), (3900, 3999)) == [(0, 99), (3900, 3999)]
    assert spans() == []


def test_a_contact_of_fifty_milliseconds_is_a_touch():
    """A shorter one is a knock; two contacts less than 300 ms apart are one, and may be long enough together."""
    assert spans((100, 150)) == [(100, 150)]
    t_ns, force = forces((100, 150))
    t_ns[150] -= 1
    assert contact_spans(t_ns, force, 0.0) == []
    assert spans((100, 200), (500, 600)) == [(100, 200), (500, 600)]
    assert spans((100, 200), (499, 600)) == [(100, 600)]
    t_ns, force = forces((100, 200), (500, 600))
    t_ns[500:] -= 1
    assert len(contact_spans(t_ns, force, 0.0)) == 1
    assert spans((100, 200), (1000, 1100), (1200, 1300)) == [(100, 200), (1000, 1300)]
    assert spans((100, 101), (399, 400), (698, 699), (1500, 1600)) == [(100, 699), (1500, 1600)]


def test_a_force_of_half_a_newton_is_no_touch():
    """More is one; values that are not known are no contact."""
    assert spans((100, 300), height=0.5) == []
    assert spans((100, 300), height=0.51) == [(100, 300)]
    t_ns, force = forces((100, 300))
    force[250] = np.nan
    assert contact_spans(t_ns, force, 0.0) == [(START + 100 * MS, START + 300 * MS)]
    force[250:] = np.nan
    assert contact_spans(t_ns, force, 0.0) == [(START + 100 * MS, START + 249 * MS)]
    assert contact_spans(t_ns, force, 1.0) == []


def segmented(*presses, axis=2):
    t_ns, force = forces(*presses, count=12_000)
    values = np.zeros((len(force), 6))
    values[:, axis] = force
    found, _ = segment_by_contact(signal("contact_wrench", t_ns, values), 0.0, "D1")
    return [(one.name, (one.start_ns - START) / MS, (one.end_ns - START) / MS, one.sensor) for one in found]


def test_a_second_of_free_air_is_kept_on_either_side():
    """A second of free air, or half the way to the neighbour, is kept; the outer ends reach beyond the recording."""
    assert MARGIN == 1000 * MS
    assert segmented((500, 600), (1000, 1100), (3100, 3200), (5201, 5300), (10_000, 11_999)) == [
        ("touch-0000", -500, 800, "D1"),
        ("touch-0001", 800, 2100, "D1"),
        ("touch-0002", 2100, 4200, "D1"),
        ("touch-0003", 4201, 6300, "D1"),
        ("touch-0004", 9000, 12_999, "D1"),
    ]
    assert segmented() == []


def test_torques_are_no_forces():
    """Each of the three forces makes a touch, and no torque does."""
    assert [len(segmented((500, 600), axis=axis)) for axis in range(6)] == [1, 1, 1, 0, 0, 0]


@pytest.mark.parametrize(("noise", "count"), [(0.288, 1), (0.289, 0)])
def test_noise_raises_the_threshold(noise, count):
    """Noise of 0.2887 N in each component hides a touch of 3 N: six standard deviations of a norm are needed."""
    t_ns, force = forces((100, 300), height=3.0)
    assert len(contact_spans(t_ns, force, noise)) == count


def test_a_whole_recording_is_one_trajectory():
    """Its last sample is inside the half-open interval."""
    (only,), finding = whole_recording(5, 9, "D1")
    assert (only.name, only.start_ns, only.end_ns, only.sensor) == ("whole-recording", 5, 10, "D1")
    assert (finding.code, finding.severity, finding.start_ns, finding.end_ns) == ("no-segmentation", "warning", 5, 9)


@pytest.mark.parametrize(
    ("presses", "touches", "is_said"),
    [
        ([(0, 90)], [], True),
        ([(0, 90), (900, 1900)], [(900, 1900)], True),
        ([(0, 299), (900, 1900)], [(900, 1900)], True),
        ([(0, 300), (900, 1900)], [(0, 300), (900, 1900)], False),
        ([(1, 90)], [(1, 90)], False),
        ([(0, 90), (200, 1900)], [(0, 1900)], False),
        ([(0, 30)], [], False),
        ([], [], False),
    ],
    ids=["alone", "before a touch", "just under the limit", "long", "with an onset", "joined", "a knock", "nothing"],
)
def test_a_force_at_the_beginning_is_no_touch(presses, touches, is_said):
    """What is there at the first sample and gone at once is said and is no touch; touches with an onset stay."""
    t_ns, force = forces(*presses)
    values = np.zeros((len(force), 6))
    values[:, 2] = force
    wrench = signal("contact_wrench", t_ns, values)
    found, finding = segment_by_contact(wrench, 0.0, "D1")
    assert [touch.name for touch in found] == [f"touch-{number:04d}" for number in range(len(touches))]
    middles = [START + (first + last) // 2 * MS for first, last in touches]
    assert all(touch.start_ns < middle < touch.end_ns for touch, middle in zip(found, middles, strict=True))
    assert (finding is not None) == is_said
    if finding is not None:
        assert (finding.code, finding.start_ns) == ("begins-under-force", START)
