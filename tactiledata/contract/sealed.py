"""JSON documents that carry the SHA-256 of their own bytes, so that a change of any bit of the file shows."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping
from typing import Any

from tactiledata.contract.atomic import readable_json

SEAL = "file_sha256"
"""Field of a sealed document: the SHA-256 of the file as it is with 64 zeros in the place of this field's digits."""

_ZEROS = b"0" * 64
_PLACE = re.compile(rb'(\n  "' + SEAL.encode() + rb'": ")([0-9a-f]{64})"')
"""Only a field of the document itself stands after two spaces; in texts, line breaks and quotes are escaped."""


def sealed_json(document: Mapping[str, Any]) -> bytes:
    """The bytes of a JSON file with all fields of a document and the seal; a seal that it has already is replaced."""
    content = readable_json({**document, SEAL: _ZEROS.decode()})
    return _PLACE.sub(lambda place: place[1] + hashlib.sha256(content).hexdigest().encode() + b'"', content)


def fits_seal(content: bytes) -> bool:
    """Whether a file's bytes are those that were sealed; a file without a seal does not fit."""
    place = _PLACE.search(content)
    if place is None:
        return False
    unsealed = content[: place.start(2)] + _ZEROS + content[place.end(2) :]
    return hashlib.sha256(unsealed).hexdigest().encode() == place[2]
