"""A flat punch on a bonded layer in closed form."""

from __future__ import annotations

import numpy as np

from tactiledata.arrays import Array
from tactiledata.effects.closed_form.ball_on_layer import stick_and_slip
from tactiledata.effects.closed_form.on_layer import OnLayer
from tactiledata.effects.touch.response import ContactResponse, GelVariant
from tactiledata.effects.touch.state import wrench_at

GARCIA = (-0.291, 0.598, 1.283, 1.133, 1.0)
"""Coefficients of powers of a / h, highest first, for a flat punch on an incompressible bonded layer (Biophys. J. 114,
2018)."""


class PunchOnLayer(OnLayer):
    """A round flat punch that stands square on the gel and has the friction of one spring under Coulomb's limit.

    F_z = 2 E* a d f(a / h), E* = E / (1 - nu^2); tangential stiffness 8 G a / (2 - nu). Variants of the gel change it
    by rules of thumb. The tilt of a punch is ignored.

    Parameters
    ----------
    touch : Touch
        The touch; its indenter has a ``radius``.
    """

    def _respond(self, offset: Array, shift: Array, friction: Array, gel: GelVariant) -> ContactResponse:
        material = self.touch.material
        centre = self.touch.tips[:, :2] + shift
        thickness = self.touch.geometry.thickness * gel.thickness
        a = self.touch.indenter.sizes["radius"] * gel.indenter_scale
        depth = -self.touch.tips[:, 2] + offset - thickness * gel.dome * (centre**2).sum(axis=1)
        # normal force: a punch on a layer, with the factors of the variant
        pressed = np.maximum(depth, 0.0)
        touching = pressed > 0
        modulus = material.youngs_modulus / (1.0 - material.poisson_ratio**2)
        normal = 2.0 * modulus * a * pressed * np.polyval(GARCIA, a / thickness)
        strain = 3.0 * (pressed / a / 3.0 + pressed / thickness / 3.0) ** 2
        normal = normal * (1.0 + 2.0 * gel.c20 * strain + 3.0 * gel.c30 * strain**2) * (1.0 + 0.3 * gel.skin / a)
        # shear: one spring under Coulomb's limit
        spring = np.where(touching, 8.0 * material.shear_modulus * a / (2.0 - material.poisson_ratio), 0.0)
        shear, sliding = stick_and_slip(centre, spring, material.friction * friction * normal)
        wrench = wrench_at(np.column_stack([shear, normal]), np.column_stack([centre, -pressed]))
        wrench = np.where(touching[:, None], wrench, 0.0)
        area = np.where(touching, np.pi * a**2, 0.0)
        return ContactResponse(wrench, area, centre, depth, sliding & touching, spring)
