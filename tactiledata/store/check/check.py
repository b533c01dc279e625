"""Whether a store is whole: manifest, files, arrays, tables, payloads, and what does not belong to it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from tactiledata.contract.lfs_pointer import without_remedy
from tactiledata.contract.progress import Progress
from tactiledata.contract.records import Finding
from tactiledata.contract.take import FrameFlag
from tactiledata.contract.wording import counted, listed
from tactiledata.errors import SchemaError, TactileDataError
from tactiledata.store.check.documents import document_findings
from tactiledata.store.check.flags import flags_findings
from tactiledata.store.check.indices import INDEX_NEEDS, index_findings
from tactiledata.store.check.lost_files import lost_images
from tactiledata.store.check.meshes import mesh_findings
from tactiledata.store.check.payloads import payload_faults
from tactiledata.store.check.pointers import pointer_findings
from tactiledata.store.check.splits import split_findings
from tactiledata.store.check.stray_sizes import stray_findings
from tactiledata.store.check.tables import not_checked, table_findings
from tactiledata.store.check.values import remedied_value_findings
from tactiledata.store.layout.manifest import need_manifest_schema
from tactiledata.store.layout.statistics import statistics_fault
from tactiledata.store.read.reader import Store
from tactiledata.store.write.documents import sensor_faults
from tactiledata.store.write.recover import (
    foreign_arrays,
    foreign_parts,
    heaps,
    is_interrupted,
    raw_arrays,
    row_arrays,
    stale_staging,
    temporary_files,
)

IMAGES = "whether images are those that were recorded"
NEEDS = {
    **INDEX_NEEDS,
    "whether numbers are those of their recordings": ("sources",),
    IMAGES: ("frames",),
    "whether images of another size are marked": ("frames", "sources"),
}
"""Checks, and the tables that they need."""


def check(
    store: Store | Path | str,
    images: bool = True,
    decode: bool = False,
    threads: int | None = None,
    progress: Progress | None = None,
) -> list[Finding]:
    """What is wrong with a store; empty where nothing is.

    Parameters
    ----------
    store : Store or Path or str
        An open store, or its folder, which is opened even where it is damaged.
    images : bool
        Whether every image is held against its CRC-32C.
    decode : bool
        Whether every image is decoded as well.
    threads : int, optional
        Threads that check images; one a core by default.
    progress : callable, optional
        Told after each source and each block of images how far the check is.

    Raises
    ------
    MissingFile, StoreError
        It cannot even be opened.
    """
    opened = store if isinstance(store, Store) else Store.open(store, damaged=True)
    of_tables = table_findings(opened)
    broken = {table for table, found in of_tables.items() if found}
    n_sources = opened.manifest["rows"]["sources"] if "sources" not in broken else 0
    n_images = opened.n_frames if images and "frames" not in broken else 0
    steps = _Steps(n_sources + n_images, progress)
    findings = [
        *pointer_findings(opened),
        *manifest_findings(opened.manifest),
        *document_findings(opened),
        *(one for found in of_tables.values() for one in found),
    ]
    findings += [*_shape_findings(opened), *_sensor_findings(opened)]
    findings += index_findings(opened, broken)
    if "sources" not in broken:
        findings += remedied_value_findings(opened, lambda key: steps.take(1, key))
    if n_images:
        findings += image_findings(opened, decode, threads, lambda count: steps.take(count, "images"))
    if not {"frames", "sources"} & broken:
        findings += stray_findings(opened)
    findings += [
        *mesh_findings(opened),
        *split_findings(opened),
        *flags_findings(opened),
        *not_checked(broken, NEEDS if images else _without_images()),
    ]
    return [*findings, *_leftover_findings(opened)]


class _Steps:
    """Counts what is done, for who watches."""

    def __init__(self, total: int, progress: Progress | None) -> None:
        self._done, self._total, self._progress = 0, total, progress

    def take(self, count: int, what: str) -> None:
        """Report that so many more steps are done."""
        self._done += count
        if self._progress is not None:
            self._progress(self._done, self._total, what)


def _without_images() -> dict[str, tuple[str, ...]]:
    return {what: tables for what, tables in NEEDS.items() if what != IMAGES}


def _damage(code: str, message: str, stream: str = "", count: int = 1) -> Finding:
    return Finding(code, "damage", message, stream=stream, count=count)


def manifest_findings(manifest: Mapping[str, Any]) -> Iterator[Finding]:
    """What contradicts itself in a manifest."""
    try:
        need_manifest_schema(dict(manifest))
    except SchemaError as error:
        yield _damage("store-manifest", str(error))
        return
    rows = manifest["rows"]
    for table, parts in manifest["index"].items():
        total = sum(part["rows"] for part in parts)
        if total != rows[table]:
            yield _damage("store-manifest", f"the parts of {table} have {total} rows, the manifest says {rows[table]}")
    if len(manifest["sources"]) != rows["sources"]:
        yield _damage("store-manifest", f"{len(manifest['sources'])} digests for {rows['sources']} sources")
    for kind in ("aligned", "frame_values"):
        for name, facts in manifest[kind].items():
            if facts["rows"] != rows["frames"]:
                yield _damage("store-manifest", f"{kind} {name!r} has {facts['rows']} rows for {rows['frames']} frames")
    for kind in ("signals", "aligned", "frame_values"):
        for name, facts in manifest[kind].items():
            if fault := statistics_fault(facts["statistics"], len(facts["columns"])):
                yield _damage("store-manifest", f"the statistics of {kind} {name!r} {fault}")


def _shape_findings(store: Store) -> Iterator[Finding]:
    """Arrays that are missing or shorter than the manifest says."""
    wanted = [*row_arrays(store.manifest), *heaps(store.manifest)]
    wanted += [(path, count) for path, _, count in raw_arrays(store.manifest)]
    for path, length in wanted:
        try:
            shape = store.array(path).shape
        except (TactileDataError, OSError, ValueError, KeyError) as error:
            yield _damage("store-array", f"array {path} cannot be opened: {without_remedy(error)}", path)
            continue
        if shape[0] < length:
            yield _damage("store-array", f"array {path} has {shape[0]} rows, the manifest names {length}", path)


def _sensor_findings(store: Store) -> Iterator[Finding]:
    try:
        for sensor, fault in sensor_faults(store):
            yield _damage("store-sensors", fault, sensor)
    except TactileDataError as error:
        yield _damage("store-sensors", without_remedy(error))
    for sensor in store.manifest["references"]:
        try:
            store.reference(sensor)
        except (TactileDataError, OSError, ValueError, KeyError) as error:
            found = error.found if isinstance(error, TactileDataError) else str(error)
            yield _damage("store-reference", found, sensor)


def image_findings(store: Store, decode: bool, threads: int | None, said: Callable[[int], None]) -> list[Finding]:
    """Findings for damaged images: those that the store does not mark yet, and those that it does.

    Parameters
    ----------
    store : Store
        The store, which may be damaged.
    decode : bool
        Whether images are decoded too.
    threads : int, optional
        Threads that check images; one a core by default.
    said : callable
        Told how many more images were checked.
    """
    try:
        flags = np.asarray(store.frames(["flags"])["flags"])
        faults = list(payload_faults(store, decode, threads, said))
    except TactileDataError as error:
        return [_damage("store-payload", without_remedy(error))]
    new = [(row, why) for row, why in faults if not flags[row] & FrameFlag.BROKEN]
    marked = len(faults) - len(new)
    findings, new = lost_images(store, new)
    if new:
        shown = "; ".join(f"frame {row}: {why}" for row, why in new[:5]) + ("; …" if len(new) > 5 else "")
        message = f"{_damaged_words(len(new))} ({shown}); `check {'--decode ' * decode}--repair` marks them as broken"
        findings.append(_damage("store-payload", message, count=len(new)))
    if marked:
        message = f"{_damaged_words(marked)} and marked as broken"
        findings.append(Finding("store-payload-marked", "warning", message, count=marked))
    return findings


def _damaged_words(count: int) -> str:
    """How many images are damaged, in words that hold for those too large to be decoded, too."""
    return f"{counted(count, 'image')} {'is' if count == 1 else 'are'} damaged or too large"


def _leftover_findings(store: Store) -> Iterator[Finding]:
    place = Path(store.location)
    if not place.is_dir():
        return
    leftovers = [*foreign_arrays(place, store.manifest), *foreign_parts(place, store.manifest), *temporary_files(place)]
    leftovers += stale_staging(place, store.manifest)
    if leftovers or is_interrupted(place):
        shown = listed([str(one.relative_to(place)) for one in leftovers], 5)
        message = (
            f"a writer was interrupted and left {shown or 'unfinished appends'}; harmless, the next write removes it"
        )
        yield Finding("store-leftover", "info", message, count=max(1, len(leftovers)))
