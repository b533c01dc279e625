"""Simulation of measured touches at the nodes of a plan; touches simulated before are read from the cache."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from tactiledata.arrays import Array
from tactiledata.calibrate.plan import Node, ResponsePlan
from tactiledata.calibrate.plays.estimated_plays import (
    Estimates,
    estimated_node,
    is_learned,
    is_played,
    middle_node,
)
from tactiledata.calibrate.plays.kept_plays import Play, play_path
from tactiledata.calibrate.plays.learned_plays import example_touches, learned_nodes
from tactiledata.calibrate.plays.play_batches import PlayTask, effort_of, play_batches, played_or_kept
from tactiledata.calibrate.touches import MeasuredTouch
from tactiledata.compute.base import Scheduler
from tactiledata.contract.progress import Progress, following, no_progress
from tactiledata.gel.contact.history import GelTouch
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.gel.make_engine import Mechanics, make_engine
from tactiledata.gel.mesh.pad import PadMesh

MOST_TOGETHER = 16
"""Touches at their own offsets that are simulated together, at most: workers share them."""


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

    def __str__(self) -> str:
        return f"plays of {len(self.touches)} touches at {self.words}"

    @property
    def paths(self) -> list[Path]:
        """Cache file of each touch, in order."""
        digest = self.mesh.digest
        return [play_path(touch, digest, self.mechanics, self.ratio, self.friction) for touch in self.touches]

    @property
    def words(self) -> str:
        """Poisson's ratio and friction, in words."""
        return f"nu {self.ratio:.3f}, mu {self.friction:.2f}"

    @property
    def effort(self) -> float:
        """About how long it takes, in frames of the linear engine."""
        return effort_of(self.touches, self.mechanics == "linear", self.ratio)

    def play(self) -> list[Play]:
        """Return the plays in order, simulated with Young's modulus 1 or read from the cache."""
        return played_or_kept(
            self.touches,
            self.paths,
            GelMaterial(1.0, self.ratio, self.friction),
            lambda: make_engine(self.mesh, self.ratio, self.mechanics),
        )


@dataclass(frozen=True)
class NodeRequest:
    """Touches that are simulated at some nodes, those of one nu and mu together: more of them advance in lockstep.

    Parameters
    ----------
    mechanics : str
        Engine and fidelity.
    touches : sequence of MeasuredTouch
        Poses and indenters.
    nodes : sequence of Node
        Nodes of one nu and mu must follow one another.
    """

    mechanics: Mechanics
    touches: Sequence[MeasuredTouch]
    nodes: Sequence[Node]

    @property
    def groups(self) -> list[list[Node]]:
        """Nodes of each pair of nu and mu."""
        grouped = itertools.groupby(self.nodes, key=lambda node: (node.poisson_ratio, node.friction))
        return [list(group) for _, group in grouped]

    def batches(self, mesh: PadMesh) -> list[PlayBatch]:
        """Return one batch for each pair of nu and mu: its touches at all its offsets."""
        batches = []
        for group in self.groups:
            shifted = tuple(touch.deeper(node.offset) for node in group for touch in self.touches)
            batches.append(PlayBatch(mesh, self.mechanics, group[0].poisson_ratio, group[0].friction, shifted))
        return batches

    def by_node(self, plays: Iterator[list[Play]]) -> dict[Node, list[Play]]:
        """Return the plays of each node in the order of the touches, taken from those of the batches in order."""
        found: dict[Node, list[Play]] = {}
        for group in self.groups:
            of_batch = iter(next(plays))
            found |= {node: list(itertools.islice(of_batch, len(self.touches))) for node in group}
        return found


def play_requests(
    mesh: PadMesh,
    requests: Sequence[NodeRequest],
    beside: Sequence[PlayTask] = (),
    runner: Scheduler | None = None,
    report_progress: Progress = no_progress,
) -> tuple[list[dict[Node, list[Play]]], list[list[Play]]]:
    """Return the plays of each request by its nodes, and those of further batches that are simulated beside them.

    Parameters
    ----------
    mesh : PadMesh
        Mesh of the gel.
    requests : sequence of NodeRequest
        Touches and nodes.
    beside : sequence of PlayTask
        Further batches.
    runner : Scheduler, optional
        Where all batches run; in this process where it is ``None``.
    report_progress : Progress
        Called with the number of finished plays of touches, their total and a label.

    Raises
    ------
    Exception
        The error of a batch that failed.
    """
    of_requests: list[PlayTask] = [batch for request in requests for batch in request.batches(mesh)]
    plays = iter(play_batches([*of_requests, *beside], runner, report_progress))
    return [request.by_node(plays) for request in requests], list(plays)


def play_nodes(
    mesh: PadMesh,
    mechanics: Mechanics,
    touches: Sequence[MeasuredTouch],
    nodes: Sequence[Node],
    runner: Scheduler | None = None,
    report_progress: Progress = no_progress,
) -> dict[Node, list[Play]]:
    """Simulate all touches at each node, and return the plays of each node in the order of the touches.

    Parameters
    ----------
    mesh : PadMesh
        Mesh of the gel.
    mechanics, touches, nodes
        See `NodeRequest`.
    runner, report_progress
        See `play_requests`; its errors as well.
    """
    (plays,), _ = play_requests(mesh, [NodeRequest(mechanics, touches, nodes)], (), runner, report_progress)
    return plays


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
) -> PlanPlays:
    """Simulate all touches at the nodes of a plan; see `play_plan_beside`.

    Parameters
    ----------
    mesh, mechanics, touches, plan, runner, report_progress
        See `play_plan_beside`.
    """
    return play_plan_beside(mesh, mechanics, touches, plan, (), runner, report_progress)[0]


def play_plan_beside(
    mesh: PadMesh,
    mechanics: Mechanics,
    touches: Sequence[MeasuredTouch],
    plan: ResponsePlan,
    beside: Sequence[PlayTask],
    runner: Scheduler | None = None,
    report_progress: Progress = no_progress,
    estimates: Estimates = "learned",
) -> tuple[PlanPlays, list[list[Play]]]:
    """Simulate all touches at the nodes of a plan, and further batches beside them; return the plays of both.

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
    beside : sequence of PlayTask
        Further batches.
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
        every = NodeRequest(mechanics, touches, nodes)
        (played,), of_beside = play_requests(mesh, [every], beside, runner, report_progress)
        return PlanPlays(plan, played, {}), of_beside
    examples = example_touches([touch.touch for touch in touches])
    chosen = [touches[place] for place in examples]
    single = [node for node in nodes if is_learned(plan, node)]
    learned = single if estimates == "learned" and len(chosen) < len(touches) else []
    not_played = single if estimates == "rough" else learned
    full = [node for node in nodes if is_played(plan, node) and node not in not_played]
    requests = [
        NodeRequest(mechanics, touches, full),
        NodeRequest(mechanics, chosen, learned),
        NodeRequest("linear", touches, nodes),
    ]
    (played, of_examples, linear), of_beside = play_requests(mesh, requests, beside, runner, report_progress)
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
    if far:
        finished = sum(len(request.touches) * len(request.nodes) for request in requests)
        finished += sum(len(batch.touches) for batch in beside)
        played |= play_nodes(mesh, mechanics, touches, far, runner, following(report_progress, finished))
    return PlanPlays(plan, played, linear), of_beside


def play_at(
    mesh: PadMesh,
    mechanics: Mechanics,
    touches: Sequence[MeasuredTouch],
    ratio: float,
    friction: float,
    offsets: Array,
    runner: Scheduler | None = None,
    most_together: int = MOST_TOGETHER,
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
    runner : Scheduler, optional
        Where the touches are simulated; in this process where it is ``None``.
    most_together : int
        Touches that are simulated in one batch, at most: fewer are dealt out more evenly to several workers.
    """
    shifted = tuple(touch.deeper(float(offset)) for touch, offset in zip(touches, offsets, strict=True))
    parts = max(1, -(-len(shifted) // most_together))
    batches = [PlayBatch(mesh, mechanics, ratio, friction, shifted[part::parts]) for part in range(parts)]
    # the touches were dealt out to the parts in turn
    plays = [iter(of_part) for of_part in play_batches(batches, runner)]
    return [next(plays[number % parts]) for number in range(len(shifted))]
