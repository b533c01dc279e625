"""Friction depends on the area of contact beside the load."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tactiledata.arrays import Array
from tactiledata.effects.base import Effect
from tactiledata.effects.parameter import shape, strength
from tactiledata.effects.touch.state import TouchState


class AreaFriction(Effect):
    """Friction follows the area of contact: a shear strength is added to Coulomb's law, or limits it.

    Added: F_t = tau A + alpha N, alpha = mu - tau / p0. The factor on mu is 1 + tau / mu (A / N - 1 / p0): light, wide
    contacts have a larger mu; that of a ball is about in proportion to N^(-1/3).

    Limited: nowhere in the contact is the shear stress larger than 1 / saturation. With Coulomb's law below it and
    Hertz's pressure, whose mean is p, F_t = mu N (3 k - k^3) / 2, k = 2 / (3 mu p saturation), at most 1. Under high
    pressure F_t = A / saturation, as where only a shear strength acts.

    In both, friction is as simulated at the mean pressure p0.

    Source: Bowden and Tabor's shear strength; Trejo, Fretigny and Chateauminois, arXiv 1701.08013: under a smooth lens
    the local shear stress on rubber does not depend on pressure. The sum over Hertz's pressure is ours.
    """

    name = "area_friction"
    title = "friction by area"
    slot = "interface"
    parameters = (
        strength(
            "shear_strength", "Pa", "tau: friction per area of contact",
            bounds=(-2e5, 4e5), plausible=(0.0, 4e5), deviation=1e5, source="0.05 to 0.4 MPa of silicones",
        ),
        strength(
            "saturation", "1/Pa", "1 over the largest shear stress that the interface carries",
            bounds=(0.0, 1e-4), plausible=(0.0, 2e-5), deviation=5e-6, grid=(2.5e-6, 1e-5),
            source="0.05 to 0.4 MPa of silicones",
        ),
        shape(
            "pressure", "Pa", "p0: mean pressure at which friction is as simulated",
            default=3e5, bounds=(1e4, 3e6), grid=(3e5,), source="a 4 mm ball, 0.5 mm deep",
        ),
    )  # fmt: skip
    look_alikes = ("rate_friction", "partial_slip", "static_friction", "adhesion")
    distinguishing_trial = (
        "Slides at one speed under 1, 3 and 10 N, with a ball and a flat punch: mu follows A / N, not speed."
    )
    detectability = "0.1 MPa: mu differs by 0.2 between 2 and 10 N of a 4 mm ball, 0.3 N of shear at 2 N."
    reference = "Trejo, Fretigny and Chateauminois, arXiv 1701.08013"

    def material_of(self, values: Mapping[str, float]) -> Mapping[str, str]:
        return {"mu": f"a contact under a mean pressure of {1e-6 * values['pressure']:g} MPa"}

    def change(self, state: TouchState, values: Mapping[str, float]) -> TouchState:
        contact, mu = state.contact, state.touch.material.friction
        if mu == 0.0:
            return state
        normal = contact.wrench[:, 2]
        presses = contact.touching & (normal > 0)
        spread = np.divide(contact.area, normal, out=np.full_like(normal, 1.0 / values["pressure"]), where=presses)
        added = 1.0 + values["shear_strength"] / mu * (spread - 1.0 / values["pressure"])
        usual = np.array([1.0 / values["pressure"]])
        limited = (_share_of_coulomb(one, mu * values["saturation"]) for one in (spread, usual))
        return state.rubbed(added * np.divide(*limited))


def _share_of_coulomb(spread: Array, softness: float) -> Array:
    """Share (n,) of Coulomb's friction that a limited shear stress leaves under Hertz's pressure.

    Parameters
    ----------
    spread : (n,) 1/Pa
        Area of contact over normal force.
    softness : 1/Pa
        Coefficient of friction over the largest shear stress.
    """
    if softness == 0.0:
        return np.ones_like(spread)
    # radius, over that of the contact, within which the stress is limited: sqrt(1 - k^2)
    k = np.minimum(1.0, 2.0 * spread / (3.0 * softness))
    limited: Array = 0.5 * (3.0 * k - k**3)
    return limited
