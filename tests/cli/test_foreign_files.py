"""What a command writes replaces what an earlier run wrote, and nothing of others; a link to nothing is called one."""

import os
import struct
import zlib

import cv2
import numpy as np
import pytest
from bench import command

from tactiledata.contract.own_files import is_ours, marked_png, refuse_foreign
from tactiledata.errors import UsageError

MATERIAL = ["--youngs-modulus", "9e5", "--poisson-ratio", "0.4", "--friction", "0.6"]
WRITERS = {
    "D20001.mcap": ["record", "tiny", "--out", "."],
    "D20002": ["record", "tiny", "--out", ".", "--format", "folder"],
    "truth/D20001.json": ["record", "tiny", "--out", "."],
    "truth/D20002.parquet": ["record", "tiny", "--out", ".", "--format", "folder"],
    "planted.zarr.label.json": ["plant", "STORE", "--effect", "lag", "--into", "planted.zarr"],
    "planted.zarr.seal.json": ["plant", "STORE", "--effect", "lag", "--into", "planted.zarr"],
    "calibration.json": ["calibrate", "STORE"],
    "calibration.html": ["calibrate", "STORE"],
    "report.html": ["report", "STORE", "--out", "."],
    "recorded.png": ["report", "STORE", "--out", "."],
    "diagnosis.json": ["diagnose", "STORE", "--out", "."],
    "next/hold.yaml": ["diagnose", "STORE", "--out", "."],
    "replay-low.html": ["replay", "STORE", *MATERIAL, "--out", "."],
    "touch.rrd": ["view", "STORE", "--out", "touch.rrd"],
    "made.png": ["transfer", "STORE", "--to", "ycb-sensorA", "--out", "made.zarr"],
    "tsne.png": ["score", "STORE", "--metric", "tsne", "--out", "."],
    "scene.png": ["scene", "STORE", "--trajectory", "t00000"],
    "scene.xml": ["scene", "STORE", "--trajectory", "t00000", "--out", "scene.xml"],
    "shapes.png": ["indenters", "--picture", "shapes.png"],
}
"""A file that each command writes, and the command."""
LINKED = {
    "ingest": ["LOG", "--store"],
    "merge": ["STORE", "--into"],
    "report": ["STORE", "--out"],
    "export-data": ["STORE", "--to", "lerobot", "--out"],
    "record": ["tiny", "--out"],
    "transfer": ["STORE", "--to", "ycb-sensorA", "--out"],
    "plant": ["STORE", "--effect", "lag", "--into"],
}


def typed(bench, words):
    """The words of a command with the bench's store and log in their places."""
    return [str({"STORE": bench.store, "LOG": bench.log}[word]) if word in ("STORE", "LOG") else word for word in words]


@pytest.mark.parametrize("name", WRITERS)
def test_what_others_wrote_is_refused_before_any_work(name, bench, capsys):
    """Exit 2 names the file and says what to do; the file, and all beside it, stay as they are."""
    words = typed(bench, WRITERS[name])
    place = bench.folder / name
    file = place if place.suffix else place / "notes.txt"
    file.parent.mkdir(exist_ok=True, parents=True)
    file.write_text("my own notes on tactiledata\n")
    before = sorted(path.name for path in bench.folder.iterdir())
    code, text = command(capsys, *words)
    flat = " ".join(text.split())
    assert code == 2, text
    assert f"{name} is there and carries no mark of tactiledata: others wrote it, or an earlier version did" in flat
    assert "Move it, or name another place." in flat
    assert file.read_text() == "my own notes on tactiledata\n"
    assert sorted(path.name for path in bench.folder.iterdir()) == before


@pytest.mark.slow
@pytest.mark.parametrize("name", ["D20001.mcap", "D20002", "report.html", "touch.rrd", "scene.png", "scene.xml"])
def test_what_an_earlier_run_wrote_is_replaced(name, bench, capsys):
    """Negative control: the same command twice at one place, and once more where an empty file was made for it."""
    words = typed(bench, WRITERS[name])
    for _ in range(2):
        code, text = command(capsys, *words)
        assert code == 0, text
    if "." in name:
        (bench.folder / name).write_bytes(b"")
        code, text = command(capsys, *words)
        assert code == 0, text
        assert is_ours(bench.folder / name)
        assert (bench.folder / name).stat().st_size > 0


@pytest.mark.slow
def test_what_others_put_into_a_recording_is_refused(bench, capsys):
    """A recording is a folder that is replaced whole: what the recorder does not write would be lost."""
    words = typed(bench, WRITERS["D20002"])
    assert command(capsys, *words)[0] == 0
    for name in ("notes.txt", "frames/mine.png", "calibration/raw.csv", "link"):
        place = bench.folder / "D20001" / name
        place.parent.mkdir(exist_ok=True)
        if name == "link":
            place.symlink_to("gone")
        else:
            place.write_text("mine")
        code, text = command(capsys, *words)
        assert code == 2, text
        assert f"holds {name}, which the recorder did not write" in " ".join(text.split())
        assert place.is_symlink() or place.read_text() == "mine"
        place.unlink()
    assert command(capsys, *words)[0] == 0


def test_a_label_without_its_seal_is_kept(bench, capsys):
    """A label that was kept elsewhere, or whose seal is gone, is not drawn anew; where both are there it goes on."""
    words = [*typed(bench, WRITERS["planted.zarr.label.json"])]
    assert command(capsys, *words)[0] == 0
    seal, label = (bench.folder / f"planted.zarr.{name}.json" for name in ("seal", "label"))
    for gone, left in ((seal, label), (label, seal)):
        content = gone.read_bytes()
        gone.unlink()
        before = left.read_bytes()
        code, text = command(capsys, *words)
        assert code == 2, text
        assert f"{left.name} is there, and {gone.name} is not beside it" in " ".join(text.split())
        assert left.read_bytes() == before
        gone.write_bytes(content)
    assert command(capsys, *words)[0] == 0
    label.write_text('{"format": "tactiledata-planted/1"}')
    code, text = command(capsys, *words)
    assert code == 1, text
    assert "holds no label that can be read" in " ".join(text.split())


@pytest.mark.parametrize("kind", ["pipe", "device"])
def test_a_pipe_or_a_device_is_no_empty_file(kind, bench, capsys):
    """It has no bytes and was not made for a page: it is refused, is not read, and stays."""
    place = bench.folder / "report.html"
    os.mkfifo(place) if kind == "pipe" else place.symlink_to("/dev/null")
    code, text = command(capsys, *typed(bench, WRITERS["report.html"]))
    assert code == 2, text
    assert "report.html is no file, but a pipe, a device or a socket" in " ".join(text.split())
    assert place.is_fifo() or place.is_symlink()


@pytest.mark.parametrize("name", LINKED)
def test_a_name_that_is_no_text_is_refused_before_any_work(name, bench, capsys):
    """Bytes that are no UTF-8 cannot be written into documents: wrong usage, and nothing comes to be."""
    words = typed(bench, LINKED[name])
    before = set(bench.folder.iterdir())
    place = os.fsdecode(b"st\xff.zarr")
    code, text = command(capsys, name, *words, place)
    assert code == 2, text
    assert f"{words[-1]} 'st\\udcff.zarr' holds bytes that are no UTF-8 text" in " ".join(text.split())
    assert set(bench.folder.iterdir()) == before


def test_a_marked_picture_is_the_same_picture():
    """The mark is a chunk of its own with a checksum that fits, and pixels do not change."""
    picture = np.random.default_rng(0).integers(0, 256, (9, 7, 3), np.uint8)
    content = cv2.imencode(".png", picture)[1].tobytes()
    marked = marked_png(content)
    np.testing.assert_array_equal(cv2.imdecode(np.frombuffer(marked, np.uint8), cv2.IMREAD_COLOR), picture)
    start = marked.index(b"tEXt")
    (size,) = struct.unpack(">I", marked[start - 4 : start])
    chunk = marked[start : start + 4 + size]
    assert marked[start + 4 + size :][:4] == struct.pack(">I", zlib.crc32(chunk))
    assert marked.replace(marked[start - 4 : start + 8 + size], b"") == content


def test_a_mark_across_two_pieces_of_a_file_is_found(tmp_path, monkeypatch):
    """A large file is read in pieces, and the mark may lie across the end of one."""
    monkeypatch.setattr("tactiledata.contract.own_files.CHUNK", 7)
    for start in range(8):
        path = tmp_path / f"{start}.rrd"
        path.write_bytes(b"x" * start + b"tactiledata-x")
        refuse_foreign(path)
    (tmp_path / "other.rrd").write_bytes(b"tactile" * 9)
    with pytest.raises(UsageError, match="carries no mark"):
        refuse_foreign(tmp_path / "other.rrd")
    refuse_foreign(tmp_path / "nothing.rrd")


@pytest.mark.parametrize("name", LINKED)
def test_a_link_to_nothing_is_said_to_be_one(name, bench, capsys):
    """Neither the disk nor the rights are blamed, and the link stays a link; of a place behind it the same is said."""
    words = typed(bench, LINKED[name])
    link = bench.folder / "link"
    link.symlink_to("gone")
    for place, said in (("link", "link is a"), ("link/deep", "link/deep is behind link, a")):
        code, text = command(capsys, name, *words, place)
        assert code == 2, text
        assert f"{words[-1]} {said} link that leads to gone, which is not there" in " ".join(text.split())
    assert link.is_symlink()
    assert not link.exists()


@pytest.mark.slow
def test_a_link_to_a_folder_is_written_through(bench, capsys):
    """Negative control: a link to a folder that is there serves as that folder."""
    (bench.folder / "real").mkdir()
    (bench.folder / "link").symlink_to("real")
    code, text = command(capsys, "report", bench.store, "--out", "link")
    assert code == 0, text
    assert (bench.folder / "real" / "report.html").is_file()


@pytest.mark.slow
def test_an_export_is_written_through_a_link(bench, capsys):
    """The folder behind the link is filled, and the link stays one."""
    (bench.folder / "real").mkdir()
    (bench.folder / "link").symlink_to("real")
    words = ["export-data", bench.store, "--to", "webdataset", "--split", "none", "--out", "link"]
    code, text = command(capsys, *words)
    assert code == 0, text
    assert (bench.folder / "link").is_symlink()
    assert (bench.folder / "real" / "README.md").is_file()


def test_a_link_in_the_place_of_a_recording_is_refused(bench, capsys):
    """The folder behind it is not what would be replaced; the link stays, and nothing is beside it."""
    (bench.folder / "real").mkdir()
    (bench.folder / "D20001").symlink_to("real")
    code, text = command(capsys, *typed(bench, WRITERS["D20002"]))
    assert code == 2, text
    assert "the recording D20001 is a link to real" in " ".join(text.split())
    assert sorted(path.name for path in bench.folder.iterdir()) == ["D20001", "real"]
