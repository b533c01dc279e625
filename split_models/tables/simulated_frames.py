"""The same frames of the same touches, simulated on the low- and on the high-resolution pad, with time and memory."""

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
    """A sensor model's gel pad, its material and constitutive law, and the nodes whose displacements are kept.

    Parameters
    ----------
    sensor : str
        Sensor model.
    geometry : GelGeometry
    material : GelMaterial
    fidelity : str
        Constitutive law: finite strain or linear.
    keep : "all" or "surface"
        Nodes whose displacements are kept at low resolution.
    """

    sensor: str
    geometry: GelGeometry
    material: GelMaterial
    fidelity: Fidelity
    keep: Keep

    def engine(self, resolution: Resolution) -> Engine:
        """The simulation of the pad at a resolution; building it is not counted as a frame's time."""
        if resolution == "high":
            return EmbeddedEngine(self.sensor, self.geometry, self.material.poisson_ratio, self.fidelity)
        mesh = pad_mesh(self.sensor, self.geometry, "low")
        return FemEngine(mesh, self.material.poisson_ratio, self.fidelity)


@dataclass
class SimulatedFrames:
    """Frames of touches, simulated at one resolution.

    Parameters
    ----------
    surface : GelSurface
        Surface of the pad, over the kept nodes.
    vertices : int
        Number of vertices of the whole pad.
    seconds : list of float
        Mean time of a solved frame, touch by touch.
    displacements : list of (k, 3), m
        Displacements of each solved frame.
    frames : list of (touch, frame)
        Touch and frame of each displacement.
    memory : float
        Peak resident memory, MB, of a process that builds the pad and plays the first touch.
    """

    surface: GelSurface
    vertices: int
    seconds: list[float] = field(default_factory=list)
    displacements: list[NDArray[np.float32]] = field(default_factory=list)
    frames: list[tuple[int, int]] = field(default_factory=list)
    memory: float = float("nan")


def simulate(
    pad: Pad, touches: Sequence[GelTouch], tell: Progress | None = None, measures_memory: bool = True
) -> dict[Resolution, SimulatedFrames]:
    """Simulated frames by resolution: every touch at both resolutions in turn, with its time.

    At high resolution only the surface's nodes are kept, which is all that pictures need.

    Parameters
    ----------
    pad : Pad
    touches : sequence of GelTouch
        Touches, each played alone.
    tell : callable, optional
        Called with touches done, touches in all, and words.
    measures_memory : bool
        Whether memory is measured as well, in a process of its own for each resolution.
    """
    resolutions: tuple[Resolution, ...] = ("low", "high")
    keeps: dict[Resolution, Keep] = {"low": pad.keep, "high": "surface"}
    engines = {resolution: pad.engine(resolution) for resolution in resolutions}
    simulated = {
        resolution: SimulatedFrames(surface_of_pad(engine.mesh, keeps[resolution]), len(engine.mesh.vertices))
        for resolution, engine in engines.items()
    }
    for resolution, engine in engines.items():
        next(engine.play(touches[:1], pad.material, keeps[resolution]))  # the first call compiles
    for number, touch in enumerate(touches):
        if tell is not None:
            tell(number, len(touches), "simulation: touches at both resolutions")
        for resolution, engine in engines.items():
            started = time.perf_counter()
            _, history = next(engine.play([touch], pad.material, keeps[resolution]))
            seconds = time.perf_counter() - started
            solved = np.flatnonzero(history.status == FrameStatus.SOLVED)
            result = simulated[resolution]
            result.seconds += [seconds / len(solved)] if len(solved) else []
            result.displacements += list(history.displacement[solved])
            result.frames += [(number, int(frame)) for frame in solved]
    for resolution, result in simulated.items() if measures_memory else ():
        result.memory = peak_memory(partial(_played, pad, resolution, touches[0], keeps[resolution]))
    return simulated


def surface_of_pad(mesh: PadMesh, keep: Keep) -> GelSurface:
    """The pad's outer surface, over all nodes or over the surface's nodes."""
    if keep == "all":
        return GelSurface(np.asarray(mesh.vertices, np.float64), mesh.triangles)
    nodes = mesh.surface
    return GelSurface(np.asarray(mesh.vertices[nodes], np.float64), np.searchsorted(nodes, mesh.triangles))


def _played(pad: Pad, resolution: Resolution, touch: GelTouch, keep: Keep) -> Any:
    """History of a touch on a pad that is built for it."""
    return next(pad.engine(resolution).play([touch], pad.material, keep))
