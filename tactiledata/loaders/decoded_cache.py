"""Decoded pictures kept on a local disk, so that only the first epoch decodes them (docs/decisions/0055).

Each frame that was given room (`cache_room`) has a slot in one file. A slot is written pixels first, then its record
with their checksum; whoever reads holds the pixels against the record. So every moment leaves slots that are whole or
that count as empty, nobody waits for anybody, and two processes that fill one slot write the same bytes.
"""

from __future__ import annotations

import errno
import fcntl
import os
import stat
import struct
import warnings
import weakref
from pathlib import Path
from typing import Any

import numpy as np
import xxhash
from numpy.typing import NDArray

from tactiledata.arrays import PictureArray

PAGE = 4096
RECORD = struct.Struct("<4sIqQ")
"""Behind the pixels of a slot: a mark, their number of bytes, the row of the frame, their checksum (xxh3, 64 bit)."""
MARK = b"tdpx"


class DecodedCacheWarning(UserWarning):
    """Decoded pictures were damaged on the disk, or cannot be kept any more; the pictures given out are right."""


def slot_bytes(shape: tuple[int, ...]) -> int:
    """Bytes of a slot for a picture (h, w, 3): pixels and record, rounded up to pages."""
    return -(-(int(np.prod(shape)) + RECORD.size) // PAGE) * PAGE


class DecodedCache:
    """Slots of decoded pictures of one size; may be pickled, forked, and used by several threads at once.

    Parameters
    ----------
    path : Path
        The file of slots.
    rows : (n_slots,) int64
        The row of the store that each slot belongs to.
    n_frames : int
        Frames of the store.
    shape : (h, w, 3)
        Of every picture.

    Attributes
    ----------
    n_slots : int
    """

    def __init__(self, path: Path, rows: NDArray[np.int64], n_frames: int, shape: tuple[int, ...]) -> None:
        self._path, self._shape = path, shape
        self._bytes, self._slot_bytes = int(np.prod(shape)), slot_bytes(shape)
        self._slots = np.full(n_frames, -1, np.int32)
        # rows come from a file that anybody may have damaged; a slot given to a wrong row only counts as empty
        known = (rows >= 0) & (rows < n_frames)
        self._slots[rows[known]] = np.flatnonzero(known)
        self.n_slots = int((self._slots >= 0).sum())
        self._descriptor: _Descriptor | None = None
        self._is_full = False
        self._warned: set[str] = set()

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_descriptor": None}

    def has_room(self, rows: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Return which frames (n,) have a slot, filled or not."""
        return self._slots[rows] >= 0

    def read(self, row: int, target: PictureArray) -> bool:
        """Whether the picture of a frame is kept and was read into ``target``; what is damaged is not.

        Parameters
        ----------
        row : int
            Row of the frame in the store.
        target : (h, w, 3) uint8, contiguous
            Where the pixels go; holds anything where it returns False.
        """
        slot = int(self._slots[row])
        if slot < 0 or target.shape != self._shape or not target.flags.c_contiguous:
            return False
        start = slot * self._slot_bytes
        try:
            descriptor = self._opened()
            record = os.pread(descriptor.number, RECORD.size, start + self._bytes)
            if len(record) < RECORD.size:
                return False
            mark, count, owner, checksum = RECORD.unpack(record)
            if (mark, count, owner) != (MARK, self._bytes, row):
                return False  # empty
            if os.preadv(descriptor.number, [target.data], start) == self._bytes and checksum == _checksum(target):
                return True
            reason = "a checksum does not fit"
        except OSError as error:
            reason = str(error.strerror)
        self._warn("damaged", f"a decoded picture of frame {row} cannot be read from {self._path} ({reason})")
        return False

    def keep(self, row: int, picture: PictureArray) -> None:
        """Write the picture of a frame into its slot, where it has one.

        Parameters
        ----------
        row : int
            Row of the frame in the store.
        picture : (h, w, 3) uint8
            Its pixels.
        """
        slot = int(self._slots[row])
        if slot < 0 or self._is_full or picture.shape != self._shape or not picture.flags.c_contiguous:
            return
        start = slot * self._slot_bytes
        record = RECORD.pack(MARK, self._bytes, row, _checksum(picture))
        try:
            descriptor = self._opened()
            if os.pwrite(descriptor.number, picture.data, start) == self._bytes:
                os.pwrite(descriptor.number, record, start + self._bytes)
                return
            reason = "the disk is full"
        except OSError as error:
            reason = str(error.strerror)
        self._is_full = True
        self._warn("full", f"decoded pictures are not kept in {self._path} any more ({reason})")

    def _warn(self, kind: str, text: str) -> None:
        if kind not in self._warned:
            self._warned.add(kind)
            warnings.warn(f"{text}; it is decoded from the store", DecodedCacheWarning, stacklevel=2)

    def _opened(self) -> _Descriptor:
        """Return the open file; the caller holds it as long as it uses its number.

        After a dataset was copied to another process, several threads may open the file at once. The last one stays;
        the others must not be closed, and their numbers given to other files, before their threads are done.
        """
        descriptor = self._descriptor
        if descriptor is None:
            descriptor = self._descriptor = _Descriptor(self._path)
        return descriptor

    def open(self) -> None:
        """Open the file of slots, made where it is missing, and say to others that it is in use.

        Raises
        ------
        OSError
            It cannot be read and written, or is no file.
        """
        self._descriptor = _Descriptor(self._path, os.O_CREAT)


class _Descriptor:
    """An open file of slots; its shared lock, which goes with the process, says that it is in use."""

    def __init__(self, path: Path, flags: int = 0) -> None:
        self.number = open_slots(path, flags)
        weakref.finalize(self, os.close, self.number)
        fcntl.flock(self.number, fcntl.LOCK_SH)
        if not os.fstat(self.number).st_nlink:  # removed for another cache before it was said to be in use
            raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), str(path))


def open_slots(path: Path, flags: int = 0) -> int:
    """Return a descriptor of a file of slots, to read and write.

    Raises
    ------
    OSError
        It cannot be opened, or is a link, a pipe or a device.
    """
    number = os.open(path, os.O_RDWR | os.O_CLOEXEC | os.O_NOFOLLOW | flags, 0o644)
    if not stat.S_ISREG(os.fstat(number).st_mode):
        os.close(number)
        raise OSError(errno.EINVAL, "it is no file", str(path))
    return number


def _checksum(picture: PictureArray) -> int:
    return xxhash.xxh3_64_intdigest(picture.data)
