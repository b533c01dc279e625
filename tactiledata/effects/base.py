"""What every effect declares and offers; a new effect is one file with one such class and one line in the table."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar, Literal

from tactiledata.effects.design import null_exact_weights
from tactiledata.effects.parameter import Parameter
from tactiledata.effects.touch.response import GelVariant
from tactiledata.effects.touch.state import TouchState
from tactiledata.errors import UnknownName

Slot = Literal["pose", "geometry", "material", "interface", "time", "sensor"]
SLOTS: tuple[Slot, ...] = ("pose", "geometry", "material", "interface", "time", "sensor")
"""Slots in the order in which their effects act; an effect lies in the folder of its slot."""
CONTACT_SLOTS = SLOTS[:4]
"""Slots of effects that change what the gel is asked; effects of the others work on its answer."""
SLOT_TITLES: dict[Slot, str] = {
    "pose": "pose",
    "geometry": "contact geometry",
    "material": "constitutive law",
    "interface": "interface",
    "time": "time",
    "sensor": "sensor",
}
"""Titles of the slots, for pages."""


class Effect:
    """A piece of physics that a simulation may lack; members are stateless.

    Attributes
    ----------
    name : str
        Key in the table and in settings.
    title : str
        What it is in a few words.
    slot : str
        One of ``SLOTS``; the folder of an effect of this package has the same name.
    parameters : tuple of Parameter
        Numbers of the effect, strengths and shapes.
    look_alikes : tuple of str
        Names of effects that leave similar traces in the data.
    distinguishing_trial : str
        The trial that separates the effect from its look-alikes.
    unlisted_look_alike : str
        Physics outside the catalogue that was given the name of the effect, and the trial that tells the two apart, in
        words; empty where none is known.
    detectability : str
        What can be seen of the effect on such a rig, with a number.
    reference : str
        Where equation and ranges come from.
    needs : tuple of str
        Optional fields of `Touch` without which the effect cannot be played.
    feeds_back : bool
        Whether the effect depends on the wrench that it changes; the simulator then solves for the force balance.
    designs : dict, parameter -> values
        Design points, other than the null, at which the gel engine plays `variant` beforehand, one parameter at a time;
        empty for effects that the gel engine does not play.
    varies_by : str
        Field of a touch by whose value the strengths differ: ``sensor``, ``indenter_name`` or ``mount``. Naming then
        fits strengths for each value. Empty where all touches share the numbers.
    """

    name: ClassVar[str]
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
    varies_by: ClassVar[str] = ""
    unlisted_look_alike: ClassVar[str] = ""

    def complete(self, values: Mapping[str, float]) -> dict[str, float]:
        """Return all parameters by name: the given values, checked, and the defaults of the others.

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
        """Whether every strength has its null value, so that the effect changes nothing."""
        return self.has_no_strength(self.complete(values))

    def has_no_strength(self, complete: Mapping[str, float]) -> bool:
        """Whether every strength of complete values has its null value; shapes have none and do not count."""
        return all(parameter.null in (None, complete[parameter.name]) for parameter in self.parameters)

    def apply(self, state: TouchState, values: Mapping[str, float]) -> TouchState:
        """Return the state with the effect; the very same object where every strength is null.

        Raises
        ------
        UsageError
            A value outside its bounds, or a covariate that the touch does not state.
        """
        complete = self.complete(values)
        return state if self.has_no_strength(complete) else self.applied(state, complete)

    def applied(self, state: TouchState, complete: Mapping[str, float]) -> TouchState:
        """Return the state with the effect, for values that were completed before and are not all null."""
        state = self.change(state, complete)
        # what the gel engine has played at design points, interpolated
        for name, places in self.designs.items():
            if complete[name] != 0.0:
                weights = null_exact_weights(places, complete[name])
                for weight, place in zip(weights, places, strict=True):
                    state = state.with_elastic(weight * state.base.difference(self.variant({name: place})))
        return state

    def change(self, state: TouchState, values: Mapping[str, float]) -> TouchState:
        """Return the state with all of the effect that is not played at ``designs``.

        A member overrides it; ``values`` are complete and not all null.
        """
        return state

    def variant(self, values: Mapping[str, float]) -> GelVariant:
        """Return the gel or the indenter that values stand for; parameters that are not given are null.

        It is played for deformed meshes, and beforehand at the design points for wrenches.
        """
        return GelVariant()

    def material_of(self, values: Mapping[str, float]) -> Mapping[str, str]:
        """Return for which state of the gel ``E``, ``nu`` or ``mu`` holds, where the effect makes it depend on one.

        A report continues "mu is that of" with the text; ``values`` are complete.
        """
        return {}

    def parameters_not_played_by_gel(self, values: Mapping[str, float]) -> Mapping[str, float]:
        """Return the values that `change` still has to apply where the gel engine itself plays `variant`."""
        return values
