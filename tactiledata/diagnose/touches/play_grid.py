"""Plays of measured touches by the gel engine: over nu, mu, offset, shift along the gel, and variants of the gel.

Every play is kept on disk and not made again.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from tactiledata.arrays import Array, Mask
from tactiledata.calibrate.bounds import Bounds
from tactiledata.calibrate.plan import Node, ResponsePlan
from tactiledata.calibrate.plays.estimated_plays import Estimates, estimated_change, middle_node
from tactiledata.calibrate.plays.kept_plays import Play
from tactiledata.calibrate.plays.learned_plays import example_touches, learned_laws
from tactiledata.calibrate.plays.play_batches import play_batches
from tactiledata.calibrate.plays.player import play_plan_beside
from tactiledata.calibrate.touches import MeasuredTouch
from tactiledata.compute.base import Scheduler
from tactiledata.contract.progress import Progress, following, no_progress
from tactiledata.diagnose.touches.between_plays import Parabola
from tactiledata.diagnose.touches.grid_answer import TouchPlays
from tactiledata.diagnose.touches.missing_frames import complete, solved
from tactiledata.diagnose.touches.variant_plays import VariantBatch, has_own_law, is_solvable
from tactiledata.effects.touch.gel_variants import contact_height
from tactiledata.effects.touch.response import GelVariant
from tactiledata.gel.contact.history import GelTouch
from tactiledata.gel.engines.fem import Fidelity
from tactiledata.gel.mesh.pad import PadMesh

SHIFT = 5e-5
"""Distance in metres by which whole paths are moved to either side along x and along y."""


def play_touches(
    mesh: PadMesh,
    fidelity: Fidelity,
    touches: Sequence[MeasuredTouch],
    bounds: Bounds,
    runner: Scheduler | None = None,
    progress: Progress = no_progress,
    variants: Sequence[GelVariant] = (),
    estimates: Estimates = "learned",
    full: Collection[GelVariant] = (),
) -> list[TouchPlays]:
    """Return the plays of each touch.

    At finite strain most of them are estimated from a few and from those of the linear engine
    (`tactiledata.calibrate.plays.estimated_plays`). The linear engine knows no other elastic law: a few touches are
    played with it, from which the others are learned (`tactiledata.calibrate.plays.learned_plays`).

    Frames that the middle play could not solve are not numbers. Frames that another play could not solve are
    interpolated from those that it could (`missing_frames`). Plays without shift and variant are those of the
    calibration, and are read from disk where it was run before.

    Parameters
    ----------
    mesh : PadMesh
        Nominal mesh of the gel.
    fidelity : "finite-strain" or "linear"
        Mechanics of the gel engine.
    touches : sequence of MeasuredTouch
        The trajectories.
    bounds : Bounds
        Bounds of nu and mu, between which the nodes of the grid lie.
    runner : Scheduler, optional
        Where the touches are played; in this process where it is ``None``.
    progress : Progress
        Called with how many plays of touches are finished, how many there are, and what was played last.
    variants : sequence of GelVariant
        Variants that are played at the middle nu and mu. A variant that fails in more than ``MOST_LOST`` of the frames
        is left out.
    estimates : "learned", "rough" or "none"
        How plays at finite strain are estimated. Rough estimates leave out variants with another elastic law.
    full : collection of GelVariant
        Variants that are played in any case.
    """
    # batches: paths moved along the gel, then variants; another law is played for some touches, where that is enough
    plan = ResponsePlan.of(bounds)
    nu_middle, mu_middle = plan.middle
    pair = plan.ratios[nu_middle], plan.frictions[mu_middle]
    is_estimated = estimates != "none" and fidelity == "finite-strain"
    quick: Fidelity = "linear" if is_estimated else fidelity
    if is_estimated and estimates == "rough":
        variants = [variant for variant in variants if not has_own_law(variant)]
    every = range(len(touches))
    plain = [touch.touch for touch in touches]
    moved = [[_moved(touch, axis, side * SHIFT) for touch in plain] for axis in range(2) for side in (-1.0, 1.0)]
    exact = {variant for variant in variants if not is_estimated or variant in full or has_own_law(variant)}
    examples = example_touches(plain) if is_estimated else list(every)
    played_for = {variant: every if variant in full or variant not in exact else examples for variant in variants}

    def batch(variant: GelVariant, places: Sequence[int]) -> VariantBatch:
        of_variant: Fidelity = fidelity if variant in exact else quick
        return VariantBatch(mesh, of_variant, *pair, variant, tuple(plain[place] for place in places))

    batches = [VariantBatch(mesh, quick, *pair, GelVariant(), tuple(group)) for group in moved]
    batches += [batch(variant, places) for variant, places in played_for.items()]
    asked = 0

    def counted(done: int, total: int, what: str = "", /) -> None:
        nonlocal asked
        asked = total
        progress(done, total, what)

    # plays, each kept on disk as soon as it is finished
    grid, played = play_plan_beside(mesh, fidelity, touches, plan, batches, runner, counted, estimates)
    of_moved, varied = played[: len(moved)], dict(zip(variants, played[len(moved) :], strict=True))
    # laws of the other touches, where they can be told from the examples
    heights = [np.nan_to_num(touch.poses[:, 2, 3]) for touch in plain]
    at_middle = middle_node(plan)
    middle = grid.played[at_middle]
    of_quick = grid.linear[at_middle] if is_estimated else middle
    solvable = [
        variant
        for variant, places in played_for.items()
        if is_solvable(varied[variant], [(middle if variant in exact else of_quick)[place] for place in places])
    ]
    far = []
    for variant in solvable:
        places = played_for[variant]
        if len(places) < len(every):
            stiff = grid.linear[replace(at_middle, poisson_ratio=plan.ratios[-1])]
            known = dict(zip(places, varied[variant], strict=True))
            answer = learned_laws(known, middle, of_quick, stiff, [-height for height in heights])
            varied[variant] = answer.plays
            if not answer.are_close:
                far.append(variant)
    if far:
        again = play_batches([batch(variant, every) for variant in far], runner, following(progress, asked))
        varied |= zip(far, again, strict=True)
    # what a play has not solved is taken from the others; then the plays that were not made are estimated
    whole = [*grid.played.values(), *grid.linear.values(), *of_moved, *(varied[variant] for variant in solvable)]
    solved_by_all = [np.all([solved(plays[k]) for plays in whole], axis=0) for k in every]
    all_nodes = replace(
        grid,
        played={node: complete(plays, middle, heights) for node, plays in grid.played.items()},
        linear={node: complete(plays, of_quick, heights) for node, plays in grid.linear.items()},
    ).by_node()

    def completed(plays: Sequence[Play], was_quick: bool) -> list[Play]:
        if not (is_estimated and was_quick):
            return complete(plays, middle, heights)
        known = complete(plays, of_quick, heights)
        return [estimated_change(*three) for three in zip(middle, of_quick, known, strict=True)]

    all_shifted = [completed(plays, True) for plays in of_moved]
    all_varied = {variant: completed(varied[variant], variant not in exact) for variant in solvable}
    learned = {variant for variant in solvable if len(played_for[variant]) < len(every) and variant not in far}
    by_estimate = frozenset(variant for variant in solvable if variant not in exact or variant in learned)
    join = partial(_touch_plays, plan, mesh, by_estimate)
    return [
        join(
            {node: plays[k] for node, plays in all_nodes.items()},
            [plays[k] for plays in all_shifted],
            {variant: plays[k] for variant, plays in all_varied.items()},
            touch,
            solved(middle[k]) & ~solved_by_all[k],
        )
        for k, touch in enumerate(touches)
    ]


def _moved(touch: GelTouch, axis: int, by: float) -> GelTouch:
    """Return a touch whose whole path is moved by metres along an axis of the gel frame: 0 is x, 1 is y."""
    poses = touch.poses.copy()
    poses[:, axis, 3] += by
    return GelTouch(touch.indenter, poses)


def _touch_plays(
    plan: ResponsePlan,
    mesh: PadMesh,
    by_estimate: frozenset[GelVariant],
    plays: dict[Node, Play],
    shifted: Sequence[Play],
    varied: Mapping[GelVariant, Play],
    touch: MeasuredTouch,
    estimated: Mask,
) -> TouchPlays:
    """Return the plays of one touch, as levels and finite differences.

    Parameters
    ----------
    plan : ResponsePlan
        Nodes of the grid.
    mesh : PadMesh
        Nominal mesh, for the height of its surface.
    by_estimate : frozenset of GelVariant
        Variants whose changes are estimated.
    plays : dict, Node -> Play
        Plays of the nominal gel on the recorded path.
    shifted : sequence of 4 Play
        With the path moved along -x, x, -y and y.
    varied : dict, GelVariant -> Play
        Plays of the variants.
    touch : MeasuredTouch
        The trajectory, n frames.
    estimated : (n,) bool
        Frames that are interpolated in some play.
    """
    unknown = np.zeros(len(touch.seconds), dtype=bool)
    for play in (*plays.values(), *shifted, *varied.values()):
        unknown |= ~solved(play)

    def columns(play: Play) -> Array:
        rows = np.column_stack([np.nan_to_num(play.wrench), play.area])
        rows[unknown] = np.nan
        return rows

    def bend(ratio: float, friction: float) -> list[Array]:
        less, none, more = (columns(plays[Node(ratio, friction, z)]) for z in (-plan.offset, 0.0, plan.offset))
        bent = Parabola.through(less, none, more, plan.offset)
        return [bent.slope, bent.curvature]

    nu_middle, mu_middle = plan.middle
    middle = columns(plays[Node(plan.ratios[nu_middle], plan.frictions[mu_middle], 0.0)])
    left, right, down, up = (columns(play) for play in shifted)
    return TouchPlays(
        plan,
        level=np.array([[columns(plays[Node(ratio, mu, 0.0)]) for mu in plan.frictions] for ratio in plan.ratios]),
        by_ratio=np.array([bend(ratio, plan.frictions[mu_middle]) for ratio in plan.ratios]),
        by_friction=np.array([bend(plan.ratios[nu_middle], friction) for friction in plan.frictions]),
        by_shift=np.stack([right - left, up - down]) / (2 * SHIFT),
        height=np.where(unknown, np.nan, contact_height(mesh, touch.touch.indenter, np.nan_to_num(touch.touch.poses))),
        variants={variant: (columns(play) - middle)[:, :6] for variant, play in varied.items()},
        estimated=estimated,
        by_estimate=by_estimate,
    )
