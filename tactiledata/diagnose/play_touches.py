"""Measured touches through the gel, at all that effects may ask of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from tactiledata.calibrate.bounds import Bounds
from tactiledata.calibrate.kept_plays import Play
from tactiledata.calibrate.plan import Node, ResponsePlan
from tactiledata.calibrate.player import Batch, play_batch, play_nodes
from tactiledata.calibrate.touches import MeasuredTouch
from tactiledata.diagnose.gel_variants import surface_height
from tactiledata.diagnose.touch_plays import TouchPlays
from tactiledata.gel.engines import Mechanics
from tactiledata.gel.history import FrameStatus, GelTouch
from tactiledata.gel.pad import PadMesh

Array = NDArray[np.float64]
Tell = Callable[..., None]

SHIFT = 5e-5
"""m: paths are played this much to either side along x and y."""
KNOWN = (FrameStatus.SOLVED, FrameStatus.NO_CONTACT)


def play_touches(
    mesh: PadMesh,
    mechanics: Mechanics,
    touches: Sequence[MeasuredTouch],
    bounds: Bounds,
    workers: int = 1,
    tell: Tell = lambda done, total, what="": None,
) -> list[TouchPlays]:
    """The plays of each touch; frames that one of them could not solve are NaN in all.

    Those without a shift are the calibration's own, and are read from disk where it was run.
    """
    plan = ResponsePlan.of(bounds)
    nodes = play_nodes(mesh, mechanics, touches, list(plan.nodes()), workers, tell)
    nu_middle, mu_middle = plan.middle
    pair = plan.ratios[nu_middle], plan.frictions[mu_middle]
    moved = [
        [_moved(touch.touch, axis, side * SHIFT) for touch in touches] for axis in range(2) for side in (-1.0, 1.0)
    ]
    shifted = play_batch(Batch(mesh, mechanics, *pair, tuple(touch for group in moved for touch in group)))
    count = len(touches)
    return [
        _touch_plays(plan, {node: nodes[node][k] for node in nodes}, shifted[k::count], touch, mesh)
        for k, touch in enumerate(touches)
    ]


def _moved(touch: GelTouch, axis: int, by: float) -> GelTouch:
    poses = touch.poses.copy()
    poses[:, axis, 3] += by
    return GelTouch(touch.indenter, poses)


def _touch_plays(
    plan: ResponsePlan, plays: dict[Node, Play], shifted: Sequence[Play], touch: MeasuredTouch, mesh: PadMesh
) -> TouchPlays:
    """``shifted``: along -x, x, -y and y."""
    unknown = np.zeros(len(touch.seconds), dtype=bool)
    for play in (*plays.values(), *shifted):
        unknown |= ~np.isin(play.status, KNOWN)

    def columns(play: Play) -> Array:
        rows = np.column_stack([np.nan_to_num(play.wrench), play.area])
        rows[unknown] = np.nan
        return rows

    def bend(ratio: float, friction: float) -> list[Array]:
        less, none, more = (columns(plays[Node(ratio, friction, z)]) for z in (-plan.offset, 0.0, plan.offset))
        return [(more - less) / (2 * plan.offset), (more + less - 2 * none) / (2 * plan.offset**2)]

    nu_middle, mu_middle = plan.middle
    left, right, down, up = (columns(play) for play in shifted)
    return TouchPlays(
        plan,
        np.array([[columns(plays[Node(ratio, mu, 0.0)]) for mu in plan.frictions] for ratio in plan.ratios]),
        np.array([bend(ratio, plan.frictions[mu_middle]) for ratio in plan.ratios]),
        np.array([bend(plan.ratios[nu_middle], friction) for friction in plan.frictions]),
        np.stack([right - left, up - down]) / (2 * SHIFT),
        np.where(unknown, np.nan, surface_height(mesh, np.nan_to_num(touch.touch.poses[:, :2, 3]))),
    )
