"""Commitments to labels, and their Merkle root: one number that fixes all of them before anything is diagnosed.

A commitment is the SHA-256 of a random salt and of the label as canonical JSON: it tells nothing of the label, and no
other label fits it. Leaves and inner nodes are hashed with different prefixes, as in RFC 6962, so that neither can be
taken for the other.
"""

from __future__ import annotations

import hashlib
import secrets
from collections.abc import Mapping, Sequence
from typing import Any

from tactiledata.contract.provenance import json_bytes

SALT_BYTES = 32
"""Number of random bytes of a salt."""
_LEAF, _NODE = b"\x00", b"\x01"


def new_salt() -> str:
    """Return a random salt, as hexadecimal digits."""
    return secrets.token_hex(SALT_BYTES)


def commitment(salt: str, label: Mapping[str, Any]) -> str:
    """Return the SHA-256 (hex) of a salt (hex) and a label."""
    return hashlib.sha256(bytes.fromhex(salt) + json_bytes(label)).hexdigest()


def merkle_root(leaves: Sequence[str]) -> str:
    """Return the Merkle root (hex) of texts in their order; the root of nothing is the SHA-256 of nothing.

    Examples
    --------
    >>> merkle_root(["a", "b", "c"]) == merkle_root(["a", "c", "b"])
    False
    """
    level = [hashlib.sha256(_LEAF + leaf.encode()).digest() for leaf in leaves]
    if not level:
        return hashlib.sha256().hexdigest()
    while len(level) > 1:
        pairs = [level[place : place + 2] for place in range(0, len(level), 2)]
        # a node without a sister goes up as it is
        level = [hashlib.sha256(_NODE + b"".join(pair)).digest() if len(pair) == 2 else pair[0] for pair in pairs]
    return level[0].hex()


def root_of(entries: Mapping[str, str]) -> str:
    """Return the Merkle root (hex) of names and digests, sorted by name."""
    return merkle_root([f"{name} {digest}" for name, digest in sorted(entries.items())])
