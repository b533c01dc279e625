"""What a user may choose of a calibration."""

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
"""Trajectories to fit: fewer cannot disagree."""


@dataclass(frozen=True)
class CalibrationOptions:
    """What shapes a calibration, beside the store.

    Parameters
    ----------
    loss : "vector" or "norm"
    engine : "fem" or "mujoco-flex"
        The latter is for comparison: see ``FlexEngine``.
    fidelity : "finite-strain" or "linear"
    bounds : "paper" or "wide"
    trajectories : int
        Drawn from the store, those held out among them.
    hold_out : share of them that is not fitted, 0 to below 1
    seed : int
        Of what is drawn.
    shore_a : durometer reading, for the start (Gent)
    offset_prior : m
        Standard deviation of each trajectory's contact offset; 0: the recorded poses are taken as they are.
    shape_error : share, optional
        Standard deviation of a factor that the forces of each indenter have in common; that of the engine and its
        fidelity where it is not given, 0: the simulation is taken to be exact.
    sensor : str, optional
        Only trajectories of this sensor.
    indenters : tuple of str
        Only trajectories of these; all where it is empty.
    workers : int
        Processes that play trajectories.
    make_pad : callable, optional
        A pad of one's own for each sensor model, instead of the low-resolution ones.
    indenter_folder : Path, optional
        Where the meshes of indenters lie that recordings name by a path.

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
        for name, holds, wanted in checks:
            if not holds:
                raise UsageError(f"{name} {getattr(self, name)}", wanted, "Correct the option.", option=name)

    @property
    def mechanics(self) -> Mechanics:
        """What plays the touches."""
        return mechanics_of(self.engine, self.fidelity)

    @property
    def shape_share(self) -> float:
        """``shape_error``, or that of what plays the touches."""
        return SHAPE_ERROR[self.mechanics] if self.shape_error is None else self.shape_error

    @property
    def pads(self) -> MakePad:
        """What makes the pads."""
        return self.make_pad or partial(pad_mesh, resolution="low")

    def document(self) -> dict[str, Any]:
        """What the result depends on, for provenance."""
        names = ("loss", "engine", "fidelity", "bounds", "trajectories", "hold_out", "seed", "shore_a", "offset_prior")
        return {name: getattr(self, name) for name in (*names, "sensor")} | {
            "shape_error": self.shape_share,
            "indenters": sorted(self.indenters),
        }
