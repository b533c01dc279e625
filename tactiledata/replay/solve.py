"""A run of trajectories through the gel, into files that wait for their commit; what a worker executes."""

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
    """Some trajectories, solved together; how they are grouped does not depend on the number of workers.

    Parameters
    ----------
    store : str
    folder : str
        Where the rows are written.
    frames : (first, stop)
        Rows of frames that the run covers, those outside any trajectory included.
    touches : tuple of PlannedTouch
    offsets : tuple of float
        m, of each touch: how much deeper the indenter is than recorded.
    effects : tuple of EffectTouch
        Of each touch; ``None`` where nothing acts on it.
    pads : tuple of PlannedPad
    is_carried : bool
        Whether the pads are carried by the solution on low-resolution ones.
    sizes : dict
        Lengths of the mesh's arrays.
    material, fidelity, keep, gap_limit_ns : see `ReplayOptions`
    """

    store: str
    folder: str
    frames: tuple[int, int]
    touches: tuple[PlannedTouch, ...]
    offsets: tuple[float, ...]
    effects: tuple[EffectTouch | None, ...]
    pads: tuple[PlannedPad, ...]
    is_carried: bool
    sizes: dict[str, int]
    material: GelMaterial
    fidelity: Fidelity
    keep: Keep
    gap_limit_ns: int

    def __str__(self) -> str:
        return self.touches[-1].name if self.touches else f"frames {self.frames[0]} to {self.frames[1]}"


@dataclass(frozen=True)
class _EngineKey:
    """What an engine is known by."""

    digest: str
    law: GelVariant
    poisson_ratio: float
    fidelity: Fidelity
    is_carried: bool
    pad: PlannedPad = field(compare=False)


@lru_cache(maxsize=1)
def _engine(key: _EngineKey) -> FemEngine | EmbeddedEngine:
    # the next run of this process mostly has the same pad, and to factorise it takes as long as to solve a run
    if key.is_carried:
        return EmbeddedEngine(key.pad.sensor, key.pad.geometry, key.poisson_ratio, key.fidelity)
    return variant_engine(key.pad.mesh, key.poisson_ratio, key.fidelity, key.law)


def solve_run(run: Run) -> dict[str, str]:
    """The files of a run's rows, by array; rows are mapped from the disk while they are filled."""
    folder = Path(run.folder)
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    rows = _Rows(folder, run)
    store = Store.open(run.store)
    for number, pad in enumerate(run.pads):
        chosen = [
            (touch, touch.gel_touch(store, offset, run.gap_limit_ns), effect)
            for touch, offset, effect in zip(run.touches, run.offsets, run.effects, strict=True)
            if touch.obstacle is None and touch.pad == number
        ]
        if chosen:
            engine = _engine(
                _EngineKey(pad.mesh.digest, pad.law, run.material.poisson_ratio, run.fidelity, run.is_carried, pad)
            )
            _, touches, effects = zip(*chosen, strict=True)
            for place, history in play_with_effects(engine, touches, effects, run.material, run.keep):
                rows.fill(chosen[place][0], history)
    for touch in run.touches:
        if touch.obstacle is not None:
            rows.refuse(touch)
    return rows.close()


class _Rows:
    """The rows of a run, in files of their own; all of them lie outside any trajectory until they are filled."""

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
        return slice(touch.frames[0] - self._first, touch.frames[1] - self._first)

    def refuse(self, touch: PlannedTouch) -> None:
        """A touch that the engine was not asked for."""
        self._arrays["status"][self._span(touch)] = touch.obstacle

    def fill(self, touch: PlannedTouch, history: GelHistory) -> None:
        """What the engine answered; rows without a mesh stay NaN."""
        span, arrays = self._span(touch), self._arrays
        is_free = history.status == FrameStatus.NO_CONTACT
        has_mesh = is_free | (history.status == FrameStatus.SOLVED)
        arrays["status"][span] = history.status
        arrays["displacement"][span] = history.displacement
        arrays["force"][span] = history.node_forces
        arrays["wrench"][span] = history.wrench
        # without a contact force there is nothing to compare what is unbalanced with
        arrays["residual"][span] = np.where(is_free, 0.0, history.residual)
        arrays["contact"][span] = np.where(has_mesh[:, None], history.pressed, FRAME_ARRAYS["contact"][1])
        arrays["pad"][span] = np.where(has_mesh, touch.pad, -1)

    def close(self) -> dict[str, str]:
        """All rows are in their files."""
        for values in self._arrays.values():
            values.flush()  # type: ignore[attr-defined]
        self._arrays.clear()
        return {array: str(path) for array, path in self._paths.items()}
