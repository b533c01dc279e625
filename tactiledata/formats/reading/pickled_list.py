"""Pickled lists of bytes, indexed instead of loaded: how corpora keep fifty thousand JPEG images in one file."""

from __future__ import annotations

import pickletools
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from tactiledata.formats.reading.restricted_pickle import PICKLE_FAULTS, BoundedReader, broken_file, open_named


@dataclass(frozen=True)
class BytesList:
    """A pickled list of bytes, known by where its items lie: they are read one by one, in any order.

    Parameters
    ----------
    path : Path
    spans : (n, 2) int64
        First byte in the file and length of each item.
    complete : bool
        Whether the pickle's end was reached; a truncated one gives the items before the cut.
    """

    path: Path
    spans: NDArray[np.int64]
    complete: bool

    def __len__(self) -> int:
        return len(self.spans)

    def __getitem__(self, index: int) -> bytes:
        start, length = self.spans[index].tolist()
        with self.path.open("rb") as stream:
            stream.seek(start)
            return stream.read(length)


_BYTES_OPCODES = {"SHORT_BINBYTES": 2, "BINBYTES": 5, "BINBYTES8": 9}
_OTHER_OPCODES = {"PROTO", "FRAME", "MARK", "APPEND", "APPENDS", "STOP"}
_PUT_OPCODES = {"MEMOIZE", "BINPUT", "LONG_BINPUT", "PUT"}
_GET_OPCODES = {"BINGET", "LONG_BINGET", "GET"}


def index_bytes_list(path: Path) -> BytesList | None:
    """Return the places of the items of a pickled list of bytes; ``None`` where the file holds something else.

    Nothing is executed and one item at a time is in memory, so a list of any length is read in flat memory.

    Raises
    ------
    BrokenLog
        Not a pickle, or cut before its first item.
    """
    spans: list[tuple[int, int]] = []
    memo: dict[int, tuple[int, int] | None] = {}
    latest: tuple[int, int] | None = None
    lists, complete = 0, False
    with open_named(path) as stream:
        size = path.stat().st_size
        try:
            operations: Iterator[tuple[Any, Any, Any]] = pickletools.genops(cast("Any", BoundedReader(stream, size)))
            for opcode, argument, position in operations:
                if opcode.name in _BYTES_OPCODES:
                    latest = (position + _BYTES_OPCODES[opcode.name], len(argument))
                    spans.append(latest)
                elif opcode.name in _PUT_OPCODES:
                    memo[len(memo) if argument is None else argument] = latest
                elif opcode.name in _GET_OPCODES and (again := memo.get(argument)) is not None:
                    spans.append(again)
                elif opcode.name == "EMPTY_LIST":
                    lists, latest = lists + 1, None
                elif opcode.name not in _OTHER_OPCODES:
                    return None
            complete = True
        except PICKLE_FAULTS as error:
            if not spans:
                raise broken_file(str(path), str(error)) from error
    if lists != 1:
        return None
    return BytesList(path, np.array(spans, dtype=np.int64).reshape(-1, 2), complete)
