"""Measured wrenches beside simulated ones: the frames that both know, as rows of one array."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import Array, Indices
from tactiledata.calibrate.plan import Node, ResponsePlan
from tactiledata.calibrate.plays.kept_plays import Play
from tactiledata.calibrate.response import Response
from tactiledata.calibrate.touches import MeasuredTouch
from tactiledata.gel.contact.history import FrameStatus

FEWEST_FRAMES = 3
"""Fewest usable frames of a trajectory that takes part."""
KNOWN = (FrameStatus.SOLVED, FrameStatus.NO_CONTACT)
"""States of a simulated frame whose wrench is known."""


@dataclass(frozen=True)
class Experiment:
    """The frames of t trajectories that a fit compares: measured wrenches and their simulated response.

    Parameters
    ----------
    touches : tuple of MeasuredTouch
        The t trajectories that take part.
    frames : tuple of (n_i,)
        Which frames of each touch take part; n of them in all.
    response : Response
        Simulated wrenches of the n frames, over nu, mu and contact offset.
    measured : (n, 6) N, N m
        Contact wrenches of the same frames, gel frame.
    left_out : dict, reason -> number of trajectories
        Why other trajectories take no part.
    """

    touches: tuple[MeasuredTouch, ...]
    frames: tuple[Indices, ...]
    response: Response
    measured: Array
    left_out: dict[str, int]

    @property
    def free_samples(self) -> Array:
        """Number (t,) of samples in free air from which each touch's zero was taken."""
        return np.array([touch.free_samples for touch in self.touches])

    def rows(self, wrenches: Sequence[Array]) -> Array:
        """Rows (n, 6) of the frames that take part, from one wrench array (frames, 6) for each touch."""
        return np.concatenate([wrench[kept] for wrench, kept in zip(wrenches, self.frames, strict=True)])


def assemble(
    touches: Sequence[MeasuredTouch], plan: ResponsePlan, plays: Mapping[Node, Sequence[Play]]
) -> Experiment | dict[str, int]:
    """Return the experiment, or where no touch is left, the number of trajectories under each reason.

    A frame takes part where its wrench is known and every play either solved it or found no contact.

    Parameters
    ----------
    touches : sequence of MeasuredTouch
        Candidates.
    plan : ResponsePlan
        The nodes over nu, mu and offset.
    plays : mapping, node -> plays in the order of ``touches``
        Simulated with Young's modulus 1.
    """
    left_out: Counter[str] = Counter()
    kept: list[tuple[int, Indices]] = []
    # keep the touches with enough usable frames
    for number, touch in enumerate(touches):
        touch_plays = [plays[node][number] for node in plays]
        usable: NDArray[np.bool_] = np.asarray(np.isfinite(touch.wrench).all(axis=1))
        for play in touch_plays:
            usable = np.logical_and(usable, np.isin(play.status, KNOWN) & np.isfinite(play.wrench).all(axis=1))
        reason = _reason(touch, touch_plays, usable)
        if reason:
            left_out[reason] += 1
        else:
            kept.append((number, np.flatnonzero(usable)))
    if not kept:
        return dict(left_out)
    # stack the frames that take part, trajectory after trajectory
    used = tuple(touches[number] for number, _ in kept)
    frames = tuple(rows for _, rows in kept)
    starts = np.concatenate([[0], np.cumsum([len(rows) for rows in frames])[:-1]]).astype(np.int64)
    wrenches = {
        node: np.concatenate([plays[node][number].wrench[rows] for number, rows in kept]) for node in plan.nodes()
    }
    measured = np.concatenate([touch.wrench[rows] for touch, rows in zip(used, frames, strict=True)])
    return Experiment(used, frames, Response.of(plan, wrenches, starts), measured, dict(left_out))


def _reason(touch: MeasuredTouch, plays: Sequence[Play], usable: NDArray[np.bool_]) -> str:
    """Return why a touch takes no part, or an empty text where it does."""
    is_pressed = np.any([play.status == FrameStatus.SOLVED for play in plays], axis=0)
    if usable.sum() >= FEWEST_FRAMES and (is_pressed & usable).any():
        return ""
    if not np.isfinite(touch.touch.poses).all(axis=(1, 2)).any():
        return FrameStatus.POSE_MISSING.reason
    failed = Counter(int(status) for play in plays for status in play.status if status not in KNOWN)
    if failed:
        return FrameStatus(failed.most_common(1)[0][0]).reason
    if not is_pressed.any():
        return "no contact: the sensor felt a force, but by its poses the indenter never touches the gel"
    return f"fewer than {FEWEST_FRAMES} frames with pose and wrench"
