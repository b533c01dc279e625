"""A store reads the same from a folder, from memory, out of a zip file, over HTTP, and on both sides of a fork."""

from __future__ import annotations

import contextlib
import functools
import hashlib
import http.server
import os
import threading
import zipfile
from collections.abc import Iterator
from pathlib import Path

import fsspec
import numpy as np
import pytest
from copied_trees import copy_tree
from random_takes import SMALL, random_images, staged_take

from tactiledata.contract.sealed import sealed_json
from tactiledata.errors import MissingFile, StoreError
from tactiledata.store.check.check import check
from tactiledata.store.read.reader import Store
from tactiledata.store.write.commit import commit, create


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A store with every kind of content."""
    place = tmp_path_factory.mktemp("remote") / "ds.zarr"
    create(place, SMALL)
    rng = np.random.default_rng(0)
    commit(place, [staged_take(place, seed, images=random_images(rng, 12))[0] for seed in (1, 2, 3)])
    (place / "splits").mkdir()
    (place / "splits/default.parquet").write_bytes(b"a table")
    table = {"file": "default.parquet", "sha256": hashlib.sha256(b"a table").hexdigest()}
    document = {"format": "tactiledata-split/1", "table": table}
    (place / "splits/default.json").write_bytes(sealed_json(document))
    return place


class _WholeFiles(http.server.SimpleHTTPRequestHandler):
    """Serves whole files whatever range is asked for, as `python -m http.server` does, silently."""

    def log_message(self, *_: object) -> None:
        pass


class _Ranges(_WholeFiles):
    """Serves byte ranges, silently."""

    def do_GET(self) -> None:
        asked = self.headers.get("Range")
        place = Path(self.translate_path(self.path))
        if not asked or not place.is_file():
            super().do_GET()
            return
        size = place.stat().st_size
        first, _, last = asked.removeprefix("bytes=").partition("-")
        start = int(first) if first else size - int(last)
        stop = int(last) + 1 if first and last else size
        with place.open("rb") as stream:  # heaps are large: reading them whole for a range takes long
            stream.seek(start)
            part = stream.read(stop - start)
        self.send_response(206)
        self.send_header("Content-Length", str(len(part)))
        self.send_header("Content-Range", f"bytes {start}-{start + len(part) - 1}/{size}")
        self.end_headers()
        self.wfile.write(part)


@contextlib.contextmanager
def _served(folder: Path, handler: type[http.server.SimpleHTTPRequestHandler]) -> Iterator[str]:
    """The URL of a store that a server of this process serves."""
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(handler, directory=str(folder.parent)))
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    try:
        yield f"http://127.0.0.1:{server.server_port}/{folder.name}"
    finally:
        server.shutdown()
        server.server_close()
        thread.join()


@pytest.fixture
def url(folder: Path, tmp_path: Path, request: pytest.FixtureRequest) -> Iterator[str]:
    """The store's URL over a protocol."""
    if request.param == "memory":
        system = fsspec.filesystem("memory")
        system.put(str(folder), "/remote/ds.zarr", recursive=True)
        yield "memory://remote/ds.zarr"
        system.rm("/remote", recursive=True)
    elif request.param == "zip":
        place = tmp_path / "ds.zip"
        with zipfile.ZipFile(place, "w") as archive:
            for file in folder.rglob("*"):
                archive.write(file, file.relative_to(folder))
        yield f"zip://::file://{place}"
    elif request.param == "file":
        yield f"file://{folder}"
    else:
        pytest.importorskip("aiohttp")
        with _served(folder, _Ranges) as place:
            yield place


def test_a_server_without_byte_ranges_is_named(folder: Path) -> None:
    """Whole files in the place of ranges would be read as damage: the message says what the server lacks."""
    pytest.importorskip("aiohttp")
    with _served(folder, _WholeFiles) as place:
        store = Store.open(place)
        assert store.n_frames == Store.open(folder).n_frames
        for read in (lambda: store.images([0]), lambda: store.signal("wrench").values(0, 3)):
            with pytest.raises(StoreError, match="asked for 2 bytes") as caught:
                read()
            assert "python -m http.server" in str(caught.value)


@pytest.mark.slow
@pytest.mark.parametrize("url", ["file", "memory", "zip", "http"], indirect=True)
def test_remote_store_reads_the_same(folder: Path, url: str) -> None:
    """Tables, payloads, pictures, signals, values, references and splits are all as from the folder."""
    local, remote = Store.open(folder), Store.open(url)
    rows = np.random.default_rng(0).permutation(local.n_frames)
    assert remote.digest == local.digest
    assert remote.frames().to_pylist() == local.frames().to_pylist()
    assert remote.encoded(rows) == local.encoded(rows)
    for mine, theirs in zip(local.images(rows, missing="zeros"), remote.images(rows, missing="zeros"), strict=True):
        assert (mine == theirs).all()
    n_rows = local.signal("wrench").n_rows
    assert (remote.signal("wrench").values(3, n_rows) == local.signal("wrench").values(3, n_rows)).all()
    for name in local.aligned_names:
        np.testing.assert_array_equal(remote.aligned(name, rows)[0], local.aligned(name, rows)[0])
    assert (remote.references()["D1"].image == local.references()["D1"].image).all()
    assert remote.sensors() == local.sensors()
    assert local.split_names() == ["default"]
    assert remote.split_names() == ["default"]
    assert check(remote) == []


@pytest.mark.slow
@pytest.mark.parametrize("url", ["memory", "http"], indirect=True)
def test_remote_place_without_store(url: str) -> None:
    """A URL without a store is an error, not a traceback of the protocol."""
    with pytest.raises((MissingFile, StoreError)):
        Store.open(url.replace("ds.zarr", "no.zarr"))


def test_missing_chunk_is_named(folder: Path, tmp_path: Path) -> None:
    """A chunk file that is gone is an error with its name."""
    copy = copy_tree(folder, tmp_path / "ds.zarr")
    (copy / "streams/digit/heap/c.0").unlink()
    store = Store.open(copy)
    encodings = store.frames(["encoding"])["encoding"].to_pylist()
    row = next(index for index, encoding in enumerate(encodings) if encoding in ("jpeg", "png"))
    with pytest.raises(MissingFile, match=r"heap/c\.0"):
        store.images([row])


def test_fork_after_use(folder: Path) -> None:
    """A store that has decoded, cached and pooled in the parent reads on in forked children, as loader workers do."""
    store = Store.open(folder)
    rows = list(range(store.n_frames))
    expected = store.images(rows, missing="zeros", threads=2)
    values = store.signal("wrench").values(0, 20)
    store.aligned(store.aligned_names[0])
    children = []
    for _ in range(3):
        child = os.fork()
        if child == 0:
            try:
                again = store.images(rows, missing="zeros", threads=2)
                fresh = Store.open(folder).signal("wrench").values(0, 20)
                same = all((one == other).all() for one, other in zip(again, expected, strict=True))
                os._exit(7 if same and (fresh == values).all() else 8)
            finally:
                os._exit(9)
        children.append(child)
    assert [os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) for child in children] == [7, 7, 7]


def test_open_store_ignores_what_comes_later(tmp_path: Path) -> None:
    """What is appended after a store was opened does not show in it; opened again, it does."""
    create(tmp_path, SMALL)
    images = random_images(np.random.default_rng(1), 6)
    commit(tmp_path, [staged_take(tmp_path, 1, images=images)[0]])
    old = Store.open(tmp_path)
    before = old.encoded(range(old.n_frames))
    commit(tmp_path, [staged_take(tmp_path, 2, images=images)[0]])
    assert old.encoded(range(old.n_frames)) == before
    assert old.frames().num_rows == old.n_frames == 6
    new = Store.open(tmp_path)
    assert new.n_frames == 12
    old_pictures, new_pictures = (store.images(range(6), missing="zeros") for store in (old, new))
    assert all((one == other).all() for one, other in zip(old_pictures, new_pictures, strict=True))
    # a shard index that the old reader keeps is read again when rows were appended to the shard
    assert new.encoded(range(12))[6:] == before
