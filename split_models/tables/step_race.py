"""Methods that draw the same frames in turn, each step on the clock."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from split_models.methods.methods import for_sensor, title_of
from split_models.methods.optical_method import OpticalMethod
from split_models.tables.peak_memory import peak_memory
from split_models.tables.simulated_frames import SimulatedFrames
from tactiledata.arrays import PictureArray
from tactiledata.contract.progress import Progress
from tactiledata.gel.mesh.structured_pad import Resolution

Simulated = Mapping[Resolution, SimulatedFrames]
Steps = list[tuple[str, Callable[[Any], Any]]]
WARM_UP = 3
"""Frames before the clock starts: first ones allocate and choose kernels."""


@dataclass
class Contender:
    """A method at the resolution of the meshes that it is given.

    Parameters
    ----------
    name : str
        Of its row.
    method : MeshToImage
    resolution : "low" or "high"
    seconds : dict
        Of each step, frame by frame.
    pictures : list of (h, w, 3)
    memory : float
        Peak resident memory, MB, of a process that draws with it.
    """

    name: str
    method: Any
    resolution: Resolution
    seconds: dict[str, list[float]] = field(default_factory=dict)
    pictures: list[PictureArray] = field(default_factory=list)
    memory: float = float("nan")

    @property
    def title(self) -> str:
        """For people."""
        return f"{title_of(self.name)}, {self.resolution} resolution"

    @property
    def is_optical(self) -> bool:
        """Whether it draws height maps: then the mesh may have any resolution."""
        return isinstance(self.method, OpticalMethod) or hasattr(self.method, "for_sensor")

    def of_unit(self, sensor: str, simulated: Simulated) -> Any:
        """The method for a unit, on the surface of its resolution."""
        method = for_sensor(self.method, sensor)
        is_optical = isinstance(method, OpticalMethod)
        return replace(method, surface=simulated[self.resolution].surface) if is_optical else method

    def drawing_seconds(self) -> float:
        """Median over frames of all steps together."""
        return float(np.median(np.sum(list(self.seconds.values()), axis=0)))


def contenders(methods: Mapping[str, Any]) -> list[Contender]:
    """Methods that draw height maps at both resolutions, networks at that of their meshes, the low one."""
    found = []
    for name, method in methods.items():
        found.append(Contender(name, method, "low"))
        if found[-1].is_optical:
            found.append(Contender(name, method, "high"))
    return found


def race(
    runners: Sequence[Contender],
    simulated: Simulated,
    frames: Sequence[tuple[int, str]],
    backgrounds: Mapping[str, PictureArray],
    tell: Progress | None = None,
) -> None:
    """Each contender draws each frame, taking turns, so that whatever else the machine does falls on all alike.

    Parameters
    ----------
    runners : sequence of Contender
        Seconds and pictures are written into them.
    simulated : dict
        By resolution.
    frames : sequence of (number, sensor)
        Number of a simulated frame, and the unit whose picture is drawn.
    backgrounds : dict, sensor -> (h, w, 3) uint8
    tell : callable, optional
    """
    ready: dict[tuple[int, str], Steps] = {}
    for turn, (number, sensor) in enumerate([*frames[:WARM_UP], *frames]):
        if tell is not None:
            tell(turn, len(frames) + WARM_UP, "pictures: each method in turn")
        for place, one in enumerate(runners):
            if (place, sensor) not in ready:
                ready[place, sensor] = steps_of(one.of_unit(sensor, simulated), backgrounds[sensor])
            found: Any = simulated[one.resolution].displacements[number][None]
            for name, step in ready[place, sensor]:
                started = time.perf_counter()
                found = step(found)
                if turn >= WARM_UP:
                    one.seconds.setdefault(name, []).append(time.perf_counter() - started)
            if turn >= WARM_UP:
                one.pictures.append(found[0])


def weigh(
    runners: Sequence[Contender], simulated: Simulated, frame: tuple[int, str], backgrounds: Mapping[str, PictureArray]
) -> None:
    """Each contender's memory while it draws a frame, (number, sensor) as in `race`, in a process of its own."""
    number, sensor = frame
    for one in runners:
        moved = simulated[one.resolution].displacements[number][None]
        one.memory = peak_memory(_drawn, one.of_unit(sensor, simulated), moved, backgrounds[sensor])


def steps_of(method: Any, background: PictureArray) -> Steps:
    """What a method does with a displacement (1, k, 3), step by step; a method that does not tell has one step."""
    if hasattr(method, "steps"):
        steps: Steps = method.steps(background)
        return steps
    return [("picture", lambda moved: method.predict(moved, background))]


def _drawn(method: Any, displacement: Any, background: Any) -> None:
    """A picture, step by step, twice: what the first one allocates for good may not be all."""
    steps = steps_of(method, background)
    for _ in range(2):
        found = displacement
        for _, step in steps:
            found = step(found)
