"""The solid that touches the gel in a trajectory, and where it is at each frame, as recorded."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import trimesh

from tactiledata.arrays import Array, Indices
from tactiledata.contract.description import LogDescription
from tactiledata.errors import TactileDataError
from tactiledata.indenters import make_indenter
from tactiledata.replay.poses import gel_from_indenter
from tactiledata.store.read.reader import Store


def indenter_path(
    store: Store,
    description: LogDescription,
    indenter: str,
    aligned: Mapping[str, str],
    rows: Indices,
    folder: Path | None = None,
) -> tuple[trimesh.Trimesh, Array] | str:
    """The mesh of an indenter, and its poses (n, 4, 4) in the gel frame at frames; or why these are not known.

    Parameters
    ----------
    store : Store
    description : LogDescription
        What the recording says of the rig.
    indenter : str
        Its name in the description.
    aligned : dict, name -> name in the store
        Values of the recording at the moments of frames.
    rows : (n,)
        Frames.
    folder : Path, optional
        Folder of the mesh files that recordings name.

    Returns
    -------
    (mesh, poses) or str
        Metres; a pose is NaN where the arm's pose is missing.
    """
    if "tcp" not in aligned:
        return "the recording has no stream of tcp poses"
    tcp_from_gel = description.transform("tcp_from_gel")
    if tcp_from_gel is None:
        return "the recording does not state where the gel is (robot.tcp_from_gel)"
    if indenter not in description.indenters:
        return "the recording does not describe the trajectory's indenter"
    place = description.base_from_indenter(indenter)
    if place is None:
        return "the recording does not state where the indenter stands (base_from_indenter)"
    try:
        solid = make_indenter(description.indenters[indenter], folder, f"indenter {indenter!r}").mesh()
    except TactileDataError as error:
        return error.found
    poses = np.full((len(rows), 4, 4), np.nan)
    if len(rows):
        values = store.aligned(aligned["tcp"], rows)[0]
        poses = gel_from_indenter(values, tcp_from_gel.matrix, place.matrix, 0.0)
    return solid, poses
