"""A scenario recorded: ordinary logs that any reader can take, and the truth in a folder that no reader opens."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Literal

from tactiledata.errors import UnknownName, UsageError
from tactiledata.rig.generate import touches
from tactiledata.rig.play import Stage
from tactiledata.rig.sampling import sample
from tactiledata.rig.scenario import Scenario, Touch
from tactiledata.rig.truth import write_truth
from tactiledata.rig.write_folder import write_folder
from tactiledata.rig.write_mcap import write_mcap

Form = Literal["mcap", "folder"]
BETWEEN_LOGS_NS = 3600 * 10**9
"""Logs of one scenario start an hour apart."""
TRUTH = "truth"


def record(
    scenario: Scenario, out: Path, form: Form = "mcap", progress: Callable[[int, int], None] | None = None
) -> list[Path]:
    """The logs of a scenario, in order: files (``mcap``) or folders (``folder``) in ``out``.

    Each log is there whole or not at all, and the same scenario gives the same bytes. ``out/truth`` holds, per log,
    what only the rig knows; the toolkit never reads it.

    Parameters
    ----------
    scenario : Scenario
    out : Path
        Made where it is not there.
    form : "mcap" or "folder"
    progress : callable, optional
        Called as ``progress(pictures done, pictures in all)``; the total grows as logs are planned.

    Raises
    ------
    UnknownName
        No such form.
    UsageError
        A pose out of the arm's reach, no place to write.
    """
    if form not in ("mcap", "folder"):
        raise UnknownName("form of a log", form, ("folder", "mcap"))
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UsageError(
            f"{out} cannot be made: {error.strerror}", "a folder to write to", "Name another with --out."
        ) from error
    stage = Stage(scenario)
    counter = _Counter(progress)
    paths = []
    for index, (name, group) in enumerate(log_groups(scenario)):
        start_ns = scenario.start_ns + index * BETWEEN_LOGS_NS
        tape = sample(stage, name, index, stage.perform(group, index, start_ns))
        counter.total += sum(not shot.dropped for shot in tape.shots)
        path = out / (f"{name}.mcap" if form == "mcap" else name)
        (write_mcap if form == "mcap" else write_folder)(tape, path, counter.add)
        write_truth(tape, out / TRUTH)
        paths.append(path)
    return paths


class _Counter:
    """Pictures done and planned, passed on to whoever watches."""

    def __init__(self, progress: Callable[[int, int], None] | None) -> None:
        self.progress = progress
        self.done = 0
        self.total = 0

    def add(self, count: int) -> None:
        self.done += count
        if self.progress is not None:
            self.progress(self.done, self.total)


def log_groups(scenario: Scenario) -> Iterator[tuple[str, Sequence[Touch]]]:
    """Name and touches of each log, as ``recordings`` groups them.

    Touches keep the scenario's order within an indenter, and indenters are mounted one after the other.
    """
    setup = scenario.recordings
    keys: dict[str, list[Touch]] = {}
    for touch in touches(scenario):
        key = {
            "sensor": touch.sensor,
            "sensor_indenter": f"{touch.sensor}-{touch.indenter}",
            "all": "recording",
            "each": touch.name,
        }[setup.group]
        keys.setdefault(key, []).append(touch)
    order = {name: place for place, name in enumerate(scenario.indenters)}
    for key, members in keys.items():
        members = sorted(members, key=lambda touch: order[touch.indenter])
        parts = range(0, len(members), setup.trajectories_per_log)
        for number, first in enumerate(parts):
            name = key if len(parts) == 1 else f"{key}-{number:03d}"
            yield name, members[first : first + setup.trajectories_per_log]
