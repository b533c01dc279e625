"""Plays at finite strain that are estimated from a few others and from the linear engine.

The linear engine is some ten times faster, and its forces are 5 to 20 % off, but most of that cancels in differences
between its plays. With F the wrenches at finite strain and L those of the linear engine, each over Young's modulus, and
R the ratio of the sizes of their forces at the middle of the plan, frame by frame:

- where one thing differs from the middle, F = F0 + R (L - L0);
- where two things differ, each of which was played alone at finite strain, F = F1 + F2 - F0 + R (L - L1 - L2 + L0).

Source: control variates, as in Peherstorfer, Willcox and Gunzburger, SIAM Review 60 (2018). docs/results.md has the
errors.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from tactiledata.arrays import Array
from tactiledata.calibrate.experiment import KNOWN
from tactiledata.calibrate.plan import Node, ResponsePlan
from tactiledata.calibrate.plays.kept_plays import Play
from tactiledata.gel.contact.history import FrameStatus

Estimates = Literal["learned", "rough", "none"]
"""How plays at finite strain are estimated.

"learned": changes by nu and by the offset are learned from a few touches, others are taken from the linear engine.
"rough": all but changes by friction are taken from the linear engine. "none": all are played.
"""
SMALLEST_RATIO, LARGEST_RATIO = 1.0 / 3.0, 3.0
"""Bounds of the ratio of the forces of the two engines."""


def is_played(plan: ResponsePlan, node: Node) -> bool:
    """Return whether a node is played at finite strain: at most one of nu, mu and offset is not in the middle."""
    return len(_departures(plan, node)) < 2


def is_learned(plan: ResponsePlan, node: Node) -> bool:
    """Return whether a few touches are enough to tell a node's change: where nu or the offset alone differs.

    Changes by friction depend on how each touch slides, and are too different for that.
    """
    departures = _departures(plan, node)
    return len(departures) == 1 and departures[0] != "friction"


def estimated_node(
    plan: ResponsePlan, node: Node, played: Mapping[Node, Sequence[Play]], linear: Mapping[Node, Sequence[Play]]
) -> list[Play]:
    """Return the plays of all touches at a node of which one or two of nu, mu and offset are not in the middle.

    Frames that one of the plays at finite strain lacks are missing; where two numbers differ, the linear plays are left
    out of frames that one of them lacks.

    Parameters
    ----------
    plan : ResponsePlan
        Nodes over nu, mu and offset.
    node : Node
        The node.
    played : dict, Node -> plays of t touches
        At finite strain: at the middle, and, where two numbers of the node differ, at those where one of them does.
        What was not played is estimated as well.
    linear : dict, Node -> plays of t touches
        By the linear engine, at these nodes and at the node.
    """
    middle = middle_node(plan)
    alone = [replace(middle, **{name: getattr(node, name)}) for name in _departures(plan, node)]
    if len(alone) < 2:
        return [estimated_change(*three) for three in zip(played[middle], linear[middle], linear[node], strict=True)]
    first, second = alone
    singles = [played[one] if one in played else estimated_node(plan, one, played, linear) for one in alone]
    estimates = []
    for touch in range(len(played[middle])):
        full = [plays[touch] for plays in (*singles, played[middle])]
        slow = [linear[one][touch] for one in (node, first, second, middle)]
        change = rows_of(slow[0]) - rows_of(slow[1]) - rows_of(slow[2]) + rows_of(slow[3])
        more = ratio_of(full[2], slow[3]) * np.where(np.isfinite(change), change, 0.0)
        estimates.append(play_of_rows(full, rows_of(full[0]) + rows_of(full[1]) - rows_of(full[2]) + more))
    return estimates


def estimated_change(middle: Play, linear_middle: Play, linear: Play) -> Play:
    """Return the play at finite strain of a touch of which one thing differs from the middle of the plan.

    Frames that the middle play lacks, or the linear play, are missing.

    Parameters
    ----------
    middle, linear_middle : Play
        The middle of the plan at finite strain, and by the linear engine.
    linear : Play
        What differs, by the linear engine.
    """
    change = rows_of(linear) - rows_of(linear_middle)
    return play_of_rows([middle, linear], rows_of(middle) + ratio_of(middle, linear_middle) * change)


def middle_node(plan: ResponsePlan) -> Node:
    """The node of the middle nu and mu, without offset."""
    nu, mu = plan.middle
    return Node(plan.ratios[nu], plan.frictions[mu], 0.0)


def _departures(plan: ResponsePlan, node: Node) -> list[str]:
    """Names of the numbers of a node that are not in the middle of the plan."""
    middle = middle_node(plan)
    return [name for name in ("poisson_ratio", "friction", "offset") if getattr(node, name) != getattr(middle, name)]


def rows_of(play: Play) -> Array:
    """Wrench over Young's modulus and contact area (n, 7) of a play; not a number where it is unknown."""
    rows = np.column_stack([play.wrench, play.area])
    rows[~np.isin(play.status, KNOWN)] = np.nan
    return rows


def ratio_of(play: Play, linear: Play) -> Array:
    """Ratio (n, 1) of the sizes of the forces of two plays, within bounds; 1 where either has none."""
    size, of_linear = (np.linalg.norm(np.nan_to_num(one.wrench[:, :3]), axis=1) for one in (play, linear))
    is_known = (size > 0) & (of_linear > 0)
    ratio = np.divide(size, of_linear, out=np.ones_like(size), where=is_known)
    return np.clip(ratio, SMALLEST_RATIO, LARGEST_RATIO)[:, None]


def play_of_rows(sources: Sequence[Play], rows: Array) -> Play:
    """A play of estimated rows (n, 7) whose missing frames are those of its sources; without load there is no contact.

    Parameters
    ----------
    sources : sequence of Play
        Plays from which it was estimated.
    """
    status = sources[0].status.copy()
    for source in sources[1:]:
        status = np.where(np.isin(status, KNOWN), source.status, status)
    is_known = np.isin(status, KNOWN)
    touches = is_known & (rows[:, 2] > 0)
    wrench = np.where(touches[:, None], rows[:, :6], 0.0)
    wrench[~is_known] = np.nan
    area = np.where(touches, np.maximum(np.nan_to_num(rows[:, 6]), 0.0), 0.0)
    contact = np.where(touches, FrameStatus.SOLVED, FrameStatus.NO_CONTACT)
    return Play(wrench, np.where(is_known, contact, status).astype(np.int8), area)
