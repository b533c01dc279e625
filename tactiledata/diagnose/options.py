"""The choices of a diagnosis of a store."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tactiledata.calibrate.gent import DIGIT_SHORE_A
from tactiledata.calibrate.options import CalibrationOptions
from tactiledata.diagnose.touches.touch_case import FEWEST_CASES
from tactiledata.effects import EFFECTS
from tactiledata.errors import UnknownName, UsageError
from tactiledata.gel.engines.fem import Fidelity
from tactiledata.replay.plan import MakePad


@dataclass(frozen=True)
class DiagnosisOptions:
    """The choices that decide the result of a diagnosis, beside the store.

    Parameters
    ----------
    trajectories : int
        Number of trajectories that are drawn from the store, indenters in turn; at least ``FEWEST_CASES``.
    fidelity : "finite-strain" or "linear"
        Mechanics of the gel. Effects that change the gel itself are simulated at finite strain only.
    bounds : "paper" or "wide"
        Bounds of nu and mu in the fits. E is free, as an effect may move it far.
    shore_a : float
        Reading of a Shore A durometer; it gives the Young's modulus from which fits start (Gent).
    sensor : str, optional
        Serial number: only trajectories of this sensor are drawn.
    indenters : tuple of str
        Only trajectories of these indenters are drawn; of all where the tuple is empty.
    effects : tuple of str
        Names of candidate effects; the whole catalogue where the tuple is empty.
    pairs : bool
        Whether two effects at once are tried.
    seed : int
        Random seed for drawing trajectories, folds and sign flips.
    workers : int
        Number of processes that play trajectories.
    scheduler : str, optional
        Address of a Dask scheduler that plays them instead; its workers see the same cache folder.
    make_pad : callable, optional
        Makes the mesh of the gel from a sensor model's name and geometry, instead of the built-in one.
    indenter_folder : Path, optional
        Folder of the mesh files that recordings name for their indenters.

    Raises
    ------
    UsageError
        A value is outside its range.
    UnknownName
        An effect is not in the catalogue.
    """

    trajectories: int = 60
    fidelity: Fidelity = "finite-strain"
    bounds: str = "paper"
    shore_a: float = DIGIT_SHORE_A
    sensor: str | None = None
    indenters: tuple[str, ...] = ()
    effects: tuple[str, ...] = ()
    pairs: bool = True
    seed: int = 0
    workers: int = 1
    scheduler: str | None = None
    make_pad: MakePad | None = None
    indenter_folder: Path | None = None

    def __post_init__(self) -> None:
        if self.trajectories < FEWEST_CASES:
            raise UsageError(
                f"trajectories {self.trajectories}", f"at least {FEWEST_CASES}", "Whole trajectories are held out."
            )
        for name in self.effects:
            if name not in EFFECTS:
                raise UnknownName("effect", name, EFFECTS)
        self.calibration()

    def calibration(self) -> CalibrationOptions:
        """Return the choices that concern reading and playing touches, as a calibration takes them.

        Raises
        ------
        UsageError
            A value is outside its range.
        """
        return CalibrationOptions(
            fidelity=self.fidelity,
            bounds=self.bounds,
            trajectories=self.trajectories,
            seed=self.seed,
            shore_a=self.shore_a,
            sensor=self.sensor,
            indenters=self.indenters,
            workers=self.workers,
            scheduler=self.scheduler,
            make_pad=self.make_pad,
            indenter_folder=self.indenter_folder,
        )

    def document(self) -> dict[str, Any]:
        """Return all choices on which the result depends, ready for JSON, as its provenance."""
        names = ("trajectories", "fidelity", "bounds", "shore_a", "sensor", "pairs", "seed")
        return {name: getattr(self, name) for name in names} | {
            "indenters": sorted(self.indenters),
            "effects": sorted(self.effects),
        }
