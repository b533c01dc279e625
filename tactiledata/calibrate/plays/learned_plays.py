"""Plays at finite strain of touches that were not played, learned from the touches that were.

One thing differs from the middle of the plan: nu, the contact offset, or the law of the gel. A few touches, the
examples, are played with it. The change of every other touch is a sum of terms that are known of all touches, such as
the change that the linear engine finds; the weights of the terms are those that fit the examples best. Forces along the
normal and across it, torques and areas have weights of their own.

Each example is also predicted from the others alone. Where that is too far off (`TOO_FAR`), all touches are played.

Source: regression between simulators of two fidelities, as in Kennedy and O'Hagan, Biometrika 87 (2000).
docs/results.md has the errors.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array
from tactiledata.calibrate.plays.estimated_plays import play_of_rows, ratio_of, rows_of
from tactiledata.calibrate.plays.kept_plays import Play
from tactiledata.gel.contact.history import GelTouch

FEWEST_EXAMPLES = 8
"""Touches that are played as examples, at least; where fewer are left over than this, all are played."""
SHARE_OF_EXAMPLES = 1 / 12
"""Share of the touches that are examples, at least: more of them hardly help (docs/decisions/0049)."""
TOO_FAR = 0.01
"""Error of a predicted force, as a share of the touch's largest one, from which on all touches are played.

It is the root mean square over the frames of all examples, each predicted from the others."""
RIDGE = 1e-4
"""Weight of the penalty on the terms' weights, relative to the mean square of the terms."""
DEPTH = 1e-3
"""Unit of depth, m, in which terms are formed."""
GROUPS = ((2,), (0, 1), (3, 4), (5,), (6,))
"""Columns of wrench and area that share their weights: normal force, shear, torques across and along it, area."""


def example_touches(touches: Sequence[GelTouch]) -> list[int]:
    """Return the places of the touches that are played as examples, ascending; all places where touches are few.

    These are the deepest touch of each indenter, and then one after the other the touch that is least like those
    chosen, in depth, travel across the gel and place on it.

    Parameters
    ----------
    touches : sequence of GelTouch
        Poses and indenters.
    """
    deepest_first = sorted(range(len(touches)), key=lambda place: float(np.nanmin(touches[place].poses[:, 2, 3])))
    of_indenter: dict[str, int] = {}
    for place in deepest_first:
        of_indenter.setdefault(json.dumps(touches[place].indenter.document, sort_keys=True), place)
    chosen = list(of_indenter.values())
    count = max(FEWEST_EXAMPLES, len(chosen), math.ceil(SHARE_OF_EXAMPLES * len(touches)))
    if len(touches) - count < FEWEST_EXAMPLES:
        return list(range(len(touches)))
    places = np.array([_traits(touch) for touch in touches])
    places = (places - places.mean(axis=0)) / np.maximum(places.std(axis=0), 1e-12)
    while len(chosen) < count:
        distances = np.linalg.norm(places[:, None] - places[chosen], axis=-1).min(axis=1)
        chosen.append(int(distances.argmax()))
    return sorted(chosen)


def _traits(touch: GelTouch) -> tuple[float, float, float, float]:
    """Lowest height of a touch, its travel across the gel, and the middle of its path along x and y, m."""
    positions = touch.poses[:, :3, 3]
    positions = positions[np.isfinite(positions).all(axis=1)]
    travel = float(np.linalg.norm(np.ptp(positions[:, :2], axis=0)))
    middle = positions[:, :2].mean(axis=0)
    return float(positions[:, 2].min()), travel, float(middle[0]), float(middle[1])


@dataclass(frozen=True)
class LearnedPlays:
    """Plays of all touches with one change, most of them predicted.

    Parameters
    ----------
    plays : list of t Play
        Those of the examples as they were played, the others predicted.
    error : float
        Error of a predicted force: see `LearnedChange`.
    """

    plays: list[Play]
    error: float

    @property
    def are_close(self) -> bool:
        """Whether predictions are close enough, so that the other touches need not be played."""
        return self.error <= TOO_FAR


def learned_nodes(
    examples: Mapping[int, Play], middle: Sequence[Play], linear_middle: Sequence[Play], linear: Sequence[Play]
) -> LearnedPlays:
    """Return the plays of all touches at a node, from those of the examples and of the linear engine.

    Terms are the linear engine's change, times the ratio of the two engines' forces and without it, and the forces of
    the middle by both engines. Frames that the middle play lacks, or a linear one, are missing.

    Parameters
    ----------
    examples : dict, touch -> Play
        At the node, at finite strain.
    middle, linear_middle : sequence of t Play
        Middle of the plan, at finite strain and by the linear engine.
    linear : sequence of t Play
        At the node, by the linear engine.
    """
    terms = []
    for one, quick_middle, quick in zip(middle, linear_middle, linear, strict=True):
        change = rows_of(quick) - rows_of(quick_middle)
        terms.append(
            np.stack([ratio_of(one, quick_middle) * change, change, rows_of(one), rows_of(quick_middle)], axis=1)
        )
    sources = [list(three) for three in zip(middle, linear_middle, linear, strict=True)]
    return _learned(examples, middle, terms, np.array([1.0, 0.0, 0.0, 0.0]), sources)


def learned_laws(
    examples: Mapping[int, Play],
    middle: Sequence[Play],
    linear_middle: Sequence[Play],
    linear_stiff: Sequence[Play],
    depths: Sequence[Array],
) -> LearnedPlays:
    """Return the plays of all touches with another elastic law, which the linear engine does not know.

    Terms are the forces of the middle, also times the depth and times the ratio of the two engines' forces, those of
    the linear engine, and its change by a larger nu.

    Parameters
    ----------
    examples : dict, touch -> Play
        With the other law, at finite strain.
    middle, linear_middle : sequence of t Play
        Middle of the plan, at finite strain and by the linear engine.
    linear_stiff : sequence of t Play
        At a larger nu, by the linear engine.
    depths : sequence of t (n,), m
        Depth of the tip in each frame.
    """
    terms = []
    for one, quick_middle, stiff, depth in zip(middle, linear_middle, linear_stiff, depths, strict=True):
        force, quick = rows_of(one), rows_of(quick_middle)
        deep = np.clip(depth, 0.0, None)[:, None] / DEPTH
        terms.append(
            np.stack([force, quick, ratio_of(one, quick_middle) * force, deep * force, rows_of(stiff) - quick], axis=1)
        )
    sources = [list(three) for three in zip(middle, linear_middle, linear_stiff, strict=True)]
    return _learned(examples, middle, terms, np.zeros(5), sources)


def _learned(
    examples: Mapping[int, Play],
    middle: Sequence[Play],
    terms: Sequence[Array],
    prior: Array,
    sources: Sequence[Sequence[Play]],
) -> LearnedPlays:
    """Plays of all touches, from the examples and the terms (n, k, 7) of each.

    Frames that one of a touch's sources lacks are missing.
    """
    middle_rows = [rows_of(play) for play in middle]
    fitted = LearnedChange.of(
        {touch: terms[touch] for touch in examples},
        {touch: rows_of(play) - middle_rows[touch] for touch, play in examples.items()},
        {touch: _sizes(middle_rows[touch]) for touch in examples},
        prior,
    )
    plays = [
        examples[touch]
        if touch in examples
        else play_of_rows(sources[touch], middle_rows[touch] + fitted.change(terms[touch]))
        for touch in range(len(middle))
    ]
    return LearnedPlays(plays, fitted.error)


@dataclass(frozen=True)
class LearnedChange:
    """Weights of the terms of a change, and how far predicted forces are off.

    Parameters
    ----------
    weights : (g, k)
        Weight of each of the k terms, for each of the ``GROUPS``.
    error : float
        Error of the forces of an example that is predicted from the others, as a share of its largest force; root mean
        square over all frames.
    """

    weights: Array
    error: float

    @staticmethod
    def of(
        terms: Mapping[int, Array], changes: Mapping[int, Array], sizes: Mapping[int, Array], prior: Array
    ) -> LearnedChange:
        """Fit the weights to the changes of the examples.

        Parameters
        ----------
        terms : dict, touch -> (n, k, 7)
            Terms at the n frames of each example: wrench and area. Frames with unknown values do not count.
        changes : dict, touch -> (n, 7)
            Changes that were played.
        sizes : dict, touch -> (7,)
            Largest force, torque and area of each example, for its columns. Touches count alike by these.
        prior : (k,)
            Weights to which the fit is drawn where the examples do not tell them.
        """
        weights, off = [], 0.0
        frames = 0
        for group in GROUPS:
            parts = {touch: _equations(terms[touch], changes[touch], sizes[touch], group) for touch in terms}
            total = _Normal.sum(list(parts.values()), len(prior))
            weights.append(total.solved(prior))
            if max(group) > 2:
                continue
            for part in parts.values():
                found = total.without(part).solved(prior)
                off += part.squares(found)
                frames += part.rows if group == (2,) else 0
        return LearnedChange(np.array(weights), math.sqrt(off / frames) if frames else math.inf)

    def change(self, terms: Array) -> Array:
        """Return the predicted change (n, 7) of a touch with these terms (n, k, 7)."""
        change = np.empty((len(terms), terms.shape[2]))
        for weights, group in zip(self.weights, GROUPS, strict=True):
            change[:, group] = np.einsum("k,nkc->nc", weights, terms[:, :, group])
        return change


@dataclass(frozen=True)
class _Normal:
    """Normal equations of some frames.

    Parameters
    ----------
    gram : (k, k)
        Products of the terms.
    right : (k,)
        Products of the terms with the changes.
    square : float
        Sum of the squared changes.
    rows : int
        Number of equations.
    """

    gram: Array
    right: Array
    square: float
    rows: int

    @staticmethod
    def sum(parts: Sequence[_Normal], count: int) -> _Normal:
        """Return the sum of the equations of all parts, for ``count`` terms."""
        whole = _Normal(np.zeros((count, count)), np.zeros(count), 0.0, 0)
        for part in parts:
            whole = _Normal(
                whole.gram + part.gram, whole.right + part.right, whole.square + part.square, whole.rows + part.rows
            )
        return whole

    def without(self, part: _Normal) -> _Normal:
        """Return these equations without those of a part."""
        return _Normal(self.gram - part.gram, self.right - part.right, self.square - part.square, self.rows - part.rows)

    def solved(self, prior: Array) -> Array:
        """Return the weights (k,) that fit best, drawn a little towards a prior."""
        sizes = np.sqrt(np.maximum(np.diag(self.gram), 0.0))
        sizes[sizes == 0.0] = 1.0
        scaled = self.gram / np.outer(sizes, sizes) + RIDGE * np.eye(len(sizes))
        return prior + np.linalg.solve(scaled, (self.right - self.gram @ prior) / sizes) / sizes

    def squares(self, weights: Array) -> float:
        """Return the sum of the squared errors with these weights."""
        return max(float(self.square - 2 * self.right @ weights + weights @ self.gram @ weights), 0.0)


def _equations(terms: Array, change: Array, sizes: Array, group: tuple[int, ...]) -> _Normal:
    """Normal equations of the columns of a group, of the frames whose terms and change are known."""
    left = np.concatenate([terms[:, :, column] / sizes[column] for column in group])
    right = np.concatenate([change[:, column] / sizes[column] for column in group])
    known = np.isfinite(right) & np.isfinite(left).all(axis=1)
    left, right = left[known], right[known]
    return _Normal(left.T @ left, left.T @ right, float(right @ right), len(right))


def _sizes(rows: Array) -> Array:
    """Largest force, torque and area (7,) of a touch for the columns of its wrench and area (n, 7)."""
    lengths = [np.linalg.norm(rows[:, part], axis=1) for part in (slice(0, 3), slice(3, 6))]
    force, torque = (float(np.nanmax(length, initial=0.0)) for length in lengths)
    area = float(np.nanmax(rows[:, 6], initial=0.0))
    return np.array([force or 1.0] * 3 + [torque or 1.0] * 3 + [area or 1.0])
