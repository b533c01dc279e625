"""Streams and images whose clock is off as a whole, or jumps, are damage; those that begin late or pause are not."""

import re

import numpy as np
import pytest
from copied_trees import copy_tree
from hypothesis import given
from hypothesis import strategies as st

from tactiledata.contract.description import LogDescription
from tactiledata.contract.records import Recording, Source, Trajectory
from tactiledata.contract.take import findings_of
from tactiledata.ingest.clocks.clock_shifts import judge_frames, shift_of
from tactiledata.ingest.pipeline import ingest
from tactiledata.store.check.check import check
from tactiledata.store.read.reader import Store

SECOND = 1_000_000_000
CLOCKS = {"clock-apart", "clock-jump", "frame-elsewhere"}
TOUCHES = (2 * SECOND, 58 * SECOND)


def moved(log, folder, table, seconds, first=0, last=None):
    """A copy of a folder log with rows of a table at another time."""
    copy_tree(log, folder)
    head, *rows = (folder / f"{table}.csv").read_text().splitlines()
    for number in range(first, len(rows) if last is None else last):
        t_ns, rest = rows[number].split(",", 1)
        rows[number] = f"{int(t_ns) + int(seconds * SECOND)},{rest}"
    (folder / f"{table}.csv").write_text("\n".join([head, *rows]) + "\n")
    return folder


def taken(log, place):
    report = ingest([log], place)
    [source] = report.sources
    return report, [(one.code, one.stream) for one in source.findings if one.code in CLOCKS]


@given(st.sampled_from([-60, -5, -3, 3, 5, 60]), st.integers(-200, 200))
def test_a_stream_that_is_shifted_is_known(seconds, off):
    """Both ends are late by the same time, against a stream that lasts as long and covers the touches."""
    spans = {"tcp": (0, 60 * SECOND), "wrench": (seconds * SECOND, (60 + seconds) * SECOND + off * 10**6)}
    shift = shift_of("wrench", spans, TOUCHES)
    assert shift.against == "tcp"
    assert abs(shift.late_ns - seconds * SECOND) <= 10**8
    assert shift_of("tcp", spans, TOUCHES) is None


@given(st.integers(-60_000, 60_000), st.integers(-60_000, 60_000))
def test_what_begins_late_or_ends_early_is_not_shifted(begins, ends):
    """Negative control: without both ends shifted alike nothing is said; nor where the stream covers the touches."""
    spans = {"tcp": (0, 60 * SECOND), "wrench": (begins * 10**6, 60 * SECOND + ends * 10**6)}
    shift = shift_of("wrench", spans, TOUCHES)
    if shift is not None:
        assert abs(begins - ends) <= 250
        assert begins > 1900 or ends < -1900
    assert shift_of("wrench", spans, None) is None


@pytest.mark.slow
@pytest.mark.parametrize(
    ("table", "seconds"), [("wrench", 5), ("wrench", -5), ("wrench", 2), ("tcp", -5), ("joints", 2)]
)
def test_a_log_with_a_shifted_signal_falls_short(table, seconds, tiny_folders, tmp_path):
    """No force or pose comes from another touch; the damage says by how much, and the offset that mends it."""
    log = moved(tiny_folders[0], tmp_path / "log", table, seconds)
    report, said = taken(log, tmp_path / "ds.zarr")
    assert report.fell_short
    assert said == [("clock-apart", table)]
    assert check(tmp_path / "ds.zarr") == []
    if table == "wrench":
        assert np.isnan(Store.open(tmp_path / "ds.zarr").frames(["contact_force"])["contact_force"].to_numpy()).all()
    [finding] = [one for one in report.sources[0].findings if one.code == "clock-apart"]
    offset = re.search(r"offset_ns: (-?\d+)", finding.message)[1]
    text = (log / "log.yaml").read_text()
    known = {"wrench": 4_000_000}.get(table, 0)
    before = f"{table}: {{offset_ns: {known}, known: {'true' if known else 'false'}}}"
    assert before in text
    (log / "log.yaml").write_text(text.replace(before, f"{table}: {{offset_ns: {offset}, known: true}}"))
    mended = ingest([log], tmp_path / "mended.zarr")
    assert not mended.fell_short


@pytest.fixture(scope="module")
def plain(tiny_folders, tmp_path_factory):
    """A store of the log as it was recorded; read only."""
    place = tmp_path_factory.mktemp("plain") / "plain.zarr"
    assert not ingest([tiny_folders[0]], place).fell_short
    return place


@pytest.mark.slow
@pytest.mark.parametrize(
    ("first", "last", "seconds"), [(0, None, 5), (0, None, -5), (20, None, 5), (0, 10, -5), (5, 12, 60)]
)
def test_images_at_another_time_get_no_force(first, last, seconds, tiny_folders, plain, tmp_path):
    """Images whose time is off keep their picture and trajectory, and have no force of another moment."""
    log = moved(tiny_folders[0], tmp_path / "log", "frames", seconds, first, last)
    report, said = taken(log, tmp_path / "ds.zarr")
    assert report.fell_short
    assert said == [("frame-elsewhere", "frames")]
    assert check(tmp_path / "ds.zarr") == []
    now, before = (Store.open(place).frames(["crc32c", "contact_force"]) for place in (tmp_path / "ds.zarr", plain))
    truth = dict(zip(before["crc32c"].to_pylist(), before["contact_force"].to_pylist(), strict=True))
    off = [
        abs(force - truth[crc])
        for crc, force in zip(now["crc32c"].to_pylist(), now["contact_force"].to_pylist(), strict=True)
    ]
    count = (len(truth) if last is None else last) - first
    assert np.isnan(off).sum() == count
    assert np.nanmax([0.0, *off]) < 1e-6


@pytest.mark.slow
def test_images_a_little_outside_are_kept(tiny_folders, tmp_path):
    """Negative control: images 0.4 s beside their trajectory are a warning."""
    log = moved(tiny_folders[0], tmp_path / "log", "frames", -0.4, 0, 8)
    report, said = taken(log, tmp_path / "ds.zarr")
    assert said == []
    assert not report.fell_short
    assert "frame-elsewhere" not in {one.code for one in findings_of(Store.open(tmp_path / "ds.zarr").findings())}


FILMED = np.arange(1800) * (SECOND // 30)
SIGNALS = {"wrench": np.arange(6000) * (SECOND // 100), "tcp": np.arange(6000) * (SECOND // 100)}
NOTHING = Recording(Source("p", "k", "folder", ()), LogDescription({}), {}, (Trajectory("t", *TOUCHES),))


def judged(t_ns):
    crc = np.arange(len(t_ns), dtype=np.int64)
    answer = judge_frames(NOTHING, {"digit": np.arange(len(t_ns))}, t_ns, crc, SIGNALS)
    return answer.is_off, [(finding.code, finding.stream) for finding in answer.findings]


@given(st.integers(60, 1740), st.sampled_from([-5, -2, 2, 5, 60]))
def test_a_camera_whose_clock_jumps_is_known_by_the_signals(row, seconds):
    """Images that name no trajectory, of a camera that films all the time: those behind the jump are off."""
    is_off, said = judged(FILMED + np.where(np.arange(1800) >= row, seconds * SECOND, 0))
    assert (is_off == (np.arange(1800) >= row)).all()
    assert said == [("clock-jump", "digit")]


@pytest.mark.parametrize("seconds", [-60, -5, 5, 60])
def test_a_camera_that_is_shifted_is_known_by_the_signals(seconds):
    """All its images are off, and the damage says so once."""
    is_off, said = judged(FILMED + seconds * SECOND)
    assert is_off.all()
    assert said == [("clock-apart", "digit")]


@given(st.integers(0, 600), st.integers(1200, 1800), st.integers(0, 1200), st.integers(0, 300))
def test_a_camera_that_pauses_or_begins_late_is_sound(first, last, pause, lost):
    """Negative control: images that are missing at the start, the end and in the middle say nothing of the clock."""
    rows = np.r_[first : max(pause, first), min(max(pause, first) + lost, last) : last]
    is_off, said = judged(FILMED[rows])
    assert not is_off.any()
    assert said == []


@given(st.integers(0, 10**6), st.integers(2, 30))
def test_a_camera_that_films_by_steps_is_sound(seed, steps):
    """A camera with long pauses of any length within the time of the signals is sound."""
    rng = np.random.default_rng(seed)
    t_ns = np.unique(
        np.concatenate([start + np.arange(6) * SECOND // 30 for start in rng.integers(0, 59 * SECOND, steps)])
    )
    is_off, said = judged(t_ns)
    assert not is_off.any()
    assert said == []
