"""Whether a force sensor reads the acceleration of the tool, from readings in free air, where nothing touches.

Before a touch the arm starts, moves and stops. A tool of mass m that swings on the arm with a frequency f then loads
the sensor with -m a, a its acceleration. No force of a gel and no error of a simulation is in these readings.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.residuals.wording import p_words, quantity
from tactiledata.effects.touch.felt_acceleration import FREQUENCIES

DRAWS = 999
"""Sign flips of trajectories in the test: the smallest p-value is 1 / 1000."""
LEVEL = 0.001
"""Largest p-value at which inertia is reported: no sign flip may do as well. Each diagnosis asks, and of 700 worlds
without inertia six were below 0.01."""
CERTAIN = 4.0
"""Least ratio of the mass to its standard error between trajectories at which it is reported."""
FEWEST = 14
"""Fewest trajectories with moves in free air: of fewer, too many sign flips are all alike to reach ``LEVEL``."""
MOST_BLUR = 0.7
"""Largest share of the squares of an acceleration that noise of the positions may have."""
FEWEST_READINGS = 10
"""Fewest readings of a stretch of free air."""


@dataclass(frozen=True)
class FreeAirMoves:
    """Readings of a force sensor in one stretch of free air, and the acceleration of a tool that swings on the arm.

    Parameters
    ----------
    trajectory : int
        Number of the trajectory.
    seconds : (m,) s
        Times of the readings.
    force : (m, 3) N
        Load on the sensor without the weight of the tool, in any frame.
    acceleration : (m, f, 3) m/s^2
        Of the tool in the same frame, for each frequency of ``FREQUENCIES``.
    blur : (f,) m^2/s^4
        Variance that noise of the positions gives to a component of these accelerations.
    """

    trajectory: int
    seconds: Array
    force: Array
    acceleration: Array
    blur: Array


@dataclass(frozen=True)
class FreeAirInertia:
    """Mass with which a tool loads the force sensor when it accelerates in free air.

    Parameters
    ----------
    mass, error : kg
        Mass between the sensor and the contact, and its standard error between trajectories at that frequency. Slow
        moves with noise in the positions hardly tell the frequency, and the mass with it: it may be twice as large.
    frequency : Hz
        Of the arm's mode on which the tool swings, as far as the moves tell it.
    p : float
        p-value by sign flips of whole trajectories, over all frequencies that were tried.
    """

    mass: float
    error: float
    frequency: float
    p: float

    @property
    def words(self) -> str:
        """What was found, as sentences for the user."""
        return (
            f"In free air, the force sensor reads how the tool accelerates, as one whose mass is of the order of"
            f" {quantity(self.mass, 'kg')} ({p_words(self.p)}). Forces just after starts and stops of the"
            " arm contain it as well."
        )

    @property
    def document(self) -> dict[str, object]:
        """The inertia as it stands in ``diagnosis.json`` (schemas/diagnosis.json)."""
        values = {"mass": self.mass, "error": self.error, "frequency": self.frequency, "p": self.p}
        return {"effect": "inertia", "values": values, "words": self.words}


def find_inertia(moves: Sequence[FreeAirMoves], seed: int = 0) -> FreeAirInertia | None:
    """Return the inertia that readings in free air show; ``None`` where they show none.

    The mass is fitted by least squares for each frequency, and the frequency is taken at which its ratio to the
    standard error is largest. What noise of the positions adds to the squares of the acceleration is taken off: it
    would make the mass look smaller (errors in variables; W. A. Fuller, Measurement Error Models, 1987, ch. 1). The
    error follows from how much trajectories differ, so that neither memory of the noise nor what else moves with the
    arm makes it too small; it is that at one frequency.

    Parameters
    ----------
    moves : sequence of FreeAirMoves
        Stretches of free air. A mean and a slope in time are taken off each.
    seed : int
        Random seed of the sign flips.
    """
    long_enough = [one for one in moves if len(one.seconds) >= FEWEST_READINGS]
    numbers = np.unique([one.trajectory for one in long_enough])
    if len(numbers) < FEWEST:
        return None
    # products of acceleration with load and with itself, and what noise adds to these, summed over each trajectory
    pulls, squares, blurs = np.zeros((3, len(numbers), len(FREQUENCIES)))
    for one in long_enough:
        row = int(np.searchsorted(numbers, one.trajectory))
        force, acceleration = (_without_line(one.seconds, rows) for rows in (one.force, one.acceleration))
        pulls[row] -= np.einsum("mfi,mi->f", acceleration, force)
        squares[row] += (acceleration**2).sum(axis=(0, 2))
        blurs[row] += 3.0 * len(force) * one.blur
    # frequencies at which positions show more acceleration than their noise does
    shown = np.flatnonzero(blurs.sum(axis=0) < MOST_BLUR * squares.sum(axis=0))
    if not len(shown):
        return None
    pulls, squares = pulls[:, shown], squares[:, shown] - blurs[:, shown]
    masses = pulls.sum(axis=0) / squares.sum(axis=0)
    errors = np.sqrt(((pulls - masses * squares) ** 2).sum(axis=0)) / squares.sum(axis=0)
    best = int(np.argmax(masses / np.maximum(errors, 1e-300)))
    # a sensor that reads nothing has neither a mass nor an error
    if not masses[best] > CERTAIN * errors[best]:
        return None
    # without inertia, the sign of a trajectory's product is chance
    sizes = np.sqrt((pulls**2).sum(axis=0))
    signs = np.random.default_rng(seed).choice([-1.0, 1.0], size=(DRAWS, len(numbers)))
    reached = (signs @ pulls / np.maximum(sizes, 1e-300)).max(axis=1) >= (pulls.sum(axis=0) / sizes).max()
    p = float((reached.sum() + 1) / (DRAWS + 1))
    if p > LEVEL:
        return None
    return FreeAirInertia(float(masses[best]), float(errors[best]), FREQUENCIES[shown[best]], p)


def _without_line(seconds: Array, rows: Array) -> Array:
    """Return rows (m, ...) without their mean and their slope in time, by least squares."""
    line = np.column_stack([np.ones_like(seconds), seconds - seconds.mean()])
    flat = rows.reshape(len(rows), -1)
    return np.asarray((flat - line @ np.linalg.lstsq(line, flat, rcond=None)[0]).reshape(rows.shape))
