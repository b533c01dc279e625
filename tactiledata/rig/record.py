"""A scenario recorded: ordinary logs that any reader can take, and the truth in a folder that no reader opens."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Literal

from tactiledata.errors import SchemaError, TactileDataError, UnknownName, UsageError
from tactiledata.rig.generate import touches
from tactiledata.rig.play import Stage
from tactiledata.rig.sampling import sample
from tactiledata.rig.scenario import Scenario
from tactiledata.rig.touch import Touch
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
        Called as ``progress(trajectories done, trajectories in all)``.

    Raises
    ------
    UnknownName
        No such form.
    SchemaError, MissingFile, UnsafeContent
        An indenter or a background that is none, names that collide.
    UsageError
        A pose out of the arm's reach, no place to write.
    """
    if form not in ("mcap", "folder"):
        raise UnknownName("form of a log", form, ("folder", "mcap"))
    groups = log_groups(scenario)
    stage = Stage(scenario)
    meter = _Meter(progress, sum(len(group) for _, group in groups))
    paths = []
    try:
        out.mkdir(parents=True, exist_ok=True)
        for index, (name, group) in enumerate(groups):
            start_ns = scenario.start_ns + index * BETWEEN_LOGS_NS
            tape = sample(stage, name, index, stage.perform(group, index, start_ns))
            meter.begin(len(group), sum(not shot.dropped for shot in tape.shots))
            path = out / (f"{name}.mcap" if form == "mcap" else name)
            (write_mcap if form == "mcap" else write_folder)(tape, path, meter.add)
            write_truth(tape, out / TRUTH)
            paths.append(path)
    except OSError as error:
        if isinstance(error, TactileDataError):
            raise
        raise UsageError(
            f"{error.filename or out} cannot be written: {error.strerror}",
            "a folder to write to, with room in it and names that its file system takes",
            "Name another with --out. Logs that are there are whole.",
            written=[str(path) for path in paths],
        ) from error
    return paths


class _Meter:
    """Trajectories done, counted by their pictures, passed on to whoever watches."""

    def __init__(self, progress: Callable[[int, int], None] | None, total: int) -> None:
        self.progress = progress
        self.total = total
        self.before = self.here = self.pictures = self.drawn = 0

    def begin(self, trajectories: int, pictures: int) -> None:
        """A log of so many trajectories and pictures begins."""
        self.before += self.here
        self.here, self.pictures, self.drawn = trajectories, pictures, 0

    def add(self, count: int) -> None:
        """So many pictures more are written."""
        self.drawn += count
        if self.progress is not None:
            self.progress(self.before + self.here * self.drawn // max(self.pictures, 1), self.total)


def log_groups(scenario: Scenario) -> list[tuple[str, Sequence[Touch]]]:
    """Name and touches of each log, as ``recordings`` groups them.

    Touches keep the scenario's order within an indenter, and indenters are mounted one after the other.

    Raises
    ------
    SchemaError
        Two logs, or two trajectories of a log, would have one name.
    """
    setup = scenario.recordings
    keys: dict[tuple[str, ...], list[Touch]] = {}
    for touch in touches(scenario):
        key = {
            "sensor": (touch.sensor,),
            "sensor_indenter": (touch.sensor, touch.indenter),
            "all": ("recording",),
            "each": (touch.name,),
        }[setup.group]
        keys.setdefault(key, []).append(touch)
    order = {name: place for place, name in enumerate(scenario.indenters)}
    groups: list[tuple[str, Sequence[Touch]]] = []
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
    twice = [name for name, count in Counter(names).items() if count > 1]
    if twice:
        raise SchemaError(
            f"two {what} would have the name {twice[0]!r}",
            "names of their own",
            "Rename a sensor, an indenter or a trajectory in the scenario.",
            path="$",
        )
