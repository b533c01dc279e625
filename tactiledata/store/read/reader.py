"""A store to read: tables, signals, values and images, bounded by what the manifest named when it was opened."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pyarrow as pa
import zarr
from numpy.typing import ArrayLike, NDArray

from tactiledata.arrays import PictureArray
from tactiledata.contract.provenance import digest_of
from tactiledata.contract.take import Reference
from tactiledata.errors import StoreError, UnknownName
from tactiledata.store.layout.manifest import Manifest, not_a_store, parse_manifest
from tactiledata.store.layout.places import (
    MANIFEST,
    aligned_path,
    folder_name,
    frame_values_path,
    home_of,
    reference_path,
)
from tactiledata.store.layout.sensors_table import Facts, image_crc
from tactiledata.store.read.files import StoreFiles, missing_file, open_files
from tactiledata.store.read.index_tables import IndexTables
from tactiledata.store.read.meshes import StoredMesh
from tactiledata.store.read.pictures import KeptPictures, Pictures
from tactiledata.store.read.recorded import RecordedNumbers
from tactiledata.store.read.rows import Rows, checked_rows
from tactiledata.store.read.sensor_facts import sensor_facts
from tactiledata.store.read.signal_rows import Meaning, SignalRows

RowState = tuple[int, int, str]
"""How often recordings were replaced, number of sources, digest of their digests."""


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
        self._tables = IndexTables(files, manifest)
        self._pictures = Pictures(files, manifest, self.frames)
        self._signals: dict[str, SignalRows] = {}
        self._values: dict[str, Rows] = {}
        self._recorded = RecordedNumbers(files, home_of(manifest), self.sources)
        self._meshes: dict[str, StoredMesh] = {}

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

    def table(self, table: str) -> pa.Table:
        """Any of the tables by its name: ``frames``, ``trajectories``, ``sources``, ``findings``."""
        return self._tables.read(table)

    def frames(self, columns: Sequence[str] | None = None) -> pa.Table:
        """The frames table (``FRAME_SCHEMA``), or some of its columns; the row is the frame's number everywhere."""
        return self._tables.read("frames", columns)

    def trajectories(self, columns: Sequence[str] | None = None) -> pa.Table:
        """The trajectories table (``TRAJECTORY_SCHEMA``), or some of its columns."""
        return self._tables.read("trajectories", columns)

    def sources(self, columns: Sequence[str] | None = None) -> pa.Table:
        """The sources table (``SOURCE_SCHEMA``), or some of its columns."""
        return self._tables.read("sources", columns)

    def findings(self, columns: Sequence[str] | None = None) -> pa.Table:
        """The findings table (``FINDING_SCHEMA``), or some of its columns."""
        return self._tables.read("findings", columns)

    # -- numbers -----------------------------------------------------------------------------------------------------

    def signal(self, name: str) -> SignalRows:
        """A signal at its native rate."""
        if name not in self._signals:
            facts = self._facts("signals", "signal", name)
            self._signals[name] = SignalRows(self._recorded, home_of(self.manifest), name, facts)
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
            self._values[path] = self._recorded.rows(path, length)
        return self._values[path]

    def rows(self, path: str, length: int) -> Rows:
        """The first ``length`` rows of any array of the store, by its path, as they read."""
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
        self,
        rows: ArrayLike,
        threads: int | None = None,
        missing: Literal["error", "zeros"] = "error",
        *,
        size: Sequence[int] | None = None,
        kept: KeptPictures | None = None,
    ) -> list[PictureArray] | PictureArray:
        """RGB pictures, uint8: one array (n, H, W, 3) where all have one size, else a list of (H, W, 3).

        Parameters
        ----------
        rows : row numbers of frames, or a mask over all frames
        threads : int, optional
            Threads that decode; one a core by default. Say 1 inside worker processes.
        missing : "error" or "zeros"
            What to do for captured moments without an image.
        size : (rows, columns), optional
            A smaller size for all pictures. A JPEG is decoded at the nearest size above that libjpeg-turbo can leave
            its transform at, in less time; what is still larger, and other pictures, are averaged by area.
        kept : KeptPictures, optional
            Where pictures that were decoded before, at this size, are looked for first and others are put.

        Raises
        ------
        StoreError
            An image that is damaged or missing; names the row, also in ``facts['row']``.
        UsageError
            A size that is larger than that of a picture.
        """
        wanted = checked_rows(rows, self.n_frames, "the frames").tolist()
        return self._pictures.pictures(wanted, threads, missing, size, kept)

    def image_shape(self, row: int) -> tuple[int, int]:
        """Rows and columns of the image of a frame, as the table of frames says."""
        return self._pictures.facts(row)[2:]

    # -- sensors and splits ------------------------------------------------------------------------------------------

    def sensors(self) -> Facts:
        """What is known of each sensor, by serial."""
        return sensor_facts(self._files, self.manifest)

    def references(self) -> dict[str, Reference]:
        """Pictures without contact, by sensor."""
        return {sensor: self.reference(sensor) for sensor in sorted(self.manifest["references"])}

    def reference(self, sensor: str) -> Reference:
        """The picture of a sensor without contact.

        Raises
        ------
        UnknownName
            The store has none of that sensor.
        StoreError
            It is not the one that the manifest names: a chunk that is gone reads as black.
        """
        if sensor not in self.manifest["references"]:
            raise UnknownName("sensor with a picture without contact", sensor, self.manifest["references"])
        path = reference_path(home_of(self.manifest), sensor)
        array = self.array(path)
        facts = {name: str(array.attrs.get(name, "")) for name in ("origin", "licence", "model")}
        try:
            image, fault = np.asarray(array[...], dtype=np.uint8), "it does not fit its CRC-32C"
        except (ValueError, RuntimeError) as error:
            self._files.need_fetched(path)
            image, fault = None, str(error)
        if image is None or image_crc(image) != self.manifest["references"][sensor]:
            # zarr reads a chunk that is gone as black
            if self.names(path) == ["zarr.json"]:
                fault = "the file with its pixels is missing"
            raise StoreError(
                f"the picture of {sensor} without contact ({path} in {self.location}) is damaged: {fault}",
                "the picture that the manifest names",
                "Open the store again, if it was replaced meanwhile; else `tactiledata check` lists all damage.",
                sensor=sensor,
            )
        return Reference(image, **facts)

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
        """Return the path of a split's file (``.parquet`` or ``.json``), or its URL for a remote store."""
        return self._files.place(f"splits/{folder_name(name)}{suffix}")

    def read_file(self, path: str) -> bytes:
        """A file of the store as bytes, wherever the store lies."""
        try:
            return self._files.read(path)
        except FileNotFoundError as error:
            raise missing_file(path, self.location) from error
