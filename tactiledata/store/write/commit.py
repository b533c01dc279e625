"""Staged takes become part of a store, in groups that are there wholly or not at all: the manifest is written last."""

from __future__ import annotations

import copy
import shutil
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from tactiledata.contract.provenance import bytes_digest, file_digest
from tactiledata.errors import NotAStore, TactileDataError, UsageError
from tactiledata.store.layout.arrays import open_root
from tactiledata.store.layout.batch import Batch
from tactiledata.store.layout.lock import unwritable, writing_lock
from tactiledata.store.layout.manifest import (
    Manifest,
    empty_manifest,
    has_tables,
    not_a_store,
    read_manifest,
    settings_of,
    write_manifest,
)
from tactiledata.store.layout.places import CARD, COMMITTING, MANIFEST, STAGING, Settings, store_around
from tactiledata.store.read.reader import Store
from tactiledata.store.write.appender import Appender
from tactiledata.store.write.card import card_bytes, write_card
from tactiledata.store.write.documents import drop_other_sensors, need_whole_documents, record_documents
from tactiledata.store.write.recover import begin_commit, clean_commit, clean_staging, drop_unnamed, is_interrupted
from tactiledata.store.write.writer import StagedTake

GROUP_BYTES = 256 * 2**20
GROUP_FRAMES = 8192
GROUP_TAKES = 256


def create(store_path: Path | str, settings: Settings | None = None) -> Manifest:
    """The manifest of a store, which is made where there is none.

    Parameters
    ----------
    settings : Settings, optional
        Sizes of chunks of a new store.

    Raises
    ------
    StoreError
        The folder holds something else, cannot be written, or is a store of a newer version.
    UsageError
        The store exists with other settings, or the place lies in another store.
    """
    folder = Path(store_path)
    if (outer := store_around(folder.resolve().parent)) is not None:
        raise UsageError(
            f"{folder} lies in the store {outer}",
            "a place outside any store",
            "Choose another name; nothing was changed.",
        )
    try:
        if folder.exists() and not (folder / MANIFEST).exists():
            _refuse_foreign(folder)
        folder.mkdir(parents=True, exist_ok=True)
        if not (folder / MANIFEST).exists():
            with writing_lock(folder):
                if not (folder / MANIFEST).exists():
                    _start(folder, settings or Settings())
    except OSError as error:
        if isinstance(error, TactileDataError):
            raise
        raise unwritable(folder, error) from error
    manifest = read_manifest(folder)
    if settings is not None and settings_of(manifest) != settings:
        raise UsageError(
            f"the store {folder} was made with {settings_of(manifest)}", f"{settings}", "Leave the settings away."
        )
    return manifest


def _refuse_foreign(folder: Path) -> None:
    if not folder.is_dir():
        raise NotAStore(f"{folder} is a file", "a folder for a store", "Choose another name.", path=str(folder))
    ours = {".lock", STAGING, "zarr.json"}
    strangers = sorted(place.name for place in folder.iterdir() if place.name not in ours and place.suffix != ".part")
    if (folder / MANIFEST).exists():
        return  # another process made the store since the caller looked
    if strangers and has_tables(folder):
        raise not_a_store(str(folder), exists=True)
    if strangers:
        raise NotAStore(
            f"the folder {folder} holds {', '.join(strangers[:3])}{' …' * (len(strangers) > 3)} but no {MANIFEST}",
            "a store, an empty folder or a new name",
            "Choose another name; nothing was changed.",
            path=str(folder),
        )


def _start(folder: Path, settings: Settings) -> None:
    with Batch(folder) as batch:
        open_root(batch)
        batch.publish()
    manifest = empty_manifest(settings)
    # the manifest first: a folder with a card alone would be taken for somebody else's
    record_documents(folder, manifest)
    _name_card(folder, manifest)
    write_manifest(folder, manifest)
    write_card(folder, manifest)


def _name_card(folder: Path, manifest: Manifest) -> None:
    manifest["documents"][CARD] = bytes_digest(card_bytes(folder, manifest))


def _settle(folder: Path, manifest: Manifest, with_card: bool) -> None:
    """The manifest becomes the store's, with the digests of all documents; every commit ends here."""
    record_documents(folder, manifest)
    if with_card:
        _name_card(folder, manifest)
    write_manifest(folder, manifest)
    drop_unnamed(folder, manifest)
    drop_other_sensors(folder, manifest)
    if with_card:
        write_card(folder, manifest)
    (folder / STAGING / COMMITTING).unlink()


def record_anew(folder: Path, manifest: Manifest) -> None:
    """The digests of all documents as they are now become part of the manifest, and the card is written anew."""
    begin_commit(folder, manifest)
    _settle(folder, manifest, with_card=True)


def refresh_card(folder: Path, manifest: Manifest) -> None:
    """The card, and its digest in the manifest, are of the store as it is now; all other digests stay."""
    if "documents" not in manifest:
        write_card(folder, manifest)
        return
    before = manifest["documents"].get(CARD)
    _name_card(folder, manifest)
    if manifest["documents"][CARD] == before:
        write_card(folder, manifest)
        return
    begin_commit(folder, manifest)
    write_manifest(folder, manifest)
    write_card(folder, manifest)
    (folder / STAGING / COMMITTING).unlink()


def recover(store_path: Path | str) -> Manifest:
    """The manifest, after whatever a killed writer left behind has been removed.

    Rows and bytes beyond the manifest's lengths, files that it does not name, takes that are half staged or committed
    already. Takes that are staged whole stay. To be called before workers start to stage, not while they do.
    """
    folder = Path(store_path)
    manifest = read_manifest(folder)
    with store_errors(folder), writing_lock(folder):
        clean_staging(folder, manifest)
        _clean(folder, manifest)
    return manifest


class store_errors:
    """Turns errors of the system inside the block into a `StoreError` that says what to do."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def __enter__(self) -> None:
        return None

    def __exit__(self, _: object, error: BaseException | None, __: object) -> None:
        if isinstance(error, OSError) and not isinstance(error, TactileDataError):
            raise unwritable(self._folder, error) from error


def commit(store_path: Path | str, staged: Sequence[StagedTake], with_card: bool = True) -> Manifest:
    """The manifest after one atomic group of takes, in their order; a source that the store holds already is skipped.

    Parameters
    ----------
    store_path : Path or str
        Folder of the store.
    staged : sequence of StagedTake
        Takes that lie in the staging folder of this store.
    with_card : bool
        Whether the dataset card is brought up to date; it counts the whole store, so many commits in a row leave it to
        the last.

    Raises
    ------
    StoreBusy
        Another process writes to the store.
    StoreError
        The disk is full or read-only, or a take is not whole; the store is as it was before.
    """
    folder = Path(store_path)
    with store_errors(folder), writing_lock(folder):
        manifest = _commit(folder, _recovered(folder), staged, with_card)
        if with_card:
            refresh_card(folder, manifest)
        return manifest


def _recovered(folder: Path) -> Manifest:
    """The manifest to change, after what an interrupted commit left is gone and all documents are known to be whole."""
    manifest = read_manifest(folder, checked=False)
    if is_interrupted(folder):
        _clean(folder, manifest)
    need_whole_documents(Store.open(folder))
    return manifest


def _clean(folder: Path, manifest: Manifest) -> None:
    """What an interrupted commit left is gone, and the card is that of the manifest."""
    was_interrupted = is_interrupted(folder)
    place, recorded = folder / CARD, manifest.get("documents", {}).get(CARD)
    if was_interrupted and recorded and not (place.is_file() and file_digest(place) == recorded):
        write_card(folder, manifest)
    clean_commit(folder, manifest)


def _commit(folder: Path, before: Manifest, staged: Sequence[StagedTake], with_card: bool) -> Manifest:
    fresh, skipped = _new_takes(before, staged)
    if fresh:
        manifest = copy.deepcopy(before)
        begin_commit(folder, before)
        with Batch(folder) as batch:
            appender = Appender(batch, manifest)
            for take in fresh:
                appender.add(take)
            appender.finish()
            batch.publish()
        _settle(folder, manifest, with_card)
    else:
        manifest = before
    for take in [*fresh, *skipped]:
        shutil.rmtree(take.folder, ignore_errors=True)
    return manifest


@contextmanager
def changing(store_path: Path | str, with_card: bool = True) -> Iterator[tuple[Path, Manifest]]:
    """The store's folder and its manifest, which counts as the block has left it; what it does not name then goes.

    A kill, or an error in the block, leaves the manifest as it was; the next writer clears what is beside it.
    """
    folder = Path(store_path)
    with store_errors(folder), writing_lock(folder):
        manifest = copy.deepcopy(_recovered(folder))
        begin_commit(folder, manifest)
        yield folder, manifest
        _settle(folder, manifest, with_card)


def _new_takes(manifest: Manifest, staged: Sequence[StagedTake]) -> tuple[list[StagedTake], list[StagedTake]]:
    known = set(manifest["sources"])
    fresh: list[StagedTake] = []
    skipped: list[StagedTake] = []
    for take in staged:
        (skipped if take.sha256 in known else fresh).append(take)
        known.add(take.sha256)
    return fresh, [take for take in skipped if take.folder not in {other.folder for other in fresh}]


def commit_groups(
    store_path: Path | str, staged: Iterable[StagedTake], committed: Callable[[int], None] = lambda count: None
) -> Manifest:
    """The manifest after takes were committed in their order, in groups whose borders depend on their content only.

    So an ingest that was killed and runs again ends with the same manifest, byte for byte. ``staged`` is drawn from
    while groups are committed: it may be a generator that waits for workers.

    Parameters
    ----------
    store_path : Path or str
        Folder of the store.
    staged : iterable of StagedTake
        Takes that lie in the staging folder of this store.
    committed : callable
        Told after each group how many takes it had.
    """
    folder = Path(store_path)
    manifest = read_manifest(folder)
    for group in groups(staged, set(manifest["sources"])):
        manifest = commit(folder, group, with_card=False)
        committed(len(group))
    with store_errors(folder), writing_lock(folder):
        refresh_card(folder, manifest)
    return manifest


def groups(staged: Iterable[StagedTake], known: set[str]) -> Iterator[list[StagedTake]]:
    """Takes in groups that end where bytes, frames or takes reach their limit; known sources count nothing."""
    group: list[StagedTake] = []
    fresh: list[StagedTake] = []
    for take in staged:
        group.append(take)
        if take.sha256 not in known:
            fresh.append(take)
            known.add(take.sha256)
        n_bytes, n_frames = sum(one.n_bytes for one in fresh), sum(one.n_frames for one in fresh)
        if n_bytes >= GROUP_BYTES or n_frames >= GROUP_FRAMES or len(fresh) >= GROUP_TAKES:
            yield group
            group, fresh = [], []
    if group:
        yield group
