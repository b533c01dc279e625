"""Room for decoded pictures in a folder: which frames get a slot, within a bound that all caches of the folder share.

A cache is two files: ``<key>.rows`` lists the rows of the store that have a slot, in the order of the slots, and
``<key>.pixels`` holds the slots. A dataset takes its room when it is made, under the folder's lock; slots are never
moved afterwards. A cache that nobody uses is removed where another needs its room, the one longest unused first.
"""

from __future__ import annotations

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tactiledata.contract.atomic import FULL, REFUSED, write_atomic
from tactiledata.contract.provenance import digest_of
from tactiledata.errors import TactileDataError, UsageError
from tactiledata.loaders.decoded_cache import DecodedCache, open_slots, slot_bytes

if TYPE_CHECKING:
    from tactiledata.store.read.reader import Store

LAYOUT = 1
"""Version of the layout of the cache's files; it is part of the key, so that another layout makes new files."""
CACHE_BYTES = 16 * 2**30
"""What the caches of a folder may take unless stated: 73,000 pictures of 320 x 240."""
ROW_BYTES = 8
LOCK, ROWS, PIXELS = "lock", ".rows", ".pixels"


def cache_key(store: Store, shape: tuple[int, ...]) -> str:
    """Return what decoded pictures (h, w, 3) of a store are kept under: another key where any pixel may be another.

    The table of frames says where each image lies and what its CRC-32C is; decoders may change with their versions.
    """
    import cv2
    import simplejpeg

    return digest_of(
        {
            "layout": LAYOUT,
            "frames": store.manifest["index"]["frames"],
            "shape": list(shape),
            "decoders": [simplejpeg.__version__, cv2.__version__],
        }
    )[:40]


def claim(
    folder: str | os.PathLike[str], most_bytes: int, store: Store, rows: NDArray[np.int64], shape: tuple[int, ...]
) -> tuple[DecodedCache, str]:
    """Return the cache of a store's decoded pictures, with room for frames, and a note on how many have room.

    Parameters
    ----------
    folder : path
        Of caches, on a local disk; made where it is missing.
    most_bytes : int
        What all caches of the folder may take.
    store : Store
        Whose pictures they are.
    rows : (n,) int64
        Frames that will be read.
    shape : (h, w, 3)
        Of every picture.

    Raises
    ------
    UsageError
        The folder is none, or the bound has no room for one picture.
    TactileDataError
        The folder may not be written to, or its disk is full.
    """
    folder = Path(folder)
    each = slot_bytes(shape) + ROW_BYTES
    if isinstance(most_bytes, bool) or not isinstance(most_bytes, int) or most_bytes < each:
        raise UsageError(
            f"a bound of {most_bytes!r} bytes for decoded pictures",
            f"a whole number, at least {each}: one picture of {shape[0]} x {shape[1]}",
        )
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with _locked(folder):
            return _claimed(folder, most_bytes, store, rows, shape)
    except OSError as error:
        kind = TactileDataError if error.errno in (*FULL, *REFUSED) else UsageError
        raise kind(
            f"decoded pictures cannot be kept in {folder}: {error.strerror or error}",
            "a folder on a local disk with room, that may be written",
            "Name another folder, or leave `cache` out.",
        ) from error


def _claimed(
    folder: Path, most_bytes: int, store: Store, rows: NDArray[np.int64], shape: tuple[int, ...]
) -> tuple[DecodedCache, str]:
    key = cache_key(store, shape)
    each = slot_bytes(shape) + ROW_BYTES
    pixels = folder / f"{key}{PIXELS}"
    known = _shrunk(folder / key, _rows_of(folder / key), most_bytes // each, each - ROW_BYTES)
    wanted = np.unique(rows)
    lacking = wanted[~np.isin(wanted, known)]
    room = _made_room(folder, key, most_bytes, each * (len(known) + len(lacking)))
    fits = max(0, min(len(lacking), room // each - len(known)))
    slots = np.concatenate([known, lacking[:fits]]).astype("<i8")
    cache = DecodedCache(pixels, slots, store.n_frames, shape)
    cache.open()
    # sparse: filled as pictures are decoded; first, so that a kill in between leaves a file that counts as more
    os.truncate(pixels, len(slots) * (each - ROW_BYTES))
    if fits:
        write_atomic(folder / f"{key}{ROWS}", slots.tobytes())
    os.utime(pixels)
    has = int(cache.has_room(wanted).sum())
    short = "" if has == len(wanted) else f"; the others are decoded each time, for the bound is {most_bytes:,} bytes"
    return cache, f"decoded pictures of {has:,} of {len(wanted):,} frames have room in {folder}{short}"


@contextmanager
def _locked(folder: Path) -> Iterator[None]:
    descriptor = open_slots(folder / LOCK, os.O_CREAT)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX)
        yield
    finally:
        os.close(descriptor)


def _rows_of(stem: Path) -> NDArray[np.int64]:
    """Rows that have a slot, in the order of the slots; none where the file is missing or is no list of them."""
    try:
        content = stem.with_name(stem.name + ROWS).read_bytes()
    except FileNotFoundError:
        content = b""
    return np.frombuffer(content[: len(content) // ROW_BYTES * ROW_BYTES], "<i8")


def _shrunk(stem: Path, known: NDArray[np.int64], most_slots: int, each: int) -> NDArray[np.int64]:
    """Rows that keep their slots under a bound that is lower than before; all, where another process uses them."""
    if len(known) <= most_slots:
        return known
    with _alone(stem.with_name(stem.name + PIXELS)) as is_alone:
        if is_alone:
            known = known[:most_slots]
            write_atomic(stem.with_name(stem.name + ROWS), known.tobytes())
            os.truncate(stem.with_name(stem.name + PIXELS), most_slots * each)
    return known


def _made_room(folder: Path, key: str, most_bytes: int, needed: int) -> int:
    """Bytes that a cache may take beside the others, once as many of them are removed as it takes and as may be."""
    others = {path: _taken(path) for path in folder.glob(f"*{PIXELS}") if path.name != f"{key}{PIXELS}"}
    for path in sorted(others, key=lambda path: path.lstat().st_mtime_ns):
        if most_bytes - sum(others.values()) >= needed:
            break
        with _alone(path) as is_alone:
            if is_alone:
                path.unlink()
                path.with_suffix(ROWS).unlink(missing_ok=True)
                others[path] = 0
    return most_bytes - sum(others.values())


def _taken(pixels: Path) -> int:
    """Bytes that a cache may come to take: those of its slots, filled or not, and of its list of rows."""
    sizes = 0
    for path in (pixels, pixels.with_suffix(ROWS)):
        with suppress(FileNotFoundError):
            sizes += path.lstat().st_size
    return sizes


@contextmanager
def _alone(pixels: Path) -> Iterator[bool]:
    """Whether no dataset of any process uses a file of slots; none can begin to inside the ``with`` block."""
    try:
        descriptor = open_slots(pixels)
    except FileNotFoundError:
        yield True
        return
    except OSError:
        yield False  # a link or a pipe: not ours
        return
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        is_alone = True
    except BlockingIOError:
        is_alone = False
    try:
        yield is_alone
    finally:
        os.close(descriptor)
