"""A store to read: tables, signals, values and images, bounded by what the manifest named when it was opened."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import zarr
from numpy.typing import ArrayLike, NDArray

from tactiledata.arrays import PictureArray
from tactiledata.contract.provenance import digest_of
from tactiledata.contract.take import Reference
from tactiledata.errors import StoreError, UnknownName
from tactiledata.store.layout.manifest import Manifest, not_a_store, parse_manifest
from tactiledata.store.layout.places import (
    MANIFEST,
    TABLE_SCHEMAS,
    aligned_path,
    folder_name,
    frame_values_path,
    home_of,
    reference_path,
    sensors_path,
    signal_path,
    table_folder,
)
from tactiledata.store.layout.sensors_table import Facts, parse_sensors
from tactiledata.store.read.files import StoreFiles, missing_file, open_files
from tactiledata.store.read.meshes import StoredMesh
from tactiledata.store.read.pictures import Pictures
from tactiledata.store.read.rows import Rows, checked_rows

RowState = tuple[int, int, str]
"""How often recordings were replaced, number of sources, digest of their digests."""


@dataclass(frozen=True)
class Meaning:
    """What columns of numbers mean.

    Parameters
    ----------
    columns, units : tuple of str
    frame : str
        The frame in which vectors are expressed, as the recording names it.
    attributes : dict
        Of the first recording that brought them; ``sources()`` has each recording's own in ``contents``.
    statistics : dict
        ``count``, ``mean``, ``m2``, ``min``, ``max`` of each column, over all finite values of the store.
    """

    columns: tuple[str, ...]
    units: tuple[str, ...]
    frame: str
    attributes: Mapping[str, Any]
    statistics: Mapping[str, Any]

    @classmethod
    def of(cls, facts: Mapping[str, Any]) -> Meaning:
        """From an entry of the manifest."""
        columns, units = tuple(facts["columns"]), tuple(facts["units"])
        return cls(columns, units, facts["frame"], facts["attributes"], facts["statistics"])


class SignalRows:
    """A signal at its native rate; ``signal_rows`` of a trajectory are ranges of its rows."""

    def __init__(self, files: StoreFiles, home: str, name: str, facts: Mapping[str, Any]) -> None:
        self.name = name
        self.meaning = Meaning.of(facts)
        self.n_rows: int = facts["rows"]
        arrays = ("t_ns", "value", "log_ns", "publish_ns", "header_ns")
        self._rows = {array: Rows(files, signal_path(home, name, array), self.n_rows) for array in arrays}

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the columns."""
        return self.meaning.columns

    @property
    def units(self) -> tuple[str, ...]:
        """Units of the columns."""
        return self.meaning.units

    @property
    def frame(self) -> str:
        """The frame in which vectors are expressed."""
        return self.meaning.frame

    @property
    def attributes(self) -> Mapping[str, Any]:
        """Clock, rate and the like of the first recording that brought it."""
        return self.meaning.attributes

    def t_ns(self, start: int, stop: int) -> NDArray[np.int64]:
        """Times (n,) of rows [start, stop), host clock, ns."""
        return self._rows["t_ns"].span(start, stop)

    def values(self, start: int, stop: int) -> NDArray[np.float64]:
        """Values (n, k) of rows [start, stop), SI units; read-only."""
        return self._rows["value"].span(start, stop)

    def stamps(self, kind: Literal["log", "publish", "header"], start: int, stop: int) -> NDArray[np.int64]:
        """Time stamps (n,) as recorded, ns; -1 where the recording has none."""
        return self._rows[f"{kind}_ns"].span(start, stop)


class Store:
    """A store at a path or URL; cheap to open, picklable, safe to use after a fork.

    It shows what the manifest named when it was opened: what others append later does not appear, and does not disturb.

    Examples
    --------
    >>> import tempfile
    >>> from tactiledata.store.write.commit import create
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = create(folder)
    ...     Store.open(folder).n_frames
    0
    """

    def __init__(self, files: StoreFiles, manifest: Manifest) -> None:
        self._files = files
        self.manifest = manifest
        self._pictures = Pictures(files, manifest, self.frames)
        self._signals: dict[str, SignalRows] = {}
        self._values: dict[str, Rows] = {}
        self._meshes: dict[str, StoredMesh] = {}
        self._whole_parts: set[str] = set()

    @classmethod
    def open(
        cls, location: str | Path, storage_options: Mapping[str, Any] | None = None, damaged: bool = False
    ) -> Store:
        """The store at a local path or any fsspec URL (``memory://``, ``http://``, ``zip::…``).

        Parameters
        ----------
        location : str or Path
        storage_options : dict, optional
            For fsspec.
        damaged : bool
            Whether it is opened although its manifest does not fit its own digest, as `check` does.

        Raises
        ------
        MissingFile
            There is nothing at the location.
        StoreError
            Not a store, written by a newer version, or its manifest is damaged.
        """
        files = open_files(location, storage_options)
        try:
            content = files.read(MANIFEST)
        except (FileNotFoundError, NotADirectoryError, KeyError) as error:
            raise not_a_store(str(location), files.exists()) from error
        except OSError as error:
            raise StoreError(
                f"the store {location} cannot be read: {error}",
                "a store that may be read",
                "Check the place and your rights.",
            ) from error
        return cls(files, parse_manifest(content, f"{location}/{MANIFEST}", damaged=damaged))

    def __repr__(self) -> str:
        return f"Store({self.location!r}, {self.n_frames} frames)"

    # -- what there is -----------------------------------------------------------------------------------------------

    @property
    def location(self) -> str:
        """Path or URL."""
        return self._files.location

    @property
    def digest(self) -> str:
        """Digest of the content of all sources, in order."""
        return self.manifest["digest"]

    @property
    def row_state(self) -> RowState:
        """What decides which row is which: appending continues it, replacing a recording does not."""
        return self._row_state(self.manifest["rows"]["sources"])

    def continues(self, state: RowState) -> bool:
        """Whether rows that were noted in another state of this store, at this place, still mean the same."""
        return self._row_state(state[1]) == state

    def _row_state(self, n_sources: int) -> RowState:
        known = self.manifest["sources"][:n_sources]
        return self.manifest.get("generation", 0), len(known), digest_of(known)

    @property
    def n_frames(self) -> int:
        """Number of frames."""
        return self.manifest["rows"]["frames"]

    @property
    def cameras(self) -> tuple[str, ...]:
        """Names of the image streams."""
        return tuple(sorted(self.manifest["cameras"]))

    @property
    def signal_names(self) -> tuple[str, ...]:
        """Signals at native rate."""
        return tuple(sorted(self.manifest["signals"]))

    @property
    def aligned_names(self) -> tuple[str, ...]:
        """Values at the moments of the frames."""
        return tuple(sorted(self.manifest["aligned"]))

    @property
    def frame_value_names(self) -> tuple[str, ...]:
        """Values that corpora annotate image by image."""
        return tuple(sorted(self.manifest["frame_values"]))

    @property
    def mesh_names(self) -> tuple[str, ...]:
        """Meshes that `tactiledata replay` attached to the frames."""
        return tuple(sorted(self.manifest.get("meshes", {})))

    # -- tables ------------------------------------------------------------------------------------------------------

    def _table(self, table: str, columns: Sequence[str] | None) -> pa.Table:
        schema = TABLE_SCHEMAS[table]
        for column in columns or ():
            if column not in schema.names:
                raise UnknownName(f"column of {table}", column, schema.names)
        wanted = pa.schema([schema.field(name) for name in (schema.names if columns is None else columns)])
        pieces = [wanted.empty_table()]
        for part in self.manifest["index"][table]:
            path = f"{table_folder(table)}/{part['file']}"
            try:
                content = self._part(path, part["sha256"])
                piece = (
                    pq.read_table(content, columns=wanted.names, partitioning=None).select(wanted.names).cast(wanted)
                )
            except FileNotFoundError as error:
                raise missing_file(path, self.location) from error
            except (pa.ArrowException, OSError, KeyError) as error:
                raise StoreError(
                    f"the part {path} of the store {self.location} is damaged: {error}",
                    "a parquet file that fits the manifest",
                    "Run `tactiledata check` on the store; restore the file from a copy.",
                ) from error
            if len(piece) != part["rows"]:
                raise StoreError(f"{path} has {len(piece)} rows", f"the {part['rows']} rows that the manifest names")
            pieces.append(piece)
        return pa.concat_tables(pieces).unify_dictionaries()

    def _part(self, path: str, sha256: str) -> Path | pa.BufferReader:
        """A part of a table, to read from; its bytes are held against the manifest the first time.

        A flipped byte mostly still reads, to other numbers; whoever writes them on would give them a fitting checksum.
        """
        if path in self._whole_parts and isinstance(place := self._files.place(path), Path):
            return place
        content = self._files.read(path)
        if (digest := hashlib.sha256(content).hexdigest()) != sha256:
            raise StoreError(
                f"the part {path} of the store {self.location} is damaged: its SHA-256 is {digest[:12]}…",
                f"{sha256[:12]}…, as the manifest says",
                "Restore the file from a copy, or ingest the recordings into a new store; `tactiledata check` lists "
                "all damage.",
            )
        self._whole_parts.add(path)
        return pa.BufferReader(content)

    def table(self, table: str) -> pa.Table:
        """Any of the tables by its name: ``frames``, ``trajectories``, ``sources``, ``findings``."""
        return self._table(table, None)

    def frames(self, columns: Sequence[str] | None = None) -> pa.Table:
        """The frames table (``FRAME_SCHEMA``), or some of its columns; the row is the frame's number everywhere."""
        return self._table("frames", columns)

    def trajectories(self, columns: Sequence[str] | None = None) -> pa.Table:
        """The trajectories table (``TRAJECTORY_SCHEMA``), or some of its columns."""
        return self._table("trajectories", columns)

    def sources(self, columns: Sequence[str] | None = None) -> pa.Table:
        """The sources table (``SOURCE_SCHEMA``), or some of its columns."""
        return self._table("sources", columns)

    def findings(self, columns: Sequence[str] | None = None) -> pa.Table:
        """The findings table (``FINDING_SCHEMA``), or some of its columns."""
        return self._table("findings", columns)

    # -- numbers -----------------------------------------------------------------------------------------------------

    def signal(self, name: str) -> SignalRows:
        """A signal at its native rate."""
        if name not in self._signals:
            facts = self._facts("signals", "signal", name)
            self._signals[name] = SignalRows(self._files, home_of(self.manifest), name, facts)
        return self._signals[name]

    def aligned(self, name: str, rows: ArrayLike | None = None) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """Values (n, k) at the moments of frames, NaN where there are none, and gaps (n,) in ns, -1 likewise."""
        facts = self._facts("aligned", "aligned value", name)
        home = home_of(self.manifest)
        values = self._rows(aligned_path(home, name, "value"), facts["rows"])
        return values.take(rows), self._rows(aligned_path(home, name, "gap_ns"), facts["rows"]).take(rows)

    def frame_values(self, name: str, rows: ArrayLike | None = None) -> NDArray[np.float64]:
        """Annotated values (n, k) of frames, NaN where there are none."""
        facts = self._facts("frame_values", "frame value", name)
        return self._rows(frame_values_path(home_of(self.manifest), name), facts["rows"]).take(rows)

    def mesh(self, name: str) -> StoredMesh:
        """What a replay attached to the frames."""
        if name not in self._meshes:
            known = self.manifest.get("meshes", {})
            if name not in known:
                raise UnknownName("mesh", name, known, "`tactiledata replay` attaches meshes.")
            home = home_of(self.manifest)
            self._meshes[name] = StoredMesh(name, known[name], self.n_frames, self.rows, home)
        return self._meshes[name]

    def meaning(self, kind: Literal["signals", "aligned", "frame_values"], name: str) -> Meaning:
        """Columns, units, frame, attributes and statistics of values."""
        return Meaning.of(self._facts(kind, kind.rstrip("s").replace("_", " "), name))

    def _facts(self, kind: str, word: str, name: str) -> Mapping[str, Any]:
        known = self.manifest[kind]
        if name not in known:
            raise UnknownName(word, name, known)
        return known[name]

    def _rows(self, path: str, length: int) -> Rows:
        if path not in self._values:
            self._values[path] = self.rows(path, length)
        return self._values[path]

    def rows(self, path: str, length: int) -> Rows:
        """The first ``length`` rows of any array of the store, by its path."""
        return Rows(self._files, path, length)

    def array(self, path: str) -> zarr.Array:
        """Any array of the store, by its path; rows beyond the manifest's lengths are not data."""
        return self._files.array(path)

    # -- images ------------------------------------------------------------------------------------------------------

    def encoded(self, rows: ArrayLike, verify: bool = True) -> list[bytes | None]:
        """Payloads as kept: JPEG and PNG files, raw frames as RGB bytes, ``None`` where no image was recorded.

        Parameters
        ----------
        verify : bool
            Whether each is held against its CRC-32C; a damaged JPEG may still decode, to other pixels.
        """
        return self._pictures.payloads(checked_rows(rows, self.n_frames, "the frames").tolist(), verify)

    def images(
        self, rows: ArrayLike, threads: int | None = None, missing: Literal["error", "zeros"] = "error"
    ) -> list[PictureArray] | PictureArray:
        """RGB pictures, uint8: one array (n, H, W, 3) where all have one size, else a list of (H, W, 3).

        Parameters
        ----------
        rows : row numbers of frames, or a mask over all frames
        threads : int, optional
            Threads that decode; one a core by default. Say 1 inside worker processes.
        missing : "error" or "zeros"
            What to do for captured moments without an image.

        Raises
        ------
        StoreError
            An image that is damaged or missing; names the row, also in ``facts['row']``.
        """
        return self._pictures.pictures(checked_rows(rows, self.n_frames, "the frames").tolist(), threads, missing)

    # -- sensors and splits ------------------------------------------------------------------------------------------

    def sensors(self) -> Facts:
        """What is known of each sensor, by serial."""
        place = sensors_path(home_of(self.manifest))
        try:
            content = self._files.read(place) if self.manifest["sensors"] else None
        except FileNotFoundError as error:
            raise missing_file(place, self.location) from error
        return parse_sensors(content, self.manifest, f"{self.location}/{place}")

    def references(self) -> dict[str, Reference]:
        """Pictures without contact, by sensor."""
        return {sensor: self.reference(sensor) for sensor in sorted(self.manifest["references"])}

    def reference(self, sensor: str) -> Reference:
        """The picture of a sensor without contact."""
        if sensor not in self.manifest["references"]:
            raise UnknownName("sensor with a picture without contact", sensor, self.manifest["references"])
        array = self.array(reference_path(home_of(self.manifest), sensor))
        facts = {name: str(array.attrs.get(name, "")) for name in ("origin", "licence", "model")}
        return Reference(np.asarray(array[...], dtype=np.uint8), **facts)

    def names(self, folder: str) -> list[str]:
        """Names of the files in a folder of the store, sorted; empty where there is none or it cannot be listed."""
        return self._files.names(folder)

    def split_names(self) -> list[str]:
        """Names of the splits that were made of this store."""
        # a split is a table and its document; other documents there (normalisation) have no table
        files = self.names("splits")
        stems = [name.removesuffix(".json") for name in files if name.endswith(".json")]
        return [stem for stem in stems if f"{stem}.parquet" in files]

    def split_path(self, name: str, suffix: str = ".parquet") -> Path | str:
        """Where a split's file lies (``.parquet`` or ``.json``): a path, or a URL for a remote store."""
        return self._files.place(f"splits/{folder_name(name)}{suffix}")

    def read_file(self, path: str) -> bytes:
        """A file of the store as bytes, wherever the store lies."""
        try:
            return self._files.read(path)
        except FileNotFoundError as error:
            raise missing_file(path, self.location) from error
