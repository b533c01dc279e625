"""Kept decoded pictures are the decoded ones, whatever happens to their files, to processes and to the store."""

import errno
import multiprocessing
import os
import pickle
import shutil
import signal
import threading
import time
import warnings
from pathlib import Path

import loader_stores as made
import numpy as np
import pytest

from tactiledata.errors import StoreError, UsageError
from tactiledata.loaders import decoded_cache
from tactiledata.loaders.cache_room import ROW_BYTES
from tactiledata.loaders.decoded_cache import PAGE, DecodedCache, DecodedCacheWarning
from tactiledata.loaders.numpy import TactileArrays
from tactiledata.store.read.files import LocalFiles

SLOT = PAGE + ROW_BYTES
"""Bytes that a picture of these small stores takes."""


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A store of PNG files."""
    folder = tmp_path_factory.mktemp("cached") / "ds.zarr"
    made.write_loader_store(folder)
    return folder


def arrays(place, cache=None, **options):
    """All frames of a store as bytes."""
    chosen = {"image_dtype": "uint8", "allow_leaks": True, "threads": 1, **options}
    return TactileArrays(place, "all", ["digit"], cache=cache, **chosen)


def whole(dataset):
    """All pictures of a dataset."""
    return dataset.batch(range(len(dataset)))["digit"]


def fetches(monkeypatch):
    """How many images each later call reads from a local store, as a list that grows."""
    counts = []
    spans = LocalFiles.spans

    def counted(self, wanted):
        counts.append(sum("streams/" in path and start >= 0 for path, start, _ in wanted))
        return spans(self, wanted)

    monkeypatch.setattr(LocalFiles, "spans", counted)
    return counts


def slots(cache):
    """The file of slots in a folder that has one."""
    (path,) = cache.glob("*.pixels")
    return path


@pytest.mark.slow
@pytest.mark.parametrize("encoding", ["png", "jpeg", "raw"])
@pytest.mark.parametrize("size", [None, (7, 5)])
def test_cached_is_decoded_to_the_byte(tmp_path, monkeypatch, encoding, size):
    """First read, read again and read by a dataset made later, pictures are those without a cache, and decoded once."""
    made.write_loader_store(tmp_path / "ds.zarr", n_sources=2, encoding=encoding)
    plain = whole(arrays(tmp_path / "ds.zarr", image_size=size))
    first = arrays(tmp_path / "ds.zarr", tmp_path / "cache", image_size=size)
    counts = fetches(monkeypatch)
    for dataset in (first, first, arrays(tmp_path / "ds.zarr", tmp_path / "cache", threads=3, image_size=size)):
        np.testing.assert_array_equal(whole(dataset), plain)
    assert len(plain) == sum(counts)
    assert plain.shape[1:3] == (size or (made.HEIGHT, made.WIDTH))


def test_trajectories_and_halves_share_the_cache(place, tmp_path, monkeypatch):
    """Whole trajectories read what frames left, and only the frames that no dataset has read are decoded."""
    frames = arrays(place, tmp_path)
    frames.batch(range(0, len(frames), 2))
    counts = fetches(monkeypatch)
    touches = arrays(place, tmp_path, unit="trajectory")
    for item, plain in zip(
        touches.read_trajectories([0, 1]), arrays(place, unit="trajectory").read_trajectories([0, 1]), strict=True
    ):
        np.testing.assert_array_equal(item["digit"], plain["digit"])
    assert counts[0] == made.FRAMES  # half of two trajectories


@pytest.mark.parametrize("where", ["pixels", "record", "end"])
def test_a_flipped_byte_is_found_and_decoded_anew(place, tmp_path, where):
    """A byte that changed on the disk costs a decoding and a warning, and gives no other pixels; then all is whole."""
    dataset = arrays(place, tmp_path)
    plain = whole(dataset)
    count = made.HEIGHT * made.WIDTH * 3
    at = 5 * PAGE + {"pixels": 17, "record": count + 9, "end": count + 20}[where]
    with slots(tmp_path).open("r+b") as stream:
        stream.seek(at)
        byte = stream.read(1)
        stream.seek(at)
        stream.write(bytes([byte[0] ^ 0x10]))
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        np.testing.assert_array_equal(whole(dataset), plain)
    # a record that names another frame counts as empty, for a slot may have been given anew
    assert [one.category for one in heard] == ([] if where == "record" else [DecodedCacheWarning])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        np.testing.assert_array_equal(whole(arrays(place, tmp_path)), plain)


@pytest.mark.parametrize(
    "harm", ["cut", "emptied", "rows gone", "rows cut", "rows of nonsense", "rows turned", "pixels gone"]
)
def test_harmed_files_give_the_same_pictures(place, tmp_path, harm):
    """Files that were cut, emptied, removed or filled with something else give the right pictures."""
    plain = whole(arrays(place, tmp_path))
    pixels = slots(tmp_path)
    rows = pixels.with_suffix(".rows")
    {
        "cut": lambda: os.truncate(pixels, 3 * PAGE + 100),
        "emptied": lambda: os.truncate(pixels, 0),
        "rows gone": rows.unlink,
        "rows cut": lambda: os.truncate(rows, 8 * 5 + 3),
        "rows of nonsense": lambda: rows.write_bytes(np.arange(-40, 10**6, 10**4).tobytes()),
        "rows turned": lambda: rows.write_bytes(np.frombuffer(rows.read_bytes(), "<i8")[::-1].tobytes()),
        "pixels gone": pixels.unlink,
    }[harm]()
    for _ in range(2):
        np.testing.assert_array_equal(whole(arrays(place, tmp_path)), plain)


def test_the_bound_is_held(place, tmp_path, monkeypatch):
    """With room for ten pictures ten are kept, whatever is read; the report says so, and the batch is right."""
    bound = 10 * SLOT + 7
    dataset = arrays(place, tmp_path, cache_bytes=bound)
    np.testing.assert_array_equal(whole(dataset), whole(arrays(place)))
    taken = sum(path.stat().st_size for path in tmp_path.iterdir() if path.name != "lock")
    assert 10 * SLOT - PAGE < taken <= bound
    assert f"decoded pictures of 10 of {len(dataset)} frames have room" in str(dataset.report)
    counts = fetches(monkeypatch)
    whole(dataset)
    assert sum(counts) == len(dataset) - 10


def test_unused_caches_make_room_for_others(place, tmp_path):
    """Another size takes the room of a cache that nobody uses any more, and none of one that is in use."""
    bound = 30 * SLOT
    first = arrays(place, tmp_path, cache_bytes=bound)
    whole(first)
    second = arrays(place, tmp_path, cache_bytes=bound, image_size=(8, 6))
    assert "decoded pictures of 0 of" in str(second.report)
    np.testing.assert_array_equal(whole(second), whole(arrays(place, image_size=(8, 6))))
    del first
    third = arrays(place, tmp_path, cache_bytes=bound, image_size=(8, 6))
    assert "decoded pictures of 30 of" in str(third.report)
    whole(third)
    assert sum(path.stat().st_size for path in tmp_path.iterdir() if path.name != "lock") <= bound
    assert len(list(tmp_path.glob("*.pixels"))) == 1


def test_a_cache_that_was_removed_is_done_without(place, tmp_path):
    """A dataset that travels pickled, and finds its cache removed where it arrives, decodes, and says so."""
    dataset = arrays(place, tmp_path)
    plain = whole(dataset)
    there = pickle.loads(pickle.dumps(dataset))
    slots(tmp_path).unlink()
    with pytest.warns(DecodedCacheWarning, match="No such file"):
        np.testing.assert_array_equal(whole(there), plain)
    assert not list(tmp_path.glob("*.pixels"))
    np.testing.assert_array_equal(whole(dataset), plain)  # who has it open goes on with it (the negative control)


def test_a_lower_bound_shrinks_what_is_there(place, tmp_path):
    """A bound below what is kept already cuts it, where nobody else uses it."""
    plain = whole(arrays(place, tmp_path))
    lower = arrays(place, tmp_path, cache_bytes=4 * SLOT)
    assert slots(tmp_path).stat().st_size == 4 * PAGE
    np.testing.assert_array_equal(whole(lower), plain)


@pytest.mark.slow
def test_a_store_that_changed_is_decoded_anew(tmp_path):
    """Another recording in the place of the first gives its own pictures, from the same folder of caches."""
    store, cache = tmp_path / "ds.zarr", tmp_path / "cache"
    made.write_loader_store(store, encoding="png")
    before = whole(arrays(store, cache))
    shutil.rmtree(store)
    made.write_loader_store(store, encoding="jpeg")
    after = whole(arrays(store, cache))
    assert (after != before).any()
    np.testing.assert_array_equal(after, whole(arrays(store)))
    shutil.copytree(store, tmp_path / "copy.zarr")
    arrays(tmp_path / "copy.zarr", cache)
    assert len(list(cache.glob("*.pixels"))) == 2  # a copy of a store is the same recording


def _read_all(place, cache, seed, repeats, answers):
    dataset = arrays(place, cache)
    order = np.random.default_rng(seed).permutation(len(dataset))
    for _ in range(repeats):
        pictures = np.concatenate([dataset.batch(part)["digit"] for part in np.array_split(order, 6)])
    if answers is not None:
        answers.put((order, pictures))


def test_two_processes_fill_one_cache(place, tmp_path, monkeypatch):
    """Two processes that read and fill at once get the pictures of one, and leave a whole cache."""
    context = multiprocessing.get_context("fork")
    answers = context.Queue()
    both = [context.Process(target=_read_all, args=(place, tmp_path, seed, 2, answers)) for seed in (1, 2)]
    for process in both:
        process.start()
    plain = whole(arrays(place))
    for _ in both:
        order, pictures = answers.get(timeout=60)
        np.testing.assert_array_equal(pictures, plain[order])
    for process in both:
        process.join(60)
    counts = fetches(monkeypatch)
    np.testing.assert_array_equal(whole(arrays(place, tmp_path)), plain)
    assert sum(counts) == 0


def _fill_for_ever(place, cache):
    while True:
        whole(arrays(place, cache))
        for path in Path(cache).glob("*.pixels"):
            os.truncate(path, 0)


@pytest.mark.slow
def test_killed_while_it_writes_it_goes_on(place, tmp_path):
    """Killed at any moment, what is left gives the right pictures, without a warning, and is filled up."""
    context = multiprocessing.get_context("fork")
    plain = whole(arrays(place))
    for number in range(8):
        process = context.Process(target=_fill_for_ever, args=(place, tmp_path))
        process.start()
        time.sleep(0.03 + 0.011 * number)
        os.kill(process.pid, signal.SIGKILL)
        process.join()
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            for _ in range(2):
                np.testing.assert_array_equal(whole(arrays(place, tmp_path)), plain)


def test_threads_that_open_it_at_once_do_not_close_each_others_file(tmp_path, monkeypatch):
    """A copy opens its file at the first read: here by two threads, of which one reads while the other still opens."""
    kept = DecodedCache(tmp_path / "slots", np.arange(2), 2, (4, 3, 3))
    kept.open()
    pictures = np.random.default_rng(0).integers(0, 256, (2, 4, 3, 3), np.uint8)
    for row in range(2):
        kept.keep(row, pictures[row])
    both, first_reads, second_is_open = threading.Barrier(2), threading.Event(), threading.Event()
    open_slots, pread = decoded_cache.open_slots, os.pread

    def slow_open(path, flags=0):
        if both.wait(10) == 1:
            assert first_reads.wait(10)
        return open_slots(path, flags)

    def slow_read(*asked):
        if first_reads.is_set():
            second_is_open.set()
        else:
            first_reads.set()
            assert second_is_open.wait(10)
        return pread(*asked)

    monkeypatch.setattr(decoded_cache, "open_slots", slow_open)
    monkeypatch.setattr(os, "pread", slow_read)
    copy, found = pickle.loads(pickle.dumps(kept)), np.zeros_like(pictures)
    threads = [threading.Thread(target=copy.read, args=(row, found[row])) for row in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    np.testing.assert_array_equal(found, pictures)


@pytest.mark.slow
def test_workers_share_it(place, tmp_path, monkeypatch):
    """What the workers of a loader decoded is there for the main process, and the dataset travels pickled."""
    pytest.importorskip("torch")
    from torch.utils.data import DataLoader

    from tactiledata.loaders.torch import TactileDataset, collate

    dataset = TactileDataset(place, "all", ["digit"], cache=tmp_path, image_dtype="uint8", allow_leaks=True)
    loader = DataLoader(dataset, 8, num_workers=2, collate_fn=collate, multiprocessing_context="fork")
    batches = [batch["digit"].numpy() for batch in loader]
    counts = fetches(monkeypatch)
    there = pickle.loads(pickle.dumps(dataset.arrays))
    np.testing.assert_array_equal(whole(there), np.concatenate(batches).transpose(0, 2, 3, 1))
    assert sum(counts) == 0


def test_a_full_disk_is_said_once(place, tmp_path, monkeypatch):
    """Where nothing can be written any more, pictures are decoded and given, and one warning says why."""

    def full(*_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "pwrite", full)
    dataset = arrays(place, tmp_path)
    with pytest.warns(DecodedCacheWarning, match="No space left") as heard:
        given = [whole(dataset), whole(dataset)]
    assert len(heard) == 1
    np.testing.assert_array_equal(given, [whole(arrays(place))] * 2)


def test_an_image_that_turned_bad_is_still_an_error(tmp_path):
    """A cache hides no damage of what it does not hold (the negative control)."""
    made.write_loader_store(tmp_path / "ds.zarr", encoding="jpeg")
    dataset = arrays(tmp_path / "ds.zarr", tmp_path / "cache")
    dataset.batch([0, 1])
    heap = tmp_path / "ds.zarr" / "streams" / "digit" / "heap" / "c.0"
    with heap.open("r+b") as stream:
        stream.write(bytes(4096))
    assert dataset.batch([0, 1])["digit"].any()
    with pytest.raises(StoreError, match="the image of frame 2 "):
        dataset.batch([2])


def test_what_cannot_be_a_cache_is_refused(place, tmp_path):
    """A file in its place, a pipe in the place of its file, a bound without room, and no pictures are usage errors."""
    (tmp_path / "file").write_text("")
    with pytest.raises(UsageError, match="cannot be kept in"):
        arrays(place, tmp_path / "file")
    for bound in (SLOT - 1, -1, 1e9, None, True):
        with pytest.raises(UsageError, match="a bound of"):
            arrays(place, tmp_path / "cache", cache_bytes=bound)
    for folder in (True, 5, "", "s3://bucket/decoded"):
        with pytest.raises(UsageError, match="a folder on a local disk"):
            arrays(place, folder)
    with pytest.raises(UsageError, match="without pictures of a camera"):
        TactileArrays(place, "all", ["wrench"], cache=tmp_path / "cache", allow_leaks=True)
    arrays(place, tmp_path / "cache")
    pixels = slots(tmp_path / "cache")
    pixels.unlink()
    os.mkfifo(pixels)
    with pytest.raises(UsageError, match="cannot be kept in"):
        arrays(place, tmp_path / "cache")
