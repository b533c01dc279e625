"""Links among folders of recordings."""

from __future__ import annotations

from pathlib import Path


def leads_back_up(path: Path) -> bool:
    """Whether a path is a link to a folder that it lies in: following it would leave what was named, or never end."""
    return path.is_symlink() and path.is_dir() and path.parent.resolve().is_relative_to(path.resolve())
