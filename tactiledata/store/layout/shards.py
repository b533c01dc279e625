"""Raw frames in Zarr shards: a frame is compressed once, when it arrives, and afterwards only its bytes are moved.

A shard file is the frames' chunks one after another, then an index of (offset, length) a frame, then the index's
CRC-32C; a chunk is the zstd frame followed by its CRC-32C. Any Zarr v3 library reads it (codec ``sharding_indexed``).
zarr-python itself cannot take chunks that are compressed already: it would decompress and compress every raw frame
again at commit, and whole shards again at every append.

Source: Zarr v3 specification, sharding codec 1.0 and crc32c codec.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence

import google_crc32c
import numpy as np
from numcodecs.zstd import Zstd
from numpy.typing import NDArray

from tactiledata.errors import StoreError
from tactiledata.store.layout.arrays import ZSTD_LEVEL

CRC = struct.Struct("<I")
ABSENT = 2**64 - 1

Entries = list[tuple[int, int]]
"""(offset, length) of each frame's chunk in the shard; ``ABSENT`` where there is none."""


def pack_frame(payload: bytes) -> bytes:
    """The chunk of one frame, from height * width * 3 bytes of RGB."""
    packed = bytes(Zstd(level=ZSTD_LEVEL).encode(payload))
    return packed + CRC.pack(google_crc32c.value(packed))


def unpack_frame(chunk: bytes, out: NDArray[np.uint8]) -> None:
    """Fill ``out`` (height, width, 3) from a frame's chunk.

    Raises
    ------
    ValueError
        The chunk's CRC-32C does not fit, or it does not hold a frame of this size.
    """
    if not is_whole(chunk):
        raise ValueError("the CRC-32C of the compressed frame does not fit")
    try:
        Zstd().decode(chunk[:-4], out)
    except RuntimeError as error:
        raise ValueError(f"the compressed frame does not decode: {error}") from error


def is_whole(chunk: bytes) -> bool:
    """Whether a frame's chunk fits its CRC-32C."""
    return len(chunk) > 4 and google_crc32c.value(chunk[:-4]) == CRC.unpack_from(chunk, len(chunk) - 4)[0]


def shard_chunks(content: bytes, capacity: int, where: str) -> list[bytes]:
    """The chunks of a shard file, in order, as far as there are any.

    Parameters
    ----------
    content : bytes
        A whole shard file.
    capacity : int
        Frames of a shard.
    where : str
        The file, as the error names it.

    Raises
    ------
    StoreError
        Its index does not fit its CRC-32C.
    """
    entries = parse_index(content[-index_bytes(capacity) :], capacity, where)
    return [content[offset : offset + length] for offset, length in entries if length != ABSENT]


def shard_bytes(chunks: Sequence[bytes], capacity: int) -> bytes:
    """A shard file that holds these chunks first and nothing after them."""
    return b"".join([*chunks, shard_index([len(chunk) for chunk in chunks], capacity)])


def shard_index(lengths: Sequence[int], capacity: int) -> bytes:
    """What a shard file ends with, where chunks of these lengths lie first in it, one after another."""
    index = np.full((capacity, 2), ABSENT, dtype="<u8")
    ends = np.cumsum(lengths, dtype="<u8")
    index[: len(lengths), 1] = lengths
    index[: len(lengths), 0] = ends - index[: len(lengths), 1]
    table = index.tobytes()
    return table + CRC.pack(google_crc32c.value(table))


def index_bytes(capacity: int) -> int:
    """Bytes of the index at the end of a shard."""
    return 16 * capacity + 4


def parse_index(content: bytes, capacity: int, where: str) -> Entries:
    """The entries of a shard, from the last `index_bytes` of its file.

    Parameters
    ----------
    content : bytes
        The last `index_bytes` of a shard file.
    capacity : int
        Frames of a shard.
    where : str
        The file, as the error names it.

    Raises
    ------
    StoreError
        The index does not fit its CRC-32C.
    """
    table = content[: 16 * capacity]
    if len(content) != index_bytes(capacity) or google_crc32c.value(table) != CRC.unpack_from(content, len(table))[0]:
        raise StoreError(
            f"the index of the shard {where} does not fit its CRC-32C",
            "an intact shard file",
            "Run `tactiledata check` on the store to see what it concerns.",
            file=where,
        )
    return [(int(offset), int(length)) for offset, length in np.frombuffer(table, dtype="<u8").reshape(-1, 2)]
