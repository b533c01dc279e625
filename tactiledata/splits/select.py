"""Which frames a split takes: those of its trajectories that show a contact and have an image."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

from tactiledata.contract.take import UNUSABLE
from tactiledata.errors import StoreError

FRAME_COLUMNS = ("trajectory", "flags", "contact_force")


def taken_frames(frames: pa.Table, force: tuple[float, float] | None) -> NDArray[np.bool_]:
    """Whether a split takes a frame.

    Parameters
    ----------
    frames : pa.Table
        The columns ``FRAME_COLUMNS`` of ``FRAME_SCHEMA``, n rows.
    force : (lowest, highest) N, both taken in, or None
        Frames without a wrench (NaN) are taken only with ``None``.

    Returns
    -------
    (n,) bool
    """
    taken = frames["trajectory"].to_numpy() >= 0
    taken &= (frames["flags"].to_numpy() & UNUSABLE) == 0
    if force is not None:
        value = contact_force(frames)
        taken &= (value >= force[0]) & (value <= force[1])
    return taken


def contact_force(frames: pa.Table) -> NDArray[np.float32]:
    """Contact force (n,), N, NaN where there is none."""
    return pc.fill_null(frames["contact_force"], np.nan).to_numpy()


def frames_per_trajectory(frames: pa.Table, taken: NDArray[np.bool_], n_trajectories: int) -> NDArray[np.int64]:
    """Return the number of taken frames (n_trajectories,) of each trajectory.

    Parameters
    ----------
    frames : pa.Table
        ``FRAME_SCHEMA``, n rows.
    taken : (n,) bool
        Frames that the split takes.
    n_trajectories : int
        Trajectories of the store.

    Raises
    ------
    StoreError
        A frame belongs to a trajectory that does not exist.
    """
    rows = frames["trajectory"].to_numpy()[taken]
    if len(rows) and int(rows.max()) >= n_trajectories:
        raise StoreError(
            f"a frame belongs to trajectory row {int(rows.max())}, and there are {n_trajectories} trajectories",
            "frames that point into the trajectories table",
            "The store is damaged: run `tactiledata check`.",
        )
    return np.bincount(rows, minlength=n_trajectories).astype(np.int64)


def check_force_filter(frames: pa.Table, taken: NDArray[np.bool_], force: tuple[float, float] | None) -> list[str]:
    """Return what the contact filter leaves out, in words; refuse a filter that leaves nothing.

    Parameters
    ----------
    frames : pa.Table
        ``FRAME_SCHEMA``, n rows.
    taken : (n,) bool
        Frames that the filter takes.
    force : (float, float), N, optional
        Lowest and highest contact force; ``None`` where there is no filter.

    Raises
    ------
    StoreError
        Nothing is left: no frames at all, no wrench at all, or no force within the bounds.
    """
    n = frames.num_rows
    usable = taken_frames(frames, None)
    if not usable.any():
        raise StoreError(
            f"none of the store's {n} frames has a whole image inside a trajectory",
            "frames to split",
            "`tactiledata info` shows what is there, `tactiledata check` whether images were damaged.",
        )
    if force is None:
        return []
    value = contact_force(frames)
    known = np.isfinite(value)
    if not known.any():
        raise StoreError(
            f"no frame has a contact force (all {n} are without a wrench)",
            f"forces in {force[0]:g}..{force[1]:g} N, by which frames in contact are chosen",
            "Use --force none to take every frame.",
        )
    if not taken.any():
        there = value[known & usable]
        reach = f"forces reach from {there.min():.3g} to {there.max():.3g} N" if len(there) else "theirs are not known"
        raise StoreError(
            f"no frame with an image has a contact force in {force[0]:g}..{force[1]:g} N: {reach}",
            "some frames in contact",
            "Use other bounds (--force LOWEST..HIGHEST), or --force none to take every frame.",
        )
    notes = [f"{int(taken.sum())} of {n} frames are taken: contact force in {force[0]:g}..{force[1]:g} N, image whole"]
    if not known.all():
        notes.append(f"{int((~known).sum())} frames have no contact force and are in no part; --force none takes them")
    return notes
