"""Which files make one recording: a single MCAP, or a rosbag2 folder whose bag may be split."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tactiledata.contract.paths import path_inside
from tactiledata.contract.records import Finding, Source
from tactiledata.contract.schema import parse_document, read_document
from tactiledata.errors import BrokenLog, SchemaError, UnsafeContent
from tactiledata.formats.mcap.layout import MAGIC
from tactiledata.formats.reading.links import leads_back_up
from tactiledata.formats.reading.natural_order import natural_key

METADATA = "metadata.yaml"
INFORMATION = "rosbag2_bagfile_information"
"""The one name that a rosbag2's metadata.yaml holds; everything is below it."""
INSIDE_DESCRIPTION = "tactiledata.yaml"
IMAGE_SUFFIXES = {".png", ".jpg", ".jpeg"}
UNREADABLE = {
    ".zst": ("an MCAP compressed as a whole", "Uncompress it with `zstd -d` (MCAP compresses its chunks itself)."),
    ".zstd": ("an MCAP compressed as a whole", "Uncompress it with `zstd -d` (MCAP compresses its chunks itself)."),
    ".db3": (
        "a rosbag2 in SQLite",
        "Convert it with `ros2 bag convert -i BAG -o convert.yaml`, where convert.yaml says "
        "`output_bags: [{uri: OUT, storage_id: mcap, all_topics: true}]`.",
    ),
    ".bag": ("a ROS 1 bag", "Convert it with `mcap convert IN.bag OUT.mcap` or `rosbags-convert`."),
}
"""Neighbours of MCAP by suffix: what they are, and what to do."""


@dataclass(frozen=True)
class Bag:
    """The files of one recording, in order, and what was found about them."""

    files: tuple[Path, ...]
    findings: tuple[Finding, ...] = ()


def is_bag_file(path: Path) -> bool:
    """Whether a file is an MCAP by its first bytes, or one by its name that deserves a clear word."""
    name = path.name.lower()
    if name.startswith(".") or not path.is_file():
        return False
    if name.endswith((".mcap", ".mcap.zst", ".mcap.zstd")):
        return True
    try:
        with path.open("rb") as stream:
            head = stream.read(16)
    except OSError:
        return False
    is_sqlite_bag = name.endswith(".db3") and head.startswith(b"SQLite format 3")
    return head.startswith(MAGIC) or is_sqlite_bag or (name.endswith(".bag") and head.startswith(b"#ROSBAG V"))


def is_bag_folder(folder: Path) -> bool:
    """Whether a folder is a rosbag2 recording, or holds MCAP recordings and nothing that another format would read."""
    try:
        if bag_metadata(folder) is not None or (_metadata_damage(folder) and any(map(_is_mcap, folder.iterdir()))):
            return True
        children = [child for child in folder.iterdir() if not child.name.startswith(".")]
        if (folder / "log.yaml").exists() or not any(_is_mcap(child) for child in children):
            return False
        return all(_is_company(child) for child in children)
    except (OSError, SchemaError):
        return False


def _is_mcap(path: Path) -> bool:
    return path.suffix.lower() == ".mcap" and not path.name.startswith(".") and path.is_file()


def _is_company(path: Path) -> bool:
    """Whether something may lie beside MCAP files without being a recording of another format."""
    if leads_back_up(path):
        return True
    if path.is_dir():
        return is_bag_folder(path) or all(
            child.suffix.lower() in IMAGE_SUFFIXES for child in path.iterdir() if not child.name.startswith(".")
        )
    return is_bag_file(path) or path.suffix.lower() in {".yaml", ".yml", ".md", ".txt", ".json", ""}


def bag_metadata(folder: Path) -> dict[str, Any] | None:
    """The content of a rosbag2 folder's metadata.yaml; ``None`` where there is none, or none that can be used."""
    path = folder / METADATA
    if not path.is_file():
        return None
    try:
        document = read_document(path)
    except SchemaError:
        return None
    found = document.get(INFORMATION) if isinstance(document, dict) else None
    return found if isinstance(found, dict) else None


def _metadata_damage(folder: Path) -> str:
    """Why metadata.yaml cannot be used; empty where it can, where there is none, and where it is no rosbag2's."""
    path = folder / METADATA
    if not path.is_file():
        return ""
    try:
        document = read_document(path)
    except SchemaError as error:
        return error.found
    if document is None:
        return f"{path} is empty"
    if isinstance(document, dict) and INFORMATION in document and not isinstance(document[INFORMATION], dict):
        return f"{path} holds nothing below {INFORMATION}"
    return "" if isinstance(document, dict) else f"{path} holds no names and values"


def bag_sources(path: Path, name: str) -> list[Source]:
    """The recordings in a file or folder, in natural order."""
    if path.is_file():
        return [_file_source(path, path.name, name)]
    if bag_metadata(path) is not None or _is_split(path) or _metadata_damage(path):
        return [_folder_source(path, path.name, name)]
    found: list[Source] = []
    for child in sorted(path.iterdir(), key=lambda child: natural_key(child.name)):
        if child.name.startswith(".") or leads_back_up(child):
            continue
        if child.is_dir() and is_bag_folder(child):
            found += [_below(path.name, source) for source in bag_sources(child, name)]
        elif child.is_file() and is_bag_file(child):
            found.append(_file_source(child, f"{path.name}/{child.name}", name))
    return found


def _below(folder: str, source: Source) -> Source:
    return Source(source.path, f"{folder}/{source.key}", source.format, source.files, source.part)


def _is_split(folder: Path) -> bool:
    """Whether the MCAP files of a folder are ``<folder>_0.mcap`` and so on: one bag without its metadata."""
    numbers = set()
    for path in folder.iterdir():
        if not _is_mcap(path):
            continue
        base, _, number = path.stem.rpartition("_")
        if base != folder.name or not number.isdecimal():
            return False
        numbers.add(int(number))
    return bool(numbers) and min(numbers) == 0


def _file_source(path: Path, key: str, name: str) -> Source:
    beside = path.with_suffix(".yaml")
    files = [path, *([beside] if beside.is_file() else [])]
    return Source(str(path), key, name, tuple(str(file) for file in files))


def _folder_source(folder: Path, key: str, name: str) -> Source:
    """All files of a bag, the description inside or beside its folder among them: it decides what the bag means."""
    try:
        files = list(files_of(folder).files)
    except (BrokenLog, SchemaError, UnsafeContent):
        files = []  # reading says what is wrong
    described = description_file(folder)
    files += [folder / METADATA] * (folder / METADATA).is_file() + ([described] if described else [])
    return Source(str(folder), key, name, tuple(str(file) for file in files))


def files_of(path: Path) -> Bag:
    """The MCAP files of a recording, in the order in which they were written.

    Raises
    ------
    BrokenLog
        The recording is of a kind that is not read, or none of its files is there.
    UnsafeContent
        The metadata name a file outside the folder.
    """
    if not path.is_dir():
        _refuse_neighbours(path)
        return Bag((path,))
    metadata = bag_metadata(path)
    if metadata is None:
        files = sorted(filter(_is_mcap, path.iterdir()), key=lambda file: natural_key(file.name))
        damage = _metadata_damage(path)
        text = (
            f"{damage}: all {len(files)} MCAP files beside it were read as one recording, by their names. Copy it "
            "again or run `ros2 bag reindex`; move it away if they are recordings of their own"
        )
        return Bag(tuple(files), (Finding("bag-metadata", "damage", text),) if damage else ())
    if metadata.get("storage_identifier") != "mcap":
        _refuse_neighbours(path / "bag.db3" if metadata.get("storage_identifier") == "sqlite3" else path)
        raise BrokenLog(
            f"{path} is a rosbag2 stored as {metadata.get('storage_identifier')!r}",
            "storage mcap",
            UNREADABLE[".db3"][1],
        )
    if str(metadata.get("compression_mode", "")).lower() == "message":
        raise BrokenLog(
            f"the messages of {path} are compressed one by one by rosbag2",
            "an MCAP, which compresses its chunks itself",
            "Convert it with `ros2 bag convert`, with no compression_mode in the output options.",
        )
    return _listed(path, metadata.get("relative_file_paths"))


def _listed(folder: Path, names: Any) -> Bag:
    listed = [str(name) for name in names] if isinstance(names, list) else []
    files: list[Path] = []
    findings: list[Finding] = []
    for name in listed:
        file = path_inside(
            folder, Path(name).name if name.startswith(f"{folder.name}/") else name, str(folder / METADATA)
        )
        _refuse_neighbours(file)
        if file in files:
            text = f"{METADATA} lists {name} more than once; it was read once"
            findings.append(Finding("unlisted-file", "warning", text))
        elif file.is_file():
            files.append(file)
        else:
            findings.append(Finding("missing-file", "damage", f"{METADATA} lists {name}, which is not there"))
    stray = [file for file in folder.iterdir() if _is_mcap(file) and file not in files]
    for file in sorted(stray, key=lambda file: natural_key(file.name)):
        findings.append(
            Finding("unlisted-file", "warning", f"{file.name} is not listed by {METADATA} and was not read")
        )
    if not files and stray and not listed:
        files = sorted(stray, key=lambda file: natural_key(file.name))
        findings = [
            Finding("unlisted-file", "warning", f"{METADATA} lists no file; all MCAP files beside it were read")
        ]
    if not files:
        raise BrokenLog(
            f"none of the files that {folder / METADATA} lists is there: {', '.join(listed[:5]) or 'it lists none'}",
            "the bag's .mcap files",
            "Copy the whole folder again.",
        )
    return Bag(tuple(files), tuple(findings))


def _refuse_neighbours(path: Path) -> None:
    suffix = path.suffix.lower()
    if suffix in UNREADABLE:
        what, remedy = UNREADABLE[suffix]
        raise BrokenLog(f"{path} is {what}", "an MCAP file", remedy, path=str(path))


def description_file(source: Path) -> Path | None:
    """The document beside a recording that describes it, where there is one."""
    places: Sequence[Path] = (
        (source / INSIDE_DESCRIPTION, source.parent / f"{source.name}.yaml")
        if source.is_dir()
        else (source.with_suffix(".yaml"),)
    )
    return next((place for place in places if place.is_file()), None)


def described_in(text: str, where: str) -> dict[str, Any]:
    """A description from the text of a metadata record."""
    document = parse_document(text, where)
    if not isinstance(document, dict):
        raise SchemaError(f"{where} is {type(document).__name__}", "a mapping of names to values", path="$", file=where)
    return document
