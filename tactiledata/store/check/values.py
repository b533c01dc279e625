"""Whether the numbers of a store are those of its sources."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from dataclasses import replace

import google_crc32c
import numpy as np

from tactiledata.contract.lfs_pointer import POINTER_WORDS, without_remedy
from tactiledata.contract.records import Finding
from tactiledata.errors import TactileDataError
from tactiledata.store.check.lost_files import ingest_again
from tactiledata.store.layout.places import (
    ALIGNED_ARRAYS,
    SIGNAL_ARRAYS,
    aligned_path,
    home_of,
    signal_path,
)
from tactiledata.store.read.reader import Store
from tactiledata.store.read.recorded import recorded_spans
from tactiledata.store.read.rows import Rows

BLOCK_ROWS = 65_536


def value_findings(
    store: Store, said: Callable[[str], None], is_asked: Callable[[str], bool] = lambda path: True
) -> list[Finding]:
    """Numbers that are not those of their sources, and times that run backwards.

    Parameters
    ----------
    store : Store
        The store, which may be damaged.
    said : callable
        Told the name of each source that was checked.
    is_asked : callable
        Of an array's path: whether it is checked.
    """
    return [finding for _, finding in _by_recording(store, said, is_asked)]


def remedied_value_findings(store: Store, said: Callable[[str], None]) -> list[Finding]:
    """`value_findings` with what to do: damaged recordings are replaced together, or those that stay prevent it.

    Parameters
    ----------
    store : Store
        The store, which may be damaged.
    said : callable
        Told the name of each source that was checked.
    """
    found = list(_by_recording(store, said, lambda path: True))
    remedy = ingest_again(store.location, list(dict.fromkeys(key for key, _ in found)))
    # of a pointer another finding says what fetches the file
    return [
        finding
        if POINTER_WORDS in finding.message
        else replace(finding, message=f"{finding.message.rstrip('.')}; {remedy}")
        for _, finding in found
    ]


def _by_recording(
    store: Store, said: Callable[[str], None], is_asked: Callable[[str], bool]
) -> Iterator[tuple[str, Finding]]:
    first_frame = 0
    rows: dict[str, Rows] = {}
    for source in store.sources(["key", "frames", "contents"]).to_pylist():
        frames = (first_frame, first_frame + source["frames"])
        first_frame = frames[1]
        key = source["key"]
        for finding in source_value_findings(store, key, source["contents"], frames, rows, is_asked):
            yield key, finding
        said(key)


def need_sound_values(store: Store, signals: Collection[str]) -> None:
    """Refuse a store whose frame values, or whose named signals at native rate, are not the numbers of their sources.

    A chunk that was lost reads as numbers that nobody recorded: whoever computes from a store asks this first.

    Raises
    ------
    TactileDataError
        They are not.
    """
    home = home_of(store.manifest)
    needed = {signal_path(home, name, array) for name in signals for array in SIGNAL_ARRAYS}
    needed |= {aligned_path(home, name, array) for name in store.aligned_names for array in ALIGNED_ARRAYS}
    found = value_findings(store, lambda key: None, needed.__contains__)
    if found:
        raise TactileDataError(
            f"a damaged store: {found[0].message}" + (f"; {len(found) - 1} more" if found[1:] else ""),
            "the numbers that were ingested",
            "`tactiledata check` lists all damage; ingest the recordings anew.",
        )


def source_value_findings(
    store: Store,
    key: str,
    contents: str,
    frames: tuple[int, int],
    rows: dict[str, Rows] | None = None,
    is_asked: Callable[[str], bool] = lambda path: True,
) -> Iterator[Finding]:
    """Findings on the numbers of one source that are not those that were ingested.

    Parameters
    ----------
    store : Store
        The store, which may be damaged.
    key, contents : str
        Of its row in the table of sources.
    frames : (first, stop)
        Its rows in the table of frames.
    rows : dict, optional
        Arrays that are open already, by path.
    is_asked : callable
        See `value_findings`.
    """
    opened = {} if rows is None else rows
    try:
        spans = recorded_spans(home_of(store.manifest), key, contents, frames)
    except TactileDataError as error:
        yield _damage(error.found, "")
        return
    for path, start, stop, crc in spans:
        if not is_asked(path):
            continue
        fault = _span_fault(store, opened, path, start, stop, crc)
        if fault:
            yield _damage(f"{path}, rows {start} to {stop} of {key}: {fault}", path)


def _damage(message: str, stream: str) -> Finding:
    return Finding("store-values", "damage", message, stream=stream)


def _span_fault(store: Store, rows: dict[str, Rows], path: str, start: int, stop: int, expected: int) -> str:
    if path not in rows:
        rows[path] = store.rows(path, stop)
    values = rows[path]
    if values.length < stop:
        values.lengthen(stop)
    crc, last = 0, None
    try:
        for first in range(start, stop, BLOCK_ROWS):
            block = values.span(first, min(first + BLOCK_ROWS, stop))
            crc = google_crc32c.extend(crc, np.ascontiguousarray(block).tobytes())
            if path.endswith("/t_ns"):
                if (np.diff(block) < 0).any() or (last is not None and block[0] < last):
                    return "times run backwards"
                last = block[-1]
    except (TactileDataError, OSError) as error:
        return without_remedy(error)
    if crc == expected:
        return ""
    lost = values.lost_files(start, stop)
    return f"the file {lost[0]} is missing" if lost else "the numbers do not fit their CRC-32C"
