"""Playing measured touches through the gel at the nodes of a plan; what was played before is read from disk."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from tactiledata.arrays import Array
from tactiledata.calibrate.kept_plays import Play, keep_play, load_play, play_path
from tactiledata.calibrate.plan import Node
from tactiledata.calibrate.play_progress import PlayProgress
from tactiledata.calibrate.touches import MeasuredTouch
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
    """Touches to be played at one nu and one mu."""

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
    workers: int = 1,
    tell: Progress = no_progress,
) -> dict[Node, list[Play]]:
    """The plays of all touches at each node, in the order of the touches.

    Nodes of one nu and mu are played together, so that more trajectories are in lockstep; batches go to ``workers``
    processes. What is finished is kept (``TACTILEDATA_CACHE``): a run that was killed goes on. ``tell`` hears how many
    plays of touches are finished.
    """
    batches, members = [], []
    for (ratio, friction), group in itertools.groupby(nodes, key=lambda node: (node.poisson_ratio, node.friction)):
        members.append(list(group))
        shifted = tuple(touch.deeper(node.offset) for node in members[-1] for touch in touches)
        batches.append(PlayBatch(mesh, mechanics, ratio, friction, shifted))
    found: dict[Node, list[Play]] = {}
    paths = [path for batch in batches for path in batch_paths(batch)]
    with PlayProgress(paths, tell) as progress:
        for played, outcome in zip(members, LocalScheduler(workers).outcomes(play_batch, batches), strict=True):
            if outcome.error is not None:
                raise outcome.error
            plays = iter(outcome.result or ())
            for node in played:
                found[node] = list(itertools.islice(plays, len(touches)))
            finished = len(found) * len(touches)
            progress.finished(finished, f"nu {outcome.task.ratio:.3f}, mu {outcome.task.friction:.2f}")
    return found


def play_at(
    mesh: PadMesh,
    mechanics: Mechanics,
    touches: Sequence[MeasuredTouch],
    ratio: float,
    friction: float,
    offsets: Array,
) -> list[Play]:
    """The plays of touches, each at an offset (t,), m, of its own."""
    shifted = tuple(touch.deeper(float(offset)) for touch, offset in zip(touches, offsets, strict=True))
    return play_batch(PlayBatch(mesh, mechanics, ratio, friction, shifted))


def play_batch(batch: PlayBatch) -> list[Play]:
    """The plays of a batch, in its order."""
    return played_or_kept(
        batch.touches,
        batch_paths(batch),
        GelMaterial(1.0, batch.ratio, batch.friction),
        lambda: make_engine(batch.mesh, batch.ratio, batch.mechanics),
    )


def batch_paths(batch: PlayBatch) -> list[Path]:
    """Return the files in which the plays of a batch are kept, in its order."""
    digest = batch.mesh.digest
    return [play_path(touch, digest, batch.mechanics, batch.ratio, batch.friction) for touch in batch.touches]


def played_or_kept(
    touches: Sequence[GelTouch],
    paths: Sequence[Path],
    material: GelMaterial,
    engine: Callable[[], FemEngine | FlexEngine],
) -> list[Play]:
    """The plays of touches: those that are kept are read, the others played and kept.

    Parameters
    ----------
    touches : sequence of GelTouch
    paths : sequence of Path
        Where the play of each is kept.
    material : GelMaterial
        Of the gel.
    engine : callable
        Makes the engine, where anything is to be played.
    """
    plays = {number: play for number, path in enumerate(paths) if (play := load_play(path)) is not None}
    missing = [number for number in range(len(paths)) if number not in plays]
    if missing:
        made = engine()
        for place, history in made.play([touches[number] for number in missing], material, keep="none"):
            play = Play(history.wrench, history.status, history.pressed @ made.surface.patch_areas)
            plays[missing[place]] = play
            keep_play(paths[missing[place]], play)
    return [plays[number] for number in range(len(paths))]
