"""What was put into a store comes out of it: payloads, pixels, numbers, tables, whatever the commits were."""

from __future__ import annotations

import json
import pickle
import tempfile
from pathlib import Path

import google_crc32c
import numpy as np
import pyarrow as pa
import pytest
import zarr
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from random_takes import SMALL, random_images, random_take, staged_take

from tactiledata.contract.records import Image
from tactiledata.contract.take import Take
from tactiledata.errors import StoreError, UnknownName, UsageError
from tactiledata.store.layout.images import place_payloads
from tactiledata.store.layout.places import Settings, folder_name
from tactiledata.store.read.reader import Store
from tactiledata.store.write.commit import commit, commit_groups, create
from tactiledata.store.write.spool import Spool


class Images(list):
    """An image sink that keeps what it is given."""

    def add(self, image: Image) -> None:
        self.append(image)


def planted(seed: int, **options) -> tuple[Take, list[Image]]:
    """The take of a seed with its images, as it is before any store has seen it."""
    with tempfile.TemporaryDirectory() as folder, Spool(Path(folder) / "spool") as spool:
        kept = Images()
        add = spool.add

        def both(image: Image) -> None:
            kept.add(image)
            add(image)

        spool.add = both  # type: ignore[method-assign]
        return random_take(seed, spool, **options), list(kept)


def assert_holds(store: Store, seeds: list[int]) -> None:
    """The store holds these seeds' takes, in order, and nothing else."""
    frames, sources = store.frames(), store.sources()
    assert sources["key"].to_pylist() == [f"run{seed}" for seed in seeds]
    row = trajectory_row = 0
    signal_row = dict.fromkeys(store.signal_names, 0)
    trajectories = store.trajectories().to_pylist()
    for number, seed in enumerate(seeds):
        take, images = planted(seed)
        rows = range(row, row + len(images))
        mine = frames.slice(row, len(images))
        assert store.encoded(rows) == [None if image.encoding == "missing" else image.payload for image in images]
        for column in ("camera", "sensor", "t_ns", "log_ns", "encoding", "height", "width", "crc32c", "contact_force"):
            assert mine[column].to_pylist() == take.frames[column].to_pylist(), column
        assert set(mine["source"].to_pylist()) <= {number}
        local = np.asarray(take.frames["trajectory"])
        assert mine["trajectory"].to_pylist() == np.where(local < 0, -1, local + trajectory_row).tolist()
        for name, signal in take.signals.items():
            start, stop = signal_row[name], signal_row[name] + len(signal.t_ns)
            assert (store.signal(name).t_ns(start, stop) == signal.t_ns).all()
            assert (store.signal(name).values(start, stop) == signal.values).all()
            assert (store.signal(name).stamps("log", start, stop) == signal.stamps.log).all()
            assert (store.signal(name).stamps("header", start, stop) == -1).all()
            for entry in take.trajectories.to_pylist():
                stored = trajectories[trajectory_row]
                span = json.loads(entry["signal_rows"])[name]
                assert json.loads(stored["signal_rows"]) == {name: [start + span[0], start + span[1]]}
                assert [stored["frame_start"], stored["frame_stop"]] == [
                    row + entry["frame_start"],
                    row + entry["frame_stop"],
                ]
                assert stored["uid"] == entry["uid"]
                assert stored["source"] == number
                trajectory_row += 1
            signal_row[name] = stop
        for name in store.aligned_names:
            values, gap = store.aligned(name, rows)
            if name in take.aligned:
                assert (values == take.aligned[name].values).all()
                assert (gap == take.aligned[name].gap_ns).all()
            else:
                assert np.isnan(values).all()
                assert (gap == -1).all()
        for name in store.frame_value_names:
            known = take.frame_values.get(name)
            values = store.frame_values(name, rows)
            assert (values == known.values).all() if known else np.isnan(values).all()
        row += len(images)
    assert store.n_frames == row == len(frames)
    assert len(trajectories) == trajectory_row
    assert {name: store.signal(name).n_rows for name in store.signal_names} == signal_row


def filled(folder: Path, groups: list[list[int]], **options) -> Store:
    """A store after one commit a group of seeds."""
    create(folder, options.pop("settings", SMALL))
    for group in groups:
        commit(folder, [staged_take(folder, seed, **options)[0] for seed in group])
    return Store.open(folder)


@st.composite
def grouped_seeds(draw: st.DrawFn) -> list[list[int]]:
    """Different seeds in any number of groups."""
    seeds = draw(st.lists(st.integers(0, 10_000), min_size=1, max_size=4, unique=True))
    borders = sorted(draw(st.sets(st.integers(1, len(seeds)))) | {len(seeds)})
    return [seeds[start:stop] for start, stop in zip([0, *borders[:-1]], borders, strict=True)]


@pytest.mark.slow
@settings(max_examples=4, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(grouped_seeds(), st.sampled_from([SMALL, Settings(1 << 20, 1000, 64), Settings(1000, 1, 1)]))
def test_random_takes_come_back(groups: list[list[int]], sizes: Settings) -> None:
    """Whatever the groups and the sizes of chunks, every byte and number comes back."""
    with tempfile.TemporaryDirectory() as folder:
        store = filled(Path(folder) / "ds.zarr", groups, settings=sizes)
        assert_holds(store, [seed for group in groups for seed in group])


@pytest.mark.slow
@settings(max_examples=2, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(grouped_seeds())
def test_content_does_not_depend_on_groups(groups: list[list[int]]) -> None:
    """One commit or many: the digest and the content of all tables agree."""
    together = [[seed for group in groups for seed in group]]
    with tempfile.TemporaryDirectory() as folder:
        one, many = filled(Path(folder) / "one", together), filled(Path(folder) / "many", groups)
        assert one.digest == many.digest
        for table in ("frames", "trajectories", "sources", "findings"):
            assert getattr(one, table)().to_pylist() == getattr(many, table)().to_pylist()


@pytest.mark.slow
def test_digest_depends_on_content_and_order(tmp_path: Path) -> None:
    """Other takes, or the same in another order, are another store."""
    digests = [filled(tmp_path / str(index), [group]).digest for index, group in enumerate([[1, 2], [2, 1], [1, 3]])]
    assert len(set(digests)) == 3


def test_same_source_twice_changes_nothing(tmp_path: Path) -> None:
    """A source that the store holds is skipped, and its staging folder removed; the manifest keeps its bytes."""
    filled(tmp_path, [[1, 2]])
    before = (tmp_path / "manifest.json").read_bytes()
    commit(tmp_path, [staged_take(tmp_path, 2)[0]])
    commit_groups(tmp_path, [staged_take(tmp_path, seed)[0] for seed in (1, 2)])
    assert (tmp_path / "manifest.json").read_bytes() == before
    assert not list((tmp_path / ".staging").glob("*/"))


def test_same_source_twice_in_one_group(tmp_path: Path) -> None:
    """A take given twice to one commit is kept once."""
    create(tmp_path, SMALL)
    take = staged_take(tmp_path, 1)[0]
    commit(tmp_path, [take, take])
    assert Store.open(tmp_path).sources()["key"].to_pylist() == ["run1"]


def test_pictures_decode_to_planted_pixels(tmp_path: Path) -> None:
    """PNG and raw frames come out as the planted pixels, in RGB, in the order asked for, with any number of threads."""
    rng = np.random.default_rng(0)
    pixels = rng.integers(0, 256, (20, 6, 8, 3), dtype=np.uint8)
    import cv2

    images = [
        Image("digit", one.tobytes(), "raw", 6, 8, 0)
        if index % 2
        else Image("digit", cv2.imencode(".png", one[..., ::-1])[1].tobytes(), "png", 6, 8, 0)
        for index, one in enumerate(pixels)
    ]
    store = filled(tmp_path, [[1]], images=images)
    order = rng.permutation(20)
    for threads in (None, 1, 3):
        assert (np.asarray(store.images(order, threads=threads)) == pixels[order]).all()
    mask = np.arange(20) % 3 == 0
    assert (np.asarray(store.images(mask)) == pixels[mask]).all()


def test_pictures_of_several_sizes_are_a_list(tmp_path: Path) -> None:
    """Frames of different sizes come as a list, each of its own size."""
    images = [Image("a", bytes(range(18)), "raw", 2, 3, 0), Image("a", bytes(12), "raw", 2, 2, 0)]
    store = filled(tmp_path, [[1]], images=images)
    pictures = store.images([0, 1])
    assert isinstance(pictures, list)
    assert [picture.shape for picture in pictures] == [(2, 3, 3), (2, 2, 3)]
    assert pictures[0].tobytes() == bytes(range(18))


def test_missing_and_broken_images_name_their_row(tmp_path: Path) -> None:
    """A missing image is an error or zeros, as asked; one that does not decode is an error with its row."""
    images = [
        Image("a", b"", "missing", 2, 3, 0),
        Image("a", b"no JPEG at all", "jpeg", 2, 3, 0),
        Image("a", b"", "jpeg", 2, 3, 0),
    ]
    store = filled(tmp_path, [[1]], images=images)
    assert store.encoded([0, 1, 2]) == [None, b"no JPEG at all", b""]
    assert not np.asarray(store.images([0], missing="zeros")).any()
    for row in range(3):
        with pytest.raises(StoreError, match=f"frame {row} ") as error:
            store.images([row])
        assert error.value.facts["row"] == row


@pytest.mark.slow
def test_plain_zarr_reads_the_arrays(tmp_path: Path) -> None:
    """Somebody with zarr alone reads heap, raw frames, signals and references."""
    store = filled(tmp_path, [[3, 4], [5, 7, 8]])
    root = zarr.open_group(str(tmp_path), mode="r")
    frames = store.frames().to_pylist()
    heap = np.asarray(root["streams/digit/heap"][...])
    n_raw = 0
    for row, payload in enumerate(store.encoded(range(store.n_frames))):
        frame = frames[row]
        if frame["encoding"] in ("jpeg", "png"):
            assert heap[frame["offset"] : frame["offset"] + frame["length"]].tobytes() == payload
        elif frame["encoding"] == "raw":
            array = root[f"streams/digit/rgb_{frame['height']}x{frame['width']}"]
            assert np.asarray(array[frame["offset"]]).tobytes() == payload
            n_raw += 1
        assert payload is None or google_crc32c.value(payload) == frame["crc32c"]
    assert n_raw > 4
    signal = store.signal("wrench")
    value = root["signals/wrench/value"]
    assert (np.asarray(value[...]) == signal.values(0, signal.n_rows)).all()
    assert value.attrs["columns"] == ["fx", "fz"]
    assert (np.asarray(root["reference/D1/image"][...]) == store.references()["D1"].image).all()


def test_tensorstore_reads_raw_frames(tmp_path: Path) -> None:
    """Shards that are put together here are shards to another implementation of the format."""
    tensorstore = pytest.importorskip("tensorstore")
    images = [Image("a", bytes([index]) * 18, "raw", 2, 3, 0) for index in range(11)]
    filled(tmp_path, [[1]], images=images)
    spec = {"driver": "zarr3", "kvstore": {"driver": "file", "path": str(tmp_path / "streams/a/rgb_2x3")}}
    array = tensorstore.open(spec, read=True).result()
    assert (array[:].read().result()[:, 0, 0, 0] == np.arange(11)).all()


def test_store_pickles(tmp_path: Path) -> None:
    """A store that has read everything travels to another process and reads on."""
    store = filled(tmp_path, [[3, 4]])
    rows = range(store.n_frames)
    store.images(rows, missing="zeros")
    store.signal("wrench").values(0, 1)
    again = pickle.loads(pickle.dumps(store))
    assert again.encoded(rows) == store.encoded(rows)
    assert (again.signal("wrench").values(0, 5) == store.signal("wrench").values(0, 5)).all()


@pytest.mark.parametrize("rows", [[-1], [10_000], [0.5], [[0]], ["a"]])
def test_rows_outside_are_refused(tmp_path: Path, rows: list) -> None:
    """A row that is no row is an error with the range, not the last frame or a traceback."""
    store = filled(tmp_path, [[3]])
    for read in (store.encoded, store.images, lambda rows: store.frame_values("centre", rows)):
        if read is not store.images and "centre" not in store.frame_value_names and read is not store.encoded:
            continue
        with pytest.raises(UsageError):
            read(rows)


def test_unknown_names_list_the_known(tmp_path: Path) -> None:
    """A signal, value or column that is not there is an error that names what is."""
    store = filled(tmp_path, [[3]])
    with pytest.raises(UnknownName, match="wrench"):
        store.signal("wrensh")
    with pytest.raises(UnknownName, match="t_ns"):
        store.frames(["t_nss"])
    with pytest.raises(UnknownName):
        store.aligned("no")


def test_columns_are_projected(tmp_path: Path) -> None:
    """A table has the columns that were asked for, in that order."""
    store = filled(tmp_path, [[3], [4]])
    assert store.frames(["t_ns", "camera"]).column_names == ["t_ns", "camera"]
    assert store.frames(["camera"])["camera"].to_pylist() == store.frames()["camera"].to_pylist()
    assert isinstance(store.findings(), pa.Table)


@given(st.lists(st.integers(0, 50), max_size=60), st.integers(0, 500))
def test_payloads_never_straddle(lengths: list[int], start: int) -> None:
    """No payload crosses a border of chunks, none overlaps another, and no more is skipped than needed."""
    chunk = 50
    offsets = place_payloads(lengths, start, chunk)
    end = start
    for offset, length in zip(offsets.tolist(), lengths, strict=True):
        assert offset >= end
        assert length == 0 or offset // chunk == (offset + length - 1) // chunk
        assert offset == end or (offset % chunk == 0 and end % chunk + length > chunk)
        end = offset + length


@given(st.lists(st.text(min_size=1, max_size=300), min_size=2, max_size=8, unique=True))
def test_folder_names_are_safe_and_distinct(names: list[str]) -> None:
    """Any name gives a folder that stays inside, fits a file system, and no two names share one."""
    folders = [folder_name(name) for name in names]
    assert len(set(folders)) == len(folders)
    for folder in folders:
        assert folder.isascii()
        assert "/" not in folder
        assert not folder.startswith(".")
        assert len(folder) < 200


@pytest.mark.parametrize("camera", ["links/rechts", "..", "Kamera ü", "x" * 400, "c", "zarr.json"])
def test_strange_camera_names(tmp_path: Path, camera: str) -> None:
    """A camera of any name is kept under it."""
    images = [Image(camera, b"abc", "jpeg", 2, 3, 0), Image(camera, bytes(18), "raw", 2, 3, 0)]
    store = filled(tmp_path / "ds.zarr", [[1]], images=images)
    assert store.cameras == (camera,)
    assert store.encoded([0, 1]) == [b"abc", bytes(18)]
    assert [place.name for place in tmp_path.iterdir()] == ["ds.zarr"]


def test_random_images_have_all_kinds() -> None:
    """The generator behind these tests plants every encoding (a control of the tests themselves)."""
    kinds = {image.encoding for image in random_images(np.random.default_rng(0), 60)}
    assert kinds == {"jpeg", "png", "raw", "missing"}
