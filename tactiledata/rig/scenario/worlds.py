"""The scenarios that come with the toolkit, found by name."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tactiledata.contract.schema import parse_document, read_document, shipped_folder
from tactiledata.errors import UnknownName


def bundled_worlds() -> list[str]:
    """Return the names of the bundled scenarios, sorted."""
    folder = shipped_folder("recipes") / "worlds"
    return sorted(entry.name.removesuffix(".yaml") for entry in folder.iterdir() if entry.name.endswith(".yaml"))


def find_scenario(name: str | Path) -> dict[str, Any] | Path:
    """Return what `load_scenario` takes: the path of a scenario's file, or the document of a bundled scenario.

    Raises
    ------
    UnknownName
        The name is neither a file nor a bundled scenario.
    """
    path = Path(name)
    if path.is_file():
        return path
    text = str(name)
    if text not in bundled_worlds():
        if path.suffix in {".yaml", ".yml", ".json"}:
            return read_document(path)
        raise UnknownName("scenario", text, bundled_worlds(), "Or name a scenario file.")
    world = shipped_folder("recipes") / "worlds" / f"{text}.yaml"
    return parse_document(world.read_text(encoding="utf-8"), f"recipes/worlds/{text}.yaml")
