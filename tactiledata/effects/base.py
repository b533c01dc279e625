"""What every effect offers; a new effect is one file with one such class and one line in the table."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar, Literal

from tactiledata.effects.design import null_exact_weights
from tactiledata.effects.parameter import Parameter
from tactiledata.effects.touch.response import GelVariant
from tactiledata.effects.touch.state import TouchState
from tactiledata.errors import UnknownName

Slot = Literal["P", "K", "C", "I", "T", "S"]
SLOTS: tuple[Slot, ...] = ("P", "K", "C", "I", "T", "S")
"""Pose, contact kinematics, constitutive law, interface, time, sensor: the order in which effects act."""
CONTACT_SLOTS = SLOTS[:4]
"""Effects that change what is asked of the gel; the others work on its answer."""
SLOT_TITLES: dict[Slot, str] = {
    "P": "pose",
    "K": "contact geometry",
    "C": "constitutive law",
    "I": "interface",
    "T": "time",
    "S": "sensor",
}


class Effect:
    """A piece of physics that a simulation may lack. Members are stateless.

    Attributes
    ----------
    name : str
        In the table and in settings.
    number : int, optional
        In the catalogue of docs/effects.md.
    title : str
        A few words.
    slot : one of ``SLOTS``
    parameters : tuple of Parameter
    look_alikes : tuple of str
        Names of effects that leave similar traces.
    distinguishing_trial : str
        The trial that separates it from them.
    detectability : str
        What of it can be seen on such a rig, with a number.
    reference : str
        Where equation and ranges come from.
    needs : tuple of str
        Fields of the touch, optional ones, without which it cannot be played.
    feeds_back : bool
        Whether it depends on the wrench that it changes; the simulator then looks for the balance.
    designs : dict, parameter -> values
        Of effects that are played by the gel engine: design points, other than the null, at which it must have played
        `variant` beforehand; one parameter at a time.
    each : str
        Of effects that are another one for each: of ``sensor``, ``indenter_name`` or ``mount``; empty where all touches
        share the numbers. Naming then fits strengths for each.
    """

    name: ClassVar[str]
    number: ClassVar[int | None] = None
    title: ClassVar[str]
    slot: ClassVar[Slot]
    parameters: ClassVar[tuple[Parameter, ...]]
    look_alikes: ClassVar[tuple[str, ...]]
    distinguishing_trial: ClassVar[str]
    detectability: ClassVar[str]
    reference: ClassVar[str]
    needs: ClassVar[tuple[str, ...]] = ()
    feeds_back: ClassVar[bool] = False
    designs: ClassVar[Mapping[str, tuple[float, ...]]] = {}
    each: ClassVar[str] = ""

    def complete(self, values: Mapping[str, float]) -> dict[str, float]:
        """All parameters by name: those given, checked, and the defaults of the others.

        Raises
        ------
        UnknownName
            A parameter that the effect does not have.
        UsageError
            A value outside its bounds.
        """
        names = [parameter.name for parameter in self.parameters]
        for name in values:
            if name not in names:
                raise UnknownName(f"parameter of effect {self.name!r}", name, names)
        return {
            parameter.name: parameter.check(values.get(parameter.name, parameter.default), self.name)
            for parameter in self.parameters
        }

    def is_null(self, values: Mapping[str, float]) -> bool:
        """Whether every strength has its null value."""
        return self._is_nothing(self.complete(values))

    def _is_nothing(self, complete: Mapping[str, float]) -> bool:
        return all(parameter.null in (None, complete[parameter.name]) for parameter in self.parameters)

    def apply(self, state: TouchState, values: Mapping[str, float]) -> TouchState:
        """The state with the effect; the very same object where its strengths are null.

        Raises
        ------
        UsageError
            Values that it cannot have, or a covariate that the touch does not tell.
        """
        complete = self.complete(values)
        return state if self._is_nothing(complete) else self.applied(state, complete)

    def applied(self, state: TouchState, complete: Mapping[str, float]) -> TouchState:
        """The same with values that are known to be complete, and not all null."""
        state = self.change(state, complete)
        for name, places in self.designs.items():
            if complete[name] != 0.0:
                weights = null_exact_weights(places, complete[name])
                for weight, place in zip(weights, places, strict=True):
                    state = state.with_elastic(weight * state.base.difference(self.variant({name: place})))
        return state

    def change(self, state: TouchState, values: Mapping[str, float]) -> TouchState:
        """The state with the effect, values complete and not all null; without what ``designs`` add."""
        return state

    def variant(self, values: Mapping[str, float]) -> GelVariant:
        """The gel, or the indenter, that values stand for; those not given are null.

        What deformed meshes are to be played with. At design points it is played beforehand, for wrenches.
        """
        return GelVariant()

    def material_of(self, values: Mapping[str, float]) -> Mapping[str, str]:
        """Of what E, nu and mu are, by their names, where the effect makes them depend on something; values complete.

        "mu is that of", and then what stands here.
        """
        return {}

    def parameters_not_played_by_gel(self, values: Mapping[str, float]) -> Mapping[str, float]:
        """The values that are left to `change` where the gel engine itself plays `variant`; all of them for most."""
        return values
