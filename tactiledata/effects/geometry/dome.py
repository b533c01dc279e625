"""The outer surface is curved more, or less, than stated."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from tactiledata.effects.base import Effect
from tactiledata.effects.parameter import strength
from tactiledata.effects.touch.response import GelVariant


class DomeCurvature(Effect):
    """A curvature beside that of the simulated pad: h(x, y) = h0 (1 - kappa r^2), a dome of radius 1 / (2 h0 kappa).

    Away from the middle, contact begins later, on an inclined and thinner gel. The gel engine plays kappa = -2000 and
    +2000 1/m^2.

    Source: geometry of a sphere to second order; dome radii of 20 to 80 mm on a 4 mm gel are 1600 to 6300 1/m^2.
    """

    name = "dome"
    title = "curvature of the gel"
    slot = "geometry"
    parameters = (
        strength(
            "curvature", "1/m^2", "share of its height by which the surface falls, per square of the distance",
            bounds=(-1e4, 1e4), plausible=(-3e3, 3e3), deviation=1e3, source="half of domes of 20 to 80 mm; estimate",
        ),
    )  # fmt: skip
    look_alikes = ("pad_edge", "soft_region", "thickness", "mount_offset")
    distinguishing_trial = (
        "The same press at five places: the change grows with the square of the distance from the middle."
    )
    detectability = "At 5 mm from the middle, 1000 1/m^2 is 0.1 mm of height: 0.6 to 1.5 N; in the middle nothing."
    reference = "geometry"
    designs: ClassVar = {"curvature": (-2e3, 2e3)}

    def variant(self, values: Mapping[str, float]) -> GelVariant:
        return GelVariant(dome=values.get("curvature", 0.0))
