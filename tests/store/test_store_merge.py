"""Merged stores hold what one store holds into which everything was ingested."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from random_takes import SMALL, staged_take

from tactiledata.errors import StoreError, UsageError
from tactiledata.store.change.merge import merge
from tactiledata.store.check.check import check
from tactiledata.store.check.repair import repair
from tactiledata.store.read.reader import Store
from tactiledata.store.write.commit import commit, create


def made(folder: Path, seeds: list[int], **options) -> Path:
    create(folder, SMALL)
    commit(folder, [staged_take(folder, seed, **options)[0] for seed in seeds])
    return folder


def assert_same(one: Store, other: Store) -> None:
    """Both stores hold the same content under the same row numbers."""
    assert one.digest == other.digest
    for table in ("frames", "trajectories", "sources", "findings"):
        assert getattr(one, table)().to_pylist() == getattr(other, table)().to_pylist(), table
    rows = range(one.n_frames)
    assert one.encoded(rows) == other.encoded(rows)
    for kind in ("signals", "aligned", "frame_values", "sensors", "references"):
        assert one.manifest[kind] == other.manifest[kind], kind
    for name in one.signal_names:
        n_rows = one.signal(name).n_rows
        assert (one.signal(name).values(0, n_rows) == other.signal(name).values(0, n_rows)).all()
        assert (one.signal(name).t_ns(0, n_rows) == other.signal(name).t_ns(0, n_rows)).all()
    for name in one.aligned_names:
        for mine, theirs in zip(one.aligned(name), other.aligned(name), strict=True):
            np.testing.assert_array_equal(mine, theirs)
    assert one.sensors() == other.sensors()


@pytest.mark.slow
@pytest.mark.parametrize(("left", "right"), [([1, 2], [3, 4]), ([5], []), ([6, 7, 8], [8, 6, 9])])
def test_merge_is_ingest_of_both(tmp_path: Path, left: list[int], right: list[int]) -> None:
    """merge(A, B) equals the store into which all recordings of A, then of B, were ingested; doubles count once."""
    findings = merge([made(tmp_path / "a", left), made(tmp_path / "b", right)], tmp_path / "ab")
    together = made(tmp_path / "together", [*left, *(seed for seed in right if seed not in left)])
    assert_same(Store.open(tmp_path / "ab"), Store.open(together))
    assert check(tmp_path / "ab") == []
    assert ("merge-twice" in {found.code for found in findings}) == bool(set(left) & set(right))


@pytest.mark.slow
def test_merge_again_changes_nothing(tmp_path: Path) -> None:
    """A merge that ran to its end and runs again leaves the store as it is."""
    stores = [made(tmp_path / "a", [1]), made(tmp_path / "b", [2])]
    merge(stores, tmp_path / "ab")
    before = (tmp_path / "ab/manifest.json").read_bytes()
    merge(stores, tmp_path / "ab")
    assert (tmp_path / "ab/manifest.json").read_bytes() == before


@pytest.mark.slow
def test_merge_keeps_signals_of_other_frames_apart(tmp_path: Path) -> None:
    """Wrenches in different frames are not one signal; merging says so, as ingesting both does."""
    stores = [made(tmp_path / "a", [1, 2]), made(tmp_path / "b", [3, 4], frame="tool0")]
    findings = merge(stores, tmp_path / "ab")
    store = Store.open(tmp_path / "ab")
    assert store.signal_names == ("wrench", "wrench@tool0")
    assert store.signal("wrench@tool0").frame == "tool0"
    assert "signal-variant" in {found.code for found in findings}
    again = tmp_path / "again"
    merge([tmp_path / "ab"], again)
    assert_same(Store.open(again), store)


@pytest.mark.slow
def test_merge_says_sensor_conflicts(tmp_path: Path) -> None:
    """One serial with two models: the first stays, and the conflict is said."""
    stores = [made(tmp_path / "a", [2]), made(tmp_path / "b", [4], sensors={"D1": {"model": "gelsight"}})]
    findings = merge(stores, tmp_path / "ab")
    assert "sensor-conflict" in {found.code for found in findings}
    assert Store.open(tmp_path / "ab").sensors() == {"D1": {"model": "digit"}}


@pytest.mark.slow
def test_merge_moves_parents(tmp_path: Path) -> None:
    """Frames derived from others point to their parents' new rows."""
    from random_takes import Spool, random_take, stage, staging_folder

    folder = tmp_path / "b"
    create(folder, SMALL)
    commit(folder, [staged_take(folder, 1)[0]])
    n_parents = Store.open(folder).n_frames
    sha256 = random_take_digest(2)
    spool = Spool(staging_folder(folder, sha256))
    take = random_take(2, spool, n_frames=n_parents)
    index = take.frames.schema.get_field_index("parent_frame")
    frames = take.frames.set_column(index, take.frames.schema.field(index), pa.array(range(n_parents), pa.int64()))
    commit(folder, [stage(folder, spool, type(take)(**{**take.__dict__, "frames": frames}))])
    merge([made(tmp_path / "a", [3]), folder], tmp_path / "ab")
    store = Store.open(tmp_path / "ab")
    first = Store.open(tmp_path / "a").n_frames
    parents = store.frames(["parent_frame"])["parent_frame"].to_pylist()
    assert parents == [-1] * (first + n_parents) + list(range(first, first + n_parents))


def random_take_digest(seed: int) -> str:
    import hashlib

    return hashlib.sha256(f"source {seed}".encode()).hexdigest()


@pytest.mark.slow
def test_merge_refuses_damaged_images_until_marked(tmp_path: Path) -> None:
    """A damaged image stops a merge with its row; marked as broken it goes along."""
    folder = made(tmp_path / "a", [1, 2, 3])
    place = folder / "streams/digit/heap/c.0"
    content = bytearray(place.read_bytes())
    content[10] ^= 1
    place.write_bytes(content)
    with pytest.raises(StoreError, match="--repair"):
        merge([folder], tmp_path / "ab")
    repair(folder)
    merge([folder], tmp_path / "ab")
    assert Store.open(tmp_path / "ab").n_frames == Store.open(folder).n_frames


@pytest.mark.slow
def test_merge_says_that_splits_stay_behind(tmp_path: Path) -> None:
    """Splits belong to their store; a merge says that it did not copy them."""
    folder = made(tmp_path / "a", [1])
    (folder / "splits").mkdir()
    for suffix in (".json", ".parquet"):
        (folder / f"splits/default{suffix}").write_bytes(b"{}")
    assert "merge-split" in {found.code for found in merge([folder], tmp_path / "ab")}
    twice = [found.code for found in merge([folder, folder], tmp_path / "aa")]
    assert twice.count("merge-split") == 1


def test_merge_into_itself_is_refused(tmp_path: Path) -> None:
    """A store cannot be merged into itself, nor nothing into something."""
    folder = made(tmp_path / "a", [1])
    with pytest.raises(UsageError):
        merge([folder], folder)
    with pytest.raises(UsageError):
        merge([], tmp_path / "b")


@pytest.mark.slow
def test_merge_carries_sensors_added_by_hand(tmp_path: Path) -> None:
    """A sensor that no recording carries goes along, with its picture."""
    from tactiledata.contract.take import Reference
    from tactiledata.store.change.keep_sensors import keep_sensors

    folder = made(tmp_path / "a", [1])
    picture = np.full((4, 5, 3), 7, np.uint8)
    keep_sensors(folder, {"D9": {"model": "digit"}}, {"D9": Reference(picture, "bg.png", "CC0", "digit")})
    merge([made(tmp_path / "b", [2]), folder], tmp_path / "ab")
    store = Store.open(tmp_path / "ab")
    assert store.sensors()["D9"] == {"model": "digit"}
    assert (store.reference("D9").image == picture).all()
    assert store.reference("D9").licence == "CC0"
    assert check(tmp_path / "ab") == []


@pytest.mark.slow
def test_merge_leaves_sensors_of_recordings_that_stay_out(tmp_path: Path) -> None:
    """A recording that two stores hold under different serials is kept once, and so is its sensor."""
    from tactiledata.contract.take import Reference
    from tactiledata.store.change.keep_sensors import BY_HAND, keep_sensors

    first, other = made(tmp_path / "a", [1]), made(tmp_path / "b", [1], sensors={"D7": {"model": "digit"}})
    assert "D7" in Store.open(other).sensors()
    merge([first, other], tmp_path / "ab")
    assert sorted(Store.open(tmp_path / "ab").sensors()) == sorted(Store.open(first).sensors())
    picture = np.full((4, 5, 3), 7, np.uint8)
    keep_sensors(other, {"D8": {"model": "digit"}}, {"D8": Reference(picture, f"{BY_HAND}bg.png", "CC0", "digit")})
    merge([first, other], tmp_path / "abc")
    assert sorted(Store.open(tmp_path / "abc").sensors()) == sorted({*Store.open(first).sensors(), "D8"})


def taken_by(folder: Path, settings: str) -> Path:
    """A store with one recording that was ingested with these options."""
    from dataclasses import replace

    from random_takes import Spool, random_take, stage, staging_folder

    create(folder, SMALL)
    spool = Spool(staging_folder(folder, random_take_digest(1)))
    take = replace(random_take(1, spool), provenance={"settings_sha256": settings})
    commit(folder, [stage(folder, spool, take)])
    return folder


@pytest.mark.slow
def test_merge_says_what_was_ingested_otherwise(tmp_path: Path) -> None:
    """One recording taken with two mappings: the first stays, and a warning names the other; equal ones give none."""
    first, other, same = (
        taken_by(tmp_path / name, settings) for name, settings in (("a", "1"), ("b", "2"), ("c", "1"))
    )
    assert "merge-otherwise" not in {found.code for found in merge([first, same], tmp_path / "ac")}
    (finding,) = (found for found in merge([first, other], tmp_path / "ab") if found.code == "merge-otherwise")
    assert finding.severity == "warning"
    assert str(other) in finding.message
    assert "merge-otherwise" in {found.code for found in merge([other], tmp_path / "ac")}
