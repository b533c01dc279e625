"""The folder log: what was written comes back exactly, and every planted fault is named."""

from __future__ import annotations

import re
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml
from generators.collect import codes, read
from generators.folder_log import FATAL, FAULTS, SENSOR, START, STEP, TOUCH, picture, write

from tactiledata import errors
from tactiledata.contract.description import LogDescription
from tactiledata.contract.provenance import files_digest
from tactiledata.formats.folder.files import TABLES, LogFolder
from tactiledata.formats.folder.folder import FolderFormat
from tactiledata.formats.folder.signals import read_signals

FORMAT = FolderFormat()


def read_one(path, mapping=None):
    [(recording, sink)] = read(FORMAT, path, mapping)
    return recording, sink.images


def damage(recording):
    return {finding.code for finding in recording.findings if finding.severity == "damage"}


def test_round_trip_is_exact(tmp_path):
    """Times, numbers, image bytes, trajectories and free columns come back as written, and nothing is found."""
    truth = write(tmp_path / "log")
    recording, images = read_one(tmp_path / "log")
    for name in ("wrench", "tcp", "joints"):
        signal = recording.signals[name]
        np.testing.assert_array_equal(signal.stamps.log, truth["times"])
        np.testing.assert_allclose(signal.values, truth[name], rtol=0, atol=1e-15)
    assert [image.payload for image in images] == truth["payloads"]
    assert {(image.encoding, image.height, image.width, image.camera, image.sensor) for image in images} == {
        ("png", 32, 24, "digit", SENSOR)
    }
    assert [image.trajectory for image in images] == ["t0"] * 4 + ["t1"] * 4
    assert [(t.name, t.start_ns, t.end_ns, t.indenter) for t in recording.trajectories] == [
        (f"t{k}", start, start + TOUCH, "ball4") for k, start in enumerate(truth["starts"].tolist())
    ]
    assert recording.trajectories[1].extra == {"depth": 0.2, "spot": "middle"}
    assert recording.findings == ()
    assert recording.host_clock == "log"
    picture = cv2.imread(str(tmp_path / "log" / "backgrounds" / f"{SENSOR}.png"))
    np.testing.assert_array_equal(recording.references[SENSOR], picture[..., ::-1])
    assert recording.description.wrench["sign"] == "load_on_sensor"
    assert (recording.signals["wrench"].frame, recording.signals["tcp"].frame) == ("ft", "base")


@pytest.mark.parametrize("fault", FAULTS)
def test_survivable_fault_is_named_and_the_rest_is_read(tmp_path, fault):
    """A planted fault gives its finding with its severity, and every stream but the one that is gone is there."""
    write(tmp_path / "log", faults=[fault])
    recording, images = read_one(tmp_path / "log")
    _, code, severity = FAULTS[fault]
    found = [finding for finding in recording.findings if finding.code == code]
    assert [finding.severity for finding in found] == [severity], recording.findings
    if fault not in ("touch-twice", "touches-gone"):  # frames name what is no longer there
        assert (severity == "damage") == bool(damage(recording))
    assert "joints" in recording.signals
    if not fault.startswith("frame"):
        assert len(images) == 8
    for signal in recording.signals.values():
        assert np.isfinite(signal.values).all()
        assert len(signal.stamps) >= 100 - 3


@pytest.mark.parametrize("fault", FATAL)
def test_fatal_fault_is_refused_with_its_place(tmp_path, fault):
    """A log that cannot be trusted whole is refused by an error of ours that names the file and what to do."""
    write(tmp_path / "log")
    plant, kind, words = FATAL[fault]
    plant(tmp_path / "log")
    [source] = FORMAT.sources(tmp_path / "log")
    with pytest.raises(getattr(errors, kind), match=words) as caught:
        read(FORMAT, tmp_path / "log")
    assert isinstance(caught.value, errors.TactileDataError)
    assert not any("secret" in file or "passwd" in file for file in source.files)


def test_faulty_rows_alone_are_left_out(tmp_path):
    """One NaN costs one row: all others, times included, are as written."""
    truth = write(tmp_path / "log", faults=["wrench-nan"])
    recording, _ = read_one(tmp_path / "log")
    rest = np.delete(np.arange(len(truth["times"])), 2)
    np.testing.assert_array_equal(recording.signals["wrench"].stamps.log, truth["times"][rest])
    np.testing.assert_array_equal(recording.signals["wrench"].values, truth["wrench"][rest])


@pytest.mark.slow
def test_truncation_at_any_byte_keeps_what_is_before(tmp_path):
    """A wrench.csv cut anywhere gives the whole rows before the cut, and a word about the last line."""
    truth = write(tmp_path / "log", touches=1, frames=1)
    path = tmp_path / "log" / "wrench.csv"
    content = path.read_bytes()
    ends = [place for place in range(len(content)) if content[place : place + 1] == b"\n"]
    for cut in range(ends[3] - 40, ends[4] + 2):
        path.write_bytes(content[:cut])
        read_back = read_signals(LogFolder(tmp_path / "log"), LogDescription())
        whole = sum(end < cut for end in ends) - 1
        values = read_back.signals["wrench"].values
        np.testing.assert_array_equal(values[:whole], truth["wrench"][:whole])
        if len(values) > whole or not content[:cut].endswith(b"\n"):
            assert codes(read_back) & {"csv-last-line-cut", "csv-last-line-open", "csv-value"}, cut


def test_out_of_order_and_repeated_times_are_kept_as_recorded(tmp_path):
    """The reader leaves the order to ingest: values stay with their times, none is lost."""
    truth = write(tmp_path / "log")
    path = tmp_path / "log" / "wrench.csv"
    rows = path.read_text().splitlines()
    path.write_text("\n".join([rows[0], rows[2], rows[1], *rows[3:], rows[-1]]) + "\n")
    recording, _ = read_one(tmp_path / "log")
    order = [1, 0, *range(2, len(truth["times"])), -1]
    np.testing.assert_array_equal(recording.signals["wrench"].stamps.log, truth["times"][order])
    np.testing.assert_array_equal(recording.signals["wrench"].values, truth["wrench"][order])


def test_empty_file_name_is_a_moment_without_image(tmp_path):
    """An empty `file` is a captured moment whose image was not recorded, and no damage."""
    write(tmp_path / "log")
    path = tmp_path / "log" / "frames.csv"
    rows = path.read_text().splitlines()
    (tmp_path / "log" / "frames" / "t0_0.png").unlink()
    path.write_text("\n".join([rows[0], rows[1].rpartition(",")[0] + ",", *rows[2:]]) + "\n")
    recording, images = read_one(tmp_path / "log")
    assert (images[0].encoding, images[0].payload, images[0].trajectory) == ("missing", b"", "t0")
    assert not damage(recording)


def test_missing_and_broken_images_keep_their_moment(tmp_path):
    """Images that cannot be read are pushed as missing moments; a cut image goes as it came."""
    write(tmp_path / "log", faults=["frame-gone"])
    _, images = read_one(tmp_path / "log")
    assert [image.encoding for image in images] == ["png", "missing", *["png"] * 6]
    write(tmp_path / "cut", faults=["frame-cut"])
    _, images = read_one(tmp_path / "cut")
    assert images[1].encoding == "png"
    assert images[1].payload == (tmp_path / "cut" / "frames" / "t0_1.png").read_bytes()


@pytest.mark.parametrize(
    "dress",
    [
        lambda text: b"\xef\xbb\xbf" + text.replace("\n", "\r\n").encode(),
        lambda text: (
            "\n".join(",".join(f'"{cell}"' for cell in row.split(",")) for row in text.splitlines()).encode() + b"\n"
        ),
        lambda text: text.replace("\n", "\n\n").encode(),
        lambda text: f"\n\r\n{text}".encode(),
        lambda text: text.replace(",", " , ").encode(),
        lambda text: "\n".join(",".join(reversed(row.split(","))) for row in text.splitlines()).encode() + b"\n",
    ],
    ids=["bom-crlf", "quoted", "blank-lines", "blank-first-lines", "spaces", "other-column-order"],
)
def test_ways_to_write_csv_do_not_matter(tmp_path, dress):
    """Byte order mark, CRLF, quotes, blank lines, spaces and the order of columns change nothing."""
    write(tmp_path / "log")
    plain, images = read_one(tmp_path / "log")
    for path in (tmp_path / "log").glob("*.csv"):
        path.write_bytes(dress(path.read_text()))
    dressed, others = read_one(tmp_path / "log")
    assert dressed.findings == ()
    assert dressed.trajectories == plain.trajectories
    assert others == images
    for name, signal in plain.signals.items():
        np.testing.assert_array_equal(dressed.signals[name].values, signal.values)
        np.testing.assert_array_equal(dressed.signals[name].stamps.log, signal.stamps.log)


def test_unicode_and_long_names(tmp_path):
    """Names of trajectories and files may be of any script, hold commas, and be as long as the file system allows."""
    write(tmp_path / "ログ – лог")
    log = tmp_path / "ログ – лог"
    name = "触れる, " + "ä" * 500
    file = "frames/" + "ü" * 120 + ".png"
    (log / "frames" / "t0_0.png").rename(log / file)
    for table in ("trajectories.csv", "frames.csv"):
        text = (log / table).read_text().replace("t0,", f'"{name}",').replace("frames/t0_0.png", file)
        (log / table).write_text(text)
    recording, images = read_one(log)
    assert recording.findings == ()
    assert recording.trajectories[0].name == name
    assert (images[0].trajectory, images[0].name) == (name, file)


def test_repeated_name_is_told_apart_by_time(tmp_path):
    """Two rows of one name become two trajectories, and each frame goes to the one that holds its time."""
    write(tmp_path / "log", faults=["touch-twice"])
    path = tmp_path / "log" / "frames.csv"
    path.write_text(path.read_text().replace(",t1,", ",t0,"))
    recording, images = read_one(tmp_path / "log")
    assert [touch.name for touch in recording.trajectories] == ["t0", "t0~2"]
    assert [image.trajectory for image in images] == ["t0"] * 4 + ["t0~2"] * 4


def test_frames_without_names_are_placed_by_the_host_clock(tmp_path):
    """Frames that name no trajectory go by time, on the host clock: the frames' stated offset counts."""
    write(tmp_path / "log")
    path = tmp_path / "log" / "frames.csv"
    shift = 123_456_789_000
    rows = [row.split(",") for row in path.read_text().splitlines()[1:]]
    path.write_text("t_ns,file\n" + "".join(f"{int(t) - shift},{file}\n" for t, _, file in rows))
    _, images = read_one(tmp_path / "log")
    assert {image.trajectory for image in images} == {""}
    document = yaml.safe_load((tmp_path / "log" / "log.yaml").read_text())
    document["clocks"]["frames"] = {"offset_ns": shift, "known": True}
    (tmp_path / "log" / "log.yaml").write_text(yaml.safe_dump(document))
    recording, images = read_one(tmp_path / "log")
    assert [image.trajectory for image in images] == ["t0"] * 4 + ["t1"] * 4
    assert images[0].log_ns == START - shift
    assert recording.findings == ()


def test_two_sensors_and_a_mapping(tmp_path):
    """Frames take the sensor of their trajectory, and a mapping renames the stream and adds to the description."""
    write(tmp_path / "log", sensors=("D20542", "D20543"))
    mapping = {
        "format": "tactiledata-mapping/1",
        "images": {"left": {"topic": "frames.csv", "sensor": "D20542"}},
        "description": {"sensors": {"D20542": {"shore_00": 75}}},
    }
    recording, images = read_one(tmp_path / "log", mapping)
    assert [(image.sensor, image.camera) for image in images] == [("D20542", "left")] * 4 + [("D20543", "digit")] * 4
    assert recording.description.sensors["D20542"]["shore_00"] == 75
    assert set(recording.references) == {"D20542", "D20543"}


def test_folder_of_logs_in_natural_order(tmp_path):
    """Logs below a folder, also two levels down, come in natural order with keys that say where they are."""
    for name in ("day1/run10", "day1/run9", "day2/run1", "alone"):
        write(tmp_path / "all" / name, touches=1, frames=1)
    (tmp_path / "all" / "notes").mkdir()
    sources = FORMAT.sources(tmp_path / "all")
    assert [source.key for source in sources] == ["all/alone", "all/day1/run9", "all/day1/run10", "all/day2/run1"]
    assert not FORMAT.sniff(tmp_path / "all")
    assert all(FORMAT.sniff(Path(source.path)) for source in sources)
    with pytest.raises(errors.BrokenLog, match="no folder log"):
        FORMAT.sources(tmp_path / "all" / "notes")


def test_digest_covers_what_belongs_and_nothing_else(tmp_path):
    """Changing any file that is read changes the identity; a store or notes beside them do not."""
    log = tmp_path / "log"
    write(log, touches=1, frames=1)
    (log / "mesh.stl").write_bytes(b"solid")
    document = yaml.safe_load((log / "log.yaml").read_text())
    document["indenters"]["part"] = {"mesh": "mesh.stl", "unit": "m"}
    (log / "log.yaml").write_text(yaml.safe_dump(document))

    def digest():
        [source] = FORMAT.sources(log)
        return files_digest(log, [Path(file) for file in source.files])

    before = digest()
    (log / "notes.txt").write_text("later")
    (log / "ds.zarr").mkdir()
    (log / "ds.zarr" / "zarr.json").write_text("{}")
    assert digest() == before
    for name in ("log.yaml", "wrench.csv", "frames/t0_0.png", f"backgrounds/{SENSOR}.png", "mesh.stl", "joints.csv"):
        content = (log / name).read_bytes()
        (log / name).write_bytes(content + b"\n")
        assert digest() != before, name
        (log / name).write_bytes(content)
    assert digest() == before


def test_images_are_pushed_one_by_one(tmp_path):
    """No image is read before the one before it was taken: memory stays flat."""
    write(tmp_path / "log")

    class Deleting:
        seen = 0

        def add(self, image):
            self.seen += 1
            assert image.encoding == "png"
            following = tmp_path / "log" / "frames" / f"t{self.seen // 4}_{self.seen % 4}.png"
            if self.seen < 8:
                following.write_bytes(image.payload)

    sink = Deleting()
    [source] = FORMAT.sources(tmp_path / "log")
    FORMAT.read(source, sink)
    names = sorted((tmp_path / "log" / "frames").iterdir())
    assert len({name.read_bytes() for name in names}) == 1


def test_sniff_wants_a_log_of_ours(tmp_path):
    """A log.yaml of somebody else, a file, or a folder without one is left alone."""
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "log.yaml").write_text("level: debug\n")
    (tmp_path / "frames").mkdir()
    (tmp_path / "frames" / "wrench.csv").write_text("t_ns\n")
    for path in (tmp_path, tmp_path / "other", tmp_path / "frames", tmp_path / "other" / "log.yaml"):
        assert not FORMAT.sniff(path)
    write(tmp_path / "log")
    assert FORMAT.sniff(tmp_path / "log")
    (tmp_path / "log" / "log.yaml").write_text("[broken")
    assert FORMAT.sniff(tmp_path / "log")


def test_inspect_counts_without_reading_images(tmp_path):
    """`inspect` tells streams, rates and trajectories."""
    write(tmp_path / "log")
    [source] = FORMAT.sources(tmp_path / "log")
    inspection = FORMAT.inspect(source)
    topics = {topic.name: topic for topic in inspection.topics}
    assert topics["digit"].messages == 8
    assert topics["wrench"].rate == pytest.approx(1e9 / STEP)
    assert inspection.facts["trajectories"] == 2


PAGE = Path(__file__).resolve().parents[3] / "docs" / "formats-folder.md"


def test_the_page_example_is_a_valid_log(tmp_path):
    """The example of the page, copied block by block into files, is read without a word."""
    log = tmp_path / "log"
    (log / "frames").mkdir(parents=True)
    (log / "backgrounds").mkdir()
    blocks = re.findall(
        r"^```(?:yaml|csv) press-day1/(\S+)\n(.*?)^```", PAGE.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE
    )
    assert [name for name, _ in blocks] == ["log.yaml", *TABLES]
    for name, content in blocks:
        (log / name).write_text(content, encoding="utf-8")
    rng = np.random.default_rng(0)
    for name in ("frames/press-1_000.png", "frames/press-2_000.png", f"backgrounds/{SENSOR}.png"):
        picture(log / name, rng, (320, 240))
    recording, images = read_one(log)
    assert recording.findings == ()
    assert set(recording.signals) == {"wrench", "tcp", "joints"}
    assert [image.encoding for image in images] == ["png", "missing", "png"]
    assert [touch.extra["spot"] for touch in recording.trajectories] == ["middle", "edge"]


def test_the_page_lists_every_code():
    """Every finding that a planted fault gives is in the page's table, with its severity."""
    rows = [row for row in PAGE.read_text(encoding="utf-8").splitlines() if row.startswith("| ")]
    for _, code, severity in FAULTS.values():
        assert any(f"`{code}`" in row and row.rstrip(" |").endswith(severity) for row in rows), code


@pytest.mark.parametrize("seed", range(16))
def test_random_harm_never_ends_in_a_foreign_error(tmp_path, seed):
    """Flipped, cut or inserted bytes anywhere give a recording with finite numbers, or an error of ours."""
    log = tmp_path / "log"
    write(log, touches=1, frames=2)
    rng = np.random.default_rng(seed)
    files = sorted(path for path in log.rglob("*") if path.is_file())
    for _ in range(3):
        path = files[rng.integers(len(files))]
        content = bytearray(path.read_bytes())
        start = int(rng.integers(len(content)))
        end = min(len(content), start + int(rng.integers(1, 200)))
        content[start:end] = [b"", rng.bytes(5), bytes(end - start), b'",\n'][rng.integers(4)]
        path.write_bytes(bytes(content))
    try:
        recording, images = read_one(log)
    except errors.TactileDataError:
        return
    for signal in recording.signals.values():
        assert np.isfinite(signal.values).all()
        assert len(signal.stamps)
    assert all(touch.start_ns < touch.end_ns for touch in recording.trajectories)
    assert len({touch.name for touch in recording.trajectories}) == len(recording.trajectories)
    assert all(image.payload or image.encoding == "missing" for image in images)
