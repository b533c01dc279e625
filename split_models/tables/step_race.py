"""Times of methods that make pictures of the same frames in turn, step by step, and their memory."""

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
"""Frames before times are measured; the first frames allocate memory and choose kernels."""


@dataclass
class TimedMethod:
    """A method with its measured times, at one resolution of the meshes that it gets.

    Parameters
    ----------
    name : str
        Name of its row.
    method : MeshToImage
    resolution : "low" or "high"
    seconds : dict of list
        Seconds of each step, frame by frame.
    pictures : list of (h, w, 3) uint8
        Pictures of all frames.
    memory : float
        Peak resident memory, MB, of a process that makes a picture.
    """

    name: str
    method: Any
    resolution: Resolution
    seconds: dict[str, list[float]] = field(default_factory=dict)
    pictures: list[PictureArray] = field(default_factory=list)
    memory: float = float("nan")

    @property
    def title(self) -> str:
        """Title for people, with the resolution."""
        return f"{title_of(self.name)}, {self.resolution} resolution"

    @property
    def is_optical(self) -> bool:
        """Whether the method draws height maps, so that the mesh may have any resolution."""
        return isinstance(self.method, OpticalMethod) or hasattr(self.method, "for_sensor")

    def of_unit(self, sensor: str, simulated: Simulated) -> Any:
        """The method for a unit, on the surface of its resolution."""
        method = for_sensor(self.method, sensor)
        is_optical = isinstance(method, OpticalMethod)
        return replace(method, surface=simulated[self.resolution].surface) if is_optical else method

    def drawing_seconds(self) -> float:
        """Median over frames of the seconds of all steps together."""
        return float(np.median(np.sum(list(self.seconds.values()), axis=0)))


def timed_methods(methods: Mapping[str, Any]) -> list[TimedMethod]:
    """Methods to be timed: those that draw height maps at both resolutions, networks at the low one of their meshes."""
    timed = []
    for name, method in methods.items():
        timed.append(TimedMethod(name, method, "low"))
        if timed[-1].is_optical:
            timed.append(TimedMethod(name, method, "high"))
    return timed


def time_methods(
    timed: Sequence[TimedMethod],
    simulated: Simulated,
    frames: Sequence[tuple[int, str]],
    backgrounds: Mapping[str, PictureArray],
    tell: Progress | None = None,
) -> None:
    """Let each method make a picture of each frame, in turn, so that other load on the machine affects all alike.

    Parameters
    ----------
    timed : sequence of TimedMethod
        Methods; their seconds and pictures are filled in.
    simulated : dict
        Simulated frames by resolution.
    frames : sequence of (number, sensor)
        Number of a simulated frame, and the sensor whose picture is made.
    backgrounds : dict of (h, w, 3) uint8
        Background of each sensor.
    tell : callable, optional
        Called with frames done, frames in all, and words.
    """
    ready: dict[tuple[int, str], Steps] = {}
    for turn, (number, sensor) in enumerate([*frames[:WARM_UP], *frames]):
        if tell is not None:
            tell(turn, len(frames) + WARM_UP, "pictures: each method in turn")
        for place, method in enumerate(timed):
            if (place, sensor) not in ready:
                ready[place, sensor] = steps_of(method.of_unit(sensor, simulated), backgrounds[sensor])
            result: Any = simulated[method.resolution].displacements[number][None]
            for name, step in ready[place, sensor]:
                started = time.perf_counter()
                result = step(result)
                if turn >= WARM_UP:
                    method.seconds.setdefault(name, []).append(time.perf_counter() - started)
            if turn >= WARM_UP:
                method.pictures.append(result[0])


def measure_memory(
    timed: Sequence[TimedMethod], simulated: Simulated, frame: tuple[int, str], backgrounds: Mapping[str, PictureArray]
) -> None:
    """Measure each method's memory while it makes a picture, in a process of its own.

    Parameters
    ----------
    timed : sequence of TimedMethod
        Methods; their memory is filled in.
    simulated : dict
        Simulated frames by resolution.
    frame : (number, sensor)
        Number of a simulated frame, and the sensor whose picture is made.
    backgrounds : dict of (h, w, 3) uint8
        Background of each sensor.
    """
    number, sensor = frame
    for method in timed:
        moved = simulated[method.resolution].displacements[number][None]
        method.memory = peak_memory(_drawn, method.of_unit(sensor, simulated), moved, backgrounds[sensor])


def steps_of(method: Any, background: PictureArray) -> Steps:
    """Named steps of a method for a displacement (1, k, 3); a method without ``steps`` has a single one."""
    if hasattr(method, "steps"):
        steps: Steps = method.steps(background)
        return steps
    return [("picture", lambda moved: method.predict(moved, background))]


def _drawn(method: Any, displacement: Any, background: Any) -> None:
    """Make a picture step by step, twice: the first may not allocate all memory that stays allocated."""
    steps = steps_of(method, background)
    for _ in range(2):
        result = displacement
        for _, step in steps:
            result = step(result)
