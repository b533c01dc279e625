"""What a user may choose of a store's diagnosis."""

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
    """What shapes a diagnosis, beside the store.

    Parameters
    ----------
    trajectories : int
        Drawn from the store, indenters in turn.
    fidelity : "finite-strain" or "linear"
    bounds : "paper" or "wide"
        In which nu and mu are sought; E is free, as an effect may move it far.
    shore_a : durometer reading, for the start (Gent)
    sensor : str, optional
        Only trajectories of this sensor.
    indenters : tuple of str
        Only trajectories of these; all where it is empty.
    effects : tuple of str
        Candidates; the whole catalogue where it is empty.
    pairs : bool
        Whether two effects at once are tried.
    seed : int
        Of what is drawn, and of folds and chances.
    workers : int
        Processes that play trajectories.
    make_pad : callable, optional
        A pad of one's own for each sensor model.
    indenter_folder : Path, optional
        Where the meshes of indenters lie that recordings name by a path.

    Raises
    ------
    UsageError
        A value outside its range.
    UnknownName
        No such effect.
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
        """The same, for what reads and plays touches.

        Raises
        ------
        UsageError
            A value outside its range.
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
            make_pad=self.make_pad,
            indenter_folder=self.indenter_folder,
        )

    def document(self) -> dict[str, Any]:
        """What the result depends on, for provenance."""
        names = ("trajectories", "fidelity", "bounds", "shore_a", "sensor", "pairs", "seed")
        return {name: getattr(self, name) for name in names} | {
            "indenters": sorted(self.indenters),
            "effects": sorted(self.effects),
        }
