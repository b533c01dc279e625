"""A recording of a few samples and images becomes a take: every table and value by hand."""

import numpy as np
import pyarrow as pa
import pytest

from tactiledata.contract.description import LogDescription
from tactiledata.contract.records import Finding, FrameValues, Recording, Signal, Source, Stamps, Trajectory
from tactiledata.contract.take import FrameFlag, findings_of
from tactiledata.ingest.trajectories.assemble import IngestOptions, assemble
from tactiledata.units import SIGNAL_COLUMNS

START = 1_700_000_000_000_000_000
MS = 1_000_000
SAME = {"xyz": [0.0, 0.0, 0.0], "xyzw": [0.0, 0.0, 0.0, 1.0]}
DOCUMENT = {
    "sensors": {"D1": {"model": "digit"}}, "robot": {"tcp_from_gel": SAME, "tcp_from_ft": SAME},
    "wrench": {"sign": "load_on_sensor", "gravity": "compensated"},
}  # fmt: skip
TOUCHES = (Trajectory("a", START, START + 1000 * MS, "D1"), Trajectory("b", START + 1000 * MS, START + 2000 * MS, "D1"))


def at(*times_ms):
    return START + np.rint(np.array(times_ms) * MS).astype(np.int64)


def images(times_ms, **columns):
    count = len(times_ms)
    values = {
        "camera": "digit", "encoding": "png", "sensor": "D1", "trajectory": "", "log_ns": at(*times_ms),
        "publish_ns": -1, "header_ns": -1, "height": 8, "width": 6, "offset": 0, "length": 1,
        "crc32c": np.arange(count), **columns,
    }  # fmt: skip
    strings = ("camera", "encoding", "sensor", "trajectory")
    return pa.table({
        name: pa.array(value if np.ndim(value) else [value] * count, pa.string() if name in strings else pa.int64())
        for name, value in values.items()
    })  # fmt: skip


def wrench(presses=((300, 600), (1300, 1600)), step=10, last=2000, force=4.0):
    """Forces fz of -4 N from the first to before the last moment (ms) of each press, every 10 ms."""
    t = np.arange(0, last, step)
    values = np.zeros((len(t), 6))
    for first, end in presses:
        values[(t >= first) & (t < end), 2] = -force
    return Signal("wrench", Stamps(at(*t)), values, SIGNAL_COLUMNS["wrench"])


def joints(times_ms):
    return Signal("joints", Stamps(at(*times_ms)), np.zeros((len(times_ms), 6)), SIGNAL_COLUMNS["joints"])


def recording(*signals, touches=TOUCHES, findings=(), document=DOCUMENT, **options):
    named = {one.name: one for one in signals}
    return Recording(
        Source("p", "key", "folder", ()), LogDescription(document), named, tuple(touches), tuple(findings), **options
    )


def assembled(recording, table, pictures=None, **options):
    def decode(rows):
        return [None] * len(rows) if pictures is None else [pictures[row] for row in rows]

    found = assemble(recording, table, decode, "ab" * 32, IngestOptions(**options))
    return found.take, found.order.tolist(), [one.code for one in findings_of(found.take.findings)]


def test_the_options_of_an_ingest():
    """By default nothing is refused and 0.1 s is a gap; what shapes the output is told."""
    assert IngestOptions() == IngestOptions(None, None, False, 100 * MS)
    assert IngestOptions({"a": 1}, "mcap", True, 5).document() == {"mapping": {"a": 1}, "gap_limit_ns": 5}


def test_a_take_by_hand():
    """Frames in the order of trajectories and time, each with its force and trajectory; one outside comes last."""
    times = [400, 2500, 1400, 10]
    values = FrameValues(np.array([[1.0], [2.0], [3.0], [4.0]]), ("v",), ("N",), "note")
    made = recording(wrench(), frame_values={"truth": values})
    take, order, codes = assembled(made, images(times))
    assert order == [3, 0, 2, 1]
    frames = take.frames.to_pydict()
    assert frames["trajectory"] == [0, 0, 1, -1]
    assert frames["t_ns"] == at(10, 400, 1400, 2500).tolist()
    assert frames["sensor"] == ["D1"] * 4
    np.testing.assert_array_equal(np.array(frames["contact_force"]), [0, 4, 4, np.nan])
    assert frames["flags"] == [0, 0, 0, FrameFlag.OUTSIDE | FrameFlag.GAP]
    assert take.aligned["contact_wrench"].values[1].tolist() == [0, 0, 4, 0, 0, 0]
    assert sorted(take.aligned) == sorted(take.signals) == ["contact_wrench", "wrench"]
    assert take.frame_values["truth"] == FrameValues(take.frame_values["truth"].values, ("v",), ("N",), "note")
    assert take.frame_values["truth"].values.ravel().tolist() == [4, 1, 3, 2]
    touches = take.trajectories.to_pydict()
    assert (touches["trajectory"], touches["segmented"], touches["peak_force"]) == (["a", "b"], ["log"] * 2, [4, 4])
    assert (touches["frame_start"], touches["frame_stop"]) == ([0, 2], [2, 3])
    assert (take.sha256, take.status, take.source.key) == ("ab" * 32, "ok", "key")
    assert take.description == DOCUMENT
    assert (take.provenance["step"], take.provenance["inputs"]) == ("ingest", {"key": "ab" * 32})
    assert take.provenance["settings"] == IngestOptions().document()
    assert take.sensors == {"D1": {"model": "digit"}}
    assert codes == ["repeated-samples", "time-order", "zero-from-free-air", "no-background"]


@pytest.mark.parametrize(("lost", "limit", "is_gap"), [(100, 100, False), (100 + 1e-6, 100, True), (100, 99, True)])
def test_a_value_over_a_gap_flags_its_frame(lost, limit, is_gap):
    """Longer than the limit that was chosen."""
    made = recording(joints([0, 10, 20, 20 + lost, 30 + lost, 1990]))
    take, _, _ = assembled(made, images([25]), gap_limit_ns=limit * MS)
    assert bool(take.frames["flags"][0].as_py() & FrameFlag.GAP) == is_gap


def test_gaps_in_trajectories_are_said():
    """Gaps in trajectories are said of every signal."""
    take, _, _ = assembled(recording(joints([*range(0, 300, 10), *range(600, 2000, 10)])), images([5]))
    [gap] = [one for one in findings_of(take.findings) if one.code == "gap"]
    assert (gap.stream, gap.start_ns, gap.end_ns, gap.count) == ("joints", *at(290, 600).tolist(), 1)


def test_without_names_and_forces_all_is_one_trajectory():
    """The only trajectory lasts from the first image or sample to the last; without any there is none."""
    take, _, codes = assembled(recording(joints([0, 10, 2000]), touches=()), images([-50, 400]))
    assert take.trajectories["trajectory"].to_pylist() == ["whole-recording"]
    assert take.trajectories["segmented"].to_pylist() == ["whole recording"]
    assert (take.trajectories["start_ns"].to_pylist(), take.trajectories["end_ns"].to_pylist()) == (
        at(-50).tolist(), (at(2000) + 1).tolist(),
    )  # fmt: skip
    assert "no-segmentation" in codes
    assert np.isnan(take.frames["contact_force"].to_numpy()).all()
    take, _, codes = assembled(recording(touches=()), images([]))
    assert (take.trajectories.num_rows, take.frames.num_rows, codes) == (0, 0, [])


def test_touches_are_found_by_the_wrench():
    """Touches are found by the wrench with the zero of each touch, and what is said of the wrench is said once."""
    take, _, codes = assembled(recording(wrench(), touches=()), images([400]))
    assert take.trajectories["trajectory"].to_pylist() == ["touch-0000", "touch-0001"]
    assert take.trajectories["segmented"].to_pylist() == ["contact onset and release"] * 2
    assert codes.count("zero-from-free-air") == 1
    assert take.trajectories["peak_force"].to_pylist() == [4, 4]
    still, _, codes = assembled(recording(wrench(()), touches=()), images([400]))
    assert (still.trajectories.num_rows, codes.count("zero-from-free-air")) == (0, 1)
    assert "no-contact" in codes
    assert still.frames["contact_force"].to_pylist() == [0]


def test_a_wrench_without_samples_is_none():
    """Nor is there a contact wrench."""
    empty = Signal("wrench", Stamps(np.zeros(0, np.int64)), np.zeros((0, 6)), SIGNAL_COLUMNS["wrench"])
    take, _, _ = assembled(recording(empty), images([400]))
    assert "contact_wrench" not in take.signals


def said(code, severity="info"):
    return Finding(code, severity, code)


@pytest.mark.parametrize(
    ("findings", "status"),
    [
        ([], "ok"), ([said("a"), said("b", "warning")], "ok"), ([said("crc-not-recorded")], "unverified"),
        ([said("crc-not-recorded"), said("a", "damage")], "damaged"), ([said("a", "damage"), said("b")], "damaged"),
    ],
)  # fmt: skip
def test_the_status_of_a_take(findings, status):
    """Damage before what could not be verified; all that the reader found stays, first."""
    take, _, codes = assembled(recording(joints(range(0, 2000, 10)), findings=findings), images([5]))
    assert take.status == status
    assert codes[: len(findings)] == [one.code for one in findings]


def test_what_the_reader_said_of_trajectories_is_not_said_again():
    """A reversed trajectory is left out and said once."""
    touches = (*TOUCHES, Trajectory("c", START + 5, START))
    for findings in ([], [said("trajectory-reversed", "damage")]):
        take, _, codes = assembled(recording(joints([0, 10]), touches=touches, findings=findings), images([5]))
        assert codes.count("trajectory-reversed") == 1
        assert take.trajectories.num_rows == 2


def test_a_lost_span_is_told_of_its_trajectory():
    """A lost span is told of its own trajectory and of no other."""
    lost = Finding("lost", "damage", "lost", start_ns=START, end_ns=START + 1)
    take, _, _ = assembled(recording(joints(range(0, 2000, 10)), findings=[lost]), images([5]))
    found = [one for one in findings_of(take.findings) if one.code == "trajectory-incomplete"]
    assert [one.trajectory for one in found] == ["a"]


def test_an_image_elsewhere_has_neither_force_nor_pose():
    """It stays in the trajectory that it names, and is in none that its wrong time lies in."""
    take, order, codes = assembled(recording(wrench()), images([1400, 400], trajectory=["a", ""]))
    assert "frame-elsewhere" not in codes
    far = images([1700, 400], trajectory=["a", ""])
    take, order, codes = assembled(recording(wrench()), far)
    assert "frame-elsewhere" in codes
    found = dict(zip(order, take.frames.to_pylist(), strict=True))
    assert found[0]["trajectory"] == 0
    assert np.isnan(found[0]["contact_force"])
    assert (found[1]["trajectory"], found[1]["contact_force"]) == (0, 4)


def test_images_of_a_camera_that_jumped_are_in_no_trajectory():
    """Images after a camera's jump are in no trajectory, as their time is not theirs; those before the jump are."""
    t = np.arange(0, 2000, 20) + np.where(np.arange(100) >= 60, 3000, 0)
    touches = (Trajectory("a", START, START + 1000 * MS), Trajectory("z", START + 4000 * MS, START + 5000 * MS))
    made = recording(joints(range(0, 2000, 10)), touches=touches)
    take, order, codes = assembled(made, images(t))
    assert "clock-jump" in codes
    owner = dict(zip(order, take.frames["trajectory"].to_pylist(), strict=True))
    assert [owner[row] for row in range(100)] == [0] * 50 + [-1] * 50


def test_a_reference_is_of_usable_images_in_free_air():
    """The reference takes no missing image; strays of size are flagged before."""
    pictures = [np.full((8, 6, 3), level, np.uint8) for level in (99, 10, 20, 30)]
    encodings = ["missing", "png", "png", "png"]
    take, _, codes = assembled(recording(wrench()), images([10, 20, 30, 40], encoding=encodings), pictures)
    assert take.references["D1"].image[0, 0, 0] == 20
    assert take.references["D1"].origin.startswith("mean of 3 frames")
    heights = [8] * 20 + [9]
    take, _, codes = assembled(recording(wrench()), images(range(21), height=heights))
    assert take.frames["flags"].to_pylist() == [0] * 20 + [FrameFlag.STRAY_SIZE]
    assert "image-stray-size" in codes


def test_sensors_of_images_and_of_trajectories_are_known():
    """Both are named, with what the description says of them."""
    touches = (*TOUCHES, Trajectory("c", START + 5000 * MS, START + 6000 * MS, "D2"))
    take, _, _ = assembled(recording(joints([0, 10]), touches=touches), images([5], sensor="D3"))
    assert take.sensors == {"D1": {"model": "digit"}, "D2": {}, "D3": {}}


def test_a_touch_that_ends_at_a_stated_tare_is_doubted_where_touches_are_found():
    """The reading is put to zero while something seems to press: said where no trajectory is named, and only there."""
    tared = {**DOCUMENT, "wrench": {**DOCUMENT.get("wrench", {}), "tare_ns": [int(at(1000)[0])]}}
    reading = wrench(((300, 1000), (1300, 1600)))
    assert "tare-under-load" in assembled(recording(reading, touches=(), document=tared), images([400]))[2]
    assert "tare-under-load" not in assembled(recording(reading, document=tared), images([400]))[2]
    assert "tare-under-load" not in assembled(recording(reading, touches=()), images([400]))[2]
