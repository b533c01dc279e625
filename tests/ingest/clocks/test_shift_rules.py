"""Streams and images that are off as a whole, just inside and just outside of each limit."""

import numpy as np
import pytest

from tactiledata.contract.description import LogDescription
from tactiledata.contract.records import Recording, Source, Trajectory
from tactiledata.ingest.clocks.clock_shifts import (
    FAR,
    LEAST_SHIFT,
    Shift,
    judge_frames,
    named_elsewhere,
    shift_finding,
    shift_of,
    span_of,
    touched_span,
)

START = 1_700_000_000_000_000_000
MS, SECOND = 1_000_000, 1_000_000_000
LONG = (0, 60_000)
TOUCHES = (2000, 58_000)


def shift(own, other=LONG, touches=TOUCHES):
    """The time (ms) by which a stream with a span (ms) is late against another one; None where nothing is said."""
    spans = {name: (START + first * MS, START + last * MS) for name, (first, last) in (("own", own), ("other", other))}
    found = shift_of("own", spans, (START + touches[0] * MS, START + touches[1] * MS))
    assert found is None or found.against == "other"
    return None if found is None else found.late_ns / MS


def recording(touches=((2000, 58_000),), **document):
    named = tuple(Trajectory(f"t{row}", a * MS, b * MS) for row, (a, b) in enumerate(touches))
    return Recording(Source("p", "k", "folder", ()), LogDescription(document), {}, named)


def test_a_shift_is_half_of_what_both_ends_say():
    """5 s at the start and 5.2 s at the end; early streams have a negative one."""
    assert shift((5000, 65_200)) == 5100
    assert shift((-5200, 55_000)) == -5100
    assert shift((5000, 65_250)) == 5125
    assert shift((5000, 65_251)) is None
    assert shift((5000, 64_750)) == 4875
    assert shift((5000, 64_749)) is None


@pytest.mark.parametrize(("late", "is_shifted"), [(999, False), (1000, True), (-999, False), (-1000, True)])
def test_a_second_is_a_shift(late, is_shifted):
    """Less is the way in which people start recorders."""
    assert (shift((late, 60_000 + late), touches=(100, 59_900)) is not None) == is_shifted
    assert LEAST_SHIFT == SECOND


@pytest.mark.parametrize(("start", "is_shifted"), [(2250, False), (2251, True)])
def test_a_stream_that_covers_the_touches_is_not_shifted(start, is_shifted):
    """A stream that covers the first and the last touch within 0.25 s is not shifted."""
    assert (shift((start, 60_000 + start)) is not None) == is_shifted
    assert (shift((-start, 60_000 - start)) is not None) == is_shifted


def test_the_other_stream_covers_all_touches():
    """One that does not is no witness, and the next one is asked."""
    assert shift((5000, 65_000), touches=(-250, 60_250)) == 5000
    assert shift((5000, 65_000), touches=(-251, 60_250)) is None
    assert shift((5000, 65_000), touches=(-250, 60_251)) is None
    spans = {"a": (9 * SECOND, 70 * SECOND), "own": (5 * SECOND, 65 * SECOND), "b": (0, 60 * SECOND)}
    touches = (2 * SECOND, 58 * SECOND)
    assert shift_of("own", spans, touches) == Shift(5 * SECOND, "b")
    assert shift_of("missing", spans, touches) is None
    assert shift_of("own", {"own": spans["own"]}, touches) is None
    assert shift_of("own", spans, None) is None


def test_spans():
    """A span goes from the least to the largest, of trajectories, or without them of the images."""
    assert span_of(np.array([5, 9, 3])) == (3, 9)
    cameras = {"a": np.array([5, 9]), "none": np.zeros(0, np.int64), "b": np.array([3, 8])}
    assert touched_span(recording(()), cameras) == (3, 9)
    assert touched_span(recording(()), {}) is None
    assert touched_span(recording(((4, 6), (2, 5))), cameras) == (2 * MS, 6 * MS)


@pytest.mark.parametrize(
    ("late", "way"), [(10**15, "1000000.000 s later"), (-(10**15), "1000000.000 s earlier"), (1, "0.000 s later")]
)
def test_what_is_said_of_a_shift(late, way):
    """The finding says how large the shift is, which offset would mend it, and when its samples were."""
    t_ns = START + late + np.array([5, 0, 9])
    found = shift_finding("wrench", Shift(late, "tcp"), t_ns, 7, "frames", "images are lost")
    assert (found.code, found.severity, found.stream, found.count) == ("clock-apart", "damage", "wrench", 3)
    assert (found.start_ns, found.end_ns) == (START, START + 9)
    assert f"wrench: begins and ends {way} than tcp," in found.message
    assert "its 3 images are lost" in found.message
    assert f"clocks: {{frames: {{offset_ns: {7 - late}}}}}" in found.message


def named(offsets_ms, names, trajectories=(("a", 0, 1000), ("b", 5000, 6000), ("a", 9000, 10_000))):
    made = tuple(Trajectory(name, first * MS, last * MS) for name, first, last in trajectories)
    found = named_elsewhere(
        Recording(Source("p", "k", "folder", ()), LogDescription(), {}, made),
        np.rint(np.array(offsets_ms) * MS).astype(np.int64),
        names,
    )
    return found.is_off.tolist(), found.findings


@pytest.mark.parametrize(("beside", "is_off"), [(500, False), (500 + 1e-6, True)])
def test_an_image_lies_half_a_second_beside_its_trajectory_at_most(beside, is_off):
    """Before its start and after its end."""
    assert named([5000 - beside], ["b"])[0] == [is_off]
    assert named([6000 + beside], ["b"])[0] == [is_off]
    assert FAR == 500 * MS


def test_of_several_trajectories_of_one_name_the_nearest_counts():
    """Images that name none, or one that nobody knows, are nowhere else."""
    found, said = named([500, 9500, 5500, 99_000, 99_000], ["a", "a", "b", "", "nobody"])
    assert (found, said) == ([False] * 5, ())


def test_what_is_said_of_images_elsewhere():
    """How many, how far, and the name that one of them gives."""
    found, [said] = named([5500, 10**9 + 6000, 20_000], ["b", "b", "a"])
    assert found == [False, True, True]
    assert (said.code, said.severity, said.stream, said.count) == ("frame-elsewhere", "damage", "frames", 2)
    assert "2 of 3 images lie up to 1000000.000 s outside" in said.message
    assert "(for example of 'b')" in said.message


FILMED = np.arange(1000) * 30 * MS
SIGNALS = {"tcp": np.arange(3000) * 10 * MS}


def judged(t_ns, signals=None, crc=None, cameras=None, **document):
    cameras = {"digit": np.arange(len(t_ns))} if cameras is None else cameras
    crc = np.arange(len(t_ns)) if crc is None else crc
    touches = ((2000, 28_000),)
    found = judge_frames(recording(touches, **document), cameras, t_ns, crc, SIGNALS if signals is None else signals)
    return np.flatnonzero(found.is_off).tolist(), [(one.code, one.count) for one in found.findings], found.findings


def test_a_camera_that_jumps_is_judged_by_the_signals_only():
    """A signal of one sample is none; without any nothing is judged."""
    jumped = FILMED + np.where(np.arange(1000) >= 600, 5 * SECOND, 0)
    assert judged(jumped)[:2] == (list(range(600, 1000)), [("clock-jump", 400)])
    assert "the 400 images were kept without forces and poses" in judged(jumped)[2][0].message
    assert judged(jumped, {})[:2] == ([], [])
    assert judged(jumped, {"tcp": SIGNALS["tcp"][:1]})[:2] == ([], [])
    assert judged(jumped, {"tcp": SIGNALS["tcp"][:0]})[:2] == ([], [])
    assert judged(FILMED)[:2] == ([], [])
    few = FILMED[:10] + np.where(np.arange(10) >= 5, 5 * SECOND, 0)
    assert judged(few, {"tcp": SIGNALS["tcp"][:1]})[:2] == ([], [])
    assert judged(few, {"tcp": SIGNALS["tcp"][:2]})[:2] == (list(range(5, 10)), [("clock-jump", 5)])


def test_a_camera_with_three_long_pauses_is_not_judged_by_jumps():
    """A camera with two long pauses is judged by jumps; of three, one may be of a camera that takes steps."""
    for pauses, is_judged in ((2, True), (3, False)):
        t_ns = FILMED.copy()
        for row in (300, 500, 700)[:pauses]:
            t_ns[row:] += 2 * SECOND
        assert bool(judged(t_ns)[0]) == is_judged


@pytest.mark.parametrize("seconds", [2, 5])
def test_a_camera_that_takes_steps_and_goes_back_in_time_is_judged(seconds):
    """Pauses of such a camera say nothing; images in a time that it has filmed already are of another moment."""
    t_ns = FILMED.copy()
    for row in (200, 400, 600, 800):
        t_ns[row:] += 700 * MS
    jumped = t_ns - np.where(np.arange(1000) >= 700, seconds * SECOND, 0)
    assert judged(jumped)[:2] == (list(range(700, 1000)), [("clock-jump", 300)])
    assert judged(t_ns)[:2] == ([], [])
    # two images that change places are a queue that was emptied out of order
    late = t_ns.copy()
    late[[500, 503]] = late[[503, 500]]
    assert judged(late)[:2] == ([], [])


def test_copies_of_images_are_no_jump():
    """Images that were written twice have equal checksums; others at the same time mean a jump back."""
    rows = np.r_[0:600, 400:1000]
    assert judged(FILMED[rows], crc=rows)[0] == []
    assert judged(FILMED[rows])[0] != []


def test_each_camera_is_judged_by_itself():
    """One with a single image, one that is shifted, and one that is sound; rows are those of the recording."""
    t_ns = np.concatenate([[10**15], FILMED + 5 * SECOND, FILMED])
    cameras = {"one": np.arange(1), "late": np.arange(1, 1001), "sound": np.arange(1001, 2001)}
    off, said, findings = judged(t_ns, cameras=cameras, clocks={"frames": {"offset_ns": 7, "known": True}})
    assert off == list(range(1, 1001))
    assert said == [("clock-apart", 1000)]
    assert f"offset_ns: {7 - 4990 * MS}" in findings[0].message
    assert f"offset_ns: {-4990 * MS}" in judged(t_ns, cameras=cameras)[2][0].message


def test_two_images_are_judged():
    """The first and the last of a camera, 5 s late; one of them alone says nothing."""
    late = np.array([5000, 35_000]) * MS
    signals = {"tcp": np.array([0, 30_000]) * MS}
    assert judged(late, signals)[1] == [("clock-apart", 2)]
    assert judged(late[:1], signals)[1] == []
