"""Streams on the host clock, in a few samples: what is left out, what is said, and what is kept of each."""

import numpy as np
import pytest

from tactiledata.contract.description import LogDescription
from tactiledata.contract.records import Recording, Signal, Source, Stamps, Trajectory
from tactiledata.ingest.clocks.timeline import LARGEST, LATEST, _witnesses, image_times, put_on_host_clock
from tactiledata.ingest.clocks.witnesses import IMAGES, SIGNAL, STAMPS, TRAJECTORIES, Witness
from tactiledata.units import SIGNAL_COLUMNS

START = 1_700_000_000_000_000_000
MS, SECOND = 1_000_000, 1_000_000_000


def signal(name, log, values=None, header=None):
    columns = SIGNAL_COLUMNS[name]
    log = np.asarray(log)
    values = np.arange(len(log) * len(columns), dtype=float).reshape(len(log), -1) if values is None else values
    return Signal(name, Stamps(log, None, header), values, columns, "base")


def recording(*signals, touches=(), clock="auto", **document):
    named = {one.name: one for one in signals}
    return Recording(Source("p", "k", "folder", ()), LogDescription(document), named, tuple(touches), (), clock)


def placed(*signals, cameras=None, **options):
    timed = put_on_host_clock(recording(*signals, **options), cameras or {})
    return timed.signals, [(one.code, one.stream, one.count) for one in timed.findings]


def test_a_signal_is_sorted_with_all_that_it_has():
    """Times, values and stamps go together; the clock, its shift and its rates are written down."""
    log = START + np.array([0, 20, 10, 30]) * MS
    found, said = placed(signal("wrench", log), clocks={"wrench": {"offset_ns": 5, "known": True}})
    wrench = found["wrench"]
    assert (wrench.t_ns - START).tolist() == [5, 10 * MS + 5, 20 * MS + 5, 30 * MS + 5]
    assert wrench.values[:, 0].tolist() == [0, 12, 6, 18]
    assert (wrench.stamps.log - START).tolist() == [0, 10 * MS, 20 * MS, 30 * MS]
    assert said == [("time-order", "wrench", 1)]
    assert wrench.attributes == {
        "clock": "log", "shift_ns": 5, "rate_hz": 100.0, "effective_rate_hz": 100.0, "repeated_samples": 0,
        "largest_gap_ns": 10 * MS,
    }  # fmt: skip
    assert (wrench.columns, wrench.units[0], wrench.frame) == (SIGNAL_COLUMNS["wrench"], "N", "base")


@pytest.mark.parametrize(
    ("name", "column", "words"),
    [("wrench", 2, "fz = 1e+308 N"), ("wrench", 5, "tz = 1e+308 N m"), ("tcp", 0, "x = 1e+308 m"),
     ("joints", 3, "q3 = 1e+308 rad")],
)  # fmt: skip
def test_numbers_that_no_sensor_gives_are_left_out(name, column, words):
    """A reading of 1e308 is damage and goes with its whole sample; the largest that is kept, NaN and inf stay."""
    log = START + np.arange(6) * 10 * MS
    values = np.zeros((6, len(SIGNAL_COLUMNS[name])))
    values[:, -1] = 1.0
    values[[1, 4], column] = 1e308, -1e308
    values[2, column] = LARGEST
    values[3, column] = np.nan
    values[5, column] = np.inf
    timed = put_on_host_clock(recording(signal(name, log, values)))
    (finding,) = (one for one in timed.findings if one.code == "value-impossible")
    assert (finding.severity, finding.stream, finding.count) == ("damage", name, 2)
    assert "2 of 6 samples hold a number that no sensor gives" in finding.message
    assert words in finding.message
    assert timed.signals[name].t_ns.tolist() == log[[0, 2, 3, 5]].tolist()
    np.testing.assert_array_equal(timed.signals[name].values, values[[0, 2, 3, 5]])


def test_numbers_without_a_unit_may_have_any_size():
    """Quaternions, counts and raw numbers are not held against a limit of readings."""
    values = np.full((2, 1), 1e300)
    raw = Signal("counts", Stamps(START + np.arange(2) * MS), values, ("n",), "", ("1",))
    found, said = placed(raw)
    assert len(found["counts"].t_ns) == 2
    assert "value-impossible" not in {code for code, _, _ in said}


def test_times_beyond_the_year_2116_are_left_out():
    """Times beyond the year 2116 are left out in either direction; of what comes before, the distances are known."""
    limit = int(LATEST)
    log = np.array([-limit, 0, 10, limit])
    found, said = placed(signal("wrench", log))
    assert found["wrench"].t_ns.tolist() == [0, 10]
    assert found["wrench"].values[:, 0].tolist() == [6, 12]
    assert ("time-impossible", "wrench", 2) in said
    # neighbouring numbers of float64 are 512 ns apart there
    found, said = placed(signal("wrench", [512 - limit, limit - 512]))
    assert found["wrench"].attributes["largest_gap_ns"] == 2 * limit - 1024
    assert "time-impossible" not in {code for code, _, _ in said}
    [finding] = put_on_host_clock(recording(signal("wrench", log))).findings
    assert finding.severity == "damage"
    assert "2 of 4 samples have a time beyond the year 2116" in finding.message
    assert limit == 2**62


def test_poses_that_are_no_rotations_are_counted():
    """Those that are not known are not broken, and only poses are judged."""
    values = np.tile([0, 0, 0, 0, 0, 0, 1.0], (5, 1))
    values[1, 6], values[2, 6], values[3, 0] = 0, np.nan, np.nan
    values[3, 6] = 0
    found, said = placed(signal("tcp", START + np.arange(5) * 10 * MS, values))
    assert said == [("rotation-broken", "tcp", 1)]
    assert len(found["tcp"].t_ns) == 5
    assert placed(signal("wrench", START + np.arange(5) * 10 * MS))[1] == []


def test_witnesses_are_the_own_log_time_the_others_and_what_was_filmed():
    """Streams with less than two samples are none; trajectories are one, from the first start to the last end.

    A log time that follows the header within a microsecond was made from it, and attests nothing.
    """
    log = np.array([5, 3, 9])
    times = {"wrench": log, "tcp": np.array([7, 2, 4]), "joints": np.array([1])}
    cameras = {"a": np.array([8, 6]), "b": np.array([6])}
    touches = (Trajectory("t", 20, 40), Trajectory("u", 10, 30))
    made = recording(touches=touches)
    beside = [Witness(SIGNAL, 2, 7), Witness(IMAGES, 6, 8), Witness(TRAJECTORIES, 10, 40)]
    for late, attests in ((1000, True), (999, False), (0, False)):
        header = log - 50 - np.array([0, late, 0])
        found = _witnesses("wrench", Stamps(log, None, header), times, cameras, made)
        assert found == [*([Witness(STAMPS, 5, 9)] if attests else []), *beside]
    assert _witnesses("tcp", Stamps(log), times, {}, recording()) == [Witness(SIGNAL, 3, 9)]
    none = np.zeros(0, np.int64)
    assert _witnesses("a", Stamps(none, None, none), {}, {}, recording()) == []
    pause = np.array([0, 10, 20, 2000]) * MS
    assert _witnesses("a", Stamps(log), {"b": pause}, {}, recording())[0].pauses == ((20 * MS, 1980 * MS),)


LONG = START + np.arange(3000) * 10 * MS


def test_a_signal_that_is_shifted_keeps_no_sample():
    """Against another signal, or against images; the offset that would mend it holds the stated one."""
    touches = [Trajectory("t", START + SECOND, START + 29 * SECOND)]
    clocks = {"wrench": {"offset_ns": 7, "known": True}}
    found, said = placed(signal("wrench", LONG + 5 * SECOND - 7), signal("tcp", LONG), touches=touches, clocks=clocks)
    assert ("clock-apart", "wrench", 3000) in said
    assert (len(found["wrench"].t_ns), len(found["tcp"].t_ns)) == (0, 3000)
    late = recording(signal("wrench", LONG + 5 * SECOND - 7), touches=touches, clocks=clocks)
    [finding] = [one for one in put_on_host_clock(late, {"digit": LONG}).findings if one.code == "clock-apart"]
    assert f"offset_ns: {7 - 5 * SECOND}" in finding.message
    assert placed(signal("wrench", LONG + 5 * SECOND), touches=touches)[1] == []


def test_one_image_covers_nothing():
    """A camera with a single image is no witness of a shift, nor of touches; two are."""
    wrench = signal("wrench", LONG + 5 * SECOND)
    two = np.array([START, int(LONG[-1])])
    assert [one[0] for one in placed(wrench, cameras={"a": two})[1]] == ["clock-apart"]
    assert placed(wrench, cameras={"a": two[:1]})[1] == []


def test_each_signal_is_judged_beside_the_others():
    """One that jumps loses what lies behind the jump, and its neighbour nothing."""
    jumped = LONG + np.where(np.arange(3000) >= 2000, 5 * SECOND, 0)
    found, said = placed(signal("wrench", jumped), signal("joints", LONG))
    assert found["wrench"].t_ns.tolist() == LONG[:2000].tolist()
    assert len(found["joints"].t_ns) == 3000
    assert said == [("clock-jump", "wrench", 1000)]


@pytest.mark.parametrize("clock", ["auto", "log"])
def test_images_have_the_offset_of_frames(clock):
    """The clock that was chosen, the times and what is said of them."""
    log = START + np.array([0, 20, 10]) * MS
    made = recording(clock=clock, clocks={"frames": {"offset_ns": 7, "known": True}})
    t_ns, facts, said = image_times(made, "left", Stamps(log))
    assert (t_ns - log).tolist() == [7] * 3
    assert facts == {"clock": "log", "shift_ns": 7}
    assert [(one.code, one.stream) for one in said] == [("time-order", "left")]
