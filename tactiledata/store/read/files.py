"""The files of a store wherever they lie: a local folder (memory-mapped) or any fsspec URL (ranges, in batches)."""

from __future__ import annotations

import contextlib
import mmap
import os
from abc import ABC, abstractmethod
from collections import OrderedDict
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import fsspec
import zarr
import zarr.abc.store
from zarr.storage import FsspecStore, LocalStore

from tactiledata.contract.lfs_pointer import START, refuse_pointer_bytes
from tactiledata.errors import LostFile, StoreError
from tactiledata.store.layout.places import MANIFEST
from tactiledata.store.layout.regular_files import need_regular, need_regular_files

MOST_MAPS = 256
"""Files that are mapped at once; each keeps a file descriptor, and 1024 is a usual limit."""
MOST_ARRAYS = 256
"""Arrays that stay open at once: opening one again takes as long as reading some thousand rows."""

PROBED = 2
"""Bytes that are asked of a remote store's manifest, to see whether ranges are served."""

Span = tuple[str, int, int]
"""(path, first byte, byte after the last); a first byte below zero counts from the end, to the end."""


class StoreFiles(ABC):
    """Reads below a store's folder; picklable, opens its handles per process."""

    location: str

    def read(self, path: str) -> bytes:
        """A whole file.

        Raises
        ------
        FileNotFoundError
            There is none.
        NotFetched
            A Git LFS pointer lies in its place.
        """
        content = self._read(path)
        refuse_pointer_bytes(content, f"{self.location}/{path}")
        return content

    @abstractmethod
    def _read(self, path: str) -> bytes:
        """A whole file as it lies there."""

    def need_fetched(self, path: str) -> None:
        """Refuse an array of which a file is a Git LFS pointer; asked where the array cannot be read.

        Raises
        ------
        NotFetched
            One is.
        """
        for name in self.names(path):
            try:
                content = self.spans([(f"{path}/{name}", 0, len(START))])[0]
            except OSError:
                continue
            refuse_pointer_bytes(content, f"{self.location}/{path}/{name}")

    @abstractmethod
    def spans(self, spans: Sequence[Span]) -> list[bytes]:
        """Ranges of files.

        Raises
        ------
        FileNotFoundError
            A file is missing.
        """

    @abstractmethod
    def names(self, folder: str) -> list[str]:
        """Names in a folder, sorted; empty where there is none."""

    @abstractmethod
    def exists(self) -> bool:
        """Whether there is anything at the location."""

    def still_there(self, path: str) -> bool:
        """Whether a file is there; where asking takes a round trip, it is not asked."""
        return True

    def may_be_missing(self, path: str) -> bool:
        """Whether a file is missing; also where asking takes a round trip."""
        return True

    @abstractmethod
    def array(self, path: str) -> zarr.Array:
        """An array, to read."""

    @abstractmethod
    def place(self, path: str) -> Path | str:
        """Return the path or the URL of a file of the store."""


class LocalFiles(StoreFiles):
    """A store on the local disk."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self.location = str(folder)
        self._maps: OrderedDict[str, mmap.mmap] = OrderedDict()
        self._arrays: OrderedDict[str, tuple[tuple[int, ...], zarr.Array]] = OrderedDict()

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_maps": OrderedDict(), "_arrays": OrderedDict()}

    def _read(self, path: str) -> bytes:
        need_regular(self._folder / path)
        return (self._folder / path).read_bytes()

    def spans(self, spans: Sequence[Span]) -> list[bytes]:
        """Ranges of files."""
        return [self.span(*span) for span in spans]

    def span(self, path: str, start: int, stop: int) -> bytes:
        """A range of a file, copied from its map.

        Parameters
        ----------
        path : str
            Of the file in the store.
        start, stop : int
            First byte, and the byte after the last. A negative ``start`` counts from the end, without ``stop``.
        """
        mapped = self._map(path)
        if start < 0:
            return mapped[start:]
        if stop > len(mapped):
            mapped = self._map(path, anew=True)
        return mapped[start:stop]

    def _map(self, path: str, anew: bool = False) -> mmap.mmap | bytes:
        mapped = None if anew else self._maps.get(path)
        if mapped is None:
            need_regular(self._folder / path)
            with (self._folder / path).open("rb") as stream:
                if not os.fstat(stream.fileno()).st_size:
                    return b""  # what cannot be mapped
                mapped = mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ)
            refuse_pointer_bytes(mapped[: len(START)], f"{self.location}/{path}")
        self._maps[path] = mapped
        if len(self._maps) > MOST_MAPS:
            self._maps.popitem(last=False)
        return mapped

    def forget(self, path: str) -> None:
        """A file that was replaced is mapped anew at its next use."""
        self._maps.pop(path, None)

    def names(self, folder: str) -> list[str]:
        """Names in a folder."""
        place = self._folder / folder
        return sorted(entry.name for entry in place.iterdir()) if place.is_dir() else []

    def exists(self) -> bool:
        """Whether the folder is there."""
        return self._folder.exists()

    def still_there(self, path: str) -> bool:
        """Whether a file is there."""
        return (self._folder / path).exists()

    def may_be_missing(self, path: str) -> bool:
        """Whether a file is missing."""
        return not self.still_there(path)

    def array(self, path: str) -> zarr.Array:
        """An array, to read; one that is open already is given again, unless its document was written anew."""
        try:
            facts = (self._folder / path / "zarr.json").stat()
        except OSError:
            return _opened(LocalStore(self._folder, read_only=True), path, self)  # which says what is wrong
        document = (os.getpid(), facts.st_ino, facts.st_mtime_ns, facts.st_size)
        known = self._arrays.get(path)
        if known is None or known[0] != document:
            need_regular_files(self._folder / path)
            known = self._arrays[path] = (document, _opened(LocalStore(self._folder, read_only=True), path, self))
            if len(self._arrays) > MOST_ARRAYS:
                self._arrays.popitem(last=False)
        return known[1]

    def place(self, path: str) -> Path:
        """Return the path of a file of the store."""
        return self._folder / path


class RemoteFiles(StoreFiles):
    """A store behind a URL that fsspec knows."""

    def __init__(self, url: str, options: Mapping[str, Any] | None) -> None:
        self.location = url
        self._options = dict(options or {})
        self._opened: tuple[fsspec.AbstractFileSystem, str] | None = None
        self._gives_ranges = False

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_opened": None}

    @property
    def _system(self) -> tuple[fsspec.AbstractFileSystem, str]:
        if self._opened is None:
            try:
                system, folder = fsspec.core.url_to_fs(self.location, **self._options)
            except (ImportError, ValueError, OSError) as error:
                raise StoreError(
                    f"{self.location} cannot be opened: {error}",
                    "a local path or a URL of a protocol that fsspec knows",
                    "Install the package that the message names, or check the URL.",
                ) from error
            self._opened = system, folder.rstrip("/")
        return self._opened

    def _need_ranges(self) -> None:
        """Refuse a server that answers with whole files where parts are asked for, as that of Python does."""
        if self._gives_ranges:
            return
        with _client_errors():
            got = len(self._system[0].cat_file(self._join(MANIFEST), start=0, end=PROBED))
        if got > PROBED:
            raise StoreError(
                f"{self.location}: asked for {PROBED} bytes of {MANIFEST}, the server sent {got}",
                "a server that answers a request for a range of bytes with these bytes",
                "`python -m http.server` does not. Use nginx, Apache, `rclone serve http` or an object store, or copy"
                " the store to this machine.",
            )
        self._gives_ranges = True

    def _join(self, path: str) -> str:
        folder = self._system[1]
        return f"{folder}/{path}" if folder else path

    def _read(self, path: str) -> bytes:
        with _client_errors():
            return self._system[0].cat_file(self._join(path))

    def spans(self, spans: Sequence[Span]) -> list[bytes]:
        """Ranges of files, fetched together."""
        if not spans:
            return []
        self._need_ranges()
        paths = [self._join(path) for path, _, _ in spans]
        starts = [start for _, start, _ in spans]
        stops = [None if start < 0 else stop for _, start, stop in spans]
        with _client_errors():
            return self._system[0].cat_ranges(paths, starts, stops, on_error="raise")

    def names(self, folder: str) -> list[str]:
        """Names in a folder; empty also where the protocol cannot list."""
        system = self._system[0]
        try:
            system.invalidate_cache()
            with _client_errors():
                listed = system.ls(self._join(folder), detail=False)
        except (OSError, NotImplementedError):
            return []
        return sorted({str(name).rstrip("/").rpartition("/")[2] for name in listed})

    def exists(self) -> bool:
        """Whether there is anything at the location."""
        system, folder = self._system
        try:
            with _client_errors():
                return bool(system.exists(folder))
        except (OSError, NotImplementedError):
            return False

    def array(self, path: str) -> zarr.Array:
        """An array, to read."""
        self._need_ranges()
        store = FsspecStore.from_url(self.location, storage_options=self._options, read_only=True)
        return _opened(store, path, self)

    def place(self, path: str) -> str:
        """The URL of a file of the store."""
        head, separator, tail = self.location.partition("::")
        return f"{head.rstrip('/')}/{path}{separator}{tail}"


@contextlib.contextmanager
def _client_errors() -> Iterator[None]:
    """Turn the errors of a protocol's client (no connection, no rights) into an `OSError`, which they often are not."""
    try:
        yield
    except (OSError, KeyError, NotImplementedError):
        raise
    except Exception as error:
        raise OSError(f"{type(error).__name__}: {error}") from error


def _opened(store: zarr.abc.store.Store, path: str, files: StoreFiles) -> zarr.Array:
    location = files.location
    try:
        # with the format known, zarr does not look for the metadata of other formats
        array = zarr.open_array(store, path=path, mode="r", zarr_format=3)
        if not array.chunks or min(array.chunks) < 1:  # zarr takes them, and divides by their number of rows
            raise ValueError(f"chunks of shape {array.chunks}")
        return array
    except FileNotFoundError as error:
        raise missing_file(path, location) from error
    except (ValueError, TypeError, KeyError, AttributeError, OverflowError) as error:
        files.need_fetched(path)
        raise StoreError(
            f"array {path} in {location} has metadata that cannot be read: {error}",
            "the zarr.json that the store was written with",
            "Run `tactiledata check` on the store; restore the file from a copy.",
            path=path,
        ) from error


def open_files(location: str | Path, storage_options: Mapping[str, Any] | None = None) -> StoreFiles:
    """The files of a store at a path or URL."""
    text = str(location)
    if text.startswith("file://"):
        return LocalFiles(Path(text.removeprefix("file://")))
    if isinstance(location, str) and ("://" in text or "::" in text):
        return RemoteFiles(text, storage_options)
    return LocalFiles(Path(location))


def missing_file(path: str, location: str) -> LostFile:
    """The error for a file that a manifest needs and that is not there."""
    return LostFile(
        f"{path} is missing in the store {location}",
        "every file that the manifest names",
        "Open the store again, if a recording was replaced meanwhile; else restore the file from a copy.",
        path=path,
    )
