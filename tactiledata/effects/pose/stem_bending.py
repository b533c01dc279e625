"""The stem of the indenter bends under shear."""

from __future__ import annotations

import math
from collections.abc import Mapping

from tactiledata.effects.base import Effect
from tactiledata.effects.parameter import strength
from tactiledata.effects.touch.state import TouchState


def stem_stiffness(diameter: float, length: float, modulus: float = 2.5e9) -> float:
    """Stiffness, N/m, of a round bar that is clamped at one end against a force across its other end, 3 E I / L^3.

    Parameters
    ----------
    diameter, length : float
        Of the bar, m.
    modulus : float
        Young's modulus of the bar, Pa; that of a print by default.

    Examples
    --------
    A printed stem, 4 mm thick and 30 mm long, in N/mm:

    >>> round(stem_stiffness(0.004, 0.030) / 1000, 1)
    3.5
    """
    return 3.0 * modulus * math.pi * diameter**4 / 64.0 / length**3


class StemBending(Effect):
    """A cantilever: the tip yields across by c F_t, c = L^3 / (3 E I); along its axis it is stiff.

    Each indenter has a stem of its own: restrict a setting to one indenter by ``where``.

    Source: Euler-Bernoulli beam.
    """

    name = "stem_bending"
    title = "bending of the indenter's stem"
    slot = "pose"
    parameters = (
        strength(
            "compliance", "m/N", "how far the tip yields across, per newton",
            bounds=(0.0, 5e-4), plausible=(0.0, 2.9e-4), deviation=1e-4,
            source="3 E I / L^3 of printed stems, 4 to 10 mm thick and 30 mm long: 3.5 to 140 N/mm",
        ),
    )  # fmt: skip
    look_alikes = ("arm_compliance", "partial_slip", "lag")
    distinguishing_trial = (
        "The same slide with a thick and a thin stem: shear stiffness follows the stem, the normal force does not."
    )
    detectability = "Stick only: a stem of 3.5 N/mm halves the shear stiffness of 2 to 4 N/mm; a slide's plateau stays."
    reference = "Euler-Bernoulli beam theory"
    feeds_back = True

    def change(self, state: TouchState, values: Mapping[str, float]) -> TouchState:
        return state.moved(along=values["compliance"] * state.felt[:, :2])
