"""What is diagnosed: trajectories with their measured wrenches, and the simulation that may lack physics."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np

from tactiledata.arrays import Array, Indices, Mask
from tactiledata.calibrate.bounds import BOUNDS, Bounds
from tactiledata.effects.simulate.balance import Balance
from tactiledata.effects.simulate.setting import EffectSetting
from tactiledata.effects.simulate.simulator import Simulator, in_contact, with_effects, with_sensor_effects
from tactiledata.effects.touch.response import BaseResponse
from tactiledata.effects.touch.state import TouchState
from tactiledata.effects.touch.touch import Touch
from tactiledata.errors import TactileDataError, UsageError
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.nuisance.noise import WrenchNoise

FEWEST_FRAMES = 3
"""Fewest frames with wrench and pose that a trajectory needs."""
FEWEST_CASES = 8
"""Fewest trajectories of a diagnosis: fewer are not enough for folds, nor for tests that flip signs of trajectories."""


class BaseFamily(Protocol):
    """The simulation without effects, at any material; its implementation decides how a gel is played."""

    def __call__(self, material: GelMaterial) -> Callable[[Touch], BaseResponse]:
        """Return the function that simulates a touch on a gel of this material."""
        ...


@dataclass(frozen=True)
class TouchCase:
    """One trajectory of n frames with its measured wrenches.

    Parameters
    ----------
    touch : Touch
        Poses and covariates. Its material is replaced by the one that a fit tries.
    measured : (n, 6) N, N m
        Wrench on the indenter, gel frame, about the gel's origin; not a number where unknown.
    noise : WrenchNoise
        Noise of a wrench that is interpolated at one frame.
    free_air : (n,) bool
        Frames in which nothing touches the gel.
    free_samples : float
        Number of readings in free air from which the zero of the force sensor was taken.
    name : str
        As in sentences for people.
    factors : (n,), optional
        Deviation of each wrench over that of ``noise``: below 1 for means of readings; 1 everywhere where ``None``.

    Raises
    ------
    UsageError
        Wrenches, flags or factors have another number of frames than the touch.
    """

    touch: Touch
    measured: Array
    noise: WrenchNoise
    free_air: Mask
    free_samples: float = 100.0
    name: str = ""
    factors: Array | None = None

    def __post_init__(self) -> None:
        for what, shape, expected in (
            ("measured wrenches", self.measured.shape, (len(self.touch), 6)),
            ("free-air flags", self.free_air.shape, (len(self.touch),)),
            ("factors on the noise", self.noise_factors.shape, (len(self.touch),)),
        ):
            if shape != expected:
                raise UsageError(f"{what} of shape {shape} for trajectory {self.name!r}", f"{expected}", "Align them.")

    @property
    def noise_factors(self) -> Array:
        """Deviation (n,) of each wrench over that of ``noise``."""
        return np.ones(len(self.touch)) if self.factors is None else self.factors

    @property
    def indenter(self) -> str:
        """Name of the indenter; a description of its shape where it has no name."""
        return self.touch.indenter_name or repr(self.touch.indenter)


class PlayedContact(NamedTuple):
    """Cached gel solution of one trajectory: request, starting balance, resulting state, resulting balance.

    Parameters
    ----------
    request : (GelMaterial, list of EffectSetting)
        Material, and the effects that act in contact.
    start_balance : Balance, optional
        Balance of springs and gel from which the solution was searched; ``None`` where there was no such start.
    state : TouchState
        The trajectory after its effects in contact.
    balance : Balance, optional
        The balance that was found; ``None`` where nothing bends under forces.
    """

    request: tuple[GelMaterial, list[EffectSetting]]
    start_balance: Balance | None
    state: TouchState
    balance: Balance | None


class Simulated(NamedTuple):
    """Simulated wrenches of trajectories, and the friction that they met.

    Parameters
    ----------
    wrench : (N, 6) N, N m
        What the sensor would read in all frames, one trajectory after the other.
    friction : (N,)
        Friction coefficient in each frame, effects on it included.
    """

    wrench: Array
    friction: Array


@dataclass(frozen=True)
class Played:
    """Simulated trajectories, with the gel solutions from which those of similar materials are found faster.

    Parameters
    ----------
    wrench : (N, 6) N, N m
        What the sensor would read in all frames, one trajectory after the other.
    friction : (N,)
        Friction coefficient in each frame, effects on it included.
    contacts : dict, number of a trajectory -> PlayedContact
        Gel solution of each trajectory.
    """

    wrench: Array
    friction: Array
    contacts: Mapping[int, PlayedContact]


@dataclass(frozen=True)
class TouchSet:
    """Trajectories, and the simulation that plays them: all N frames of t trajectories, one after the other.

    Parameters
    ----------
    touches : sequence of TouchCase
        The t trajectories.
    base : BaseFamily
        The simulation without effects.
    box : Bounds
        Bounds of E, nu and mu within which the base can simulate.
    """

    touches: Sequence[TouchCase]
    base: BaseFamily
    box: Bounds = BOUNDS["wide"]

    @property
    def counts(self) -> Indices:
        """Number of frames (t,) of each trajectory."""
        return np.array([len(case.touch) for case in self.touches])

    @property
    def indenters(self) -> tuple[str, ...]:
        """Name of each trajectory's indenter; a description of its shape where it has no name."""
        return tuple(case.indenter for case in self.touches)

    def need_touches(self) -> None:
        """Refuse a set of fewer than ``FEWEST_CASES`` trajectories, or one with too few frames in a trajectory.

        Raises
        ------
        TactileDataError
            The set has too few trajectories, or one of them has too few frames with a wrench.
        """
        if len(self.touches) < FEWEST_CASES:
            raise TactileDataError(
                f"{len(self.touches)} trajectories to name missing physics from",
                f"at least {FEWEST_CASES}: whole trajectories are held out, never frames",
                "Record more of them.",
                trajectories=len(self.touches),
            )
        for case in self.touches:
            if (known := int(np.isfinite(case.measured).all(axis=1).sum())) < FEWEST_FRAMES:
                raise TactileDataError(
                    f"trajectory {case.name!r} has {known} frames with a wrench",
                    f"at least {FEWEST_FRAMES}",
                    "Leave it out.",
                    trajectory=case.name,
                )

    def play(
        self,
        material: GelMaterial,
        settings: Sequence[EffectSetting],
        offsets: Array | None = None,
        near: Played | None = None,
    ) -> Array:
        """Return what the sensor would read (N, 6), in N and N m, gel frame, about the gel's origin.

        Parameters
        ----------
        material : GelMaterial
            Material of the gel.
        settings : sequence of EffectSetting
            Effects on top of the base simulation.
        offsets : (t,) m, optional
            By how much each trajectory is deeper than recorded; 0 where ``None``.
        near : Played, optional
            Similar simulated trajectories: the balance of gel and springs is searched from theirs.

        Raises
        ------
        UsageError
            Gel and springs find no balance, or an effect needs a covariate that a touch does not have.
        """
        return self.simulate(material, settings, offsets, near).wrench

    def simulate(
        self,
        material: GelMaterial,
        settings: Sequence[EffectSetting],
        offsets: Array | None = None,
        near: Played | None = None,
    ) -> Simulated:
        """Return what the sensor would read, with the friction of each frame; errors as of `play`.

        Parameters
        ----------
        material, settings, offsets, near
            See `play`.
        """
        simulator = with_effects(self.base(material), settings)
        parts = [self._read(number, simulator, material, offsets, near) for number in range(len(self.touches))]
        return Simulated(*(np.concatenate(rows) for rows in zip(*parts, strict=True)))

    def played(self, material: GelMaterial, settings: Sequence[EffectSetting], offsets: Array | None = None) -> Played:
        """Return what the sensor would read, with the gel solutions from which others can start; see `play`.

        Parameters
        ----------
        material : GelMaterial
            Material of the gel.
        settings : sequence of EffectSetting
            Effects on top of the base simulation.
        offsets : (t,) m, optional
            By how much each trajectory is deeper than recorded.
        """
        return Played(*self.simulate(material, settings, offsets), dict(self._contacts))

    def simulate_where(
        self,
        changed: EffectSetting,
        before: Played,
        material: GelMaterial,
        settings: Sequence[EffectSetting],
        offsets: Array | None = None,
    ) -> Simulated:
        """Return what the sensor would read after one setting has changed; other trajectories are not replayed.

        Parameters
        ----------
        changed : EffectSetting
            The setting that has changed: only trajectories on which it acts are simulated.
        before : Played
            The trajectories before the change.
        material : GelMaterial
            Material of the gel.
        settings : sequence of EffectSetting
            All effects, the changed one among them.
        offsets : (t,) m, optional
            By how much each trajectory is deeper than recorded.
        """
        simulator = with_effects(self.base(material), settings)
        ends = np.cumsum(self.counts)
        found = Simulated(before.wrench.copy(), before.friction.copy())
        for number, case in enumerate(self.touches):
            if changed.acts_on(case.touch):
                rows = slice(ends[number] - len(case.touch), ends[number])
                found.wrench[rows], found.friction[rows] = self._read(number, simulator, material, offsets, before)
        return found

    def _read(
        self, number: int, simulator: Simulator, material: GelMaterial, offsets: Array | None, near: Played | None
    ) -> Simulated:
        """Return what the sensor would read in one trajectory; gel solutions of the same request serve again."""
        if offsets is not None and offsets[number] != 0.0:
            simulator = simulator.with_effects([self._deeper(number, float(offsets[number]))])
        active = simulator.active(self.touches[number].touch)
        request = material, in_contact(active)
        # the same request as the near one: its solution is used, and effects of time and sensor are applied to it
        there = near.contacts[number] if near is not None else None
        if there is not None and there.request == request:
            return _simulated(with_sensor_effects(there.state, active))
        # the same request and start as the last one: the cached solution serves
        start_balance = there.balance if there is not None else None
        last = self._contacts.get(number)
        if last is None or last.request != request or last.start_balance is not start_balance:
            last = PlayedContact(
                request, start_balance, *simulator.contact_near(self._touch(number, material), start_balance)
            )
            self._contacts[number] = last
        return _simulated(with_sensor_effects(last.state, active))

    def _deeper(self, number: int, offset: float) -> EffectSetting:
        """Return the contact offset, m, of a trajectory as a setting; the last one where the offset is the same."""
        kept = self._offsets.get(number)
        if kept is None or kept.values["deeper"] != offset:
            kept = EffectSetting("mount_offset", {"deeper": offset})
            self._offsets[number] = kept
        return kept

    def _touch(self, number: int, material: GelMaterial) -> Touch:
        """Return one trajectory on a gel; the last object, with its cached properties, where the gel is the same."""
        if number in self._contacts and self._contacts[number].request[0] == material:
            return self._contacts[number].state.touch
        return self.touches[number].touch.on(material)

    @cached_property
    def _offsets(self) -> dict[int, EffectSetting]:
        """Last contact offset of each trajectory: several simulations in a row have the same one."""
        return {}

    @cached_property
    def _contacts(self) -> dict[int, PlayedContact]:
        """Last gel solution of each trajectory: effects of time and sensor ask for the same one again."""
        return {}


def _simulated(state: TouchState) -> Simulated:
    """Return what the sensor reads in a state, and the friction in it."""
    return Simulated(state.wrench, state.touch.material.friction * state.friction)
