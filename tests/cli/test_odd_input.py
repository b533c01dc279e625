"""Odd but valid input comes through, and a machine that refuses loses nothing."""

import errno
import os

import cv2
import numpy as np
import pytest
from bench import command


@pytest.mark.slow
def test_very_long_and_unicode_names_survive(bench, capsys):
    """A recording, a trajectory and a sensor with names of other scripts and 150 letters come through as they are."""
    name = "Prüfung-测试-🤖-" + "x" * 130
    bench.lines("trajectories.csv", lambda rows: [rows[0], ",".join([name, *rows[1].split(",")[1:]]), *rows[2:]])
    moved = bench.folder / f"log-{name}"
    bench.log.rename(moved)
    code, text = command(capsys, "ingest", moved, "--store", bench.folder / "new.zarr", "--json")
    assert code in (0, 1), text
    code, text = command(capsys, "info", bench.folder / "new.zarr")
    assert code == 0, text
    from tactiledata.store.read.reader import Store

    assert name in Store.open(bench.folder / "new.zarr").trajectories(["trajectory"])["trajectory"].to_pylist()


@pytest.mark.slow
def test_names_do_not_steer_the_terminal(bench, capsys):
    """Escape sequences and turned writing in a name are kept in the store, and printed as text."""
    name = "p\x1b[31m\u202e0"
    bench.lines("trajectories.csv", lambda rows: [rows[0], ",".join([name, *rows[1].split(",")[1:]]), *rows[2:]])
    store = bench.folder / "new.zarr"
    for arguments in (
        ("ingest", bench.log, "--store", store), ("info", store), ("info", bench.folder / name),
        ("sensors", "add", name, "--background", bench.folder / name, "--store", store),
    ):  # fmt: skip
        _, text = command(capsys, *arguments)
        assert not {"\x1b", "\u202e"} & set(text), repr(text)
    assert "\\x1b[31m\\u202e0" in text
    from tactiledata.store.read.reader import Store

    assert name in Store.open(store).trajectories(["trajectory"])["trajectory"].to_pylist()


@pytest.mark.slow
def test_a_full_disk_loses_nothing(bench, capsys, monkeypatch):
    """A full disk is named in the message, the store stays as it was, and a later run completes it."""
    before = (bench.store / "manifest.json").read_bytes()
    fsync = os.fsync
    calls = [0]

    def full(descriptor):
        calls[0] += 1
        if calls[0] > 3:
            raise OSError(errno.ENOSPC, "No space left on device")
        return fsync(descriptor)

    (bench.log / "log.yaml").write_text((bench.log / "log.yaml").read_text() + "\n# another log\n")
    monkeypatch.setattr(os, "fsync", full)
    code, text = command(capsys, "ingest", bench.log, "--store", bench.store)
    assert code == 1
    assert "No space left" in text
    assert (bench.store / "manifest.json").read_bytes() == before
    monkeypatch.setattr(os, "fsync", fsync)
    code, text = command(capsys, "ingest", bench.log, "--store", bench.store)
    assert code == 0, text
    code, text = command(capsys, "check", bench.store)
    assert code == 0, text


def test_no_read_permission_is_said(bench, capsys, monkeypatch):
    """A file that may not be read is named, and the other recordings come in."""
    import builtins
    import pathlib

    real = pathlib.Path.open

    def guarded(self, *arguments, **options):
        if self.name == "run.mcap":
            raise PermissionError(errno.EACCES, "Permission denied", str(self))
        return real(self, *arguments, **options)

    monkeypatch.setattr(pathlib.Path, "open", guarded)
    monkeypatch.setattr(builtins, "open", builtins.open)
    code, text = command(capsys, "ingest", bench.mcap, bench.log, "--store", bench.folder / "new.zarr")
    assert code == 1
    assert "Permission denied" in text
    assert "Traceback" not in text


@pytest.mark.slow
def test_a_picture_of_noise_is_still_a_picture(bench, capsys):
    """Negative control: an unusual but valid picture is taken without damage."""
    path = sorted((bench.log / "frames").iterdir())[0]
    image = np.random.default_rng(0).integers(0, 255, (320, 240, 3), dtype=np.uint8)
    cv2.imwrite(str(path), image)
    code, text = command(capsys, *bench.ingest())
    assert code == 0, text
