"""The options of a calibration and their allowed ranges."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from tactiledata.calibrate.bounds import find_bounds
from tactiledata.calibrate.gent import DIGIT_SHORE_A, youngs_modulus_of_shore_a
from tactiledata.calibrate.losses import LossName
from tactiledata.errors import UsageError
from tactiledata.gel.engines.fem import Fidelity
from tactiledata.gel.make_engine import EngineName, Mechanics, mechanics_of
from tactiledata.gel.mesh.structured_pad import pad_mesh
from tactiledata.nuisance.numerical import SHAPE_ERROR
from tactiledata.nuisance.offsets import PRIOR
from tactiledata.replay.plan import MakePad

FEWEST = 2
"""Fewest trajectories to fit: a single one cannot disagree with another."""


@dataclass(frozen=True)
class CalibrationOptions:
    """All that decides a calibration, apart from the store.

    Parameters
    ----------
    loss : "vector" or "norm"
        Whitened forces and torques, or the SPLIT paper's difference of force norms.
    engine : "fem" or "mujoco-flex"
        What simulates the gel; the latter is for comparison, see ``FlexEngine``.
    fidelity : "finite-strain" or "linear"
        Strain measure of the FEM engine; linear is a preview.
    bounds : "paper" or "wide"
        The box that is searched.
    trajectories : int
        How many are drawn from the store, those held out included.
    hold_out : float
        Share of them that is not fitted, 0 to below 1.
    seed : int
        Seed of all draws.
    shore_a : float
        Durometer reading of the gel; Gent's formula turns it into the start of the search.
    offset_prior : m
        Standard deviation of each trajectory's contact offset; 0 takes the recorded poses as exact.
    shape_error : float, optional
        Standard deviation, as a share, of the force factor that each indenter has. The default is that of the engine
        and its fidelity; 0 takes the simulation as exact.
    sensor : str, optional
        Only trajectories of this sensor.
    indenters : tuple of str
        Only trajectories of these indenters; empty takes all.
    workers : int
        Processes that simulate trajectories.
    scheduler : str, optional
        Address of a Dask scheduler that simulates them instead; its workers see the same cache folder.
    make_pad : callable, optional
        Makes the pad mesh of a sensor model; structured pads of low resolution by default.
    indenter_folder : Path, optional
        Folder of the mesh files that recordings name by a relative path.

    Raises
    ------
    UsageError
        A value outside its range.
    """

    loss: LossName = "vector"
    engine: EngineName = "fem"
    fidelity: Fidelity = "finite-strain"
    bounds: str = "paper"
    trajectories: int = 25
    hold_out: float = 0.2
    seed: int = 0
    shore_a: float = DIGIT_SHORE_A
    offset_prior: float = PRIOR
    shape_error: float | None = None
    sensor: str | None = None
    indenters: tuple[str, ...] = ()
    workers: int = 1
    scheduler: str | None = None
    make_pad: MakePad | None = None
    indenter_folder: Path | None = None

    def __post_init__(self) -> None:
        find_bounds(self.bounds)
        youngs_modulus_of_shore_a(self.shore_a)
        mechanics_of(self.engine, self.fidelity)
        if self.loss not in ("vector", "norm"):
            raise UsageError(f"loss {self.loss!r}", "vector or norm", "Name one of them.")
        checks = (
            ("trajectories", self.trajectories >= FEWEST, f"at least {FEWEST}"),
            ("hold_out", 0.0 <= self.hold_out < 1.0, "a share, 0 to below 1"),
            ("offset_prior", 0.0 <= self.offset_prior < 1e-3, "metres, 0 to below 0.001"),
            ("shape_error", 0.0 <= self.shape_share < 0.5, "a share, 0 to below 0.5"),
            ("seed", self.seed >= 0, "0 or more"),
        )
        for name, holds, expected in checks:
            if not holds:
                raise UsageError(f"{name} {getattr(self, name)}", expected, "Correct the option.", option=name)

    @property
    def mechanics(self) -> Mechanics:
        """Engine and fidelity that simulate the touches."""
        return mechanics_of(self.engine, self.fidelity)

    @property
    def shape_share(self) -> float:
        """Standard deviation of indenter factors: ``shape_error``, or where it is not given, that of the mechanics."""
        return SHAPE_ERROR[self.mechanics] if self.shape_error is None else self.shape_error

    @property
    def pads(self) -> MakePad:
        """Function that makes the pad mesh of a sensor model."""
        return self.make_pad or partial(pad_mesh, resolution="low")

    def document(self) -> dict[str, Any]:
        """Return the options on which the result depends, for the provenance."""
        names = ("loss", "engine", "fidelity", "bounds", "trajectories", "hold_out", "seed", "shore_a", "offset_prior")
        return {name: getattr(self, name) for name in (*names, "sensor")} | {
            "shape_error": self.shape_share,
            "indenters": sorted(self.indenters),
        }
