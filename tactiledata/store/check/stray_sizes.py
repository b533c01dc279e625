"""Images of another size than the others of their sensor that a store of before does not mark."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

import numpy as np

from tactiledata.contract.image_sizes import Size, share_words, stray_sizes, usual_size, words_of
from tactiledata.contract.records import Finding
from tactiledata.contract.take import UNUSABLE
from tactiledata.contract.wording import counted
from tactiledata.store.read.reader import Store

MOST_NAMED = 3
"""Recordings that a sentence names."""


def stray_findings(store: Store) -> Iterator[Finding]:
    """A warning where images are strays of size and have no mark, as in stores that were written before there was one.

    Splits and datasets take such images for usable, and what reads pictures of one size stops at them.
    """
    frames = store.frames(["source", "sensor", "height", "width", "flags"])
    usable = (frames["flags"].to_numpy() & UNUSABLE) == 0
    numbers = np.stack([frames[name].to_numpy().astype(np.int64) for name in ("source", "height", "width")], axis=1)
    sensors = frames["sensor"].combine_chunks()
    codes = np.asarray(sensors.indices) if len(frames) else np.empty(0, np.int64)
    rows, totals = np.unique(np.column_stack([numbers, codes])[usable], axis=0, return_counts=True)
    counts: dict[tuple[int, int], Counter[Size]] = {}
    for (source, height, width, code), count in zip(rows.tolist(), totals.tolist(), strict=True):
        counts.setdefault((source, code), Counter())[height, width] = count
    strays = {place: found for place, sizes in counts.items() if (found := stray_sizes(sizes))}
    if not strays:
        return
    keys = store.sources(["key"])["key"].to_pylist()
    told = []
    for place, sizes in list(strays.items())[:MOST_NAMED]:
        size, total = min(sizes), sum(counts[place].values())
        words = share_words(counts[place][size], total, size)
        told.append(f"{keys[place[0]]}: {words} (rows x columns), most are {words_of(usual_size(counts[place]))}")
    more = f"; and in {counted(len(strays) - MOST_NAMED, 'more place')}" if len(strays) > MOST_NAMED else ""
    total = sum(counts[place][size] for place, sizes in strays.items() for size in sizes)
    message = (
        f"{counted(total, 'image')} of another size than the others of their sensor without a mark, which ingest sets "
        f"since ({'; '.join(told)}{more}): splits and datasets do not leave them out. `tactiledata ingest RECORDINGS "
        "--replace` with those recordings marks them"
    )
    yield Finding("store-unmarked-size", "warning", message, count=total)
