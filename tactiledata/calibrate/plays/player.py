"""Simulation of measured touches at the nodes of a plan; touches simulated before are read from the cache."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from tactiledata.arrays import Array
from tactiledata.calibrate.plan import Node, ResponsePlan
from tactiledata.calibrate.plays.estimated_plays import (
    Estimates,
    estimated_node,
    is_learned,
    is_played,
    middle_node,
)
from tactiledata.calibrate.plays.kept_plays import Play, keep_play, load_play, play_path
from tactiledata.calibrate.plays.learned_plays import example_touches, learned_nodes
from tactiledata.calibrate.plays.play_progress import PlayProgress
from tactiledata.calibrate.touches import MeasuredTouch
from tactiledata.compute.base import Scheduler
from tactiledata.compute.local import LocalScheduler
from tactiledata.contract.progress import Progress, no_progress
from tactiledata.gel.contact.history import GelTouch
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.gel.make_engine import Mechanics, make_engine
from tactiledata.gel.mesh.pad import PadMesh

if TYPE_CHECKING:
    from tactiledata.gel.engines.fem import FemEngine
    from tactiledata.gel.flex.engine import FlexEngine


@dataclass(frozen=True)
class PlayBatch:
    """Touches to be simulated at one nu and one mu.

    Parameters
    ----------
    mesh : PadMesh
        Mesh of the gel.
    mechanics : str
        Engine and fidelity.
    ratio, friction : float
        Poisson's ratio and coefficient of friction of the gel.
    touches : tuple of GelTouch
        Poses and indenter of each touch.
    """

    mesh: PadMesh
    mechanics: Mechanics
    ratio: float
    friction: float
    touches: tuple[GelTouch, ...]


def play_nodes(
    mesh: PadMesh,
    mechanics: Mechanics,
    touches: Sequence[MeasuredTouch],
    nodes: Sequence[Node],
    runner: Scheduler | None = None,
    report_progress: Progress = no_progress,
) -> dict[Node, list[Play]]:
    """Simulate all touches at each node, and return the plays of each node in the order of the touches.

    Nodes of one nu and mu are simulated together, so that more trajectories advance in lockstep. Finished plays are
    kept in the cache (``TACTILEDATA_CACHE``), so that an interrupted run continues where it ended.

    Parameters
    ----------
    mesh : PadMesh
        Mesh of the gel.
    mechanics : str
        Engine and fidelity.
    touches : sequence of MeasuredTouch
        Poses and indenters.
    nodes : sequence of Node
        Nodes of one nu and mu must follow one another.
    runner : Scheduler, optional
        Where the batches run, each of one nu and mu; in this process where it is ``None``.
    report_progress : callable
        Called with the number of finished plays of touches, their total and a label.

    Raises
    ------
    Exception
        The error of a batch that failed.
    """
    # one batch for each pair of nu and mu: its touches at all its offsets
    batches, members = [], []
    for (ratio, friction), group in itertools.groupby(nodes, key=lambda node: (node.poisson_ratio, node.friction)):
        members.append(list(group))
        shifted = tuple(touch.deeper(node.offset) for node in members[-1] for touch in touches)
        batches.append(PlayBatch(mesh, mechanics, ratio, friction, shifted))
    # run the batches, and sort their plays by node
    plays_of: dict[Node, list[Play]] = {}
    paths = [path for batch in batches for path in batch_paths(batch)]
    outcomes = (runner or LocalScheduler()).outcomes(play_batch, batches, len(batches))
    with PlayProgress(paths, report_progress) as progress:
        for batch_nodes, outcome in zip(members, outcomes, strict=True):
            plays = iter(outcome.value)
            for node in batch_nodes:
                plays_of[node] = list(itertools.islice(plays, len(touches)))
            finished = len(plays_of) * len(touches)
            progress.finished(finished, f"nu {outcome.task.ratio:.3f}, mu {outcome.task.friction:.2f}")
    return plays_of


@dataclass(frozen=True)
class PlanPlays:
    """The plays at the nodes of a plan: all of them, or some and those of the linear engine at all nodes.

    Parameters
    ----------
    plan : ResponsePlan
        Nodes over nu, mu and offset.
    played : dict, Node -> plays of t touches
        By the engine that was asked for; at some nodes a few touches were played and the others learned from them.
    linear : dict, Node -> plays of t touches
        By the linear engine at every node; empty where every node was played.
    """

    plan: ResponsePlan
    played: dict[Node, list[Play]]
    linear: dict[Node, list[Play]]

    def by_node(self) -> dict[Node, list[Play]]:
        """Return the plays of every node of the plan, those that were not played estimated (`estimated_node`)."""
        return {
            node: self.played[node]
            if node in self.played
            else estimated_node(self.plan, node, self.played, self.linear)
            for node in self.plan.nodes()
        }


def play_plan(
    mesh: PadMesh,
    mechanics: Mechanics,
    touches: Sequence[MeasuredTouch],
    plan: ResponsePlan,
    runner: Scheduler | None = None,
    report_progress: Progress = no_progress,
    estimates: Estimates = "learned",
) -> PlanPlays:
    """Simulate all touches at the nodes of a plan.

    At finite strain, only the nodes are played at which no more than one of nu, mu and offset differs from the middle,
    and all nodes by the linear engine, from which the others are estimated. Where nu or the offset differs, a few
    touches are played; the others are learned from them (`learned_plays`), or played where that would be too far off.

    Parameters
    ----------
    mesh : PadMesh
        Mesh of the gel.
    mechanics : str
        Engine and fidelity.
    touches : sequence of MeasuredTouch
        Poses and indenters.
    plan : ResponsePlan
        Nodes over nu, mu and offset.
    runner : Scheduler, optional
        Where the touches are simulated; in this process where it is ``None``.
    report_progress : callable
        Called with the number of finished plays of touches, their total and a label.
    estimates : "learned", "rough" or "none"
        How plays at finite strain are estimated.

    Raises
    ------
    Exception
        The error of a batch that failed.
    """
    nodes = list(plan.nodes())
    if mechanics != "finite-strain" or estimates == "none":
        return PlanPlays(plan, play_nodes(mesh, mechanics, touches, nodes, runner, report_progress), {})
    examples = example_touches([touch.touch for touch in touches])
    chosen = [touches[place] for place in examples]
    single = [node for node in nodes if is_learned(plan, node)]
    learned = single if estimates == "learned" and len(chosen) < len(touches) else []
    not_played = single if estimates == "rough" else learned
    full = [node for node in nodes if is_played(plan, node) and node not in not_played]
    before, total = 0, (len(full) + len(nodes)) * len(touches) + len(learned) * len(chosen)

    def play(of: Mechanics, which: Sequence[Node], some: Sequence[MeasuredTouch]) -> dict[Node, list[Play]]:
        nonlocal before
        plays = play_nodes(
            mesh, of, some, which, runner, lambda done, _, what="": report_progress(before + done, total, what)
        )
        before += len(which) * len(some)
        return plays

    played = play(mechanics, full, touches)
    of_examples = play(mechanics, learned, chosen)
    linear = play("linear", nodes, touches)
    # the other touches, where they can be told from the examples
    middle = middle_node(plan)
    far = []
    for node in learned:
        known = dict(zip(examples, of_examples[node], strict=True))
        answer = learned_nodes(known, played[middle], linear[middle], linear[node])
        if answer.are_close:
            played[node] = answer.plays
        else:
            far.append(node)
    total += len(far) * len(touches)
    played |= play(mechanics, far, touches)
    return PlanPlays(plan, played, linear)


def play_at(
    mesh: PadMesh,
    mechanics: Mechanics,
    touches: Sequence[MeasuredTouch],
    ratio: float,
    friction: float,
    offsets: Array,
) -> list[Play]:
    """Simulate touches at one nu and mu, each at its own contact offset.

    Parameters
    ----------
    mesh : PadMesh
        Mesh of the gel.
    mechanics : str
        Engine and fidelity.
    touches : sequence of MeasuredTouch
        The t touches.
    ratio, friction : float
        Poisson's ratio and coefficient of friction of the gel.
    offsets : (t,) m
        By how much each indenter is deeper than recorded.
    """
    shifted = tuple(touch.deeper(float(offset)) for touch, offset in zip(touches, offsets, strict=True))
    return play_batch(PlayBatch(mesh, mechanics, ratio, friction, shifted))


def play_batch(batch: PlayBatch) -> list[Play]:
    """Return the plays of a batch in its order, simulated with Young's modulus 1 or read from the cache."""
    return played_or_kept(
        batch.touches,
        batch_paths(batch),
        GelMaterial(1.0, batch.ratio, batch.friction),
        lambda: make_engine(batch.mesh, batch.ratio, batch.mechanics),
    )


def batch_paths(batch: PlayBatch) -> list[Path]:
    """Return the cache file of each touch of a batch, in its order."""
    digest = batch.mesh.digest
    return [play_path(touch, digest, batch.mechanics, batch.ratio, batch.friction) for touch in batch.touches]


def played_or_kept(
    touches: Sequence[GelTouch],
    paths: Sequence[Path],
    material: GelMaterial,
    engine: Callable[[], FemEngine | FlexEngine],
) -> list[Play]:
    """Return the plays of touches: those in the cache are read, the others are simulated and added to it.

    Parameters
    ----------
    touches : sequence of GelTouch
        Poses and indenters.
    paths : sequence of Path
        Cache file of each touch.
    material : GelMaterial
        Material of the gel.
    engine : callable
        Makes the engine; called only where a touch must be simulated.
    """
    plays = {number: play for number, path in enumerate(paths) if (play := load_play(path)) is not None}
    to_simulate = [number for number in range(len(paths)) if number not in plays]
    if to_simulate:
        made_engine = engine()
        for place, history in made_engine.play([touches[number] for number in to_simulate], material, keep="none"):
            play = Play(history.wrench, history.status, history.pressed @ made_engine.surface.patch_areas)
            plays[to_simulate[place]] = play
            keep_play(paths[to_simulate[place]], play)
    return [plays[number] for number in range(len(paths))]
