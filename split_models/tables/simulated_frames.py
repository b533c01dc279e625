"""The same frames of the same touches on the low- and on the high-resolution pad, with what they cost."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from split_models.tables.peak_memory import peak_memory
from tactiledata.contract.progress import Progress
from tactiledata.gel.contact.history import FrameStatus, GelTouch
from tactiledata.gel.contact.recorder import Keep
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.gel.engines.embedded import EmbeddedEngine
from tactiledata.gel.engines.fem import FemEngine, Fidelity
from tactiledata.gel.mesh.pad import PadMesh
from tactiledata.gel.mesh.structured_pad import Resolution, pad_mesh
from tactiledata.optics.surface import GelSurface
from tactiledata.sensors.base import GelGeometry

Engine = FemEngine | EmbeddedEngine


@dataclass(frozen=True)
class Pad:
    """What is simulated: a sensor model's pad, its material and law, and which nodes' displacements are kept."""

    sensor: str
    geometry: GelGeometry
    material: GelMaterial
    fidelity: Fidelity
    keep: Keep

    def engine(self, resolution: Resolution) -> Engine:
        """What simulates it; building it is no frame's work."""
        if resolution == "high":
            return EmbeddedEngine(self.sensor, self.geometry, self.material.poisson_ratio, self.fidelity)
        mesh = pad_mesh(self.sensor, self.geometry, "low")
        return FemEngine(mesh, self.material.poisson_ratio, self.fidelity)


@dataclass
class SimulatedFrames:
    """Frames of touches at one resolution.

    Parameters
    ----------
    surface : GelSurface
        Of the pad, over the nodes that are kept.
    vertices : int
        Of the whole pad.
    seconds : list
        A solved frame, touch by touch.
    displacements : list of (k, 3), m
    frames : list of (touch, frame)
        What each displacement is of.
    memory : float
        Peak resident memory, MB, of a process that sets the pad up and plays the first touch.
    """

    surface: GelSurface
    vertices: int
    seconds: list[float] = field(default_factory=list)
    displacements: list[NDArray[np.float32]] = field(default_factory=list)
    frames: list[tuple[int, int]] = field(default_factory=list)
    memory: float = float("nan")


def simulate(
    pad: Pad, touches: Sequence[GelTouch], tell: Progress | None = None, weighs: bool = True
) -> dict[Resolution, SimulatedFrames]:
    """Every touch at both resolutions in turn, each alone, its frames one after the other.

    At high resolution the surface's nodes are kept, which is all that pictures need. ``weighs``: memory as well, each
    resolution in a process of its own.
    """
    resolutions: tuple[Resolution, ...] = ("low", "high")
    keeps: dict[Resolution, Keep] = {"low": pad.keep, "high": "surface"}
    engines = {resolution: pad.engine(resolution) for resolution in resolutions}
    found = {
        resolution: SimulatedFrames(surface_of_pad(engine.mesh, keeps[resolution]), len(engine.mesh.vertices))
        for resolution, engine in engines.items()
    }
    for resolution, engine in engines.items():
        next(engine.play(touches[:1], pad.material, keeps[resolution]))  # the first one compiles
    for number, touch in enumerate(touches):
        if tell is not None:
            tell(number, len(touches), "simulation: touches at both resolutions")
        for resolution, engine in engines.items():
            started = time.perf_counter()
            _, history = next(engine.play([touch], pad.material, keeps[resolution]))
            seconds = time.perf_counter() - started
            solved = np.flatnonzero(history.status == FrameStatus.SOLVED)
            one = found[resolution]
            one.seconds += [seconds / len(solved)] if len(solved) else []
            one.displacements += list(history.displacement[solved])
            one.frames += [(number, int(frame)) for frame in solved]
    for resolution, one in found.items() if weighs else ():
        one.memory = peak_memory(partial(_played, pad, resolution, touches[0], keeps[resolution]))
    return found


def surface_of_pad(mesh: PadMesh, keep: Keep) -> GelSurface:
    """The outer surface over all nodes, or over those of the surface."""
    if keep == "all":
        return GelSurface(np.asarray(mesh.vertices, np.float64), mesh.triangles)
    nodes = mesh.surface
    return GelSurface(np.asarray(mesh.vertices[nodes], np.float64), np.searchsorted(nodes, mesh.triangles))


def _played(pad: Pad, resolution: Resolution, touch: GelTouch, keep: Keep) -> Any:
    return next(pad.engine(resolution).play([touch], pad.material, keep))
