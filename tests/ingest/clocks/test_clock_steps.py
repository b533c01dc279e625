"""A stream's clock that jumps is told from a stream that pauses, and no force moves into another touch."""

import dataclasses

import numpy as np
import pytest
from copied_trees import copy_tree
from hypothesis import given
from hypothesis import strategies as st

from tactiledata.contract.description import LogDescription
from tactiledata.contract.records import Recording, Signal, Source, Stamps, Trajectory
from tactiledata.ingest.clocks.clock_steps import judge_steps
from tactiledata.ingest.clocks.clocks import choose_clock
from tactiledata.ingest.clocks.timeline import put_on_host_clock
from tactiledata.ingest.clocks.witnesses import Witness
from tactiledata.ingest.pipeline import ingest
from tactiledata.store.read.reader import Store

START, STEP, SECOND = 1_700_000_000_000_000_000, 10_000_000, 1_000_000_000
TRUE = START + np.arange(6000) * STEP
FORCE = ("fx", "fy", "fz", "tx", "ty", "tz")
VALUES = np.random.default_rng(0).normal(size=(6000, 6))
OTHERS = [Witness(1, START + 30_000_000, int(TRUE[-1]) - 50_000_000)]


def codes(judged):
    return [finding.code for finding in judged.findings]


@given(st.integers(300, 5700), st.sampled_from([-5, -2, 1, 5, 60]))
def test_what_lies_behind_a_jump_is_left_out(row, seconds):
    """Samples with a displaced time are left out, all others are kept, and the damage says where they belong."""
    t_ns = TRUE + np.where(np.arange(6000) >= row, seconds * SECOND, 0)
    judged = judge_steps("wrench", t_ns, VALUES, OTHERS)
    [finding] = judged.findings
    assert (finding.code, finding.severity, finding.count) == ("clock-jump", "damage", 6000 - row)
    assert (judged.kept == (t_ns == TRUE)).all()
    assert (finding.start_ns, finding.end_ns) == (TRUE[row], TRUE[-1])


def test_a_clock_that_is_set_right_loses_what_came_before():
    """A clock that is 5 s late until it is set: the first samples are left out, and those after are kept."""
    t_ns = TRUE - np.where(np.arange(6000) < 700, 5 * SECOND, 0)
    judged = judge_steps("wrench", t_ns, VALUES, OTHERS)
    assert (judged.kept == (t_ns == TRUE)).all()
    assert codes(judged) == ["clock-jump"]


def test_a_short_beginning_that_was_ahead_is_left_out():
    """The first 2 s are 5 s ahead, so they stand within what follows, twice there: they are left out."""
    t_ns = TRUE + np.where(np.arange(6000) < 200, 5 * SECOND, 0)
    judged = judge_steps("wrench", t_ns, VALUES, OTHERS)
    assert (judged.kept == (t_ns == TRUE)).all()
    assert codes(judged) == ["clock-jump"]


@pytest.mark.parametrize("others", [OTHERS, []])
def test_a_jump_that_is_taken_back_loses_the_middle(others):
    """Ahead by 5 s for 20 s: the 20 s are left out, even where nothing was recorded beside the stream."""
    t_ns = TRUE + np.where((np.arange(6000) >= 2000) & (np.arange(6000) < 4000), 5 * SECOND, 0)
    judged = judge_steps("wrench", t_ns, VALUES, others)
    assert (judged.kept == (t_ns == TRUE)).all()
    assert codes(judged) == ["clock-jump"]


@given(st.integers(1, 5700), st.integers(30, 600), st.sampled_from([-60, -5, -2, 2, 5, 60]), st.booleans())
def test_a_middle_that_stands_elsewhere_is_left_out(row, count, seconds, is_alone):
    """A stretch that is early or late for a while, also before the start or behind the end, is left out alone."""
    count = min(count, 5900 - row, abs(seconds) * 100)
    t_ns = TRUE + np.where((np.arange(6000) >= row) & (np.arange(6000) < row + count), seconds * SECOND, 0)
    judged = judge_steps("wrench", t_ns, VALUES, [] if is_alone else OTHERS)
    assert (judged.kept == (t_ns == TRUE)).all()
    assert codes(judged) == ["clock-jump"]


@pytest.mark.parametrize("others", [OTHERS, []])
@pytest.mark.parametrize(("first", "second"), [(60, 60), (60, -60), (5, 60), (60, 5), (5, 5), (-5, -60), (-60, -60)])
def test_two_middles_that_stand_elsewhere_are_left_out(first, second, others):
    """Each by itself, also where both stand together behind the end of the stream or before its start."""
    rows = np.arange(6000)
    t_ns = TRUE + np.where((rows >= 1000) & (rows < 1200), first * SECOND, 0)
    t_ns += np.where((rows >= 3000) & (rows < 3300), second * SECOND, 0)
    judged = judge_steps("wrench", t_ns, VALUES, others)
    assert (judged.kept == (t_ns == TRUE)).all()
    assert codes(judged) == ["clock-jump"]


@pytest.mark.parametrize("lost", [0, 200, 500])
def test_rows_that_come_late_beside_lost_ones_are_no_jump(lost):
    """Negative control: a stretch that was written late into its own hole, while others were lost behind it."""
    rows = np.r_[0:1000, 2000:3000, 1000:1500, 3000 + lost : 6000]
    judged = judge_steps("wrench", TRUE[rows], VALUES[rows], OTHERS)
    assert judged.kept.all()
    assert "clock-jump" not in codes(judged)


@pytest.mark.parametrize("seconds", [0.4, 0.5, 0.9, 5.0])
@pytest.mark.parametrize(("begins", "ends"), [(0.0, 0.0), (0.3, 0.0), (0.6, 0.0), (0.25, 0.25), (0.15, 0.4)])
def test_a_controller_that_stalls_is_kept(seconds, begins, ends):
    """Negative control: all signals pause together while images go on that began late, or trajectories that lie inside.

    Such images and trajectories last shorter than the signals by about as much as the pause.
    """
    rows = np.r_[0:3000, 3000 + round(100 * seconds) : 6000]
    t_ns = TRUE[rows]
    stall = Witness(1, START, int(TRUE[-1]), ((int(TRUE[2999]), int(seconds * SECOND)),))
    inside = START + int(begins * SECOND), int(TRUE[-1]) - int(ends * SECOND)
    for rank in (2, 3):
        judged = judge_steps("wrench", t_ns, VALUES[rows], [stall, stall, Witness(rank, *inside)])
        assert judged.kept.all(), rank
        assert codes(judged) == []


@pytest.mark.parametrize("seconds", [0.5, 1.0, 5.0])
@pytest.mark.parametrize("rank", [2, 3])
def test_a_controller_whose_clock_jumps_is_refused(seconds, rank):
    """All signals step together, and last longer by just that than the images that began and ended with them."""
    t_ns = TRUE + np.where(np.arange(6000) >= 2000, int(seconds * SECOND), 0)
    together = Witness(1, START, int(t_ns[-1]), ((int(TRUE[1999]), int(seconds * SECOND)),))
    judged = judge_steps("wrench", t_ns, VALUES, [together, Witness(rank, START + 20_000_000, int(TRUE[-1]))])
    if rank == 3 and seconds < 1:
        assert codes(judged) == []  # trajectories begin and end when they like
        return
    assert (judged.kept == (t_ns == TRUE)).all()
    assert codes(judged) == ["clock-jump"]


@given(st.integers(300, 5000), st.integers(40, 600))
def test_a_stream_that_paused_is_kept(row, lost):
    """Negative control: samples that are missing for a while, with a right clock, cost nothing but themselves."""
    rows = np.r_[0:row, row + lost : 6000]
    judged = judge_steps("wrench", TRUE[rows], VALUES[rows], OTHERS)
    assert judged.kept.all()
    assert judged.findings == ()


def test_a_pause_and_a_jump_are_told_apart():
    """A pause of 3 s and a jump of 5 s in one stream: what lies behind the jump is left out, and not the pause."""
    rows = np.r_[0:1000, 1300:6000]
    t_ns = TRUE[rows] + np.where(rows >= 3000, 5 * SECOND, 0)
    judged = judge_steps("wrench", t_ns, VALUES[rows], OTHERS)
    assert (judged.kept == (rows < 3000)).all()


def test_streams_that_pause_together_are_no_evidence():
    """Where all signals halt at one moment the recorder halted: nothing is left out, unless the images tell."""
    t_ns = TRUE + np.where(np.arange(6000) >= 2000, 5 * SECOND, 0)
    together = [Witness(1, int(t_ns[0]), int(t_ns[-1]), ((int(t_ns[1999]), 5 * SECOND),))]
    judged = judge_steps("wrench", t_ns, VALUES, together)
    assert judged.kept.all()
    assert judged.findings == ()
    assert judge_steps("wrench", t_ns, VALUES, [*together, Witness(2, START, int(TRUE[-1]))]).kept.sum() == 2000


@pytest.mark.parametrize(("usual_ms", "back_ms", "is_jump"), [(100, 600, True), (100, 300, False), (10, 320, True)])
def test_a_slow_stream_goes_back_from_three_samples_on(usual_ms, back_ms, is_jump):
    """Images at 10 Hz that go back by 0.6 s stand twice; steps forward are pauses up to twenty samples."""
    true = START + np.arange(400) * usual_ms * 1_000_000
    t_ns = true - np.where(np.arange(400) >= 200, back_ms * 1_000_000, 0)
    judged = judge_steps("digit", t_ns, VALUES[:400], [Witness(1, int(true[0]), int(true[-1]))])
    assert (codes(judged) == ["clock-jump"]) == is_jump
    assert judged.kept.sum() == (200 if is_jump else 400)


def test_late_rows_and_copies_are_no_jumps():
    """Negative control: rows that were written late fill a hole, and rows written twice stand at one time."""
    late = np.r_[0:1000, 1500:3000, 1000:1500, 3000:6000]
    twice = np.r_[0:3000, 2000:6000]
    for rows in (late, twice):
        judged = judge_steps("wrench", TRUE[rows], VALUES[rows], OTHERS)
        assert judged.kept.all(), rows
        assert "clock-jump" not in codes(judged)


def test_a_pause_that_no_stream_can_judge_is_said():
    """Alone, or beside streams of quite another length, a pause of 5 s gets a warning."""
    t_ns = TRUE + np.where(np.arange(6000) >= 2000, 5 * SECOND, 0)
    for others in ([], [Witness(2, START, START + 20 * SECOND)]):
        judged = judge_steps("wrench", t_ns, VALUES, others)
        assert judged.kept.all()
        assert codes(judged) == ["pause-or-jump"]


def recording(wrench_ns):
    poses = np.concatenate([np.zeros((6000, 3)), np.tile([0.0, 0, 0, 1], (6000, 1))], axis=1)
    signals = {
        "wrench": Signal("wrench", Stamps(wrench_ns), VALUES, FORCE),
        "tcp": Signal("tcp", Stamps(TRUE), poses, ("x", "y", "z", "qx", "qy", "qz", "qw")),
    }
    touches = tuple(Trajectory(f"t{k}", START + k * 6 * SECOND, START + (k * 6 + 5) * SECOND) for k in range(10))
    return Recording(Source("p", "k", "folder", ()), LogDescription({}), signals, touches)


def test_no_force_of_a_recording_moves_to_another_touch():
    """A wrench that jumps by 5 s keeps only samples at their true time; poses are untouched; one damage is reported."""
    jumped = TRUE + np.where(np.arange(6000) >= 2500, 5 * SECOND, 0)
    timed = put_on_host_clock(recording(jumped))
    assert (timed.signals["wrench"].t_ns == TRUE[:2500]).all()
    assert (timed.signals["wrench"].values == VALUES[:2500]).all()
    assert len(timed.signals["tcp"].t_ns) == 6000
    assert [finding.stream for finding in timed.findings if finding.severity == "damage"] == ["wrench"]
    assert put_on_host_clock(recording(TRUE)).findings == ()


@pytest.mark.parametrize("row", [30, 3000, 5900])
def test_a_header_clock_that_jumps_is_seen_by_the_log_time(row):
    """Wherever it jumps, the header is not taken: the log time is the recorder's, and is right."""
    header = TRUE + np.where(np.arange(6000) >= row, 5 * SECOND, 0)
    choice = choose_clock("wrench", Stamps(TRUE + 2_000_000, None, header))
    assert choice.clock == "log"
    assert "clock" in choice.findings[0].message


def test_a_recorder_that_stalls_keeps_the_header():
    """Negative control: half a second in which nothing is written, and then all of it, is no jump of the header."""
    log = TRUE + 2_000_000
    stalled = np.maximum(log, np.where((np.arange(6000) >= 3000) & (np.arange(6000) < 3050), log[3050], 0))
    assert choose_clock("wrench", Stamps(stalled, None, TRUE)).clock == "header"


def test_a_forced_header_that_jumps_is_damage():
    """Where a mapping asks for the header stamps, the log times of the same messages tell that they jump."""
    header = TRUE + np.where(np.arange(6000) >= 2500, 5 * SECOND, 0)
    whole = recording(TRUE)
    wrench = dataclasses.replace(whole.signals["wrench"], stamps=Stamps(TRUE + 2_000_000, None, header))
    forced = dataclasses.replace(whole, signals={"wrench": wrench}, host_clock="header")
    timed = put_on_host_clock(forced)
    assert (timed.signals["wrench"].t_ns == TRUE[:2500]).all()
    assert "clock-jump" in {finding.code for finding in timed.findings}


@pytest.mark.parametrize("seconds", [2, 5, 60])
@pytest.mark.parametrize("constant", [0, 2_000_000])
def test_log_times_that_are_copies_of_the_header_attest_no_jump(seconds, constant):
    """A converter that writes header stamps as log times carries a jump over: the other streams tell it all the same.

    Log times with a jitter of their own that pause as long are a recorder's, and attest a pause.
    """
    header = TRUE + np.where(np.arange(6000) >= 2500, seconds * SECOND, 0)
    whole = recording(TRUE)

    def timed(log):
        wrench = dataclasses.replace(whole.signals["wrench"], stamps=Stamps(log, None, header))
        return put_on_host_clock(dataclasses.replace(whole, signals={**whole.signals, "wrench": wrench}))

    copied = timed(header + constant)
    assert codes(copied) == ["clock-jump"]
    assert (copied.signals["wrench"].values == VALUES[:2500]).all()
    jitter = np.random.default_rng(1).integers(0, 200_000, 6000)
    assert "clock-jump" not in codes(timed(header + constant + jitter))


def rewritten(log, folder, change, *tables):
    """A copy of a folder log whose rows of wrench.csv (or other tables) went through ``change``."""
    copy_tree(log, folder)
    for table in tables or ("wrench",):
        head, *rows = (folder / f"{table}.csv").read_text().splitlines()
        (folder / f"{table}.csv").write_text("\n".join([head, *change(rows)]) + "\n")
    return folder


def later(row):
    t_ns, rest = row.split(",", 1)
    return f"{int(t_ns) + 5 * SECOND},{rest}"


@pytest.mark.slow
def test_a_log_whose_wrench_jumps_falls_short(tiny_folders, tmp_path):
    """Ingest reports damage, and no frame after the jump has a force; samples lost in a pause are no damage."""
    log = tiny_folders[0]
    jumped = rewritten(log, tmp_path / "jumped", lambda rows: [*rows[:300], *map(later, rows[300:])])
    halted = rewritten(log, tmp_path / "halted", lambda rows: [*rows[:300], *rows[400:]])
    report = ingest([jumped], tmp_path / "jumped.zarr")
    assert report.fell_short
    said = {finding.code for finding in report.sources[0].findings}
    assert {"clock-jump", "trajectory-incomplete"} <= said
    first = int((log / "wrench.csv").read_text().splitlines()[301].split(",")[0]) + 4_000_000
    frames = Store.open(tmp_path / "jumped.zarr").frames(["t_ns", "contact_force"])
    has_force = np.isfinite(frames["contact_force"].to_numpy())
    assert has_force[frames["t_ns"].to_numpy() < first - 20_000_000].all()
    assert not has_force[frames["t_ns"].to_numpy() >= first].any()
    assert not ingest([halted], tmp_path / "halted.zarr").fell_short


def earlier(row):
    t_ns, rest = row.split(",", 1)
    return f"{int(t_ns) - 5 * SECOND},{rest}"


@pytest.mark.slow
def test_a_log_whose_middle_is_early_falls_short(tiny_folders, tmp_path):
    """Samples that stand 5 s early, before the log's start, are damage, and none of them is kept."""
    changed = rewritten(
        tiny_folders[0], tmp_path / "log", lambda rows: [*rows[:200], *map(earlier, rows[200:500]), *rows[500:]]
    )
    report = ingest([changed], tmp_path / "ds.zarr")
    assert report.fell_short
    said = {finding.code: finding for finding in report.sources[0].findings}
    assert said["clock-jump"].count == 300


@pytest.mark.slow
@pytest.mark.parametrize("row", [300, 400, 500])
def test_a_log_whose_controller_stalls_is_whole(tiny_folders, tmp_path, row):
    """Negative control: half a second without wrench, tcp and joints, while images go on, is a pause."""
    changed = rewritten(
        tiny_folders[0], tmp_path / "log", lambda rows: rows[:row] + rows[row + 50 :], "wrench", "tcp", "joints"
    )
    report = ingest([changed], tmp_path / "ds.zarr")
    assert "clock-jump" not in {finding.code for finding in report.sources[0].findings}
    assert not report.fell_short
