"""A spot that was touched often has another stiffness and another friction."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tactiledata.effects.base import Effect
from tactiledata.effects.parameter import shape, strength
from tactiledata.effects.touch.state import TouchState


class Wear(Effect):
    """Stiffness and friction times 1 + change u, where u = 1 - exp(-n / contacts) after n earlier touches of the spot.

    Source: residual deformation of a used gel is reported in DTact issue 1; saturation is the simplest form that stays
    bounded.
    """

    name = "wear"
    title = "wear and ageing"
    slot = "material"
    parameters = (
        strength(
            "stiffness_change", "1", "share by which a worn spot is stiffer than a fresh one",
            bounds=(-0.5, 0.3), plausible=(-0.15, 0.05), deviation=0.05, source="0 to 15 % over a campaign; estimate",
        ),
        strength(
            "friction_change", "1", "share by which friction is larger on a worn spot",
            bounds=(-0.6, 0.6), plausible=(-0.3, 0.3), deviation=0.1, source="loss of coating; estimate",
        ),
        shape(
            "contacts", "1", "after how many touches the change is 63 % done",
            default=500.0, bounds=(5.0, 1e5), grid=(50.0, 500.0, 5000.0), source="estimate",
        ),
    )  # fmt: skip
    look_alikes = ("heating", "mullins", "soft_region")
    distinguishing_trial = "A spot that was never touched beside one that was, at the same minute since power-on."
    detectability = "10 % is 0.5 N at 5 N; cannot be told from heating where days and indenters do not interleave."
    reference = "DTact issue 1 (residual deformation)"
    needs = ("earlier_contacts",)

    def material_of(self, values: Mapping[str, float]) -> Mapping[str, str]:
        return {"E": "an unused spot", "mu": "an unused spot"}

    def change(self, state: TouchState, values: Mapping[str, float]) -> TouchState:
        worn = -np.expm1(-state.covariate("earlier_contacts", self.name) / values["contacts"])
        softened = state.stiffened(1.0 + values["stiffness_change"] * worn)
        return softened.rubbed(1.0 + values["friction_change"] * worn)
