"""Recording of a scenario: ordinary logs that any reader can take, and the truth in a folder that no reader opens."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from functools import partial
from pathlib import Path
from queue import Empty, Queue
from typing import Literal

from tactiledata.contract.atomic import FULL, REFUSED
from tactiledata.contract.progress import Progress
from tactiledata.contract.worker_pool import shared_queue, worker_died, worker_pool
from tactiledata.errors import SchemaError, TactileDataError, UnknownName, UsageError
from tactiledata.rig.logs.sampling import sample
from tactiledata.rig.logs.truth import write_truth
from tactiledata.rig.logs.write_folder import write_folder
from tactiledata.rig.logs.write_mcap import write_mcap
from tactiledata.rig.motion.touch import TouchPlan
from tactiledata.rig.play import RigSetup
from tactiledata.rig.scenario.generate import touches
from tactiledata.rig.scenario.scenario import Scenario

Form = Literal["mcap", "folder"]
BETWEEN_LOGS_NS = 3600 * 10**9
"""Time between the starts of two logs of a scenario: an hour, in ns."""
TRUTH = "truth"
"""Name of the folder for what only the rig knows."""


def record(
    scenario: Scenario,
    out: Path,
    form: Form = "mcap",
    progress: Progress | None = None,
    workers: int = 1,
) -> list[Path]:
    """Record a scenario and return the paths of its logs, in order: files (``mcap``) or folders (``folder``).

    Each log is there whole or not at all, and the same scenario gives the same bytes. ``out/truth`` holds, per log,
    what only the rig knows; the toolkit never reads it.

    Parameters
    ----------
    scenario : Scenario
        The world to record.
    out : Path
        Folder for the logs; made where it is missing.
    form : "mcap" or "folder"
        Form in which logs are written.
    progress : callable, optional
        Called as ``progress(trajectories done, trajectories in all)``.
    workers : int
        Number of local processes, each at one log at a time; the recordings do not depend on it. A script that asks
        for more than one must do so under ``if __name__ == "__main__":``.

    Raises
    ------
    UnknownName
        The form is unknown.
    SchemaError, MissingFile, UnsafeContent
        An indenter or a background cannot be used, or names collide.
    UsageError
        A pose is out of the arm's reach, or ``out`` is no folder.
    TactileDataError
        ``out`` has no room or may not be written to; or a worker process died.
    """
    if form not in ("mcap", "folder"):
        raise UnknownName("form of a log", form, ("folder", "mcap"))
    groups = log_groups(scenario)
    counts = _Counts(progress, [len(group) for _, group in groups])
    written: list[Path] = []
    try:
        out.mkdir(parents=True, exist_ok=True)
        if workers <= 1 or len(groups) < 2:
            rig_setup = RigSetup(scenario)
            for index in range(len(groups)):
                written.append(_record_log(scenario, out, form, counts.report, index, rig_setup))
        else:
            _record_in_processes(scenario, out, form, counts, workers, written)
    except BrokenProcessPool as error:
        raise worker_died(f"logs of {out}") from error
    except OSError as error:
        if isinstance(error, TactileDataError):
            raise
        kind = TactileDataError if error.errno in (*FULL, *REFUSED) else UsageError
        raise kind(
            f"{error.filename or out} cannot be written: {error.strerror}",
            "a folder to write to, with room in it and names that its file system takes",
            "Make room, or name another folder with --out. Logs that are already there are whole.",
            written=[str(path) for path in written],
        ) from error
    return written


def _record_in_processes(
    scenario: Scenario, out: Path, form: Form, counts: _Counts, workers: int, written: list[Path]
) -> None:
    """Record each log in one of several local processes and append their paths to ``written`` in order."""
    with shared_queue() as counts_queue, worker_pool(workers) as pool:
        report = partial(_send_count, counts_queue)
        waiting = [pool.submit(_record_log, scenario, out, form, report, index) for index in range(len(counts.whole))]
        # counts arrive while the logs are recorded; the rest is in the queue when all are done
        while not all(future.done() for future in waiting):
            with suppress(Empty):
                counts.report(*counts_queue.get(timeout=0.2))
        while not counts_queue.empty():
            counts.report(*counts_queue.get())
        written.extend(future.result() for future in waiting)


def _send_count(counts_queue: Queue[tuple[int, int]], index: int, done: int) -> None:
    """Send from a worker how many trajectories of the log ``index`` are done."""
    counts_queue.put((index, done))


def _record_log(
    scenario: Scenario,
    out: Path,
    form: Form,
    report: Callable[[int, int], None],
    index: int,
    rig_setup: RigSetup | None = None,
) -> Path:
    """Record one log and return its path; ``report`` gets its index and how many of its trajectories are done."""
    rig_setup = rig_setup or RigSetup(scenario)
    name, group = log_groups(scenario)[index]
    meter = _Meter(partial(report, index), len(group))
    start_ns = scenario.start_ns + index * BETWEEN_LOGS_NS
    tape = sample(rig_setup, name, index, rig_setup.play(group, index, start_ns, meter.played))
    meter.pictures = sum(not shot.dropped for shot in tape.shots)
    path = out / (f"{name}.mcap" if form == "mcap" else name)
    (write_mcap if form == "mcap" else write_folder)(tape, path, meter.add)
    write_truth(tape, out / TRUTH)
    report(index, len(group))
    return path


class _Counts:
    """Numbers of trajectories that are done in each log, reported as a sum over all logs.

    Parameters
    ----------
    progress : callable, optional
        Called as ``progress(trajectories done, trajectories in all)``.
    whole : list of int
        Number of trajectories of each log.
    """

    def __init__(self, progress: Progress | None, whole: list[int]) -> None:
        self.progress, self.whole = progress, whole
        self.done = [0] * len(whole)

    def report(self, index: int, done: int) -> None:
        """Note that ``done`` trajectories of the log ``index`` are done, and report the new sum."""
        self.done[index] = done
        if self.progress is not None:
            self.progress(sum(self.done), sum(self.whole))


class _Meter:
    """The count of trajectories of one log that are done: half of each is its contact, half its pictures.

    Parameters
    ----------
    report : callable
        Called with the number of trajectories that are done.
    trajectories : int
        Number of trajectories of the log.
    """

    def __init__(self, report: Callable[[int], None], trajectories: int) -> None:
        self.report, self.trajectories = report, trajectories
        self.pictures = self.drawn = self.solved = 0

    def played(self) -> None:
        """Note that the contact of one more trajectory is solved."""
        self.solved += 1
        self.report(self.solved // 2)

    def add(self, count: int) -> None:
        """Note that ``count`` more pictures are written."""
        self.drawn += count
        drawn = self.trajectories * self.drawn // max(self.pictures, 1)
        self.report((self.trajectories + drawn) // 2)


def log_groups(scenario: Scenario) -> list[tuple[str, Sequence[TouchPlan]]]:
    """Return the name and the touches of each log, as the scenario's ``recordings`` section groups them.

    Touches keep the scenario's order within an indenter, and indenters are mounted one after the other.

    Raises
    ------
    SchemaError
        Two logs, or two trajectories of a log, would have the same name.
    """
    setup = scenario.recordings
    keys: dict[tuple[str, ...], list[TouchPlan]] = {}
    for touch in touches(scenario):
        key = {
            "sensor": (touch.sensor,),
            "sensor_indenter": (touch.sensor, touch.indenter),
            "all": ("recording",),
            "each": (touch.name,),
        }[setup.group]
        keys.setdefault(key, []).append(touch)
    # within a group: indenter after indenter, cut into logs of the stated length
    order = {name: place for place, name in enumerate(scenario.indenters)}
    groups: list[tuple[str, Sequence[TouchPlan]]] = []
    for key, members in keys.items():
        _distinct([touch.name for touch in members], "trajectories of one log")
        members = sorted(members, key=lambda touch: order[touch.indenter])
        parts = range(0, len(members), setup.trajectories_per_log)
        for number, first in enumerate(parts):
            name = "-".join(key) if len(parts) == 1 else f"{'-'.join(key)}-{number:03d}"
            groups.append((name, members[first : first + setup.trajectories_per_log]))
    _distinct([TRUTH, *(name for name, _ in groups)], "logs, or a log and the folder of the truth,")
    return groups


def _distinct(names: Sequence[str], what: str) -> None:
    """Refuse names of which two are the same."""
    twice = [name for name, count in Counter(names).items() if count > 1]
    if twice:
        raise SchemaError(
            f"two {what} would have the name {twice[0]!r}",
            "names of their own",
            "Rename a sensor, an indenter or a trajectory in the scenario.",
            path="$",
        )
