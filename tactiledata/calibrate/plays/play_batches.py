"""Batches of touches that are simulated together, all of them in one run of a scheduler."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from tactiledata.calibrate.plays.kept_plays import Play, keep_play, load_play
from tactiledata.calibrate.plays.play_progress import PlayProgress
from tactiledata.compute.base import Scheduler
from tactiledata.compute.local import LocalScheduler
from tactiledata.contract.progress import Progress, no_progress
from tactiledata.gel.contact.history import GelTouch
from tactiledata.gel.elasticity.material import GelMaterial

if TYPE_CHECKING:
    from tactiledata.gel.engines.fem import FemEngine
    from tactiledata.gel.flex.engine import FlexEngine

EFFORT = 15.0
"""Time of a frame at finite strain, over that of the linear engine, about."""
EASY = 0.475
"""Poisson's ratio up to which a frame at finite strain takes no longer than that; beyond, it takes up to four times."""


class PlayTask(Protocol):
    """Touches that are simulated together by one engine; must pickle."""

    @property
    def touches(self) -> tuple[GelTouch, ...]:
        """Poses and indenter of each touch."""
        ...

    @property
    def paths(self) -> list[Path]:
        """File of the cache in which the play of each touch is kept."""
        ...

    @property
    def words(self) -> str:
        """What the batch simulates, in words."""
        ...

    @property
    def effort(self) -> float:
        """About how long it takes, in frames of the linear engine (`effort_of`)."""
        ...

    def play(self) -> list[Play]:
        """Return the play of each touch, simulated with Young's modulus 1 or read from the cache."""
        ...


def effort_of(touches: Sequence[GelTouch], is_linear: bool, ratio: float) -> float:
    """Return about how long touches take, in frames of the linear engine.

    Parameters
    ----------
    touches : sequence of GelTouch
        Poses and indenters.
    is_linear : bool
        Whether the linear engine simulates them.
    ratio : float
        Poisson's ratio: nearly incompressible gels take longer at finite strain.
    """
    frames = sum(len(touch.poses) for touch in touches)
    return float(frames) if is_linear else frames * EFFORT * max(1.0, (0.5 - EASY) / (0.5 - ratio))


def play_batches(
    batches: Sequence[PlayTask], runner: Scheduler | None = None, report_progress: Progress = no_progress
) -> list[list[Play]]:
    """Return the plays of each batch, in order.

    All batches are tasks of one run, and those that take longest begin first: no worker waits for another before the
    last of them begins. Finished plays are kept in the cache (``TACTILEDATA_CACHE``): an interrupted run goes on where
    it ended.

    Parameters
    ----------
    batches : sequence of PlayTask
        What is simulated.
    runner : Scheduler, optional
        Where the batches run; in this process where it is ``None``.
    report_progress : Progress
        Called with how many plays of touches are finished, how many there are, and what was played last.

    Raises
    ------
    Exception
        The error of a batch that failed.
    """
    order = sorted(range(len(batches)), key=lambda number: -batches[number].effort)
    longest_first = [batches[number] for number in order]
    outcomes = (runner or LocalScheduler()).outcomes(_play, longest_first, len(batches))
    plays: dict[int, list[Play]] = {}
    finished = 0
    # paths are digests, which take their time
    by_batch = [batch.paths for batch in longest_first]
    paths = [path for each in by_batch for path in each]
    efforts = [batch.effort / len(each) for batch, each in zip(longest_first, by_batch, strict=True) for _ in each]
    with PlayProgress(paths, report_progress, efforts) as progress:
        for number, outcome in zip(order, outcomes, strict=True):
            plays[number] = outcome.value
            finished += len(outcome.task.touches)
            progress.finished(finished, outcome.task.words)
    return [plays[number] for number in range(len(batches))]


def _play(batch: PlayTask) -> list[Play]:
    """Return the plays of a batch; workers execute this function."""
    return batch.play()


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
