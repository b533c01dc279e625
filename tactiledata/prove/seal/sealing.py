"""Sealing: drawn cases get random names and salts, and commitments to their labels are written before any diagnosis."""

from __future__ import annotations

import secrets
from collections.abc import Mapping, Sequence
from typing import Any

from tactiledata.contract.atomic import write_json_atomic
from tactiledata.contract.provenance import digest_of
from tactiledata.errors import StoreError, UsageError
from tactiledata.prove.seal.folder import FORMAT, ProofFolder, read_json, read_sealed, write_case, write_sealed
from tactiledata.prove.seal.frozen import changed_numbers, frozen_tool
from tactiledata.prove.seal.merkle import commitment, new_salt, root_of

NAME_BYTES = 8
"""Number of random bytes of a case's name."""


def named_labels(folder: ProofFolder, drawn: Sequence[Mapping[str, Any]]) -> dict[str, dict[str, Any]]:
    """Return label, salt and number of the draw of each case by its random name; the first call writes them.

    Parameters
    ----------
    folder : ProofFolder
        The folder of the proof.
    drawn : sequence of dict
        ``number`` and ``label`` of each case.
    """
    if folder.labels.exists():
        kept: dict[str, dict[str, Any]] = read_json(folder.labels)
        return kept
    named: dict[str, dict[str, Any]] = {}
    for one in drawn:
        name = secrets.token_hex(NAME_BYTES)
        named[name] = {"draw": one["number"], "salt": new_salt(), "label": one["label"]}
    write_json_atomic(folder.labels, named)
    return named


def seal_cases(
    folder: ProofFolder, drawn: Sequence[Mapping[str, Any]], plans: Mapping[str, str], left_out: Mapping[str, int]
) -> dict[str, Any]:
    """Write the cases under random names, then the seal; return the seal. A seal that exists is returned as it is.

    Parameters
    ----------
    folder : ProofFolder
        The folder of the proof; readings of the draws lie there.
    drawn : sequence of dict
        ``number`` and ``label`` of each case.
    plans : dict, number of a draw -> name of its plan
        All that a diagnosis is told beside the readings.
    left_out : dict, kind -> int
        Number of cases for which no draw was of the kind.
    """
    if folder.seal.exists():
        return read_seal(folder)
    named = named_labels(folder, drawn)
    digests = {}
    # in the order of the random names, so that no order tells of a draw
    for name in sorted(named):
        content = folder.drawn_readings(named[name]["draw"]).read_bytes()
        digests[name] = write_case(folder.case(name), content)
    commitments = {name: commitment(one["salt"], one["label"]) for name, one in named.items()}
    document = {
        "format": FORMAT,
        "root": root_of({name: f"{commitments[name]} {digests[name]}" for name in named}),
        "cases": {
            name: {
                "commitment": commitments[name],
                "readings_sha256": digests[name],
                "plan": plans[str(named[name]["draw"])],
            }
            for name in sorted(named)
        },
        "left_out": dict(left_out),
        "request_sha256": digest_of(read_json(folder.proof)),
        "tool": frozen_tool(),
    }
    write_sealed(folder.seal, document)
    return document


def read_seal(folder: ProofFolder) -> dict[str, Any]:
    """Return the seal of a proof.

    Raises
    ------
    StoreError
        The seal was changed after it was written.
    """
    document, is_whole = read_sealed(folder.seal)
    if not is_whole or document.get("format") != FORMAT:
        raise StoreError(
            f"{folder.seal} is not as it was written", f"a seal of format {FORMAT}", "Restore it from a copy."
        )
    return document


def need_frozen_tool(seal: Mapping[str, Any]) -> None:
    """Refuse to go on with another tool than the one that was sealed.

    Raises
    ------
    UsageError
        Program or numbers have changed since.
    """
    now = frozen_tool()
    if now["digest"] == seal["tool"]["digest"]:
        return
    numbers = changed_numbers(seal["tool"], now)
    rooms = [room for room, digest in now["program"].items() if digest != seal["tool"]["program"].get(room)]
    found = "; ".join(numbers[:5]) if numbers else f"the program of {', '.join(rooms)} has changed"
    raise UsageError(
        f"this is not the tool that was sealed: {found}",
        f"version {seal['tool']['version']}, commit {seal['tool']['commit'] or 'unknown'}",
        "Check that version out, or begin a new proof in another folder.",
    )
