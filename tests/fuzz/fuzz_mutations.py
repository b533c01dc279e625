"""Changes of the bytes of files and of the values of documents, drawn by a seed."""

from __future__ import annotations

import json
import shutil
import struct
from pathlib import Path

import numpy as np
import yaml

WHOLE = (0, 1, 2, 127, 128, 255, 2**15, 2**16 - 1, 2**31 - 1, 2**31, 2**32 - 1, 2**63 - 1, 2**63, 2**64 - 1)
"""Integers at the ends of what counters and sizes can hold."""
WORDS = (
    b"nan", b"inf", b"-1", b"1e400", b"0", b"", b"\x00", b"\xff\xfe", b"../../x", b"/etc/passwd", b"9" * 400, b'"',
    b"\n", b",", b"{", b"[", b": &a *a", b"true", b"null", b"\xe2\x80\xae", b"-0.0", b"1970-01-01", b"~", b"!!python/x",
)  # fmt: skip
"""Texts that readers of numbers, names and tables may stumble over."""
VALUES = (
    None, True, -1, 0, 2**64, -(2**70), 0.5, float("nan"), float("inf"), 1e308, "", "x", "../up", "a" * 5000, [], {},
    [[]], {"": None}, [1, "a", None], "\x00", "nan", [0] * 1000, "\ud800", "2024-01-01",
)  # fmt: skip
"""Values of other types and sizes than a document has at any place."""
TEXTS = {".json", ".yaml", ".yml", ".csv", ".tsv", ".txt", ".stl", ".obj", ".mesh", ".msh"}


def mutate_folder(folder: Path, rng: np.random.Generator) -> str:
    """Change one to three files of a folder, and say in words what was done."""
    done = []
    for _ in range(int(rng.integers(1, 4))):
        places = sorted(place for place in folder.rglob("*") if place.is_file())
        if not places:
            break
        weights = np.array([8.0 if place.suffix in TEXTS else 1.0 for place in places])
        place = places[int(rng.choice(len(places), p=weights / weights.sum()))]
        done.append(f"{place.relative_to(folder)}: {_mutate_file(place, places, rng)}")
    return "; ".join(done)


def _mutate_file(place: Path, others: list[Path], rng: np.random.Generator) -> str:
    """Change one file, and say how."""
    kind = rng.random() if len(others) > 1 else rng.uniform(0.06, 1)
    if kind < 0.03:
        place.unlink()
        return "removed"
    if kind < 0.06:
        other = others[int(rng.integers(len(others)))]
        if other != place:
            shutil.copyfile(other, place)
        return f"content of {other.name}"
    content = place.read_bytes()
    if place.suffix in (".json", ".yaml", ".yml") and kind < 0.6:
        changed = mutate_document(content, place.suffix, rng)
        if changed is not None:
            place.write_bytes(changed)
            return "another value"
    place.write_bytes(mutate_bytes(content, rng, is_text=place.suffix in TEXTS))
    return "other bytes"


def mutate_document(content: bytes, suffix: str, rng: np.random.Generator) -> bytes | None:
    """A JSON or YAML document with a value replaced, removed or repeated; ``None`` where it is no such document."""
    try:
        document = json.loads(content) if suffix == ".json" else yaml.safe_load(content)
    except (ValueError, yaml.YAMLError):
        return None
    places = list(_places(document))
    if not places:
        return None
    for _ in range(int(rng.integers(1, 3))):
        holder, key = places[int(rng.integers(len(places)))]
        value = VALUES[int(rng.integers(len(VALUES)))]
        way = rng.random()
        if isinstance(holder, list) and key >= len(holder):
            continue
        if way < 0.7:
            holder[key] = value
        elif isinstance(holder, dict):
            holder.pop(key, None)
            if way > 0.85:
                holder[f"{key}x"] = value
        else:
            holder.append(value)
    text = json.dumps(document) if suffix == ".json" else yaml.safe_dump(document, allow_unicode=True)
    return text.encode("utf-8", "surrogatepass")


def _places(value: object):
    """Pairs of a container and a key in it, all the way down."""
    entries = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, inner in list(entries):
        yield value, key
        yield from _places(inner)


def mutate_bytes(content: bytes, rng: np.random.Generator, is_text: bool = False) -> bytes:
    """Bytes with one to eight changes: flipped bits, other integers, words, parts cut, repeated or moved."""
    changed = bytearray(content)
    for _ in range(int(rng.integers(1, 9))):
        size = len(changed)
        at = int(rng.integers(size + 1))
        span = int(min(size - at, rng.integers(1, 1 + max(1, min(size, 2 ** int(rng.integers(1, 14)))))))
        way = int(rng.integers(9)) if not is_text else int(rng.choice([0, 3, 4, 5, 6, 7, 7, 7, 8, 8]))
        if way == 0 and size:
            changed[min(at, size - 1)] ^= 1 << int(rng.integers(8))
        elif way in (1, 2):
            number = WHOLE[int(rng.integers(len(WHOLE)))]
            width = int(rng.choice([1, 2, 4, 8]))
            order = "<" if rng.random() < 0.7 else ">"
            packed = struct.pack(f"{order}Q", number)
            changed[at : at + width] = packed[:width] if order == "<" else packed[8 - width :]
        elif way == 3:
            del changed[at : at + span]
        elif way == 4:
            changed[at:at] = changed[at : at + span]
        elif way == 5:
            changed[at : at + span] = rng.bytes(span)
        elif way == 6 and rng.random() < 0.3:
            del changed[at:]
        elif way == 7:
            changed[at : at + int(rng.integers(0, 8))] = WORDS[int(rng.integers(len(WORDS)))]
        else:
            _replace_token(changed, at, rng)
    return bytes(changed)


def _replace_token(content: bytearray, at: int, rng: np.random.Generator) -> None:
    """Replace what stands between two separators near a place, as a cell of a table or a value of a document."""
    separators = b",;:\n\t \"'[]{}"
    start, stop = at, at
    while start > 0 and content[start - 1] not in separators and at - start < 60:
        start -= 1
    while stop < len(content) and content[stop] not in separators and stop - at < 60:
        stop += 1
    content[start:stop] = WORDS[int(rng.integers(len(WORDS)))]
