"""What is diagnosed: trajectories with the wrench that was measured, and the simulation that may lack something."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import Array, Indices
from tactiledata.calibrate.bounds import BOUNDS, Bounds
from tactiledata.effects.simulate.balance import Balance
from tactiledata.effects.simulate.setting import EffectSetting
from tactiledata.effects.simulate.simulator import Simulator, in_contact, with_effects
from tactiledata.effects.touch.response import BaseResponse
from tactiledata.effects.touch.state import TouchState
from tactiledata.effects.touch.touch import Touch
from tactiledata.errors import TactileDataError, UsageError
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.nuisance.noise import WrenchNoise

FEWEST_FRAMES = 3
FEWEST_CASES = 8
"""Trajectories: with fewer neither folds nor signs of trajectories say anything."""


class BaseFamily(Protocol):
    """The simulation without effects, at any material: what implements it decides how a gel is played."""

    def __call__(self, material: GelMaterial) -> Callable[[Touch], BaseResponse]:
        """What answers for touches."""
        ...


@dataclass(frozen=True)
class TouchCase:
    """One trajectory of n frames.

    Parameters
    ----------
    touch : Touch
        Its material is replaced by the one that is tried.
    measured : (n, 6) N, N m
        Wrench on the indenter, gel frame, about the gel's origin; NaN where unknown.
    noise : WrenchNoise
        Of one frame.
    free_air : (n,) bool
        Frames in which nothing touches.
    free_samples : float
        Readings from which the zero was taken.
    name : str

    Raises
    ------
    UsageError
        Arrays that do not fit the touch.
    """

    touch: Touch
    measured: Array
    noise: WrenchNoise
    free_air: NDArray[np.bool_]
    free_samples: float = 100.0
    name: str = ""

    def __post_init__(self) -> None:
        for what, found, wanted in (
            ("measured wrenches", self.measured.shape, (len(self.touch), 6)),
            ("free-air flags", self.free_air.shape, (len(self.touch),)),
        ):
            if found != wanted:
                raise UsageError(f"{what} of shape {found} for trajectory {self.name!r}", f"{wanted}", "Align them.")


class PlayedContact(NamedTuple):
    """What was asked of the gel in a trajectory, from which balance on, the answer and the balance found."""

    asked: tuple[GelMaterial, list[EffectSetting]]
    begun: Balance | None
    state: TouchState
    balance: Balance | None


@dataclass(frozen=True)
class Played:
    """Trajectories as they were played.

    Parameters
    ----------
    wrench : (N, 6)
        What the sensor would read.
    contacts : dict, number of a trajectory -> PlayedContact
    """

    wrench: Array
    contacts: Mapping[int, PlayedContact]


@dataclass(frozen=True)
class TouchSet:
    """Trajectories and the simulation that is to play them, all frames one after the other: N rows of t trajectories.

    Parameters
    ----------
    touches : sequence of TouchCase
    base : BaseFamily
    box : Bounds
        Of the materials that the base answers for.
    """

    touches: Sequence[TouchCase]
    base: BaseFamily
    box: Bounds = BOUNDS["wide"]

    @property
    def counts(self) -> Indices:
        """Frames (t,) of each trajectory."""
        return np.array([len(case.touch) for case in self.touches])

    @property
    def indenters(self) -> tuple[str, ...]:
        """Name of each trajectory's indenter; its shape where it has no name."""
        return tuple(case.touch.indenter_name or repr(case.touch.indenter) for case in self.touches)

    def need_cases(self) -> None:
        """Nothing, where there are trajectories enough.

        Raises
        ------
        TactileDataError
            There are too few, or one has too few frames with wrench and pose.
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
        """What the sensor would read (N, 6), each trajectory deeper by an offset (t,), m, of its own.

        What bends under forces is looked for ``near`` what was played before, where that is given.
        """
        simulator = with_effects(self.base(material), settings)
        numbers = range(len(self.touches))
        return np.concatenate([self._read(number, simulator, material, offsets, near) for number in numbers])

    def played(self, material: GelMaterial, settings: Sequence[EffectSetting], offsets: Array | None = None) -> Played:
        """The same, to play others near it."""
        wrench = self.play(material, settings, offsets)
        return Played(wrench, dict(self._contacts))

    def play_where(
        self,
        changed: EffectSetting,
        before: Played,
        material: GelMaterial,
        settings: Sequence[EffectSetting],
        offsets: Array | None = None,
    ) -> Array:
        """The same where one setting differs from what was played ``before``: only what it acts on is played."""
        simulator = with_effects(self.base(material), settings)
        ends = np.cumsum(self.counts)
        read = before.wrench.copy()
        for number, case in enumerate(self.touches):
            if changed.acts_on(case.touch):
                rows = slice(ends[number] - len(case.touch), ends[number])
                read[rows] = self._read(number, simulator, material, offsets, before)
        return read

    def _read(
        self, number: int, simulator: Simulator, material: GelMaterial, offsets: Array | None, near: Played | None
    ) -> Array:
        if offsets is not None and offsets[number] != 0.0:
            simulator = simulator.with_effects([EffectSetting("mount_offset", {"deeper": float(offsets[number])})])
        asked = material, in_contact(simulator.active(self.touches[number].touch))
        there = near.contacts[number] if near is not None else None
        if there is not None and there.asked == asked:
            return simulator.read(there.state).wrench
        begun = there.balance if there is not None else None
        last = self._contacts.get(number)
        if last is None or last.asked != asked or last.begun is not begun:
            last = PlayedContact(asked, begun, *simulator.contact_near(self._touch(number, material), begun))
            self._contacts[number] = last
        return simulator.read(last.state).wrench

    def _touch(self, number: int, material: GelMaterial) -> Touch:
        """A trajectory on a gel; as before, with what it has worked out, where the gel is that of the answer before."""
        if number in self._contacts and self._contacts[number].asked[0] == material:
            return self._contacts[number].state.touch
        return replace(self.touches[number].touch, material=material)

    @cached_property
    def _contacts(self) -> dict[int, PlayedContact]:
        """Of each trajectory the last answer of the gel: effects of time and sensor ask for the same one again."""
        return {}
