"""LEDs and electronics warm the gel, which swells and changes its stiffness."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tactiledata.effects.base import Effect
from tactiledata.effects.parameter import shape, strength
from tactiledata.effects.touch.state import TouchState

EXPANSION = 3e-4
"""Coefficient of linear thermal expansion of silicone, 1/K."""


def swelling(rise: float, thickness: float, expansion: float = EXPANSION) -> float:
    """Height, m, by which a bonded gel rises when it is warmed.

    Parameters
    ----------
    rise : float
        Rise of the temperature, K.
    thickness : float
        Height of the gel, m.
    expansion : float
        Coefficient of linear thermal expansion, 1/K.

    Examples
    --------
    >>> round(swelling(10.0, 0.004) * 1e6)
    12
    """
    return expansion * rise * thickness


class Heating(Effect):
    """Stiffness times 1 + change s(t), and the surface higher by rise s(t), where s(t) = 1 - exp(-t / time).

    t is the time since power-on.

    Rubber elasticity stiffens in proportion to the absolute temperature, +0.3 %/K; silicone gels are also seen to
    soften, 0.2 to 1 %/K. Expansion of 3e-4/K times 4 mm times 10 K is 12 um.

    Source: Treloar, The Physics of Rubber Elasticity; Newton's law of cooling.
    """

    name = "heating"
    title = "heating of the gel"
    slot = "material"
    parameters = (
        strength(
            "change", "1", "share by which a warm gel is stiffer than a cold one",
            bounds=(-0.4, 0.2), plausible=(-0.15, 0.045), deviation=0.05, source="-1 to +0.3 %/K over 15 K; estimate",
        ),
        strength(
            "rise", "m", "how much higher a warm gel stands",
            bounds=(-1e-4, 1e-4), plausible=(0.0, 2e-5), deviation=8e-6, source="3e-4/K, 4 mm, 0 to 15 K",
        ),
        shape(
            "time", "s", "time constant of the warming",
            default=900.0, bounds=(60.0, 7200.0), grid=(400.0, 900.0, 2000.0), source="20 to 40 min to a steady state",
        ),
    )  # fmt: skip
    look_alikes = ("wear", "sensor_drift", "mullins")
    distinguishing_trial = (
        "The same press every five minutes from power-on, then after a pause: heating starts anew, wear goes on."
    )
    detectability = "10 K: 12 um are 0.12 N, 5 % of stiffness 0.25 N at 5 N; E hides 91 % of its variance."
    reference = "Treloar, The Physics of Rubber Elasticity"
    needs = ("powered",)

    def material_of(self, values: Mapping[str, float]) -> Mapping[str, str]:
        return {"E": "the gel at power-on"}

    def change(self, state: TouchState, values: Mapping[str, float]) -> TouchState:
        warm = -np.expm1(-state.covariate("powered", self.name) / values["time"])
        return state.moved(deeper=values["rise"] * warm).stiffened(1.0 + values["change"] * warm)
