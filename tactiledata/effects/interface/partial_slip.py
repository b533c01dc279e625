"""The rim of a contact slips before its middle."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tactiledata.arrays import Array
from tactiledata.effects.base import Effect
from tactiledata.effects.parameter import strength
from tactiledata.effects.touch.state import TouchState

ELEMENTS = 8
"""Number of contacts in parallel that stand for one: the knee is then within 1 % of Mindlin's curve."""


def slip_levels(count: int = ELEMENTS) -> Array:
    """Factors (count,) on friction, ascending, mean 1, at which equal parts of Mindlin's contact slip.

    With x = k_t u / (mu N), Mindlin's F_t / (mu N) = 1 - (1 - 2 x / 3)^(3/2) is the mean of min(x, phi) over parts with
    the distribution P(phi) = 1 - (1 - 2 phi / 3)^(1/2) of limits (Iwan, J. Appl. Mech. 33, 1966).
    """
    quantiles = (np.arange(count) + 0.5) / count
    levels = 1.5 * (1.0 - (1.0 - quantiles) ** 2)
    return levels / levels.mean()


class PartialSlip(Effect):
    """Coulomb's sharp knee rounded as by Cattaneo and Mindlin, loops at reversals included.

    F_t = mu N [1 - (1 - u / u*)^(3/2)], u* = 3 mu N / (2 k_t), k_t = 8 G a / (2 - nu). The contact is a sum of equal
    parts, each simulated with a friction of its own (`slip_levels`): Masing's rule for reversals follows by itself.
    ``share`` mixes it with the base. A base that rubs node by node has it already: the linear gel engine follows
    Mindlin's curve within 2 % of mu N, so that on it a share other than 0 stands for something else.

    Source: Mindlin, J. Appl. Mech. 16, 1949; Iwan, J. Appl. Mech. 33, 1966.
    """

    name = "partial_slip"
    title = "partial slip (Cattaneo-Mindlin)"
    slot = "interface"
    parameters = (
        strength(
            "share", "1", "how much of the rounding is missing: 1 is all of it",
            bounds=(0.0, 2.0), plausible=(0.0, 1.5), deviation=0.4,
            source="0: none, 1: Mindlin's contact, more where parts of it differ more; estimate",
        ),
    )  # fmt: skip
    look_alikes = ("stem_bending", "static_friction", "lag", "rate_friction")
    distinguishing_trial = (
        "Small shear to and fro, below sliding: open loops without dependence on speed, an annulus in the image."
    )
    detectability = "At the knee 0.19 mu N: 0.8 N at 5 N and mu 0.8; nothing in the plateau, nor on a base that has it."
    reference = "Mindlin, J. Appl. Mech. 16, 1949"

    def change(self, state: TouchState, values: Mapping[str, float]) -> TouchState:
        parts = [state.rubbed(np.full(len(state.touch), level)).contact.wrench for level in slip_levels()]
        return state.with_interface(values["share"] * (sum(parts) / len(parts) - state.contact.wrench))
