"""Where things lie in a store: names of folders and files, sizes of chunks, the format's version."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote

from tactiledata.contract.take import FINDING_SCHEMA, FRAME_SCHEMA, SOURCE_SCHEMA, TRAJECTORY_SCHEMA
from tactiledata.errors import UsageError

FORMAT_NAME = "tactiledata-store"
FORMAT_VERSION = 1
FORMAT = f"{FORMAT_NAME}/{FORMAT_VERSION}"

MANIFEST = "manifest.json"
ROOT_GROUP = "zarr.json"
"""Beside the manifest in every store: Zarr's document of the root."""
CARD = "README.md"
SENSORS = "sensors.json"
MADE_SPLITS = "splits.json"
FLAGS = "flags.json"
HOMES = "replaced-"
"""The folder of all numbers is called so, and a number, after a recording was replaced."""
STAGING = ".staging"
LOCK = ".lock"
INTAKE_LOCK = ".intake.lock"
FLAGS_LOCK = ".flags.lock"
COMMITTING = "committing"
"""Marker in the staging folder: a commit has begun and has not ended."""

TABLE_SCHEMAS = {
    "frames": FRAME_SCHEMA,
    "trajectories": TRAJECTORY_SCHEMA,
    "sources": SOURCE_SCHEMA,
    "findings": FINDING_SCHEMA,
}
TABLES = tuple(TABLE_SCHEMAS)
NUMBERS = ("signals", "aligned", "frame_values", "reference", "meshes")
"""What lies in the folder of all numbers, beside ``sensors.json``."""
SIGNAL_ARRAYS = ("t_ns", "value", "log_ns", "publish_ns", "header_ns")
ALIGNED_ARRAYS = ("value", "gap_ns")

LONGEST_NAME = 120
"""Longest folder name that is taken as it is; file systems allow 255 bytes, temporary names need some of them."""
LARGEST_SHARD = 64 * 2**20
"""Bytes of decoded frames that one shard holds at most; a commit keeps one shard in memory."""


@dataclass(frozen=True)
class Settings:
    """Sizes that are fixed when a store is created.

    Parameters
    ----------
    heap_chunk_bytes : int
        Bytes of one chunk file of an image heap; also the largest payload.
    signal_chunk_rows : int
        Rows of one chunk of a signal.
    shard_frames : int
        Raw frames of one shard; fewer where frames are large.
    """

    heap_chunk_bytes: int = 64 * 2**20
    signal_chunk_rows: int = 65_536
    shard_frames: int = 64

    def __post_init__(self) -> None:
        for name, value in asdict(self).items():
            if not isinstance(value, int) or value < 1:
                raise UsageError(f"store setting {name} is {value!r}", "a whole number of at least 1")

    def document(self) -> dict[str, Any]:
        """The settings as the manifest keeps them."""
        return asdict(self)

    def frames_per_shard(self, height: int, width: int) -> int:
        """Raw frames of this size in one shard."""
        return max(1, min(self.shard_frames, LARGEST_SHARD // (height * width * 3)))


def folder_name(name: str) -> str:
    """The folder under which something named by a recording is kept: safe on every file system, one to one.

    Letters, digits, ``_``, ``-``, ``~``, ``@`` and inner dots stay; all else is percent-encoded; a very long name is
    cut and gets its digest.

    Examples
    --------
    >>> folder_name("D20542"), folder_name("../left cam")
    ('D20542', '%2E.%2Fleft%20cam')
    """
    if not name:
        raise UsageError("an empty name", "a name of a camera, signal or sensor", "Name it in the mapping or the log.")
    encoded = quote(name, safe="@", errors="surrogatepass")
    if encoded.startswith("."):
        encoded = "%2E" + encoded[1:]
    if encoded in ("zarr.json", "c"):
        encoded = f"%{ord(encoded[0]):02X}{encoded[1:]}"
    if len(encoded) > LONGEST_NAME:
        encoded = f"{encoded[:LONGEST_NAME]}+{hashlib.sha256(name.encode(errors='surrogatepass')).hexdigest()[:16]}"
    return encoded


def heap_path(camera: str) -> str:
    """The array of a camera's encoded images."""
    return f"streams/{folder_name(camera)}/heap"


def rgb_path(camera: str, height: int, width: int) -> str:
    """The array of a camera's raw images of one size.

    Parameters
    ----------
    camera : str
        Name of the camera.
    height, width : int
        Pixels of its images.
    """
    return f"streams/{folder_name(camera)}/rgb_{height}x{width}"


def home_of(manifest: Mapping[str, Any]) -> str:
    """The folder of all numbers, with ``/``; empty (the store itself) until a recording was replaced.

    Numbers lie recording after recording, so that one that is replaced moves all after it. They are written to a folder
    of their own then, and the manifest changes over to it in one moment.
    """
    generation = manifest.get("generation", 0)
    return f"{HOMES}{generation}/" if generation else ""


def signal_path(home: str, name: str, array: str) -> str:
    """One of the arrays of a signal, below the folder of all numbers.

    Parameters
    ----------
    home : str
        Folder of all numbers with its ``/``, or empty, as `home_of` gives it.
    name : str
        Of the signal.
    array : str
        One of ``SIGNAL_ARRAYS``.
    """
    return f"{home}signals/{folder_name(name)}/{array}"


def aligned_path(home: str, name: str, array: str) -> str:
    """One of the arrays of values at the moments of the frames.

    Parameters
    ----------
    home : str
        Folder of all numbers with its ``/``, or empty, as `home_of` gives it.
    name : str
        Of the signal.
    array : str
        One of ``ALIGNED_ARRAYS``.
    """
    return f"{home}aligned/{folder_name(name)}/{array}"


def frame_values_path(home: str, name: str) -> str:
    """The array of values that a corpus annotates image by image."""
    return f"{home}frame_values/{folder_name(name)}/value"


def reference_path(home: str, sensor: str) -> str:
    """The array of a sensor's picture without contact."""
    return f"{home}reference/{folder_name(sensor)}/image"


def sensors_path(home: str) -> str:
    """The file of what is known of each sensor."""
    return f"{home}{SENSORS}"


def table_folder(table: str) -> str:
    """The folder of a table's parts."""
    return f"index/{table}.parquet"


def staging_folder(store_path: Path | str, sha256: str) -> Path:
    """Return the folder in which the staged take of a source lies until it is committed."""
    if len(sha256) != 64 or set(sha256) - set("0123456789abcdef"):
        raise UsageError(f"source digest {sha256!r}", "a SHA-256 in 64 lower-case hex digits")
    return Path(store_path) / STAGING / sha256


def store_around(path: Path | str) -> Path | None:
    """The innermost store that a local path is, or lies in; ``None`` where there is none. The path need not exist."""
    place = Path(path).resolve()
    folders = (folder for folder in (place, *place.parents) if (folder / MANIFEST).is_file())
    return next((folder for folder in folders if (folder / ROOT_GROUP).is_file()), None)
