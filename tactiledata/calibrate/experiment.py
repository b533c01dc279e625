"""Measured touches beside what the gel answers to them: the frames that both know, in one row after another."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import Array, Indices
from tactiledata.calibrate.kept_plays import Play
from tactiledata.calibrate.plan import Node, ResponsePlan
from tactiledata.calibrate.response import Response
from tactiledata.calibrate.touches import MeasuredTouch
from tactiledata.gel.contact.history import FrameStatus

FEWEST_FRAMES = 3
KNOWN = (FrameStatus.SOLVED, FrameStatus.NO_CONTACT)


@dataclass(frozen=True)
class Experiment:
    """What is fitted.

    Parameters
    ----------
    touches : t of them
    frames : tuple of (n_i,)
        Which frames of each touch take part.
    response : Response
        Of n frames.
    measured : (n, 6) N, N m
    left_out : dict, reason -> number of trajectories
    """

    touches: tuple[MeasuredTouch, ...]
    frames: tuple[Indices, ...]
    response: Response
    measured: Array
    left_out: dict[str, int]

    @property
    def free_samples(self) -> Array:
        """Of each touch (t,)."""
        return np.array([touch.free_samples for touch in self.touches])

    def rows(self, wrenches: Sequence[Array]) -> Array:
        """Wrenches of whole touches, the frames that take part one after another (n, 6)."""
        return np.concatenate([wrench[kept] for wrench, kept in zip(wrenches, self.frames, strict=True)])


def assemble(
    touches: Sequence[MeasuredTouch], plan: ResponsePlan, plays: Mapping[Node, Sequence[Play]]
) -> Experiment | dict[str, int]:
    """The experiment, or where no touch is left, the reasons.

    A frame takes part where its wrench is known and every play has solved it, or found nothing that touches.
    """
    left_out: Counter[str] = Counter()
    kept: list[tuple[int, Indices]] = []
    for number, touch in enumerate(touches):
        every = [plays[node][number] for node in plays]
        usable: NDArray[np.bool_] = np.asarray(np.isfinite(touch.wrench).all(axis=1))
        for play in every:
            usable = np.logical_and(usable, np.isin(play.status, KNOWN) & np.isfinite(play.wrench).all(axis=1))
        reason = _reason(touch, every, usable)
        if reason:
            left_out[reason] += 1
        else:
            kept.append((number, np.flatnonzero(usable)))
    if not kept:
        return dict(left_out)
    used = tuple(touches[number] for number, _ in kept)
    frames = tuple(rows for _, rows in kept)
    starts = np.concatenate([[0], np.cumsum([len(rows) for rows in frames])[:-1]]).astype(np.int64)
    wrenches = {
        node: np.concatenate([plays[node][number].wrench[rows] for number, rows in kept]) for node in plan.nodes()
    }
    measured = np.concatenate([touch.wrench[rows] for touch, rows in zip(used, frames, strict=True)])
    return Experiment(used, frames, Response.of(plan, wrenches, starts), measured, dict(left_out))


def _reason(touch: MeasuredTouch, plays: Sequence[Play], usable: NDArray[np.bool_]) -> str:
    """Why a touch takes no part; empty where it does."""
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
