"""Which recordings lie under the paths that a user names."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Sequence
from dataclasses import replace
from pathlib import Path, PurePosixPath

from tactiledata.contract.lfs_pointer import is_lfs_pointer, not_fetched, pointer_words
from tactiledata.contract.near_path import near_path
from tactiledata.contract.records import Finding, Source
from tactiledata.contract.schema import read_document
from tactiledata.errors import BrokenLog, MissingFile, TactileDataError, UsageError
from tactiledata.formats import FORMATS
from tactiledata.formats.base import Format
from tactiledata.formats.folder.files import DESCRIPTION, TABLES
from tactiledata.formats.reading.links import leads_back_up
from tactiledata.formats.reading.natural_order import natural_key
from tactiledata.ingest.sources.refused import refuse_folder, refused_findings, why_shut
from tactiledata.store.layout.manifest import ADDRESS
from tactiledata.store.layout.places import store_around

EXPORT = "export.json"
"""File that tells of an export of a store."""
MAX_DEPTH = 4
"""Folders below a named one that are searched for recordings."""


def format_of(path: Path, name: str | None = None) -> Format | None:
    """The format that claims a path, or the one that is named; ``None`` where none claims it."""
    if name is not None:
        return FORMATS[name]()
    for candidate in FORMATS:
        member = FORMATS[candidate]()
        try:
            if member.sniff(path):
                return member
        except OSError:
            continue  # what refuses to be looked at is said where it is met
    return None


def find_sources(paths: Sequence[Path], format_name: str | None = None) -> tuple[list[Source], list[Path]]:
    """Recordings under the paths, in natural order, each once, and the files that no format claims.

    Raises
    ------
    MissingFile
        A path does not exist.
    UsageError
        A path is a pipe or a device, or lies in a store.
    BrokenLog
        Nothing under a path is a recording.
    NotFetched
        Nothing, but Git LFS pointers are there.
    """
    sources: list[Source] = []
    unclaimed: list[Path] = []
    for path in paths:
        if not path.exists():
            raise _absent(path)
        if not (path.is_file() or path.is_dir()):
            raise UsageError(
                f"{path} is a pipe or a device", "a file or a folder", "Copy its content into a file.", path=str(path)
            )
        found, left = _below(path, format_name, MAX_DEPTH)
        if not found:
            _, refused = refused_findings(left)
            if refused:
                raise BrokenLog(refused[0].message, "a recording that can be read", "Check it.", path=str(path))
            if pointers := [file for file in left if is_lfs_pointer(file)]:
                raise not_fetched(str(pointers[0]), len(pointers) - 1)
            raise _no_recording(path, left)
        sources.extend(found)
        unclaimed.extend(left)
    used = {name for source in sources for name in source.files}
    seen: dict[tuple[str, str], Source] = {}
    for source in sources:
        seen.setdefault((str(Path(source.path).resolve()), source.part), source)
    return named_apart(list(seen.values())), [path for path in unclaimed if str(path) not in used]


def _export_format(folder: Path) -> str:
    """Return the format of an export that a folder holds; empty where it holds none that can be read."""
    document = folder / EXPORT
    try:
        return str(read_document(document, "export")["to"]) if document.is_file() else ""
    except (TactileDataError, OSError):
        return ""


def _absent(path: Path) -> MissingFile:
    """What is said of a path at which nothing is; an address has lost one of its two slashes on the way here."""
    expected, remedy = "a recording or a folder of recordings", near_path(path) or "Check the spelling."
    if ADDRESS.match(str(path)):
        remedy = "It looks like an address: only stores are read from there. Copy the recordings to this machine first."
    return MissingFile(f"{path} does not exist", expected, remedy, path=str(path))


def unclaimed_findings(unclaimed: Sequence[Path]) -> tuple[list[Path], list[Finding]]:
    """Files that no format claims without those that cannot be read, and what is said of these and of lost logs."""
    left, findings = refused_findings(unclaimed)
    pointers = [path for path in left if is_lfs_pointer(path)]
    if pointers:
        message = f"{pointer_words(str(pointers[0]), len(pointers) - 1)}; left out"
        findings.append(Finding("not-fetched", "warning", message, count=len(pointers)))
    return [path for path in left if path not in pointers], [*findings, *undescribed_logs(left)]


def undescribed_logs(unclaimed: Sequence[Path]) -> list[Finding]:
    """A warning for each folder with two tables or more of a folder log, and no log.yaml that makes it a recording."""
    return [
        Finding(
            "log-undescribed",
            "warning",
            f"{folder} holds {count} tables of a folder log and no {DESCRIPTION} that can be read: it was not taken. "
            f"Copy {DESCRIPTION} into it, or write one (docs/formats-folder.md)",
            count=count,
        )
        for folder, count in _tables_alone(unclaimed).items()
    ]


def _tables_alone(unclaimed: Sequence[Path]) -> dict[Path, int]:
    """Folders in which two tables or more of a folder log were left, and how many."""
    tables = Counter(path.parent for path in unclaimed if path.name in TABLES)
    return {folder: count for folder, count in tables.items() if count > 1}


def _no_recording(path: Path, left: Sequence[Path]) -> TactileDataError:
    """What to say of a path under which no recording is: it is a store, holds nothing, or what nobody can read."""
    if store := store_around(path):
        return UsageError(
            f"{path} is {'' if store == path.resolve() else 'inside '}a store",
            "recordings, from which stores are made",
            "`tactiledata info` shows what a store holds, `tactiledata merge` joins stores.",
            path=str(path),
        )
    for folder in (path, *path.parents[:MAX_DEPTH]):
        if form := _export_format(folder):
            return UsageError(
                f"{folder} is what `tactiledata export-data` wrote as {form}",
                "recordings" if form == "mcap" else "recordings, or an export as mcap, the only one that is read back",
                "Its recordings are not there: copy it again."
                if form == "mcap"
                else f"Train from it as {folder / 'README.md'} says, or ingest the recordings that it was made of.",
                path=str(path),
            )
    if path.is_dir() and not left:
        return BrokenLog(
            f"the folder {path} holds no recording and no file",
            "a recording, or a folder of recordings",
            "Check the path; hidden files and stores (*.zarr) are passed over.",
            path=str(path),
        )
    if undescribed := _tables_alone(left):
        folder, count = next(iter(undescribed.items()))
        others = f", and so is it in {len(undescribed) - 1} more of its folders" if len(undescribed) > 1 else ""
        return BrokenLog(
            f"{folder} holds {count} tables of a folder log and no {DESCRIPTION} that can be read{others}",
            f"a {DESCRIPTION} beside the tables",
            f"Copy {DESCRIPTION} into it, or write one (docs/formats-folder.md).",
            path=str(path),
        )
    depth = "" if path.is_file() else f", nor do the {MAX_DEPTH} levels of folders below it contain one"
    return BrokenLog(
        f"{path} is not a recording in a known format{depth}",
        f"one of: {', '.join(FORMATS)}",
        "`tactiledata formats` shows how each lies on disk. Tables of your own are read as a folder log "
        "(docs/formats-folder.md), HDF5 files by a mapping, NumPy files once they are written as one "
        "(docs/formats-hdf5.md).",
        path=str(path),
    )


def _below(path: Path, format_name: str | None, depth: int) -> tuple[list[Source], list[Path]]:
    if not (path.is_file() or path.is_dir()):  # opening a pipe would wait for ever
        return [], [path]
    if is_lfs_pointer(path):
        return [], [path]
    member = format_of(path, format_name)
    if member is not None:
        sources = list(member.sources(path))
        is_judged = format_name is not None or path.is_file() or member.judges_whole_folders
        more, unclaimed = ([], []) if is_judged else _beside(path, sources, member, depth)
        return [*sources, *more], unclaimed
    if not path.is_dir() or depth == 0:
        return [], [path]
    return _joined(_inside(child, format_name, depth - 1) for child in _children(path))


def _inside(path: Path, format_name: str | None, depth: int) -> tuple[list[Source], list[Path]]:
    """What lies at and below a path inside a folder; a place that the system refuses is left, and the others go on."""
    try:
        return ([], [path]) if leads_back_up(path) else _below(path, format_name, depth)
    except (OSError, BrokenLog):
        if not why_shut(path):
            raise
        return [], [path]


def _beside(folder: Path, sources: Sequence[Source], member: Format, depth: int) -> tuple[list[Source], list[Path]]:
    """Recordings and unclaimed files beside those that a format found below a folder, which is not theirs alone."""
    homes = {(Path(source.path) / source.part).resolve() for source in sources}
    ways = {parent for home in homes for parent in home.parents}

    def below(place: Path, levels: int) -> tuple[list[Source], list[Path]]:
        if levels == 0:
            return [], []
        is_home = place.resolve() in homes
        return _joined(beside(child, levels - 1) for child in _children(place) if not is_home or child.is_dir())

    def beside(child: Path, levels: int) -> tuple[list[Source], list[Path]]:
        if leads_back_up(child):
            return [], [child]
        place = child.resolve()
        if place in homes:
            return [], []
        return below(child, levels) if place in ways else _inside(child, None, levels)

    return ([], []) if folder.resolve() in homes and member.takes_subfolders else below(folder, depth)


def _children(folder: Path) -> list[Path]:
    """What lies in a folder, in natural order, without hidden files and stores."""
    refuse_folder(folder)
    children = sorted(folder.iterdir(), key=lambda child: natural_key(child.name))
    return [child for child in children if not child.name.startswith(".") and child.suffix != ".zarr"]


def _joined(parts: Iterable[tuple[list[Source], list[Path]]]) -> tuple[list[Source], list[Path]]:
    """Recordings and unclaimed files of several places, one after another."""
    sources: list[Source] = []
    unclaimed: list[Path] = []
    for found, left in parts:
        sources += found
        unclaimed += left
    return sources, unclaimed


def named_apart(sources: Sequence[Source], taken: Collection[str] = ()) -> list[Source]:
    """Sources with keys that tell them apart: ends of their paths, as short as may be.

    Parameters
    ----------
    sources : sequence of Source
    taken : collection of str
        Keys that none of them may have.

    Returns
    -------
    list of Source
        In their order. A source whose key no other has, and that is not taken, keeps it. Recordings of one file, and
        those whose whole paths are taken, get a number.

    Examples
    --------
    >>> paths = ("/data/mon/run.mcap", "/data/tue/run.mcap", "/data/a.mcap")
    >>> [source.key for source in named_apart([Source(path, Path(path).name, "mcap", (path,)) for path in paths])]
    ['mon/run.mcap', 'tue/run.mcap', 'a.mcap']
    """
    keys = [source.key for source in sources]
    ends = [path_ends(source) for source in sources]
    length = 1
    while clashes := [row for row in _clashes(keys, taken) if length < len(ends[row])]:
        for row in clashes:
            keys[row] = ends[row][length]
        length += 1
    used, named = {*taken}, []
    for source, key in zip(sources, keys, strict=True):
        name, number = key, 1
        while name in used:
            number += 1
            name = f"{key}~{number}"
        used.add(name)
        named.append(replace(source, key=name))
    return named


def path_ends(source: Source) -> list[str]:
    """What a source may be called by its path: its last part, the last two, and so on.

    Examples
    --------
    >>> path_ends(Source("/data/mon/run.mcap", "run.mcap", "mcap", ("/data/mon/run.mcap",)))
    ['run.mcap', 'mon/run.mcap', 'data/mon/run.mcap']
    """
    parts = [*Path(source.path).absolute().parts[1:], *filter(None, [source.part])]
    return [str(PurePosixPath(*parts[-length:])) for length in range(1, len(parts) + 1)]


def _clashes(keys: Sequence[str], taken: Collection[str]) -> list[int]:
    """Rows of the keys that several sources have, or that are taken."""
    times = Counter(keys)
    return [row for row, key in enumerate(keys) if times[key] > 1 or key in taken]
