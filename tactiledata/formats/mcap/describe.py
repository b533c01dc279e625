"""What a recording says of itself: the description, its trajectories, and the sensors' backgrounds."""

from __future__ import annotations

import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from mcap.records import Attachment

from tactiledata.contract.description import LogDescription
from tactiledata.contract.paths import path_inside
from tactiledata.contract.records import Finding
from tactiledata.contract.schema import MAX_DOCUMENT_BYTES, read_document
from tactiledata.errors import BrokenLog, SchemaError
from tactiledata.formats.mcap.bags import described_in, description_file
from tactiledata.formats.mcap.layout import HEAD, parse
from tactiledata.formats.mcap.survey import RECORD_FAULTS, Survey
from tactiledata.formats.reading.backgrounds import MAX_IMAGE_BYTES, Backgrounds, fetch_backgrounds, read_image_file

RECORD_NAME = "tactiledata"
RECORD_KEY = "log"


def description_of(
    source: Path, inventories: Sequence[Survey], mapping: Mapping[str, Any] | None
) -> tuple[LogDescription, list[Finding]]:
    """The metadata record, the document beside the recording laid over it, and the mapping's description over both.

    Parameters
    ----------
    source : Path
        The recording: a file or a folder.
    inventories : sequence of Survey
        One for each file of the recording.
    mapping : dict, optional
        A mapping document, whose description wins.

    Raises
    ------
    SchemaError
        A document that a person wrote does not fit. A faulty metadata record is a finding: nobody can mend it.
    """
    findings: list[Finding] = []
    description = LogDescription()
    for inventory in inventories:
        for record in inventory.metadata:
            if record.name == RECORD_NAME and RECORD_KEY in record.metadata:
                where = f"{inventory.path.name}: metadata record {RECORD_NAME!r}"
                try:
                    if len(record.metadata[RECORD_KEY]) > MAX_DOCUMENT_BYTES:
                        raise SchemaError(f"{where} is too large", "a document", path="$", file=where)
                    description = LogDescription.checked(described_in(record.metadata[RECORD_KEY], where), where)
                except ValueError as error:
                    findings.append(Finding("bad-description", "damage", str(error)))
    beside = description_file(source)
    if beside is not None:
        document = read_document(beside)
        if not isinstance(document, dict):
            raise SchemaError(f"{beside} holds no mapping", "the content of a log.yaml", path="$", file=str(beside))
        if str(document.get("format", "")).startswith("tactiledata-mapping/"):
            raise SchemaError(
                f"{beside} is a mapping, and under this name it is read as the recording's description",
                "the content of a log.yaml, or no such file",
                "Give the mapping another name, for example mapping.yaml, and name it with --mapping.",
                path="$.format",
                file=str(beside),
            )
        description = description.merged(document, str(beside))
    if mapping and mapping.get("description"):
        description = description.merged(mapping["description"], "the mapping's description")
    return description, findings


def backgrounds_of(source: Path, inventories: Sequence[Survey], description: LogDescription) -> Backgrounds:
    """Backgrounds by sensor: attachments of the name, or files beside the recording or inside its folder.

    Parameters
    ----------
    source : Path
        The recording: a file or a folder.
    inventories : sequence of Survey
        One for each file of the recording.
    description : LogDescription
        Names the backgrounds.
    """

    def fetch(name: str, where: str) -> tuple[bytes, str]:
        for inventory in inventories:
            if name in inventory.attachments:
                return _attachment(inventory, name), f"attachment {name} of {inventory.path.name}"
        folders = (source, source.parent) if source.is_dir() else (source.parent,)
        for folder in folders:
            path = path_inside(folder, name, where)
            if path.is_file():
                return read_image_file(path), f"file {name} beside {source.name}"
        raise FileNotFoundError(name)

    return fetch_backgrounds(description, fetch)


def _attachment(inventory: Survey, name: str) -> bytes:
    offset, length = inventory.attachments[name]
    if not HEAD.size < length <= MAX_IMAGE_BYTES or offset + length > inventory.size:
        raise BrokenLog(f"the attachment has {length} bytes", f"at most {MAX_IMAGE_BYTES}, inside the file")
    with inventory.path.open("rb") as stream:
        stream.seek(offset + HEAD.size)
        body = stream.read(length - HEAD.size)
    try:
        record: Attachment = parse(Attachment, body)
    except RECORD_FAULTS as error:
        raise BrokenLog(f"the attachment is damaged ({error})") from error
    stated = int.from_bytes(body[-4:], "little")
    if record.name != name or (stated and zlib.crc32(body[:-4]) != stated):
        raise BrokenLog(
            "the attachment's CRC does not fit", "", "Attach it again, or put the file beside the recording."
        )
    return record.data
