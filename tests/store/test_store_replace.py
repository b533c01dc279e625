"""A replaced take leaves a store as if the corrected one had come in its place: to read, check, merge and append to."""

from __future__ import annotations

import json
import os
import signal
from pathlib import Path

import numpy as np
import pytest
from copied_trees import copy_tree
from random_takes import SMALL, staged_take

from tactiledata.contract.take import Reference
from tactiledata.errors import StoreError, TactileDataError
from tactiledata.store.change.keep_sensors import BY_HAND, keep_sensors
from tactiledata.store.change.merge import merge
from tactiledata.store.change.replace import replace_takes
from tactiledata.store.check.check import check
from tactiledata.store.read.reader import Store
from tactiledata.store.write import commit as committing
from tactiledata.store.write.commit import commit, create, recover

pytestmark = pytest.mark.slow

MOMENTS = ("pwrite", "replace", "rename", "fsync", "ftruncate", "unlink", "rmdir", "open")


def with_takes(folder: Path, seeds: list[int], groups: int = 2, **options) -> Path:
    create(folder, SMALL)
    for start in range(0, len(seeds), groups):
        commit(folder, [staged_take(folder, seed, **options)[0] for seed in seeds[start : start + groups]])
    return folder


def everything(place: Path) -> dict:
    """All that a reader sees of a store, wherever its bytes lie."""
    store = Store.open(place)
    tables = {
        "frames": store.frames().drop_columns(["offset"]).to_pylist(),
        "trajectories": store.trajectories().to_pylist(),
        "sources": store.sources().to_pylist(),
        "findings": store.findings().to_pylist(),
    }
    numbers = {}
    for name in store.signal_names:
        rows = store.signal(name)
        numbers[f"signal {name}"] = [rows.t_ns(0, rows.n_rows).tolist(), repr(rows.values(0, rows.n_rows))]
        numbers[f"meaning {name}"] = vars(rows.meaning)
    for name in store.aligned_names:
        numbers[f"aligned {name}"] = [repr(one) for one in store.aligned(name)]
    for name in store.frame_value_names:
        numbers[f"values {name}"] = repr(store.frame_values(name))
    pictures = {name: one.image.tolist() for name, one in store.references().items()}
    images = store.encoded(range(store.n_frames))
    return {**tables, **numbers, "images": images, "sensors": store.sensors(), "pictures": pictures, "d": store.digest}


@pytest.mark.parametrize("target", [0, 1, 2, 3])
def test_replaced_equals_ingested_in_its_place(target: int, tmp_path: Path) -> None:
    """Whichever take is replaced, tables, numbers, images and digest are those of a store without the error."""
    seeds = [1, 2, 5, 7]
    place = with_takes(tmp_path / "ds.zarr", seeds)
    new, _ = staged_take(place, 11)
    old = Store.open(place).manifest["sources"][target]
    assert replace_takes(place, {old: new}) == []
    right = with_takes(tmp_path / "right.zarr", [*seeds[:target], 11, *seeds[target + 1 :]])
    assert everything(place) == everything(right)
    assert check(place, decode=True) == []


def test_replaced_twice_appended_and_merged(tmp_path: Path) -> None:
    """A store goes on as any other afterwards: replaced again, appended to, merged, with the rows of one without."""
    place = with_takes(tmp_path / "ds.zarr", [1, 2, 3])
    for new in (11, 13):
        replace_takes(place, {Store.open(place).manifest["sources"][0]: staged_take(place, new)[0]})
    commit(place, [staged_take(place, 4)[0]])
    right = with_takes(tmp_path / "right.zarr", [13, 2, 3, 4])
    assert everything(place) == everything(right)
    merge([place], tmp_path / "merged.zarr")
    assert everything(tmp_path / "merged.zarr") == everything(right)
    for one in (place, tmp_path / "merged.zarr"):
        assert check(one) == []
    assert sorted(entry.name for entry in place.glob("replaced-*")) == ["replaced-2"]


def test_a_take_may_go_without_another(tmp_path: Path) -> None:
    """A twin of a replaced take goes, and all rows behind it move up."""
    place = with_takes(tmp_path / "ds.zarr", [1, 2, 3])
    sources = Store.open(place).manifest["sources"]
    replace_takes(place, {sources[0]: staged_take(place, 9)[0], sources[2]: None})
    assert everything(place) == everything(with_takes(tmp_path / "right.zarr", [9, 2]))


def test_a_wrong_meaning_goes_with_the_take_that_brought_it(tmp_path: Path) -> None:
    """The first take said a wrong frame: the others were kept apart; corrected, all are one signal again."""
    create(tmp_path / "ds.zarr", SMALL)
    place = tmp_path / "ds.zarr"
    commit(place, [staged_take(place, 1, frame="wrong")[0], staged_take(place, 2)[0]])
    assert "wrench@ft" in Store.open(place).signal_names
    replace_takes(place, {Store.open(place).manifest["sources"][0]: staged_take(place, 11)[0]})
    assert everything(place) == everything(with_takes(tmp_path / "right.zarr", [11, 2]))
    assert Store.open(place).signal_names == ("wrench",)


def test_what_was_added_by_hand_stays(tmp_path: Path) -> None:
    """A sensor and a picture that no recording brought survive, before those of recordings."""
    place = with_takes(tmp_path / "ds.zarr", [1, 2])
    picture = np.full((4, 5, 3), 9, np.uint8)
    keep_sensors(place, {"D9": {"model": "digit"}}, {"D9": Reference(picture, f"{BY_HAND}bg.png", "CC0", "digit")})
    replace_takes(place, {Store.open(place).manifest["sources"][0]: staged_take(place, 11)[0]})
    store = Store.open(place)
    assert (store.reference("D9").image == picture).all()
    assert store.sensors()["D9"] == {"model": "digit"}
    assert check(place) == []


def test_a_picture_of_a_sensor_that_is_gone_goes_too(tmp_path: Path) -> None:
    """The picture came with the recording that named the wrong sensor: it is dropped, and that is said."""
    place = with_takes(tmp_path / "ds.zarr", [1, 2])
    assert list(Store.open(place).references()) == ["D1"]
    found = replace_takes(place, {Store.open(place).manifest["sources"][0]: staged_take(place, 12)[0]})
    assert [one.code for one in found] == ["picture-dropped"]
    assert Store.open(place).references() == {}


def test_an_open_reader_never_gets_numbers_of_another_state(tmp_path: Path) -> None:
    """A store that was open when a take was replaced gives its old numbers, or an error: never fill, never others."""
    place = with_takes(tmp_path / "ds.zarr", [1, 2, 3])
    opened, touched = Store.open(place), Store.open(place)
    rows = touched.signal("wrench")
    before = rows.values(0, 16).copy()
    replace_takes(place, {opened.manifest["sources"][0]: staged_take(place, 11)[0]})
    assert np.array_equal(rows.values(0, 16), before)
    with pytest.raises(StoreError, match="open"):
        rows.values(16, rows.n_rows)
    with pytest.raises(TactileDataError, match="signals/wrench"):
        opened.signal("wrench").values(0, 4)


def test_killed_while_replacing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Killed at any moment, a store is the old one or the new one, whole; run again, it is the new one."""
    monkeypatch.setattr(committing, "GROUP_TAKES", 2)
    origin = with_takes(tmp_path / "origin.zarr", [1, 2, 3])
    old = everything(origin)
    new = everything(with_takes(tmp_path / "right.zarr", [11, 2, 3]))
    first = Store.open(origin).manifest["sources"][0]
    states = []
    for moment in (1, 120, 240, 254, 300):
        place = copy_tree(origin, tmp_path / f"{moment}.zarr")
        child = os.fork()
        if child == 0:
            try:
                _kill_after(moment)
                replace_takes(place, {first: staged_take(place, 11)[0]})
            finally:
                os._exit(0)
        killed = os.WIFSIGNALED(os.waitpid(child, 0)[1])
        now = everything(place)
        assert now in (old, new)
        assert [one.code for one in check(place) if one.severity != "info"] == []
        states.append((killed, now == new))
        recover(place)
        if now == old:
            replace_takes(place, {first: staged_take(place, 11)[0]})
        assert everything(place) == new
        assert check(place) == []
    assert {(True, False), (True, True)} <= set(states)
    assert json.loads((place / "manifest.json").read_text())["generation"] == 1


def _kill_after(moment: int) -> None:
    """Let this process end by SIGKILL at the n-th call that changes the disk."""
    left = moment

    def counted(call):
        def run(*arguments, **options):
            nonlocal left
            left -= 1
            if left < 0:
                os.kill(os.getpid(), signal.SIGKILL)
            return call(*arguments, **options)

        return run

    for name in MOMENTS:
        setattr(os, name, counted(getattr(os, name)))


@pytest.mark.parametrize("table", ["frames", "trajectories", "sources", "findings"])
def test_a_damaged_table_is_not_written_on(tmp_path: Path, table: str) -> None:
    """A flipped byte mostly reads as other numbers: a rewritten table would carry them under a fitting checksum."""
    place = with_takes(tmp_path / "ds.zarr", [1, 2, 4, 5, 6], groups=5)
    store = Store.open(place)
    part = place / "index" / f"{table}.parquet" / store.manifest["index"][table][0]["file"]
    whole, manifest = part.read_bytes(), (place / "manifest.json").read_bytes()
    new, _ = staged_take(place, 3)
    for position in np.linspace(4, len(whole) - 1, 8).astype(int):
        part.write_bytes(whole[:position] + bytes([whole[position] ^ 0xFF]) + whole[position + 1 :])
        with pytest.raises(StoreError, match="damaged"):
            Store.open(place).table(table)
        with pytest.raises(StoreError, match="damaged"):
            replace_takes(place, {store.manifest["sources"][0]: new})
    assert (place / "manifest.json").read_bytes() == manifest
    part.write_bytes(whole)
    replace_takes(place, {store.manifest["sources"][0]: new})
