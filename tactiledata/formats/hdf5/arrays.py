"""Which arrays an HDF5 file holds, and which of them are times: by names, types and shapes, without their values."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from tactiledata.formats.reading.described import camera_topics
from tactiledata.formats.reading.hdf5_members import Hdf5Members

DEEP = 6
"""Levels of groups that are looked into."""
MOST_ARRAYS = 2000
"""Arrays of a file that are looked at; a file with more is no recording."""
FEWEST_ROWS = 2
"""Rows of an array that could be a stream."""

Kind = Literal["numbers", "pictures", "packed pictures", "other"]

_WORD = r"(t|ts|sec|secs|seconds|stamps?|times?|timestamps?|clock)"
_STREAM = r"(img|images?|pics?|pictures?|frames?|cam|camera|digit|force|ft|wrench|robot|tcp|poses?|joints?)_?\d*"
_TIME = re.compile(rf"((^|_){_WORD}|^{_WORD}_?{_STREAM})(_?(s|ms|us|ns))?$", re.IGNORECASE)


@dataclass(frozen=True)
class FoundArray:
    """An array of a file.

    Parameters
    ----------
    path : str
        Names of the groups and of the array, with slashes: ``"force/values"``.
    shape : tuple of int
    dtype : str
        NumPy's name of the type.
    kind : str
        "numbers" (n,) or (n, k), "pictures" (n, height, width, 3) uint8, "packed pictures" (n,) JPEG or PNG files as
        bytes, "other".
    """

    path: str
    shape: tuple[int, ...]
    dtype: str
    kind: Kind

    @property
    def name(self) -> str:
        """The last part of the path."""
        return self.path.rsplit("/", 1)[-1]

    @property
    def folder(self) -> str:
        """The path of the group that it lies in; empty for the file itself."""
        return self.path.rpartition("/")[0]

    @property
    def rows(self) -> int:
        """Its first dimension; 0 for a single number."""
        return self.shape[0] if self.shape else 0

    @property
    def is_time(self) -> bool:
        """Whether its name and shape say that it holds times."""
        return self.kind == "numbers" and len(self.shape) == 1 and bool(_TIME.search(self.name))

    @property
    def unit(self) -> str:
        """The unit of times in it, as far as its name and type say: whole numbers are nanoseconds, others seconds."""
        named = re.search(r"_(s|ms|us|ns)$", self.name, re.IGNORECASE)
        return named[1].lower() if named else ("s" if self.dtype.startswith("float") else "ns")


def arrays_of(members: Hdf5Members) -> list[FoundArray]:
    """Return the arrays of a file, in the order of its groups; at most ``MOST_ARRAYS``.

    Parameters
    ----------
    members : Hdf5Members
        Of the open file.

    Raises
    ------
    UnsafeContent
        The file holds links, or seems to hold more than fits into it.
    """
    found = []
    for one in _walked(members, members.root, "", DEEP):
        found.append(one)
        if len(found) == MOST_ARRAYS:
            break
    return found


def paths_read(mapping: Mapping[str, Any]) -> set[str]:
    """Return the paths of all arrays that a mapping reads: topics, their fields, and their times.

    Parameters
    ----------
    mapping : dict
        A document that fits ``schemas/mapping.json``.
    """
    signals, images = ([*mapping.get(part, {}).values()] for part in ("signals", "images"))
    paths = [*(entry["topic"] for entry in signals), *(path for entry in images for path in camera_topics(entry))]
    paths += [entry["time"] for entry in (*signals, *images) if "time" in entry]
    paths += [joined(entry["topic"], field) for entry in signals for field in entry.get("fields", ())]
    return {path.strip("/") for path in paths}


def joined(folder: str, name: str) -> str:
    """Return the path of an array in a group; "/" and nothing are the file itself."""
    return f"{folder}/{name}" if folder.strip("/") else name


def times_of(array: FoundArray, arrays: Sequence[FoundArray]) -> list[FoundArray]:
    """Return the arrays that could hold the times of another one: as long as it is, the nearest in the file first."""
    beside = [one for one in arrays if one.is_time and one.rows == array.rows and one.path != array.path]
    return sorted(beside, key=lambda one: (one.folder != array.folder, -_shared(one.path, array.path)))


def streams_of(arrays: Sequence[FoundArray]) -> list[tuple[FoundArray, FoundArray]]:
    """Return the arrays that are no times and have times, each with the likeliest of these."""
    streams = []
    for one in arrays:
        if not one.is_time and one.kind != "other" and one.rows >= FEWEST_ROWS:
            times = times_of(one, arrays)
            streams += [(one, times[0])] if times else []
    return streams


def _walked(members: Hdf5Members, group: Any, above: str, depth: int) -> Iterator[FoundArray]:
    """Yield the arrays of a group and of the groups below it."""
    import h5py

    for name in members.names(group):
        member = members.member(group, name)
        path = f"{above}/{name}" if above else name
        if isinstance(member, h5py.Dataset):
            yield _found(path, member)
        elif depth > 0:
            yield from _walked(members, member, path, depth - 1)


def _found(path: str, dataset: Any) -> FoundArray:
    """Return what is said of an array by its type and shape."""
    import h5py

    shape = tuple(dataset.shape or ())
    dtype = dataset.dtype
    kind: Kind = "other"
    if dtype == np.uint8 and len(shape) == 4 and shape[3] == 3:
        kind = "pictures"
    elif h5py.check_vlen_dtype(dtype) == np.uint8 and len(shape) == 1:
        kind = "packed pictures"
    elif dtype.kind in "fiu" and len(shape) in (1, 2):
        kind = "numbers"
    return FoundArray(path, shape, str(dtype)[:60], kind)


def _shared(one: str, other: str) -> int:
    """Return how many groups two paths share."""
    count = 0
    for a, b in zip(one.split("/")[:-1], other.split("/")[:-1], strict=False):
        if a != b:
            break
        count += 1
    return count
