"""HDF5 files of one's own: found by names and shapes, read by a mapping, refused in words."""

import cv2
import h5py
import numpy as np
import pytest
import yaml
from command import run_command
from generators import across_hdf5
from generators.collect import codes, read
from generators.hdf5_arrays import MAPPING, STAMPS, some_arrays, write
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tactiledata.contract.schema import check_document
from tactiledata.errors import BrokenLog, MissingFile, SchemaError, UnsafeContent, UsageError
from tactiledata.formats import FORMATS
from tactiledata.formats.hdf5.arrays import FoundArray
from tactiledata.formats.hdf5.hdf5 import Hdf5Format

FORMAT = Hdf5Format()


@pytest.fixture
def made(tmp_path):
    """A file with a wrench at 100 Hz, poses, and four pictures in two chunks; its arrays by path."""
    return tmp_path / "run.h5", some_arrays()


def changed(section, name, **entry):
    """The mapping with another entry."""
    return {**MAPPING, section: {**MAPPING[section], name: {**MAPPING[section].get(name, {}), **entry}}}


def test_arrays_come_back_as_they_were_written(made):
    """Times to the nanosecond, wrenches as they are, rotation vectors as quaternions, pixels in their order."""
    path, arrays = made
    check_document(MAPPING, "mapping", "here")
    [(recording, sink)] = read(FORMAT, write(path, arrays), MAPPING)
    wrench, tcp = recording.signals["wrench"], recording.signals["tcp"]
    np.testing.assert_array_equal(wrench.stamps.log, STAMPS)
    np.testing.assert_array_equal(wrench.values, arrays["force/values"])
    assert wrench.units == ("N", "N", "N", "N m", "N m", "N m")
    np.testing.assert_array_equal(tcp.values[:, :3], arrays["robot/pose"][:, :3])
    expected = Rotation.from_rotvec(arrays["robot/pose"][:, 3:]).as_matrix()
    np.testing.assert_allclose(Rotation.from_quat(tcp.values[:, 3:]).as_matrix(), expected, atol=1e-12)
    assert [(one.sensor, one.camera, one.name) for one in sink.images][3] == ("D1", "digit", "camera/images[3]")
    pixels = [np.frombuffer(one.payload, np.uint8).reshape(6, 8, 3) for one in sink.images]
    np.testing.assert_array_equal(pixels, arrays["camera/images"])
    assert np.abs([one.log_ns - stamp for one, stamp in zip(sink.images, STAMPS[::10], strict=True)]).max() < 300
    assert codes(recording) == set()


def test_bgr_pictures_become_rgb_and_packed_ones_stay_as_they_came(made):
    """Pictures as OpenCV has them are turned; JPEG files inside an array of bytes keep their bytes."""
    path, arrays = made
    [(_, sink)] = read(FORMAT, write(path, arrays), changed("images", "digit", channel_order="bgr"))
    first = np.frombuffer(sink.images[0].payload, np.uint8).reshape(6, 8, 3)
    np.testing.assert_array_equal(first, arrays["camera/images"][0, ..., ::-1])
    packed = [cv2.imencode(".jpg", one)[1].tobytes() for one in arrays.pop("camera/images")]
    write(path, arrays)
    with h5py.File(path, "r+") as file:
        rows = file.create_dataset("camera/images", (4,), dtype=h5py.vlen_dtype(np.uint8))
        for number, one in enumerate(packed):
            rows[number] = np.frombuffer(one, np.uint8)
    [(_, sink)] = read(FORMAT, path, MAPPING)
    assert [one.payload for one in sink.images] == packed
    assert {(one.encoding, one.height, one.width) for one in sink.images} == {("jpeg", 6, 8)}


def test_pictures_of_two_cameras_come_in_the_order_of_time(made):
    """Pictures are given camera by camera only where that is the order of their times."""
    path, arrays = made
    later = arrays["camera/time"] + 0.01
    write(path, arrays, **{"other/time": later, "other/images": arrays["camera/images"]})
    mapping = changed("images", "digit_2", topic="other/images", time="other/time", sensor="D2")
    [(_, sink)] = read(FORMAT, path, mapping)
    assert [one.camera for one in sink.images] == ["digit", "digit_2"] * 4


@pytest.mark.parametrize(
    ("entry", "values"),
    [
        ({"topic": "wide", "fields": [f"[{column}]" for column in (7, 2, 3, 4, 5, 6)]}, (7, 2, 3, 4, 5, 6)),
        ({"topic": "apart", "fields": list("abcdef")}, range(6)),
        ({"topic": "/", "fields": [f"apart/{name}" for name in "abcdef"]}, range(6)),
    ],
)
def test_columns_and_single_arrays_are_fields(made, entry, values):
    """A wrench may be columns of a wider array, or an array for each component, in the order of the mapping."""
    path, arrays = made
    columns = np.arange(40)[:, None] + 100.0 * np.arange(8)
    singles = {f"apart/{name}": columns[:, place] for place, name in enumerate("abcdef")}
    write(path, arrays, wide=columns, **singles)
    [(recording, _)] = read(FORMAT, path, changed("signals", "wrench", **entry))
    np.testing.assert_array_equal(recording.signals["wrench"].values, columns[:, list(values)])


@pytest.mark.parametrize("entry", [{"topic": "apart", "fields": list("abcdef")},
                                   {"topic": "/", "fields": [f"apart/{name}" for name in "abcdef"]}])  # fmt: skip
def test_arrays_that_are_fields_count_as_read(made, entry):
    """Only arrays of an HDF5 group that the mapping names as fields are read; a finding lists the others by name."""
    path, arrays = made
    write(path, arrays, **{f"apart/{name}": np.zeros(40) for name in "abcdefg"})
    [(recording, _)] = read(FORMAT, path, changed("signals", "wrench", **entry))
    [said] = [finding.message for finding in recording.findings if finding.code == "topics-not-read"]
    assert said.endswith("not read: apart/g, force/values (count 2)")


def test_stated_units_are_brought_to_si_and_own_signals_keep_theirs(made):
    """Millinewtons and newton millimetres become N and N m; a temperature stays in its unit."""
    path, arrays = made
    write(path, arrays, heat=np.full((40, 1), 31.5))
    mapping = changed("signals", "wrench", units=["mN"] * 3 + ["N mm"] * 3)
    mapping["signals"]["gel"] = {"topic": "heat", "time": "force/t_ns", "fields": ["[0]"], "units": ["K"]}
    [(recording, _)] = read(FORMAT, path, mapping)
    np.testing.assert_allclose(recording.signals["wrench"].values, 1e-3 * arrays["force/values"])
    gel = recording.signals["gel"]
    assert (gel.columns, gel.units, float(gel.values[0, 0])) == (("0",), ("K",), 31.5)


@given(st.sampled_from(["s", "ms", "us", "ns"]), st.integers(0, 2**53), st.booleans())
def test_times_keep_their_nanoseconds(tmp_path_factory, unit, start, is_whole):
    """Whole numbers are exact in every unit; seconds as floats are as exact as a float is."""
    factor = {"s": 10**9, "ms": 10**6, "us": 10**3, "ns": 1}[unit]
    first = min(start, (2**61) // factor)
    times = np.array([first, first + 1], dtype=np.int64)
    path = write(
        tmp_path_factory.mktemp("times") / "t.h5",
        {"time": times if is_whole else times.astype(np.float64), "force": np.zeros((2, 6))},
    )
    signals = {"wrench": {"topic": "force", "time": "time", "time_unit": unit}}
    [(recording, _)] = read(FORMAT, path, {"format": "tactiledata-mapping/1", "signals": signals})
    exact = [int(value) * factor for value in times]
    spacing = 0 if is_whole else max(1, int(np.spacing(float(first)) * factor))
    assert all(
        abs(int(found) - wanted) <= spacing
        for found, wanted in zip(recording.signals["wrench"].stamps.log, exact, strict=True)
    )


def test_what_is_lost_is_said(made):
    """Times that are no numbers, values that are none, unread arrays and absent ones are counted and named."""
    path, arrays = made
    times = arrays["camera/time"].copy()
    times[1] = np.nan
    arrays["force/values"][5, 0] = np.inf
    write(path, {**arrays, "camera/time": times}, notes=np.arange(3))
    mapping = changed("signals", "joints", topic="robot/q", time="force/t_ns")
    [(recording, sink)] = read(FORMAT, path, mapping)
    said = {finding.code: (finding.severity, finding.message) for finding in recording.findings}
    assert set(said) == {"bad-stamp", "non-finite", "topics-not-read", "missing-topic"}
    assert said["bad-stamp"][0] == "damage"
    assert "1 pictures of camera/images" in said["bad-stamp"][1]
    assert "robot/q" in said["missing-topic"][1]
    assert "notes" in said["topics-not-read"][1]
    assert len(sink.images) == 3
    absent = changed("images", "digit", topic="elsewhere")
    [(recording, sink)] = read(FORMAT, path, absent)
    assert "pictures-not-mapped" in codes(recording)


@pytest.mark.parametrize(
    ("section", "entry", "error", "words"),
    [
        ("signals", {"topic": "robot/pose7", "time": "force/t_ns"}, BrokenLog, "7 columns"),
        ("signals", {"time": "camera/time"}, BrokenLog, "times of shape (4,)"),
        ("signals", {"time": "nowhere"}, BrokenLog, "no array nowhere"),
        ("signals", {"topic": "force"}, BrokenLog, "no array force"),
        ("signals", {"topic": "words"}, BrokenLog, "type"),
        ("signals", {"fields": ["[9]"]}, BrokenLog, "names [9]"),
        ("signals", {"units": ["N"]}, SchemaError, "1 units"),
        ("signals", {"units": ["K"] * 6}, SchemaError, "'K'"),
        ("signals", {"joint_names": list("abcdef")}, SchemaError, "joint_names"),
        ("images", {"topic": "force/values"}, BrokenLog, "no pictures"),
        ("images", {"topic": "force"}, BrokenLog, "no pictures"),
        ("images", {"data": "frame.jpeg"}, SchemaError, "data"),
    ],
)
def test_a_mapping_that_does_not_fit_is_refused(made, section, entry, error, words):
    """Wrong widths, lengths, paths, types and units are named, with what was expected."""
    path, arrays = made
    write(path, arrays, **{"robot/pose7": np.zeros((40, 7)), "words": np.array([b"a"] * 40)})
    name = "wrench" if section == "signals" else "digit"
    with pytest.raises(error) as caught:
        read(FORMAT, path, changed(section, name, **entry))
    assert words in str(caught.value)


def test_times_have_to_be_named(made):
    """A signal without times is refused, and so is a file without a mapping; both say how to go on."""
    path, arrays = made
    write(path, arrays)
    signals = {"wrench": {"topic": "force/values"}}
    for mapping in ({"format": "tactiledata-mapping/1", "signals": signals}, None):
        with pytest.raises((SchemaError, BrokenLog)) as caught:
            read(FORMAT, path, mapping)
        assert "--suggest-mapping" in str(caught.value)


def test_a_draft_reads_the_file_it_was_made_of(made):
    """The draft fits the schema as it stands, is the same as its text, and reads what names and shapes tell."""
    path, arrays = made
    robot = {"robot/q": np.zeros((40, 6)), "robot/qd": np.zeros((40, 6)), "robot/tcp_force": np.zeros((40, 6))}
    write(path, arrays, **robot)
    [source] = FORMAT.sources(path)
    inspection = FORMAT.inspect(source)
    draft, text = FORMAT.draft([inspection])
    check_document(draft, "mapping", "draft")
    assert yaml.safe_load(text) == draft
    assert {name: entry["topic"] for name, entry in draft["signals"].items()} == {
        "wrench": "force/values", "tcp": "robot/pose", "joints": "robot/q",
    }  # fmt: skip
    assert draft["signals"]["tcp"]["rotation"] == "rotation_vector"
    assert draft["images"]["digit"]["topic"] == "camera/images"
    assert "robot/tcp_force" in text
    [(recording, sink)] = read(FORMAT, path, draft)
    assert (set(recording.signals), len(sink.images)) == ({"wrench", "tcp", "joints"}, 4)
    assert {topic.name for topic in inspection.topics} == {*arrays, *robot}
    write(path.with_name("other.h5"), {name: arrays[name] for name in ("force/t_ns", "force/values")})
    [other] = FORMAT.sources(path.with_name("other.h5"))
    assert "other.h5" in FORMAT.draft([inspection, FORMAT.inspect(other)])[1]


def test_a_draft_has_lines_for_arrays_whose_names_say_nothing(made):
    """Uncommented, they read the file: shapes tell six columns and pictures, and a person the rest."""
    path, arrays = made
    write(path, {"t": STAMPS, "f": arrays["force/values"], "pics": arrays["camera/images"], "n": np.zeros((4, 6))})
    [source] = FORMAT.sources(path)
    draft, text = FORMAT.draft([FORMAT.inspect(source)])
    assert draft == {"format": "tactiledata-mapping/1"}
    lines = [line.partition("to read it: ")[2] for line in text.splitlines() if "to read it: " in line]
    assert [line.partition(":")[0] for line in lines] == ["signals", "signals", "images"]
    wrench, other, images = (yaml.safe_load(line) for line in lines)
    assert wrench == {"signals": {"wrench": {"topic": "f", "time": "t", "time_unit": "ns"}}}
    assert other["signals"]["wrench"] == {"topic": "n", "time": "REPLACE-with-path-of-times"}
    assert images["images"]["pics"]["topic"] == "pics"
    [(recording, _)] = read(FORMAT, path, {**draft, **wrench})
    np.testing.assert_array_equal(recording.signals["wrench"].values, arrays["force/values"])
    write(path, {"t": STAMPS, "force": arrays["force/values"], "where": arrays["robot/pose"]})
    text = FORMAT.draft([FORMAT.inspect(FORMAT.sources(path)[0])])[1]
    assert "{tcp: {topic: where, time: t, time_unit: ns, rotation: rotation_vector}}" in text
    text = FORMAT.draft([FORMAT.inspect(FORMAT.sources(write(path, arrays, **{"robot/tcp_force": STAMPS}))[0])])[1]
    assert "to read it" not in text


def test_names_with_line_breaks_stay_in_their_comment(tmp_path):
    """A name that a stranger chose adds nothing to a draft but a comment."""
    name = "x\nclock: log\n#"
    path = write(tmp_path / "odd.h5", {"time": np.arange(5.0), "force": np.zeros((5, 6)), name: np.zeros((5, 3))})
    [source] = FORMAT.sources(path)
    document, text = FORMAT.draft([FORMAT.inspect(source)])
    assert yaml.safe_load(text) == document
    assert set(document) == {"format", "signals"}


def test_a_draft_knows_single_arrays_by_their_names(tmp_path):
    """An array for each component makes a signal with fields."""
    names = ("fx", "fy", "fz", "mx", "my", "mz")
    arrays = {f"ft/{name}": np.full(5, place) for place, name in enumerate(names)}
    path = write(tmp_path / "a.h5", {"ft/seconds": np.arange(5.0), **arrays})
    [source] = FORMAT.sources(path)
    draft, _ = FORMAT.draft([FORMAT.inspect(source)])
    assert draft["signals"]["wrench"] == {
        "topic": "ft", "fields": list(names), "time": "ft/seconds", "time_unit": "s",
    }  # fmt: skip
    [(recording, _)] = read(FORMAT, path, draft)
    assert recording.signals["wrench"].values[0].tolist() == [0, 1, 2, 3, 4, 5]


@pytest.mark.parametrize(
    "name",
    [
        *("time", "t_ns", "robot_timestamps", "ts", "stamp_us", "seconds"),
        *("t_img", "tcam", "timestamps_digit_2_ns", "time_force"),
    ],
)
def test_times_are_known_by_their_names(name):
    """What is called time, stamp or seconds, and has a single column, holds times."""
    assert FoundArray(f"group/{name}", (9,), "float64", "numbers").is_time
    assert not FoundArray(f"group/{name}", (9, 2), "float64", "numbers").is_time


@pytest.mark.parametrize("name", ["weights", "fts", "times_of_day_x", "contact", "state", "tforward", "t_max"])
def test_words_with_the_same_letters_are_no_times(name):
    """Words that only contain these letters say nothing of times."""
    assert not FoundArray(f"group/{name}", (9,), "float64", "numbers").is_time


def test_files_of_other_kinds_are_not_claimed(tmp_path, made):
    """A file without times, one of ACROSS and one that is no HDF5 belong to others; with times it is claimed."""
    path, arrays = made
    assert FORMAT.sniff(write(path, arrays))
    assert not FORMAT.sniff(write(tmp_path / "label.h5", {"data": np.zeros((40, 6)), "weights": np.zeros(40)}))
    (tmp_path / "not.h5").write_bytes(b"\x89HDF" + b"x" * 100)
    assert not FORMAT.sniff(tmp_path / "not.h5")
    across = across_hdf5.write(tmp_path / "sim", np.random.default_rng(0), trials=1) / "results_digit_job_7.hdf5"
    assert next(name for name in FORMATS if FORMATS[name]().sniff(across)) == "across_hdf5"


def test_any_hdf5_file_is_taken_where_this_format_is_asked_for(tmp_path, capsys):
    """Times of any name are named by a mapping; without being asked for, such a file is left, with a word on how."""
    path = write(tmp_path / "own.h5", {"when": STAMPS, "force": np.random.default_rng(0).normal(size=(40, 6))})
    code, _, said = run_command(capsys, "inspect", path)
    assert code != 0
    assert "docs/formats-hdf5.md" in said
    code, out, _ = run_command(capsys, "inspect", path, "--format", "hdf5")
    assert code == 0
    assert "when" in out
    mapping = tmp_path / "mapping.yaml"
    signals = {"wrench": {"topic": "force", "time": "when"}}
    mapping.write_text(yaml.safe_dump({"format": "tactiledata-mapping/1", "signals": signals}))
    words = ("--store", tmp_path / "out.zarr", "--mapping", mapping, "--format", "hdf5")
    code, out, _ = run_command(capsys, "ingest", path, *words)
    assert "1 recording added" in out, out
    for other in (tmp_path / "none.h5", tmp_path):
        with pytest.raises((MissingFile, UsageError)):
            FORMAT.sources(other)


def test_grey_pictures_are_said_not_to_be_read(tmp_path):
    """Pictures without colours are listed with what would be read."""
    grey = np.zeros((5, 6, 8), np.uint8)
    path = write(tmp_path / "grey.h5", {"time": np.arange(5.0), "force": np.zeros((5, 6)), "grey": grey})
    [source] = FORMAT.sources(path)
    notes = {topic.name: topic.note for topic in FORMAT.inspect(source).topics}
    assert "grey are not read" in notes["grey"]
    assert notes["force"] == "times in time"


def test_nothing_outside_the_file_is_read(made, tmp_path):
    """Links to other files, to other places and repeated links are refused."""
    path, arrays = made
    secret = write(tmp_path / "secret.h5", {"values": np.ones((40, 6))})
    for link in (h5py.ExternalLink(str(secret), "values"), h5py.SoftLink("/robot/pose")):
        with h5py.File(write(path, arrays), "r+") as file:
            del file["force/values"]
            file["force/values"] = link
        with pytest.raises(UnsafeContent, match="link"):
            read(FORMAT, path, MAPPING)


def test_a_bomb_is_not_unpacked(made):
    """Pictures that would unpack to far more than the file holds are refused before they are read."""
    path, arrays = made
    write(path, {**arrays, "camera/time": np.arange(3000) / 30})
    with h5py.File(path, "r+") as file:
        del file["camera/images"]
        file.create_dataset("camera/images", (3000, 320, 240, 3), np.uint8, chunks=(8, 320, 240, 3), compression="gzip")
    with pytest.raises(UnsafeContent, match="more numbers than fit"):
        read(FORMAT, path, MAPPING)


def test_a_cut_file_is_damage_in_words(made):
    """A file that ends early is refused with a reason, and a damaged chunk loses its pictures alone."""
    path, arrays = made
    content = write(path, arrays).read_bytes()
    path.write_bytes(content[: len(content) // 2])
    with pytest.raises(Exception, match=r"HDF5|format hdf5"):
        read(FORMAT, path, MAPPING)
    with h5py.File(write(path, arrays), "r+") as file:
        rows = file["camera/images"]
        rows.id.write_direct_chunk((3, 0, 0, 0), b"x" * 50)
    [(recording, sink)] = read(FORMAT, path, MAPPING)
    assert codes(recording) == {"image-unreadable"}
    assert [one.encoding for one in sink.images] == ["raw", "raw", "raw", "missing"]


def test_the_command_reads_a_file_by_its_draft(made, tmp_path, capsys):
    """`inspect --suggest-mapping` and `ingest --mapping` make a store of a file of one's own."""
    path, arrays = made
    write(path, arrays)
    code, draft, _ = run_command(capsys, "inspect", path, "--suggest-mapping")
    assert code == 0
    mapping = tmp_path / "mapping.yaml"
    mapping.write_text(draft.replace("REPLACE-with-serial-of-digit", "D20542"))
    code, out, _ = run_command(capsys, "ingest", path, "--store", tmp_path / "none.zarr")
    assert code == 1
    assert "--suggest-mapping" in out
    code, out, _ = run_command(capsys, "ingest", path, "--store", tmp_path / "out.zarr", "--mapping", mapping)
    assert "1 recording added" in out, out
