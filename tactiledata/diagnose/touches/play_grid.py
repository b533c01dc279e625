"""Plays of measured touches by the gel engine: over nu, mu, offset, shift along the gel, and variants of the gel.

Every play is kept on disk and not made again.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from tactiledata.arrays import Array, Mask
from tactiledata.calibrate.bounds import Bounds
from tactiledata.calibrate.estimated_plays import estimated_change
from tactiledata.calibrate.kept_plays import Play, play_path
from tactiledata.calibrate.plan import Node, ResponsePlan
from tactiledata.calibrate.play_progress import PlayProgress
from tactiledata.calibrate.player import play_plan, played_or_kept
from tactiledata.calibrate.touches import MeasuredTouch
from tactiledata.compute.base import Scheduler
from tactiledata.compute.local import LocalScheduler
from tactiledata.contract.progress import Progress, no_progress
from tactiledata.diagnose.touches.grid_answer import TouchPlays
from tactiledata.diagnose.touches.missing_frames import complete, solved
from tactiledata.effects import EFFECTS
from tactiledata.effects.base import Effect
from tactiledata.effects.touch.gel_variants import contact_height, variant_engine, warped
from tactiledata.effects.touch.response import GelVariant
from tactiledata.gel.contact.history import GelTouch
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.gel.engines.fem import Fidelity
from tactiledata.gel.mesh.pad import PadMesh
from tactiledata.indenters.scaled import scaled


@dataclass(frozen=True)
class VariantBatch:
    """Touches that are played with one variant of gel or indenter, at one nu and one mu.

    Parameters
    ----------
    mesh : PadMesh
        Nominal mesh of the gel.
    fidelity : "finite-strain" or "linear"
        Mechanics of the gel engine.
    ratio, friction : float
        Poisson's ratio nu and friction coefficient mu.
    variant : GelVariant
        How gel or indenter differ from the nominal ones.
    touches : tuple of GelTouch
        With the nominal indenters.
    """

    mesh: PadMesh
    fidelity: Fidelity
    ratio: float
    friction: float
    variant: GelVariant
    touches: tuple[GelTouch, ...]


def design_variants(effect: Effect) -> tuple[GelVariant, ...]:
    """Return the variants that must have been played before an effect can be simulated; most effects need none."""
    return tuple(effect.variant({name: place}) for name, places in effect.designs.items() for place in places)


def variants_of(names: Iterable[str]) -> tuple[GelVariant, ...]:
    """Return the variants that the effects of these names need, each once."""
    return tuple(dict.fromkeys(variant for name in names for variant in design_variants(EFFECTS[name]())))


def play_variant(batch: VariantBatch) -> list[Play]:
    """Return the play of each touch of a batch, from disk where it was made before."""
    return played_or_kept(
        _touches(batch),
        variant_paths(batch),
        GelMaterial(1.0, batch.ratio, batch.friction),
        lambda: variant_engine(batch.mesh, batch.ratio, batch.fidelity, batch.variant),
    )


def variant_paths(batch: VariantBatch) -> list[Path]:
    """Return the file in which the play of each touch of a batch is kept."""
    variant = batch.variant
    digest = warped(batch.mesh, variant).digest
    law = (variant.c20, variant.c30, variant.skin, variant.spots)
    # shapes of pad and indenter are part of their digests; the law of the material is not
    mechanics = batch.fidelity if law == (0.0, 0.0, 0.0, ()) else f"{batch.fidelity} {law!r}"
    return [play_path(touch, digest, mechanics, batch.ratio, batch.friction) for touch in _touches(batch)]


def _touches(batch: VariantBatch) -> tuple[GelTouch, ...]:
    """Return touches of a batch with the indenters scaled as its variant says."""
    scale = batch.variant.indenter_scale
    if scale == 1.0:
        return batch.touches
    return tuple(GelTouch(scaled(touch.indenter, scale), touch.poses) for touch in batch.touches)


SHIFT = 5e-5
"""Distance in metres by which whole paths are moved to either side along x and along y."""
MOST_LOST = 0.1
"""Largest share of the frames that a variant may fail to solve.

If it fails in more, the variant is left out; otherwise, the frames are interpolated.
"""


def play_touches(
    mesh: PadMesh,
    fidelity: Fidelity,
    touches: Sequence[MeasuredTouch],
    bounds: Bounds,
    runner: Scheduler | None = None,
    progress: Progress = no_progress,
    variants: Sequence[GelVariant] = (),
    estimate: bool = True,
    full: Collection[GelVariant] = (),
) -> list[TouchPlays]:
    """Return the plays of each touch.

    At finite strain most of them are estimated from a few and from those of the linear engine
    (`tactiledata.calibrate.estimated_plays`); variants of the elastic law are played, as the linear engine has none.

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
    estimate : bool
        Whether plays at finite strain may be estimated; otherwise all are played.
    full : collection of GelVariant
        Variants that are played in any case.
    """
    # batches: paths moved along the gel, then variants
    plan = ResponsePlan.of(bounds)
    nu_middle, mu_middle = plan.middle
    pair = plan.ratios[nu_middle], plan.frictions[mu_middle]
    moved = [
        tuple(_moved(touch.touch, axis, side * SHIFT) for touch in touches) for axis in range(2) for side in (-1.0, 1.0)
    ]
    plain = tuple(touch.touch for touch in touches)
    is_estimated = estimate and fidelity == "finite-strain"
    quick: Fidelity = "linear" if is_estimated else fidelity
    exact = {variant for variant in variants if variant in full or has_own_law(variant)}
    batches = [VariantBatch(mesh, quick, *pair, GelVariant(), group) for group in moved]
    batches += [
        VariantBatch(mesh, fidelity if variant in exact else quick, *pair, variant, plain) for variant in variants
    ]
    of_batches = len(batches) * len(touches)
    of_nodes = 0

    def nodes_played(done: int, total: int, what: str = "") -> None:
        nonlocal of_nodes
        of_nodes = total
        progress(done, total + of_batches, what)

    def batches_played(done: int, _: int, what: str = "") -> None:
        progress(of_nodes + done, of_nodes + of_batches, what)

    # plays, each kept on disk as soon as it is finished
    grid = play_plan(mesh, fidelity, touches, plan, runner, nodes_played, estimate)
    others: list[list[Play]] = []
    paths = [path for batch in batches for path in variant_paths(batch)]
    with PlayProgress(paths, batches_played) as play_progress:
        for outcome in (runner or LocalScheduler()).outcomes(play_variant, batches):
            if outcome.error is not None:
                raise outcome.error
            others.append(outcome.result or [])
            play_progress.finished(len(others) * len(touches), _words(len(others), len(moved)))
    # what a play has not solved is taken from the others; then the plays that were not made are estimated
    heights = [np.nan_to_num(touch.touch.poses[:, 2, 3]) for touch in touches]
    at_middle = Node(*pair, 0.0)
    middle = grid.played[at_middle]
    of_quick = grid.linear[at_middle] if is_estimated else middle
    every = [*grid.played.values(), *grid.linear.values(), *others]
    solved_by_all = [np.all([solved(plays[k]) for plays in every], axis=0) for k in range(len(touches))]
    all_nodes = replace(
        grid,
        played={node: complete(plays, middle, heights) for node, plays in grid.played.items()},
        linear={node: complete(plays, of_quick, heights) for node, plays in grid.linear.items()},
    ).by_node()

    def completed(plays: Sequence[Play], was_quick: bool) -> list[Play]:
        if not (is_estimated and was_quick):
            return complete(plays, middle, heights)
        whole = complete(plays, of_quick, heights)
        return [estimated_change(*three) for three in zip(middle, of_quick, whole, strict=True)]

    all_shifted = [completed(plays, True) for plays in others[: len(moved)]]
    varied = dict(zip(variants, others[len(moved) :], strict=True))
    kept = {
        variant: plays
        for variant, plays in varied.items()
        if is_solvable(plays, middle if variant in exact else of_quick)
    }
    all_kept = {variant: completed(plays, variant not in exact) for variant, plays in kept.items()}
    join = partial(_touch_plays, plan, mesh)
    return [
        join(
            {node: plays[k] for node, plays in all_nodes.items()},
            [plays[k] for plays in all_shifted],
            {variant: plays[k] for variant, plays in all_kept.items()},
            touch,
            solved(middle[k]) & ~solved_by_all[k],
        )
        for k, touch in enumerate(touches)
    ]


def _words(done: int, moved: int) -> str:
    """Return what was played last, in words: the first ``moved`` batches are moved paths, the others variants."""
    return "moved along the gel" if done <= moved else "gels and indenters that differ"


def _moved(touch: GelTouch, axis: int, by: float) -> GelTouch:
    """Return a touch whose whole path is moved by metres along an axis of the gel frame: 0 is x, 1 is y."""
    poses = touch.poses.copy()
    poses[:, axis, 3] += by
    return GelTouch(touch.indenter, poses)


def has_own_law(variant: GelVariant) -> bool:
    """Return whether a variant has another elastic law, which the linear engine does not know."""
    return (variant.c20, variant.c30) != (0.0, 0.0)


def is_solvable(varied: Sequence[Play], plain: Sequence[Play]) -> bool:
    """Return whether a variant solves nearly all frames which the nominal gel solves; see ``MOST_LOST``.

    Parameters
    ----------
    varied : sequence of Play
        Plays of the variant, one for each touch.
    plain : sequence of Play
        Plays of the nominal gel by the same engine at the same nu and mu, in the same order.
    """
    known = np.concatenate([solved(play) for play in plain])
    lost = known & ~np.concatenate([solved(play) for play in varied])
    return bool(lost.sum() <= MOST_LOST * known.sum())


def _touch_plays(
    plan: ResponsePlan,
    mesh: PadMesh,
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
        # slope and curvature of the parabola through three offsets
        less, none, more = (columns(plays[Node(ratio, friction, z)]) for z in (-plan.offset, 0.0, plan.offset))
        return [(more - less) / (2 * plan.offset), (more + less - 2 * none) / (2 * plan.offset**2)]

    nu_middle, mu_middle = plan.middle
    middle = columns(plays[Node(plan.ratios[nu_middle], plan.frictions[mu_middle], 0.0)])
    left, right, down, up = (columns(play) for play in shifted)
    return TouchPlays(
        plan,
        np.array([[columns(plays[Node(ratio, mu, 0.0)]) for mu in plan.frictions] for ratio in plan.ratios]),
        np.array([bend(ratio, plan.frictions[mu_middle]) for ratio in plan.ratios]),
        np.array([bend(plan.ratios[nu_middle], friction) for friction in plan.frictions]),
        np.stack([right - left, up - down]) / (2 * SHIFT),
        np.where(unknown, np.nan, contact_height(mesh, touch.touch.indenter, np.nan_to_num(touch.touch.poses))),
        {variant: (columns(play) - middle)[:, :6] for variant, play in varied.items()},
        estimated,
    )
