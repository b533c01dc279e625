"""Shear force of a viscoelastic contact, which relaxes where it sticks and obeys friction where it slides."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import Array
from tactiledata.effects.touch.time_operators import fading_steps

ROUNDING = 1e-12
"""Share of the friction limit by which a shear may exceed it and still stick: rounding errors are no slip."""


def relaxing_shear(
    seconds: Array, elastic: Array, slides: NDArray[np.bool_], sliding: Array, limit: Array, share: float, time: float
) -> Array:
    """Shear force (n, 2), N, of a gel that relaxes, from the shear T (n, 2), N, of the fully relaxed gel.

    With S the strain times the relaxed stiffness, the shear is P = S + share * integral of exp(-(t - s) / time) dS(s).
    A contact that sticks follows the surface, dS = dT, and slips where P reaches the limit. A contact that slides has
    the shear of friction, and S is what gives that shear: when it comes to rest, it relaxes from there. In free air
    the memory is lost. Pairs (x, y) are kept as complex numbers x + i y.

    Parameters
    ----------
    seconds : (n,) s, ascending
        Times of the frames.
    elastic : (n, 2), N
        Shear T of the fully relaxed gel.
    slides : (n,) bool
        Whether the contact slides.
    sliding : (n, 2), N
        Shear of friction in frames in which the contact slides.
    limit : (n,), N
        Largest shear at which a contact sticks; 0 or less in free air.
    share : float
        Modulus that relaxes, over the relaxed modulus.
    time : float
        Time constant, s.
    """
    surface, slid = (pairs[:, 0] + 1j * pairs[:, 1] for pairs in (elastic, sliding))
    shear = surface.tolist()
    memory = ahead = 0j  # of S, and S - T
    before = shear[0] if shear else 0j
    rows = zip(*fading_steps(seconds, time), surface[1:], slides[1:], slid[1:], limit[1:], strict=True)
    for frame, (fade, gain, followed, slips, friction, most) in enumerate(rows, start=1):
        if most <= 0:
            memory = ahead = before = 0j
            continue
        # what sticks follows the surface
        left = fade * memory - gain * before
        strain = followed + ahead
        pull = strain + share * (left + gain * strain)
        size = abs(pull)
        # what slides has the shear of friction, and the strain that gives it
        if slips or size > (1 + ROUNDING) * most:
            pull = friction if slips else pull * (most / size)
            strain = (pull - share * left) / (1 + share * gain)
            ahead = strain - followed
        shear[frame] = pull
        memory, before = left + gain * strain, strain
    relaxed = np.array(shear, dtype=complex)
    return np.column_stack([relaxed.real, relaxed.imag])
