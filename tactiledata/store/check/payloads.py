"""Whether the images of a store are the bytes that were recorded."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor

import google_crc32c
import numpy as np
import simplejpeg

from tactiledata.contract.image_batches import image_batches
from tactiledata.contract.image_bytes import size_fault
from tactiledata.contract.take import FrameFlag
from tactiledata.errors import TactileDataError
from tactiledata.store.read.pictures import default_threads
from tactiledata.store.read.reader import Store

BLOCK = 256
"""Frames whose payloads are in memory at once, per thread; fewer where images are large (`image_batches`)."""


def payload_faults(
    store: Store,
    decode: bool = False,
    threads: int | None = None,
    said: Callable[[int], None] = lambda count: None,
    rows: range | None = None,
) -> Iterator[tuple[int, str]]:
    """Rows whose image is damaged, in order, and how; memory stays flat.

    Parameters
    ----------
    store : Store
        The store, which may be damaged.
    decode : bool
        Whether images are decoded too; those that the store marks as broken are left out of that.
    threads : int, optional
        Threads that check images; one a core by default.
    said : callable
        Told how many more images were checked.
    rows : range, optional
        Of the table of frames; all by default.
    """
    table = store.frames(["crc32c", "flags", "height", "width"])
    height, width = (np.asarray(table[name]).astype(np.int64) for name in ("height", "width"))
    wanted = range(len(table)) if rows is None else rows
    crc32c, flags = np.asarray(table["crc32c"]), np.asarray(table["flags"])

    def of_block(block: tuple[int, int]) -> list[tuple[int, str]]:
        rows = list(wanted[slice(*block)])
        try:
            payloads: list[bytes | str | None] = list(store.encoded(rows, verify=False))
        except TactileDataError:
            payloads = [_payload(store, row) for row in rows]
        faults = []
        for row, payload in zip(rows, payloads, strict=True):
            fault = _fault(payload, int(crc32c[row])) or _size_fault(payload, int(height[row]), int(width[row]))
            if not fault and decode and payload is not None and not flags[row] & FrameFlag.BROKEN:
                fault = _decode_fault(store, row) or _jpeg_fault(payload)
            if fault:
                faults.append((row, fault))
        return faults

    with ThreadPoolExecutor(threads or default_threads()) as pool:
        blocks = list(image_batches((height * width)[wanted.start : wanted.stop], BLOCK))
        for (start, stop), faults in zip(blocks, pool.map(of_block, blocks), strict=True):
            yield from faults
            said(stop - start)


def _payload(store: Store, row: int) -> bytes | str | None:
    """A payload, or the reason why there is none, as text."""
    try:
        return store.encoded([row], verify=False)[0]
    except TactileDataError as error:
        return error.found


def _fault(payload: bytes | str | None, crc32c: int) -> str:
    if isinstance(payload, str):
        return payload
    if payload is not None and google_crc32c.value(payload) != crc32c:
        return "the payload does not fit its CRC-32C"
    return ""


def _size_fault(payload: bytes | str | None, height: int, width: int) -> str:
    fault = "" if payload is None else size_fault(height, width)
    return f"the image is never decoded: its {fault}" if fault else ""


def _decode_fault(store: Store, row: int) -> str:
    try:
        store.images([row], threads=1)
    except TactileDataError as error:
        return error.found
    return ""


def _jpeg_fault(payload: bytes | str) -> str:
    """What a decoder passes over in a damaged JPEG to show the rest of the picture; empty where there is nothing."""
    if not isinstance(payload, bytes) or not payload.startswith(b"\xff\xd8"):
        return ""
    try:
        simplejpeg.decode_jpeg(payload)
    except ValueError as error:
        try:
            simplejpeg.decode_jpeg(payload, strict=False)
        except ValueError:  # of a kind that this decoder does not know at all; another has decoded it
            return ""
        return f"its JPEG decodes to a damaged picture: {error}"
    return ""
