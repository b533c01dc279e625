"""RTDE recordings: exact controller times, the arm's own wrench kept apart, faults named."""

from __future__ import annotations

import numpy as np
import pytest
from generators.collect import codes, read
from generators.rtde_csv import write
from scipy.spatial.transform import Rotation

from tactiledata.errors import BrokenLog, UsageError
from tactiledata.formats.rtde_csv import RtdeCsvFormat

FORMAT = RtdeCsvFormat()


def read_one(path, mapping=None):
    [(recording, sink)] = read(FORMAT, path, mapping)
    assert sink.images == []
    return recording


@pytest.mark.parametrize("separator", [",", " ", ", ", "\t"])
def test_round_trip(tmp_path, separator):
    """Joints, poses and forces come back exactly, parted by commas or blanks."""
    times, values = write(tmp_path / "run.csv", separator=separator)
    assert FORMAT.sniff(tmp_path / "run.csv")
    signals = read_one(tmp_path / "run.csv").signals
    assert set(signals) == {"joints", "tcp", "ur_wrench"}
    for signal in signals.values():
        np.testing.assert_array_equal(signal.stamps.log, times)
    np.testing.assert_array_equal(signals["joints"].values, values[:, :6])
    np.testing.assert_array_equal(signals["tcp"].values[:, :3], values[:, 6:9])
    np.testing.assert_array_equal(signals["ur_wrench"].values, values[:, 12:])
    assert signals["ur_wrench"].units == ("N", "N", "N", "N m", "N m", "N m")
    assert (signals["tcp"].frame, signals["ur_wrench"].frame) == ("base", "tcp_with_base_axes")


def test_rotation_vectors_become_the_same_rotation(tmp_path):
    """The quaternion turns vectors as the rotation vector does, the zero vector included."""
    _, values = write(tmp_path / "run.csv")
    path = tmp_path / "run.csv"
    path.write_text(path.read_text() + "49000.0," + ",".join(["0"] * 19) + "\n")
    poses = read_one(path).signals["tcp"].values
    np.testing.assert_allclose(
        Rotation.from_quat(poses[:-1, 3:]).as_matrix(), Rotation.from_rotvec(values[:, 9:12]).as_matrix(), atol=1e-12
    )
    np.testing.assert_array_equal(poses[-1], [0, 0, 0, 0, 0, 0, 1])


@pytest.mark.parametrize("start", ["0.002", "48213.002", "1700000000.002", "9007199254.002"])
def test_times_are_exact_at_any_size(tmp_path, start):
    """Steps of 2 ms stay 2,000,000 ns whatever the clock reads: no time goes through a float."""
    times, _ = write(tmp_path / "run.csv", start=start)
    signal = read_one(tmp_path / "run.csv").signals["joints"]
    np.testing.assert_array_equal(signal.stamps.log, times)
    assert set(np.diff(signal.stamps.log).tolist()) == {2_000_000}


def test_it_is_said_that_the_clock_is_the_controllers(tmp_path):
    """Every recording says that its times are no UTC, and which columns were left; none of it is damage."""
    write(tmp_path / "run.csv")
    recording = read_one(tmp_path / "run.csv")
    assert codes(recording) == {"controller-clock", "columns-ignored"}
    assert {finding.severity for finding in recording.findings} == {"warning", "info"}


def test_the_arm_is_never_taken_for_the_force_sensor(tmp_path):
    """There is no signal `wrench`, and a mapping that asks for one is refused."""
    write(tmp_path / "run.csv")
    assert "wrench" not in read_one(tmp_path / "run.csv").signals
    fields = [f"actual_TCP_force_{axis}" for axis in range(6)]
    with pytest.raises(UsageError, match="another name"):
        read_one(tmp_path / "run.csv", {"signals": {"wrench": {"topic": "run.csv", "fields": fields}}})


def test_mapping_reads_other_columns(tmp_path):
    """A mapping names further signals by their columns, with units."""
    write(tmp_path / "run.csv")
    facts = {"topic": "run.csv", "fields": ["actual_digital_input_bits"], "units": ["1"]}
    recording = read_one(tmp_path / "run.csv", {"signals": {"inputs": facts}})
    assert recording.signals["inputs"].columns == ("actual_digital_input_bits",)
    assert "columns-ignored" not in codes(recording)
    with pytest.raises(BrokenLog, match="'nothing' missing"):
        read_one(tmp_path / "run.csv", {"signals": {"x": {"topic": "run.csv", "fields": ["nothing"]}}})


def rows_of(path, change):
    rows = path.read_text().splitlines()
    path.write_text("\n".join(change(rows)) + "\n")


FAULTS = {
    "nan": (lambda r: [*r[:3], r[3].replace(r[3].split(",")[1], "nan", 1), *r[4:]], "csv-value"),
    "time-word": (lambda r: [*r[:3], "noon," + r[3].partition(",")[2], *r[4:]], "csv-time"),
    "short-row": (lambda r: [*r[:3], "1,2", *r[3:]], "csv-row-length"),
    "restart": (lambda r: [*r, *("0.5" + x[x.index(",") :] for x in r[1:3])], "controller-restart"),
    "column-gone": (lambda r: [r[0].replace("actual_q_3", "q3"), *r[1:]], "columns-incomplete"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_fault_is_named_and_the_rest_is_read(tmp_path, fault):
    """A fault of rows or of one vector is damage with a name; what is sound is read."""
    write(tmp_path / "run.csv")
    change, code = FAULTS[fault]
    rows_of(tmp_path / "run.csv", change)
    recording = read_one(tmp_path / "run.csv")
    assert [finding.severity for finding in recording.findings if finding.code == code] == ["damage"]
    assert len(recording.signals["tcp"].stamps) >= 49


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "is empty"),
        (b"timestamp;actual_q_0\n1,5;2\n", "semicolons"),
        (b"time,actual_q_0\n1,2\n", "'timestamp' missing"),
        (b"timestamp,actual_q_0\n1,2\n", "no whole vector"),
        (b"timestamp,actual_q_0,actual_q_0\n1,2,3\n", "twice"),
        (("timestamp," + ",".join(f"actual_q_{i}" for i in range(6)) + "\n").encode(), "no whole vector that reads"),
        (b"\xff\xfet\0i\0", "UTF-16"),
    ],
)
def test_unreadable_files_are_refused_with_a_reason(tmp_path, content, words):
    """A file from which nothing can be read is a BrokenLog that says why."""
    (tmp_path / "run.csv").write_bytes(content)
    source = RtdeCsvFormat().make_source(tmp_path / "run.csv", tmp_path / "run.csv", [tmp_path / "run.csv"])
    with pytest.raises(BrokenLog, match=words):
        FORMAT.read(source, None)


def test_sniff_leaves_other_tables_alone(tmp_path):
    """Tables of a folder log, a tracker's export and prose are not claimed."""
    for name, content in {
        "wrench.csv": "t_ns,fx\n1,2\n",
        "tracker.csv": "Format Version,1.23,Take Name,timestamp\n",
        "notes.txt": "the timestamp was actual_ly wrong? no: actual only\n",
        "joints.csv": "timestamp,q0\n",
    }.items():
        (tmp_path / name).write_text(content)
    assert not any(FORMAT.sniff(path) for path in [tmp_path, *tmp_path.iterdir()])
