"""The gel is softer at strains below the largest one that it has had."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.special import erf

from tactiledata.effects.base import Effect
from tactiledata.effects.parameter import shape, strength
from tactiledata.effects.touch.state import TouchState

ENERGY_EXPONENT = 2.5
"""Exponent of the depth in the elastic energy of a press with a ball."""


class Mullins(Effect):
    """The stiffness is multiplied by eta = 1 - softening erf((1 - W / Wm) / beta), Wm the largest energy so far.

    Ogden and Roxburgh's law with 1 / r written as ``softening`` and m = 0, applied to the contact as a whole. The
    energy W of a press is taken to grow as depth^(5/2), as that of a ball does. Earlier touches, of any indenter, count
    in Wm by the depth at which this indenter would have done as much (`tactiledata.effects.touch.imprint`).

    Source: Ogden and Roxburgh, Proc. R. Soc. A 455, 1999; soft silicones: clean PDMS 0 to 5 %, filled or Ecoflex 5 to
    30 %.
    """

    name = "mullins"
    title = "cyclic softening (Mullins)"
    slot = "material"
    parameters = (
        strength(
            "softening", "1", "share of the stiffness that is lost at small strain after a large one",
            bounds=(0.0, 0.8), plausible=(0.0, 0.3), deviation=0.1, source="clean PDMS to 5 %, filled 5 to 30 %",
        ),
        shape(
            "beta", "1", "how far below the largest energy the loss sets in, as a share of it",
            default=0.3, bounds=(0.05, 2.0), grid=(0.1, 0.3, 0.8), source="m of 0.05 to 0.4 Wm; estimate",
        ),
    )  # fmt: skip
    look_alikes = ("relaxation", "wear", "adhesion")
    distinguishing_trial = (
        "Load, unload and load again, slowly, at a fresh spot: the second way up follows the first way down."
    )
    detectability = "10 % softening is 0.2 to 0.4 N in the middle of an unloading from 5 N."
    reference = "Ogden and Roxburgh, Proc. R. Soc. A 455, 1999"
    needs = ("earlier_depth",)

    def material_of(self, values: Mapping[str, float]) -> Mapping[str, str]:
        return {"E": "a press deeper than any before"}

    def change(self, state: TouchState, values: Mapping[str, float]) -> TouchState:
        earlier = state.covariate("earlier_depth", self.name)
        depth = np.nan_to_num(np.maximum(state.contact.depth, 0.0))
        largest = np.maximum(np.maximum.accumulate(depth), earlier)
        share = np.divide(depth, largest, out=np.ones_like(depth), where=largest > 0) ** ENERGY_EXPONENT
        return state.stiffened(1.0 - values["softening"] * erf((1.0 - share) / values["beta"]))
