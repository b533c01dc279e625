"""The writing lock of a store: one writer at a time, freed by the system when its process dies."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tactiledata.contract.atomic import refusal
from tactiledata.errors import StoreBusy, StoreError
from tactiledata.store.layout.places import LOCK, STAGING


@contextmanager
def writing_lock(store_path: Path | str, name: str = LOCK) -> Iterator[None]:
    """The store's writing lock, held inside the ``with`` block.

    Parameters
    ----------
    store_path : Path
    name : str
        ``LOCK`` is held for a commit; ``INTAKE_LOCK`` for as long as takes are staged, so that nobody sweeps away what
        another is staging.

    Raises
    ------
    StoreBusy
        Another process (or another block of this one) holds it; names its process id.
    StoreError
        The store cannot be written to.
    """
    path = Path(store_path) / name
    try:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
    except OSError as error:
        raise unwritable(store_path, error) from error
    try:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            holder = os.pread(descriptor, 32, 0).decode(errors="replace").strip() or "unknown"
            raise StoreBusy(
                f"the store {store_path} is being written by process {holder}",
                "no other writer",
                "Wait until it has ended, or end it; nothing is lost then.",
                pid=holder,
            ) from error
        os.ftruncate(descriptor, 0)
        os.pwrite(descriptor, f"{os.getpid()}\n".encode(), 0)
        yield
    finally:
        os.close(descriptor)


@contextmanager
def reading_lock(store_path: Path | str, sha256: str) -> Iterator[None]:
    """Held while a source is read and staged: two workers that were given copies of one file do it one after the other.

    The file goes with the next cleaning of the staging folder, when nobody stages.
    """
    try:
        (Path(store_path) / STAGING).mkdir(exist_ok=True)
    except OSError as error:
        raise unwritable(store_path, error) from error
    with waiting_lock(store_path, f"{STAGING}/.{sha256}.part"):
        yield


@contextmanager
def waiting_lock(store_path: Path | str, name: str) -> Iterator[None]:
    """A lock held inside the ``with`` block; who comes while another holds it waits.

    Parameters
    ----------
    store_path : Path
    name : str
        The lock's file in the store.

    Raises
    ------
    StoreError
        The store cannot be written to.
    """
    try:
        descriptor = os.open(Path(store_path) / name, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
    except OSError as error:
        raise unwritable(store_path, error) from error
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX)
        yield
    finally:
        os.close(descriptor)


def unwritable(store_path: Path | str, error: OSError) -> StoreError:
    """The error that says why a store could not be written: disk full, read-only, no permission."""
    found, expected, remedy = refusal(error, error.filename or store_path)
    return StoreError(
        f"the store {store_path}: {found}",
        expected,
        f"{remedy} What was committed before is unharmed, and the same command goes on where it stopped.",
        errno=error.errno,
    )
