"""A ball on a bonded layer in closed form: the smallest base simulation, for previews and examples."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import Array
from tactiledata.effects.closed_form.on_layer import OnLayer
from tactiledata.effects.touch.response import ContactResponse, GelVariant
from tactiledata.effects.touch.state import wrench_at

DIMITRIADIS = (0.0975, 0.769, 1.283, 1.133, 1.0)
"""Coefficients of powers of chi, highest first, for a ball on an incompressible bonded layer (Biophys. J. 82, 2002,
eq. 12)."""


class BallOnLayer(OnLayer):
    """Hertz's ball on a thin bonded layer, which sticks and slips as a spring under Coulomb's friction.

    F_z = 4/3 E* sqrt(R) d^1.5 f(sqrt(R d) / h), E* = E / (1 - nu^2); A = pi R d; tangential stiffness 8 G a / (2 - nu).
    At 1 mm depth it is 5 to 20 % off a gel at finite strain. Variants of the gel change it by rules of thumb.

    Parameters
    ----------
    touch : Touch
        The touch; its indenter has a ``radius``.
    """

    def _respond(self, offset: Array, shift: Array, friction: Array, gel: GelVariant) -> ContactResponse:
        # where the ball is, on a pad that may be thinner or a dome
        material = self.touch.material
        centre = self.touch.tips[:, :2] + shift
        thickness = self.touch.geometry.thickness * gel.thickness
        fall = thickness * gel.dome * (centre**2).sum(axis=1)
        depth = -self.touch.tips[:, 2] + offset - fall
        radius = self.touch.indenter.sizes["radius"] * gel.indenter_scale
        # a dome under a ball is a ball against a ball
        curvature = 1.0 / radius + 2.0 * thickness * gel.dome
        # normal force: Hertz on a layer, with the factors of the variant
        pressed = np.maximum(depth, 0.0)
        a = np.sqrt(pressed / curvature)
        modulus = material.youngs_modulus / (1.0 - material.poisson_ratio**2)
        bonded = np.full(len(a), DIMITRIADIS[0])
        for coefficient in DIMITRIADIS[1:]:
            bonded = bonded * (a / thickness) + coefficient
        normal = 4.0 / 3.0 * modulus * a * pressed * bonded
        if gel.c20 or gel.c30:
            # strain is about a fifth of a / R (Johnson, Contact Mechanics, ch. 6), I1 - 3 three times its square
            strain = 3.0 * (0.2 * a * curvature + pressed / thickness / 3.0) ** 2
            normal = normal * (1.0 + 2.0 * gel.c20 * strain + 3.0 * gel.c30 * strain**2)
        if gel.skin:
            # the factor is that of linear pads with stiffer uppermost cells, within a third
            normal = normal * (1.0 + 0.3 * gel.skin / np.maximum(a, 0.5 * gel.skin))
        # shear: one spring under Coulomb's limit
        spring = 8.0 * material.shear_modulus * a / (2.0 - material.poisson_ratio)
        shear, sliding = stick_and_slip(centre, spring, material.friction * friction * normal)
        force = np.column_stack([shear, normal])
        place = np.column_stack([centre, -pressed])
        touching = pressed > 0
        wrench = np.where((depth <= 0)[:, None], 0.0, wrench_at(force, place))
        return ContactResponse(wrench, np.pi * a**2, centre, depth, sliding & touching, spring)


def stick_and_slip(centre: Array, spring: Array, limit: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Return shear forces (n, 2), N, of a contact held by a spring under Coulomb's limit, and whether it slides (n,).

    Parameters
    ----------
    centre : (n, 2), m
        Centre of the contact, gel frame.
    spring : (n,), N/m
        Stiffness of the spring in each frame; where it is 0 the contact has no shear.
    limit : (n,), N
        Largest shear force in each frame.
    """
    # plain numbers: each frame needs the one before, and arrays of two are ten times as slow
    springs, limits = spring.tolist(), limit.tolist()
    x = y = 0.0
    forces, sliding = [x, y], [False]
    for frame, (along_x, along_y) in enumerate(np.diff(centre, axis=0).tolist(), start=1):
        slides = False
        if springs[frame] > 0.0:
            x, y = x - springs[frame] * along_x, y - springs[frame] * along_y
            size = math.hypot(x, y)
            slides = size > limits[frame]
            if slides:
                x, y = x * (limits[frame] / size), y * (limits[frame] / size)
        else:
            x = y = 0.0
        forces += (x, y)
        sliding.append(slides)
    return np.array(forces[: 2 * len(centre)]).reshape(-1, 2), np.array(sliding[: len(centre)], dtype=bool)
