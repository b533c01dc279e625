"""A spot of the gel is softer: a bubble, a defect, or a part that came off the backing."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tactiledata.effects.base import Effect
from tactiledata.effects.parameter import shape, strength
from tactiledata.effects.touch.response import GelVariant, SoftSpot
from tactiledata.effects.touch.state import TouchState, wrench_at

_SPOT = "digit-design issue 40 (bubbles, defects of the adhesive layer), digit-interface issue 15"

SPREAD = (0.6, 0.03)
"""Factors on the squares of contact radius and thickness whose sum is the variance of the elastic energy along the
surface."""


class SoftRegion(Effect):
    """A spot of the gel that is softer, for contacts over and beside it.

    To first order in the loss, the stiffness falls by the mean of the loss, weighted by the elastic energy. The energy
    of a contact of radius a on a gel of thickness h is taken as a Gaussian of variance s^2 = 0.6 a^2 + 0.03 h^2 about
    its centre c, the spot as exp(-|x - x0|^2 / (2 R^2)). Then w = R^2 / (R^2 + s^2) exp(-|c - x0|^2 / (2 (R^2 +
    s^2))). The force is multiplied by 1 - loss w, and the centre of pressure moves away from the spot by a^2 / 5 grad
    ln(1 - loss w), a^2 / 5 being the second moment of Hertz's pressure. s^2 is fitted to linear pads with a spot of
    modulus 0.7 E: losses agree within a quarter, shifts within some 10 um.
    Shear is softened while it sticks, and beyond a traction ``onset``, where the backing begins to slip; sliding shear
    stays mu N.
    The gel engine does not play spots for wrenches: there are too many places and sizes.

    Source: perturbation of the elastic energy (Hellmann-Feynman), convolution of Gaussians.
    """

    name = "soft_region"
    title = "bubble or delamination"
    slot = "geometry"
    parameters = (
        strength(
            "normal_loss", "1", "share of the normal stiffness that the spot has lost",
            bounds=(0.0, 0.9), plausible=(0.0, 0.5), deviation=0.2, source=_SPOT + "; size: estimate",
        ),
        strength(
            "shear_loss", "1", "share of the shear stiffness that the spot has lost",
            bounds=(0.0, 0.9), plausible=(0.0, 0.5), deviation=0.2, source=_SPOT + "; size: estimate",
        ),
        shape("x", "m", "where it lies", default=0.0, bounds=(-0.02, 0.02), grid=(-4e-3, 0.0, 4e-3), source="the gel"),
        shape("y", "m", "where it lies", default=0.0, bounds=(-0.02, 0.02), grid=(-5e-3, 0.0, 5e-3), source="the gel"),
        shape(
            "radius", "m", "standard deviation of the spot",
            default=2e-3, bounds=(2e-4, 0.01), grid=(1e-3, 3e-3), source="bubbles of 1 to 3 mm; estimate",
        ),
        shape(
            "onset", "Pa", "mean shear traction from which shear is softened",
            default=0.0, bounds=(0.0, 1e6), grid=(0.0,), source="estimate",
        ),
    )  # fmt: skip
    look_alikes = ("dome", "pad_edge", "wear", "mullins")
    distinguishing_trial = (
        "The same press on a grid of places, on two sensors: the loss stays with one place of one sensor."
    )
    detectability = "30 % in a 2 mm spot under the contact are 0.9 N of 5; 6 mm beside it 0.05 N are left."
    reference = "first-order perturbation of the elastic energy"

    def material_of(self, values: Mapping[str, float]) -> Mapping[str, str]:
        return {"E": "the gel away from the spot"}

    def change(self, state: TouchState, values: Mapping[str, float]) -> TouchState:
        contact = state.contact
        away = contact.centre - [values["x"], values["y"]]
        energy = SPREAD[0] * contact.radius**2 + SPREAD[1] * state.touch.geometry.thickness**2
        width = values["radius"] ** 2 + energy
        weight = values["radius"] ** 2 / width * np.exp(-(away**2).sum(axis=1) / (2.0 * width))
        normal = 1.0 - values["normal_loss"] * weight
        shear = 1.0 - values["shear_loss"] * weight * self._beyond_onset(state, values["onset"])
        # softer while it sticks, but sliding at mu N all the same
        rubbed = state.rubbed(normal / shear)
        answer = rubbed.contact
        softened = answer.wrench * normal[:, None]
        # shear has a loss of its own
        otherwise = answer.wrench[:, :3] * np.column_stack([shear - normal, shear - normal, np.zeros(len(shear))])
        softened += wrench_at(otherwise, np.column_stack([answer.centre, -np.maximum(answer.depth, 0.0)]))
        # the centre of pressure moves away from the spot
        moved = away * (contact.radius**2 / 5.0 * values["normal_loss"] * weight / (width * normal))[:, None]
        softened[:, 3:] += wrench_at(softened[:, :3] * [0.0, 0.0, 1.0], moved)[:, 3:]
        return rubbed.with_elastic((softened - answer.wrench) / state.stiffness[:, None])

    def variant(self, values: Mapping[str, float]) -> GelVariant:
        complete = self.complete(values)
        return GelVariant(spots=(SoftSpot(complete["x"], complete["y"], complete["radius"], complete["normal_loss"]),))

    def parameters_not_played_by_gel(self, values: Mapping[str, float]) -> Mapping[str, float]:
        complete = self.complete(values)
        # a softer modulus loses both alike
        lost = complete["normal_loss"]
        further = max((complete["shear_loss"] - lost) / (1.0 - lost), 0.0)
        return {**complete, "normal_loss": 0.0, "shear_loss": further}

    @staticmethod
    def _beyond_onset(state: TouchState, onset: float) -> np.ndarray:
        """Share (n,) of the shear traction that lies beyond the onset."""
        contact = state.contact
        shear = np.linalg.norm(contact.wrench[:, :2], axis=1)
        kept = np.divide(onset * contact.area, shear, out=np.ones_like(shear), where=shear > 0)
        return np.maximum(1.0 - kept, 0.0)
