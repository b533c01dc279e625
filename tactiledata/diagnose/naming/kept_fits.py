"""Fits that are made once and kept, several of them at a time."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from tactiledata.compute.base import Scheduler
from tactiledata.compute.local import LocalScheduler
from tactiledata.diagnose.naming.joint_fit import ROUNDS, JointFit, joint_fit
from tactiledata.diagnose.naming.parameters import JointModel
from tactiledata.diagnose.touches.whitened import WhitenedTouches
from tactiledata.errors import UsageError


@dataclass(frozen=True)
class FitRequest:
    """A fit that is asked for; the parameters are those of `joint_fit`.

    Parameters
    ----------
    start : JointModel
        Where the fit starts.
    held : tuple of int
        Entries of the model's vector that do not move, ascending.
    rounds : int
        Largest number of rounds.
    to_beat : float
        Cost of another explanation; infinite where there is none.
    """

    start: JointModel
    held: tuple[int, ...] = ()
    rounds: int = ROUNDS
    to_beat: float = np.inf


class KeptFits:
    """Fits that are made once, each kept by all that it depends on but the trajectories.

    Where trajectories differ, or how they are simulated, the fits that this changes are to be forgotten.
    """

    def __init__(self) -> None:
        self._fits: dict[bytes, JointFit] = {}

    def joint_fit(
        self,
        whitened: WhitenedTouches,
        start: JointModel,
        held: Iterable[int] = (),
        rounds: int = ROUNDS,
        to_beat: float = np.inf,
    ) -> JointFit:
        """Return what the function `joint_fit` returns: made before, or now.

        Parameters
        ----------
        whitened, start, held, rounds, to_beat
            As of that function; its errors as well.
        """
        task = _Fit(whitened, FitRequest(start, tuple(sorted(held)), rounds, to_beat))
        key = task.key
        if key not in self._fits:
            self._fits[key] = task.make()
        return self._fits[key]

    def joint_fits(
        self, whitened: WhitenedTouches, requests: Sequence[FitRequest], runner: Scheduler | None = None
    ) -> list[JointFit | None]:
        """Return the fit of each request, made before or now; ``None`` where gel and springs find no balance.

        Parameters
        ----------
        whitened : WhitenedTouches
            Measured trajectories.
        requests : sequence of FitRequest
            The fits.
        runner : Scheduler, optional
            Where those are made that were not made before; in this process where ``None``.
        """
        tasks = [_Fit(whitened, request) for request in requests]
        keys = [task.key for task in tasks]
        new = {key: task for key, task in zip(keys, tasks, strict=True) if key not in self._fits}
        outcomes = (runner or LocalScheduler()).outcomes(_Fit.make, list(new.values()))
        for key, outcome in zip(new, outcomes, strict=True):
            if not isinstance(outcome.error, UsageError):
                self._fits[key] = outcome.value
        return [self._fits.get(key) for key in keys]

    def forget(self, effects: Collection[str] | None = None) -> None:
        """Forget the fits that have one of these effects; all fits where ``None``."""
        kept = {} if effects is None else self._fits
        self._fits = {key: fit for key, fit in kept.items() if not set(fit.names) & set(effects or ())}


@dataclass(frozen=True)
class _Fit:
    """A fit of trajectories that a worker can make."""

    whitened: WhitenedTouches
    request: FitRequest

    def __str__(self) -> str:
        names = dict.fromkeys(setting.effect for setting in self.request.start.settings)
        return f"the fit of {' with '.join(names) or 'the plain simulation'}"

    @property
    def key(self) -> bytes:
        """All that the fit depends on but the trajectories."""
        start, white = self.request.start, self.whitened
        model = start.material, start.settings, start.coordinates, start.box
        how = list(self.request.held), self.request.rounds, self.request.to_beat
        key = repr((model, white.errors, white.own, *how)).encode()
        for numbers in (start.offsets, start.errors, white.trust, white.simulated):
            key += b"-" if numbers is None else numbers.tobytes()
        return key

    def make(self) -> JointFit:
        """Return the fit; workers execute this function."""
        request = self.request
        return joint_fit(self.whitened, request.start, request.held, request.rounds, request.to_beat)
