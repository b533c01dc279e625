"""The gel is thinner or thicker on its rigid backing than stated."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from tactiledata.effects.base import Effect
from tactiledata.effects.parameter import strength
from tactiledata.effects.touch.response import GelVariant


class Thickness(Effect):
    """A factor 1 + error on the height of the pad over its rigid base; the outer surface stays.

    A thin bonded layer stiffens a press by f(chi), chi = sqrt(R d) / h. The gel engine plays -15 % and +15 %; the
    closed form f = 1 + 1.133 chi + 1.283 chi^2 + 0.769 chi^3 + 0.0975 chi^4 is for a ball on an incompressible bonded
    layer.

    Source: Dimitriadis et al., Biophys. J. 82, 2002, eq. 12.
    """

    name = "thickness"
    title = "thickness of the gel"
    slot = "geometry"
    parameters = (
        strength(
            "error", "1", "share by which the gel is thicker than stated",
            bounds=(-0.4, 0.4), plausible=(-0.2, 0.2), deviation=0.08, source="unit to unit 5 to 20 %; estimate",
        ),
    )  # fmt: skip
    look_alikes = ("strain_stiffening", "arm_compliance", "dome", "mount_offset")
    distinguishing_trial = (
        "Balls of 2 and 10 mm at one depth: the change follows sqrt(R d) / h, with one h for all indenters."
    )
    detectability = "10 % at a 4 mm ball, 1 mm deep, is some 0.3 N; E and nu hide 98 % of its variance."
    reference = "Dimitriadis et al., Biophys. J. 82, 2002"
    designs: ClassVar = {"error": (-0.15, 0.15)}

    def variant(self, values: Mapping[str, float]) -> GelVariant:
        return GelVariant(thickness=1.0 + values.get("error", 0.0))
