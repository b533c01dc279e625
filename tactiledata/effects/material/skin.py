"""A coating on the gel is stiffer than the gel under it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from tactiledata.effects.base import Effect
from tactiledata.effects.parameter import strength
from tactiledata.effects.touch.response import GelVariant


class Skin(Effect):
    """A thin stiff layer on the outer surface, by its stiffness in stretching beyond the gel: e = (E_skin / E - 1) t.

    Paint of 20 to 100 um that is 2 to 10 times as stiff as the gel has e = 0.02 to 0.9 mm. Its share of the force falls
    with the radius of the contact, about as e / a. The gel engine plays e = 0.2 and 0.6 mm.

    Source: bilayer contact, e.g. Gao, Chiu and Lee, Int. J. Solids Struct. 29, 1992 (the weight of a coating falls with
    a / t).
    """

    name = "skin"
    title = "stiff coating"
    slot = "material"
    parameters = (
        strength(
            "excess", "m", "thickness of gel as stiff, in stretching, as the coating is beyond the gel",
            bounds=(0.0, 2e-3), plausible=(0.0, 9e-4), deviation=3e-4, source="20 to 100 um, 2 to 10 E; estimate",
        ),
    )  # fmt: skip
    look_alikes = ("thickness", "strain_stiffening", "mount_offset")
    distinguishing_trial = (
        "Shallow presses with balls of 2 and 10 mm: a coating stiffens small contacts most, a thin gel large ones."
    )
    detectability = "0.2 mm (50 um, 5 E) stiffens a contact of 1 mm radius by some 6 %: 0.06 N at 1 N, 0.2 N at 5 N."
    reference = "Gao, Chiu and Lee, Int. J. Solids Struct. 29, 1992"
    designs: ClassVar = {"excess": (2e-4, 6e-4)}

    def variant(self, values: Mapping[str, float]) -> GelVariant:
        return GelVariant(skin=values.get("excess", 0.0))
