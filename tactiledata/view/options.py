"""What the viewer shows of a store, and how much of it."""

from __future__ import annotations

from dataclasses import dataclass

from tactiledata.errors import UsageError

MOST_TRAJECTORIES = 20
"""Trajectories that are shown where none is named."""
MOST_PICTURES = 300
"""Pictures and meshes of one trajectory."""


@dataclass(frozen=True)
class ViewOptions:
    """What is shown.

    Parameters
    ----------
    names : tuple of str
        Trajectories by uid, name, or recording and name; all of the store, up to ``most``, where none is named.
    sensor, indenter : str, optional
        Only trajectories of these.
    flagged : bool
        Only flagged trajectories.
    most : int
        Largest number of trajectories where none is named; 0 for all.
    stride : int
        Every how manieth frame is shown.
    pictures : int
        Largest number of frames of one trajectory that are shown, of each camera; 0 for all.
    mesh : str, optional
        Name of a mesh; by default the most faithful one of the store.
    narrow : bool
        Whether panes are stacked in tabs, each as wide as the screen, for a phone or a narrow window.
    """

    names: tuple[str, ...] = ()
    sensor: str | None = None
    indenter: str | None = None
    flagged: bool = False
    most: int = MOST_TRAJECTORIES
    stride: int = 1
    pictures: int = MOST_PICTURES
    mesh: str | None = None
    narrow: bool = False

    def __post_init__(self) -> None:
        for name, least in (("most", 0), ("stride", 1), ("pictures", 0)):
            if (value := getattr(self, name)) < least:
                raise UsageError(f"{name} is {value}", f"a whole number of at least {least}")
