"""Links among folders of recordings."""

from __future__ import annotations

from pathlib import Path

from tactiledata.formats.reading.natural_order import natural_key


def leads_back_up(path: Path) -> bool:
    """Whether a path is a link to a folder that it lies in: following it would leave what was named, or never end."""
    return path.is_symlink() and path.is_dir() and path.parent.resolve().is_relative_to(path.resolve())


def links_below(folder: Path, depth: int) -> list[str]:
    """Names, from a folder, of the links in it and in the folders below it, whether they lead anywhere or not.

    Parameters
    ----------
    folder : Path
        No folder, or one that cannot be listed, has none.
    depth : int
        Levels below it that are looked into.
    """
    found, level = [], [folder]
    for _ in range(depth + 1):
        below: list[Path] = []
        for place in level:
            try:
                entries = list(place.iterdir())
            except OSError:
                continue
            found += [path for path in entries if path.is_symlink()]
            below += [path for path in entries if not path.is_symlink() and path.is_dir()]
        level = below
    return sorted((path.relative_to(folder).as_posix() for path in found), key=natural_key)
