"""Bad places, bad takes, full disks and other writers end in an error that says what to do, and lose nothing."""

from __future__ import annotations

import dataclasses
import json
import multiprocessing
import os
import resource
import signal
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from random_takes import SMALL, random_take, staged_take

from tactiledata.contract.records import Image
from tactiledata.contract.take import Reference
from tactiledata.errors import MissingFile, StoreBusy, StoreError, TactileDataError, UsageError
from tactiledata.store.check.check import check
from tactiledata.store.layout.lock import writing_lock
from tactiledata.store.layout.places import Settings, staging_folder
from tactiledata.store.read.reader import Store
from tactiledata.store.write.commit import commit, create, recover
from tactiledata.store.write.spool import Spool
from tactiledata.store.write.writer import find_staged, stage


def test_a_store_that_another_makes_meanwhile(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It is that store where another process makes it between two looks at the folder."""
    place = tmp_path / "ds.zarr"
    place.mkdir()
    look = Path.iterdir

    def made_before(folder: Path):
        monkeypatch.setattr(Path, "iterdir", look)
        create(place, SMALL)
        return look(folder)

    monkeypatch.setattr(Path, "iterdir", made_before)
    assert create(place, SMALL) == Store.open(place).manifest


def test_opening_nothing(tmp_path: Path) -> None:
    """A place that is not there, a folder without manifest, a file: each its own error."""
    with pytest.raises(MissingFile, match="no store"):
        Store.open(tmp_path / "no.zarr")
    with pytest.raises(StoreError, match="not a store"):
        Store.open(tmp_path)
    (tmp_path / "file").write_bytes(b"x")
    with pytest.raises(StoreError, match="not a store"):
        Store.open(tmp_path / "file")
    with pytest.raises(StoreError, match="cannot be opened"):
        Store.open("noprotocol://somewhere/ds.zarr")


@pytest.mark.parametrize(
    ("content", "match"),
    [
        (b"", "not JSON"),
        (b"[" * 100_000, "not JSON"),
        (b"[]", "format"),
        (b'{"format": "lerobot/3"}', "format"),
        (b'{"format": "tactiledata-store/2"}', "newer"),
        (b'{"format": "tactiledata-store/1"}', "does not fit schema"),
        (b'{"format": "tactiledata-store/1", "sources": 5}', "does not fit schema"),
        (b"\xff\xfe", "not JSON"),
    ],
)
def test_foreign_manifests(tmp_path: Path, content: bytes, match: str) -> None:
    """A manifest that is not ours, or newer than we are, is refused with what to do."""
    (tmp_path / "manifest.json").write_bytes(content)
    with pytest.raises(StoreError, match=match):
        Store.open(tmp_path)


def test_create_refuses_foreign_folders(tmp_path: Path) -> None:
    """A folder with something else in it is not turned into a store, and nothing in it changes."""
    (tmp_path / "thesis.tex").write_bytes(b"x")
    with pytest.raises(StoreError, match=r"thesis\.tex"):
        create(tmp_path)
    assert [place.name for place in tmp_path.iterdir()] == ["thesis.tex"]
    with pytest.raises(StoreError, match="is a file"):
        create(tmp_path / "thesis.tex")


def test_create_is_idempotent(tmp_path: Path) -> None:
    """Created twice is created once; other settings for a store that exists are an error."""
    create(tmp_path / "a", SMALL)
    before = (tmp_path / "a/manifest.json").read_bytes()
    create(tmp_path / "a")
    assert (tmp_path / "a/manifest.json").read_bytes() == before
    with pytest.raises(UsageError):
        create(tmp_path / "a", Settings())
    with pytest.raises(UsageError):
        Settings(heap_chunk_bytes=0)


def _hold(folder: str, ready: multiprocessing.synchronize.Event, done: multiprocessing.synchronize.Event) -> None:
    with writing_lock(folder):
        ready.set()
        done.wait(20)


def test_a_second_writer_is_told_the_first(tmp_path: Path) -> None:
    """While one process writes, another gets StoreBusy with its number; when it is gone, writing goes on."""
    create(tmp_path, SMALL)
    take = staged_take(tmp_path, 1)[0]
    context = multiprocessing.get_context("fork")
    ready, done = context.Event(), context.Event()
    holder = context.Process(target=_hold, args=(str(tmp_path), ready, done))
    holder.start()
    assert ready.wait(20)
    for write in (lambda: commit(tmp_path, [take]), lambda: recover(tmp_path)):
        with pytest.raises(StoreBusy, match=str(holder.pid)):
            write()
    done.set()
    holder.join()
    assert len(commit(tmp_path, [take])["sources"]) == 1


def test_reading_needs_no_lock(tmp_path: Path) -> None:
    """A store that is being written can be read."""
    create(tmp_path, SMALL)
    with writing_lock(tmp_path):
        assert Store.open(tmp_path).n_frames == 0


@pytest.mark.slow
@pytest.mark.parametrize("limit", [200, 3000])
def test_full_disk(tmp_path: Path, limit: int) -> None:
    """Where files cannot grow, the error says so, the store stays as it was, and the same commit works later."""
    create(tmp_path, Settings(1 << 20, 16, 4))
    commit(tmp_path, [staged_take(tmp_path, 1)[0]])
    take = staged_take(tmp_path, 3)[0]
    before = (tmp_path / "manifest.json").read_bytes()
    child = os.fork()
    if child == 0:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
        try:
            commit(tmp_path, [take])
        except StoreError as error:
            os._exit(3 if "cannot be written" in str(error) and "Make room" in str(error) else 4)
        os._exit(5)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 3
    assert (tmp_path / "manifest.json").read_bytes() == before
    assert {found.severity for found in check(tmp_path)} <= {"info"}
    recover(tmp_path)
    assert len(commit(tmp_path, [find_staged(tmp_path)[take.sha256]])["sources"]) == 2
    assert check(tmp_path) == []


def test_full_disk_while_spooling(tmp_path: Path) -> None:
    """A full disk during the reading of a recording is an error of the store, too."""
    child = os.fork()
    if child == 0:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
        try:
            spool = Spool(tmp_path / "spool")
            spool.add(Image("a", bytes(5000), "jpeg", 1, 1, 0))
            spool.close()
        except StoreError:
            os._exit(3)
        os._exit(4)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 3


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_read_only_folder(tmp_path: Path) -> None:
    """A folder that may not be written is an error with what to do, and reading it works."""
    create(tmp_path / "ds", SMALL)
    (tmp_path / "ds").chmod(0o500)
    try:
        with pytest.raises(StoreError, match="cannot be written"):
            recover(tmp_path / "ds")
        assert Store.open(tmp_path / "ds").n_frames == 0
    finally:
        (tmp_path / "ds").chmod(0o700)


def test_lock_that_cannot_be_opened(tmp_path: Path) -> None:
    """A lock file that cannot be made gives the store's own error."""
    create(tmp_path, SMALL)
    (tmp_path / ".lock").unlink()
    (tmp_path / ".lock").mkdir()
    with pytest.raises(StoreError, match="cannot be written"):
        recover(tmp_path)


@pytest.mark.parametrize(
    "image",
    [
        Image("a", bytes(5000), "jpeg", 10, 10, 0),
        Image("a", bytes(10), "raw", 2, 3, 0),
        Image("a", b"", "raw", 0, 0, 0),
        Image("a", b"", "gif", 2, 3, 0),  # type: ignore[arg-type]
        Image("a", b"", "jpeg", -1, 3, 0),
        Image("a", b"", "jpeg", 70_000, 3, 0),
        Image("", b"x", "jpeg", 2, 3, 0),
    ],
)
def test_spool_refuses_what_it_cannot_keep(tmp_path: Path, image: Image) -> None:
    """An image that does not fit its own facts or the store is refused before anything is written."""
    with Spool(tmp_path / "spool", largest_payload=4096) as spool:
        with pytest.raises(TactileDataError):
            spool.add(image)
        assert len(spool) == 0


def test_payload_larger_than_the_stores_chunk(tmp_path: Path) -> None:
    """A store with small chunks refuses a large image at commit; the store stays as it was."""
    create(tmp_path, SMALL)
    take = staged_take(tmp_path, 2, images=[Image("a", bytes(5000), "jpeg", 2, 3, 0)])[0]
    with pytest.raises(StoreError, match="5000 bytes"):
        commit(tmp_path, [take])
    assert Store.open(tmp_path).n_frames == 0


def _changed(name: str):
    def change(take):
        frames, trajectories = take.frames, take.trajectories

        def column(table: pa.Table, column_name: str, values) -> pa.Table:
            index = table.schema.get_field_index(column_name)
            return table.set_column(index, table.schema.field(index), pa.array(values, table.schema.field(index).type))

        changes = {
            "status": {"status": "fine"},
            "columns": {"frames": frames.drop_columns(["flags"])},
            "trajectory": {"frames": column(frames, "trajectory", [9] * len(frames))},
            "offset": {"frames": column(frames, "offset", [-5] * len(frames))},
            "range": {"trajectories": column(trajectories, "frame_stop", [10_000] * len(trajectories))},
            "time": {
                "signals": {
                    name: dataclasses.replace(signal, t_ns=signal.t_ns[::-1]) for name, signal in take.signals.items()
                }
            },
            "values": {
                "signals": {
                    name: dataclasses.replace(signal, values=signal.values[:1]) for name, signal in take.signals.items()
                }
            },
            "provenance": {"provenance": {"when": float("nan")}},
            "attributes": {
                "signals": {
                    name: dataclasses.replace(signal, attributes={"rate": float("inf")})
                    for name, signal in take.signals.items()
                }
            },
            "description": {"description": {"what": object()}},
            "reference": {"references": {"D1": Reference(np.zeros((3, 3), np.uint8), "x")}},
            "surrogate": {"sensors": {"D1": {"model": "\ud800"}}},
            "signal_rows": {"trajectories": column(trajectories, "signal_rows", ["no JSON"] * len(trajectories))},
            "unknown_signal": {
                "trajectories": column(trajectories, "signal_rows", ['{"x":[0,1]}'] * len(trajectories))
            },
        }
        return dataclasses.replace(take, **changes[name])

    return change


@pytest.mark.parametrize(
    "fault",
    [
        "status",
        "columns",
        "trajectory",
        "offset",
        "range",
        "time",
        "values",
        "provenance",
        "attributes",
        "description",
        "reference",
        "surrogate",
        "signal_rows",
        "unknown_signal",
    ],
)
def test_takes_that_do_not_fit_together(tmp_path: Path, fault: str) -> None:
    """A take with a fault is refused when it is staged; nothing of it is found afterwards."""
    seed = 3
    with Spool(staging_folder(tmp_path, "a" * 64)) as spool:
        take = dataclasses.replace(random_take(seed, spool, n_frames=10), sha256="a" * 64)
        assert len(take.trajectories)
        assert len(take.signals["wrench"].t_ns) > 2
        with pytest.raises(StoreError):
            stage(tmp_path, spool, _changed(fault)(take))
    assert find_staged(tmp_path) == {}


@pytest.mark.parametrize("file", ["digit.spool", "arrays.bin", "frames.parquet", "digit.rgb_6x8"])
@pytest.mark.parametrize("damage", ["flip", "cut"])
def test_staged_take_that_the_disk_damaged(tmp_path: Path, file: str, damage: str) -> None:
    """A staged take that is not what was written is refused at commit, by its CRC; the store stays as it was."""
    create(tmp_path, SMALL)
    take = staged_take(tmp_path, 1, n_frames=20)[0]
    place = take.folder / file
    content = bytearray(place.read_bytes())
    content[len(content) // 2] ^= 1
    place.write_bytes(content if damage == "flip" else content[: len(content) // 2])
    with pytest.raises(StoreError, match="damaged"):
        commit(tmp_path, [take])
    assert Store.open(tmp_path).n_frames == 0
    recover(tmp_path)
    assert check(tmp_path) == []


def test_staging_names_are_digests(tmp_path: Path) -> None:
    """A staging folder cannot be led out of the store."""
    for name in ("../../etc", "", "A" * 64, "a" * 63):
        with pytest.raises(UsageError):
            staging_folder(tmp_path, name)


def test_sensor_conflict_is_a_finding_and_first_wins(tmp_path: Path) -> None:
    """Another model or gel of a known serial is said once a recording; nothing is overwritten, and gaps are filled."""
    create(tmp_path, SMALL)
    takes = [
        staged_take(tmp_path, 2, sensors={"D1": {"power_on_ns": [1]}})[0],
        staged_take(tmp_path, 4, sensors={"D1": {"model": "digit", "power_on_ns": [2]}})[0],
        staged_take(tmp_path, 6, sensors={"D1": {"model": "gelsight"}})[0],
    ]
    commit(tmp_path, takes)
    store = Store.open(tmp_path)
    assert store.sensors() == {"D1": {"model": "digit"}}
    conflicts = [found for found in store.findings().to_pylist() if found["code"] == "sensor-conflict"]
    assert [found["source"] for found in conflicts] == [2]
    assert json.loads((tmp_path / "sensors.json").read_bytes()) == {"D1": {"model": "digit"}}
