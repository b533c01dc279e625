"""The page for people beside an export: what it holds, what it means, how to load it, what was lost."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tactiledata.contract.simulated import SimulatedCount

CELL = 100
"""Characters of a cell of a table."""


def card(document: Mapping[str, Any], title: str, snippet: str, front_matter: str = "") -> str:
    """Return the text of README.md.

    Parameters
    ----------
    document : dict
        The document of the export.
    title : str
        The format, for people.
    snippet : str
        Lines of Python that read the export.
    front_matter : str
        Lines of YAML above the page; empty for none.
    """
    simulated = SimulatedCount(**document["simulated_recordings"]).sentence
    head = [f"---\n{front_matter}---\n"] if front_matter else []
    split = document["split"]
    parted = (
        f"Parts follow the split `{split['name']}`." if split else "The data is not split: it goes out as one part."
    )
    lines = [
        *head,
        f"# Tactile recordings as {title}",
        "",
        *([simulated, ""] if simulated else []),
        f"Written by tactiledata {document['provenance']['version']} from a store with the digest "
        f"`{document['store']['digest'][:16]}`. {parted}",
        "",
        *_parts(document),
        "## Loading",
        "",
        "From inside this folder:",
        "",
        "```python",
        snippet,
        "```",
        "",
        *_streams(document),
        *_bullets("What to know", document["remarks"]),
        *_bullets("What is lost", [*_left_out(document), *document["lost"]]),
        "## What travels along",
        "",
        "`export.json` has the split, all streams, options, and the SHA-256 of every file. "
        "`tactiledata/trajectories.parquet` says who touched what, in which part and in which recording. "
        "`tactiledata/recordings.parquet` has all that the recordings say of themselves: sign, gravity and frame of "
        "the force, transforms, sensors, and whether they are simulated. `tactiledata/backgrounds` has the pictures "
        "without contact.",
        "",
    ]
    return "\n".join(lines)


def _parts(document: Mapping[str, Any]) -> list[str]:
    """Return the table of parts."""
    rows = [
        f"| {part} | {counts['trajectories']:,} | {counts['frames']:,} | {counts['in_split']:,} |"
        for part, counts in document["parts"].items()
    ]
    if not rows:
        return []
    return ["| part | trajectories | frames | frames that the split takes |", "|---|---|---|---|", *rows, ""]


def _streams(document: Mapping[str, Any]) -> list[str]:
    """Return the table of streams."""
    rows = [
        f"| {_cell(facts['kept_as'])} | {_cell(' '.join(facts['columns']))} | {_cell(_units(facts['units']))} "
        f"| {_cell(facts['frame'] or '-')} | {_cell(facts['meaning'], 400)} |"
        for facts in document["streams"].values()
    ]
    if not rows:
        return []
    head = ["| kept as | columns | unit | frame | meaning |", "|---|---|---|---|---|"]
    return ["## Streams", "", "SI units. A quaternion is x y z w.", "", *head, *rows, ""]


def _units(units: list[str]) -> str:
    """Return units as one word each, repeated ones once."""
    return ", ".join(dict.fromkeys(units))


def _left_out(document: Mapping[str, Any]) -> list[str]:
    """Return which frames did not go out."""
    return [f"{count:,} frames: {reason}." for reason, count in document["left_out"].items()]


def _bullets(title: str, sentences: list[str]) -> list[str]:
    return [f"## {title}", "", *(f"- {_shown(sentence)}" for sentence in sentences), ""] if sentences else []


def _shown(text: str) -> str:
    """Return a text so that a page shows it: what looks like a tag is a name that somebody gave."""
    return text.replace("<", "&lt;")


def _cell(value: str, most: int = CELL) -> str:
    text = " ".join(value.split())
    return _shown(text if len(text) <= most else text[: most - 1] + "…").replace("|", "\\|")
