"""The gel stiffens with strain: Yeoh's law instead of the neo-Hookean one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from tactiledata.effects.base import Effect
from tactiledata.effects.parameter import strength
from tactiledata.effects.touch.response import GelVariant


class StrainStiffening(Effect):
    """Yeoh's energy W = C10 (I - 3) + C20 (I - 3)^2 + C30 (I - 3)^3 in place of its first, neo-Hookean term.

    I is that of the isochoric deformation; C10 = E / (4 (1 + nu)), so that small strains are unchanged. The gel engine
    plays C20 / C10 = -0.05 and 0.2, and C30 / C10 = 0.05.

    Source: Yeoh, Rubber Chem. Technol. 66, 1993; the range covers Treloar's data up to the strains met here (d / h up
    to 0.4).
    """

    name = "strain_stiffening"
    title = "strain stiffening (Yeoh)"
    slot = "material"
    parameters = (
        strength(
            "c20", "1", "C20 / C10",
            bounds=(-0.1, 0.5), plausible=(-0.05, 0.2), deviation=0.08, source="silicones at moderate strain; estimate",
        ),
        strength(
            "c30", "1", "C30 / C10",
            bounds=(-0.02, 0.2), plausible=(0.0, 0.05), deviation=0.02, source="silicones at moderate strain; estimate",
        ),
    )  # fmt: skip
    look_alikes = ("thickness", "skin", "arm_compliance", "mullins")
    distinguishing_trial = (
        "Deep presses with balls of 2 and 10 mm: the change follows a / R and d / h, not force and not depth."
    )
    detectability = "c20 = 0.1 changes a 0.8 mm press by some 2 %, 0.1 N at 4 N; E and nu hide 86 % of its variance."
    reference = "Yeoh, Rubber Chem. Technol. 66, 1993"
    designs: ClassVar = {"c20": (-0.05, 0.2), "c30": (0.05,)}

    def variant(self, values: Mapping[str, float]) -> GelVariant:
        return GelVariant(c20=values.get("c20", 0.0), c30=values.get("c30", 0.0))
