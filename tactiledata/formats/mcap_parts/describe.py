"""What a recording says of itself: the description, its trajectories, and the sensors' backgrounds."""

from __future__ import annotations

import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from mcap.records import Attachment
from numpy.typing import NDArray

from tactiledata.contract.description import LogDescription
from tactiledata.contract.paths import path_inside
from tactiledata.contract.records import Finding, Trajectory
from tactiledata.contract.schema import MAX_DOCUMENT_BYTES, read_document
from tactiledata.errors import BrokenLog, SchemaError
from tactiledata.formats.image_bytes import decode_rgb
from tactiledata.formats.mcap_parts.bags import described_in, description_file
from tactiledata.formats.mcap_parts.layout import HEAD, parse
from tactiledata.formats.mcap_parts.survey import RECORD_FAULTS, Survey

RECORD_NAME = "tactiledata"
RECORD_KEY = "log"
MAX_IMAGE_BYTES = 64 * 2**20
_TRAJECTORY_KEYS = {"trajectory", "start_ns", "end_ns", "sensor", "indenter"}


def description_of(
    source: Path, inventories: Sequence[Survey], mapping: Mapping[str, Any] | None
) -> tuple[LogDescription, list[Finding]]:
    """The metadata record, the document beside the recording laid over it, and the mapping's description over both.

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
        description = description.merged(document, str(beside))
    if mapping and mapping.get("description"):
        description = description.merged(mapping["description"], "the mapping's description")
    return description, findings


def trajectories_of(description: LogDescription) -> tuple[Trajectory, ...]:
    """The trajectories that a description lists, with their free columns."""
    return tuple(
        Trajectory(
            str(row["trajectory"]),
            int(row["start_ns"]),
            int(row["end_ns"]),
            str(row.get("sensor", "")),
            str(row.get("indenter", "")),
            {key: value for key, value in row.items() if key not in _TRAJECTORY_KEYS},
        )
        for row in description.document.get("trajectories", ())
    )


def references_of(
    source: Path, inventories: Sequence[Survey], description: LogDescription
) -> tuple[dict[str, NDArray[np.uint8]], dict[str, str], list[Finding]]:
    """Backgrounds (H, W, 3) RGB by sensor, where each came from, and what was wrong with the others."""
    pictures: dict[str, NDArray[np.uint8]] = {}
    origins: dict[str, str] = {}
    findings: list[Finding] = []
    for serial, facts in description.sensors.items():
        name = facts.get("background")
        if not name:
            continue
        try:
            payload, origin = _background(source, inventories, name, description.where)
            pictures[serial], origins[serial] = decode_rgb(payload), origin
        except (BrokenLog, OSError) as error:
            text = f"the background {name} of sensor {serial} cannot be used: {error}"
            findings.append(Finding("bad-background", "warning", text))
    return pictures, origins, findings


def _background(source: Path, inventories: Sequence[Survey], name: str, where: str) -> tuple[bytes, str]:
    """The bytes of a background: an attachment of this name, or a file beside the recording or inside its folder."""
    for inventory in inventories:
        if name in inventory.attachments:
            return _attachment(inventory, name), f"attachment {name} of {inventory.path.name}"
    folders = (source, source.parent) if source.is_dir() else (source.parent,)
    for folder in folders:
        path = path_inside(folder, name, where or "the description")
        if path.is_file():
            if path.stat().st_size > MAX_IMAGE_BYTES:
                raise BrokenLog(f"{path} has {path.stat().st_size} bytes", f"at most {MAX_IMAGE_BYTES}")
            return path.read_bytes(), f"file {name} beside {source.name}"
    raise BrokenLog("there is no attachment and no file of this name", "", "Attach it, or put it beside the recording.")


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
