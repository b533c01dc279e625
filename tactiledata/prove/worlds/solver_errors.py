"""Contacts that differ from the rig's: its wrenches with errors of a solver that are drawn for each indenter."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tactiledata.rig.bank.bank import BankedContact
from tactiledata.rig.contact.contact import TouchSetup

REFERENCE = 4.0
"""Force, N, about which a law's errors grow."""


@dataclass(frozen=True)
class SolverError:
    """How another solver of the same gel errs under one indenter: shares, m, and m per rad.

    A force is off by a share that grows with a hyperbolic tangent of its logarithm and wiggles, and by another while it
    is taken off; shear that sticks by a share that grows; a tilted indenter is pushed aside; the centre of pressure is
    moved; shear adds to the normal force. Sliding shear keeps Coulomb's law.
    """

    scale: float
    power: float
    wiggle: float
    phase: float
    shear: float
    growth: float
    push: float
    centre: tuple[float, float]
    centre_by_tilt: float
    unloading: float
    dilation: float

    @staticmethod
    def drawn(chance: np.random.Generator) -> SolverError:
        """A solver's error of usual size."""
        return SolverError(
            scale=chance.normal(0, 0.03),
            power=chance.normal(0, 0.03),
            wiggle=chance.normal(0, 0.01),
            phase=chance.uniform(0, 6),
            shear=chance.normal(0, 0.05),
            growth=chance.normal(0, 0.03),
            push=chance.normal(0, 0.15),
            centre=tuple(chance.normal(0, 5e-5, 2)),
            centre_by_tilt=chance.normal(0, 5e-4),
            unloading=chance.normal(0, 0.02),
            dilation=chance.normal(0, 0.01),
        )

    def applied(self, contact: BankedContact, setup: TouchSetup, size: float) -> BankedContact:
        """Return a contact with this error.

        Parameters
        ----------
        contact : BankedContact
            The contact without it.
        setup : TouchSetup
            The touch.
        size : float
            Factor on the error.
        """
        wrench = contact.wrench.copy()
        load, shear = wrench[:, 2].copy(), wrench[:, :2].copy()
        touches, divisor = load > 0, np.maximum(load, 1e-3)
        growth = np.log(divisor / REFERENCE)
        most = np.maximum(np.maximum.accumulate(load), 1e-9)
        factor = 1 + size * (
            self.scale + 1.3 * self.power * np.tanh(growth) + self.wiggle * np.sin(2.2 * growth + self.phase)
        )
        factor = factor + size * self.unloading * np.clip(1 - load / most, 0, 1) ** 1.5
        used = np.hypot(*shear.T) / np.maximum(setup.material.friction * divisor, 1e-9)
        sticks = np.clip((1 - used) / 0.1, 0, 1)
        tilt = setup.rotation[:2, 2]
        loaded = load * factor + size * self.dilation * load * np.minimum(used, 1) ** 1.5
        of_shear = factor * (1 + size * (self.shear + self.growth * growth) * sticks)
        sheared = shear * of_shear[:, None] + size * self.push * loaded[:, None] * tilt
        x, y = np.where(touches, -wrench[:, 4] / divisor, 0.0), np.where(touches, wrench[:, 3] / divisor, 0.0)
        moved = size * (np.array(self.centre) + self.centre_by_tilt * tilt)
        out = np.column_stack(
            [sheared, loaded, (y + moved[1]) * loaded, -(x + moved[0]) * loaded, wrench[:, 5] * factor]
        )
        return replace(contact, wrench=np.where(touches[:, None], out, 0.0))


@dataclass(frozen=True)
class OtherSolver:
    """A `SolveContact` that errs beside another one.

    Parameters
    ----------
    solve : callable
        The contact without the errors.
    size : float
        Of the errors; 0: none, 1: usual.
    seed : int
        Of their draw.
    """

    solve: Any
    size: float
    seed: int

    def __call__(self, gel: Any, setup: TouchSetup, path: Any = None, deviation: Any = None) -> BankedContact:
        """The contact of a touch."""
        contact = self.solve(gel, setup, path, deviation)
        banked = BankedContact(contact.path, contact.deviation, contact.wrench, contact.slipping, contact.unsettled)
        if not self.size:
            return banked
        # an indenter errs alike in all of its touches
        chance = np.random.default_rng([self.seed, *setup.touch.indenter.encode()])
        return SolverError.drawn(chance).applied(banked, setup, self.size)
