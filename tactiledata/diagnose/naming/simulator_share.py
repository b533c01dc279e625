"""What a fit attributes to errors of the simulation itself, and not to physics."""

from __future__ import annotations

from dataclasses import dataclass

from tactiledata.diagnose.naming.joint_fit import JointFit
from tactiledata.diagnose.residuals.residuals import joined_names
from tactiledata.diagnose.residuals.wording import percent
from tactiledata.diagnose.touches.simulation_errors import KINDS
from tactiledata.diagnose.touches.whitened import WhitenedTouches

TOLD = 0.05
"""An error that a fit attributes to the forces of an indenter is reported if it is at least this share of them."""


@dataclass(frozen=True)
class SimulatorError:
    """One error of the simulation, as a fit has it.

    Parameters
    ----------
    what : str
        The error in words.
    deviations : float
        Fitted size in standard deviations of its prior; positive where the simulated force is too small.
    share : float
        Fitted size as a share of the force; of the growth of force, as a share over a factor e of the force; of the
        centre of pressure, in m. The two errors by a tilt grow with its sine; theirs holds for a sine of 1.
    indenter : str
        Indenter whose forces are off; empty where the error is common to all.
    kind : str
        The error in words, without the indenter.
    """

    what: str
    deviations: float
    share: float
    indenter: str = ""
    kind: str = ""


def simulator_share(whitened: WhitenedTouches, fit: JointFit) -> list[SimulatorError]:
    """Return the size of every error of the simulation in a fit, in standard deviations and as a share of the force.

    There is one entry, however small, for each field of `WhitenedTouches.simulation_error_fields`, in their order.

    Parameters
    ----------
    whitened : WhitenedTouches
        Trajectories of the fit, with the sizes of errors with which it was made.
    fit : JointFit
        Fit to them, with or without effects.
    """
    return [
        SimulatorError(error.label, float(size), float(size) * error.deviation, error.indenter, error.what)
        for error, size in zip(whitened.simulation_errors, fit.model.errors, strict=True)
    ]


def simulator_share_words(errors: list[SimulatorError]) -> list[str]:
    """Return a list with one sentence that names every indenter whose simulated forces are off by at least ``TOLD``.

    Only the error that is one share of all forces of an indenter counts. The list is empty where no indenter's forces
    are off by that much.

    Parameters
    ----------
    errors : list of SimulatorError
        As `simulator_share` returns them.
    """
    large = [error for error in errors if error.kind == KINDS[0].what and abs(error.share) >= TOLD]
    if not large:
        return []
    listed = joined_names([
        f"{percent(abs(error.share))} too {'small' if error.share > 0 else 'large'} under {error.indenter}"
        for error in large
    ])  # fmt: skip
    return [
        f"The fit attributes these errors to the simulation itself: its forces are {listed}. A replay does not correct"
        " them."
    ]
