"""Work of one worker: simulate a run of trajectories, and write its rows to files that wait for the commit."""

from __future__ import annotations

import shutil
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactiledata.effects.touch.gel_variants import variant_engine
from tactiledata.effects.touch.response import GelVariant
from tactiledata.gel.contact.history import FrameStatus, GelHistory
from tactiledata.gel.contact.recorder import Keep
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.gel.engines.embedded import EmbeddedEngine
from tactiledata.gel.engines.fem import FemEngine, Fidelity
from tactiledata.replay.effect_rounds import play_with_effects
from tactiledata.replay.effect_touches import EffectTouch
from tactiledata.replay.plan import PlannedPad, PlannedTouch
from tactiledata.replay.status import ReplayStatus
from tactiledata.store.read.meshes import FRAME_ARRAYS, axes_of
from tactiledata.store.read.reader import Store


@dataclass(frozen=True)
class Run:
    """Trajectories that are solved together, with all that a worker needs.

    The grouping does not depend on the number of workers.

    Parameters
    ----------
    store : str
        Location of the store.
    folder : str
        Folder to which the rows are written.
    frames : (first, stop)
        Rows of frames that the run covers, those outside any trajectory included.
    touches : tuple of PlannedTouch
        The trajectories.
    offsets : tuple of float
        How much deeper the indenter of each touch is than recorded, m.
    effects : tuple of EffectTouch
        Inputs of the effects on each touch; ``None`` where none acts.
    pads : tuple of PlannedPad
        Pads of the plan.
    is_interpolated : bool
        Whether pads are interpolated from a solution on low-resolution ones.
    sizes : dict
        Lengths of the mesh's arrays, by name.
    material, fidelity, keep, gap_limit_ns
        As in `ReplayOptions`.
    """

    store: str
    folder: str
    frames: tuple[int, int]
    touches: tuple[PlannedTouch, ...]
    offsets: tuple[float, ...]
    effects: tuple[EffectTouch | None, ...]
    pads: tuple[PlannedPad, ...]
    is_interpolated: bool
    sizes: dict[str, int]
    material: GelMaterial
    fidelity: Fidelity
    keep: Keep
    gap_limit_ns: int

    def __str__(self) -> str:
        return self.touches[-1].name if self.touches else f"frames {self.frames[0]} to {self.frames[1]}"


@dataclass(frozen=True)
class _EngineKey:
    """All on which an engine depends; the pad itself is represented by its digest."""

    digest: str
    law: GelVariant
    poisson_ratio: float
    fidelity: Fidelity
    is_interpolated: bool
    pad: PlannedPad = field(compare=False)


@lru_cache(maxsize=1)
def _engine(key: _EngineKey) -> FemEngine | EmbeddedEngine:
    """Make an engine, or return the last one where the key is the same."""
    # the next run of this process mostly has the same pad, and its factorisation takes as long as a run
    if key.is_interpolated:
        return EmbeddedEngine(key.pad.sensor, key.pad.geometry, key.poisson_ratio, key.fidelity)
    return variant_engine(key.pad.mesh, key.poisson_ratio, key.fidelity, key.law)


def solve_run(run: Run) -> dict[str, str]:
    """Solve a run and return the file of each array of its rows; the files are filled by memory mapping."""
    folder = Path(run.folder)
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    rows = _Rows(folder, run)
    store = Store.open(run.store)
    # one engine for each pad, with all its touches
    for number, pad in enumerate(run.pads):
        chosen = [
            (touch, touch.gel_touch(store, offset, run.gap_limit_ns), effect)
            for touch, offset, effect in zip(run.touches, run.offsets, run.effects, strict=True)
            if touch.obstacle is None and touch.pad == number
        ]
        if chosen:
            engine = _engine(
                _EngineKey(pad.mesh.digest, pad.law, run.material.poisson_ratio, run.fidelity, run.is_interpolated, pad)
            )
            _, touches, effects = zip(*chosen, strict=True)
            for place, history in play_with_effects(engine, touches, effects, run.material, run.keep):
                rows.fill(chosen[place][0], history)
    for touch in run.touches:
        if touch.obstacle is not None:
            rows.refuse(touch)
    return rows.close()


class _Rows:
    """Rows of a run in one file for each array; a row has the status OUTSIDE until it is filled."""

    def __init__(self, folder: Path, run: Run) -> None:
        self._first, stop = run.frames
        count = stop - self._first
        self._paths: dict[str, Path] = {}
        self._arrays: dict[str, NDArray[Any]] = {}
        for array, (dtype, fill, axes) in FRAME_ARRAYS.items():
            path = folder / f"{array}.npy"
            shape = (count, *axes_of({"sizes": run.sizes}, axes))
            values = np.lib.format.open_memmap(path, "w+", dtype, shape)
            values[...] = fill
            self._paths[array], self._arrays[array] = path, values
        self._arrays["status"][...] = ReplayStatus.OUTSIDE

    def _span(self, touch: PlannedTouch) -> slice:
        """Rows of a touch within the run."""
        return slice(touch.frames[0] - self._first, touch.frames[1] - self._first)

    def refuse(self, touch: PlannedTouch) -> None:
        """Record why a touch was not given to the engine."""
        self._arrays["status"][self._span(touch)] = touch.obstacle

    def fill(self, touch: PlannedTouch, history: GelHistory) -> None:
        """Record the engine's answer to a touch; rows without a mesh stay NaN."""
        span, arrays = self._span(touch), self._arrays
        is_free = history.status == FrameStatus.NO_CONTACT
        has_mesh = is_free | (history.status == FrameStatus.SOLVED)
        arrays["status"][span] = history.status
        arrays["displacement"][span] = history.displacement
        arrays["force"][span] = history.node_forces
        arrays["wrench"][span] = history.wrench
        # the residual is relative to the contact force, which is zero in free air
        arrays["residual"][span] = np.where(is_free, 0.0, history.residual)
        arrays["contact"][span] = np.where(has_mesh[:, None], history.pressed, FRAME_ARRAYS["contact"][1])
        arrays["pad"][span] = np.where(has_mesh, touch.pad, -1)

    def close(self) -> dict[str, str]:
        """Write all rows to disk, and return the file of each array."""
        for values in self._arrays.values():
            values.flush()  # type: ignore[attr-defined]
        self._arrays.clear()
        return {array: str(path) for array, path in self._paths.items()}
