"""Shear that relaxes where it sticks and keeps to friction where it slides."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import Array
from tactiledata.effects.touch.time_operators import fading_steps

ROUNDING = 1e-12
"""Of the limit, by which shear may be beyond it."""


def relaxing_shear(
    seconds: Array, elastic: Array, slides: NDArray[np.bool_], sliding: Array, limit: Array, share: float, time: float
) -> Array:
    """Shear (n, 2), N, of a gel that relaxes, from its relaxed elastic answer T (n, 2), N.

    A spring whose strain is S pulls with P = S + share * integral of exp(-(t - s) / time) dS(s). What sticks follows
    the surface, dS = dT, and slips where P comes to the limit. What slides pulls as friction asks, and S is what leads
    to that: a contact that comes to rest relaxes from there. In the air all is forgotten. Pairs x, y are x + i y.

    Parameters
    ----------
    seconds : (n,), ascending
    elastic : (n, 2), N
        T.
    slides : (n,) bool
    sliding : (n, 2), N
        Pull of what slides.
    limit : (n,), N
        Of what sticks; 0 or less in the air.
    share, time
        See `tactiledata.effects.time.relaxation.Relaxation`.
    """
    surface, slid = (one[:, 0] + 1j * one[:, 1] for one in (elastic, sliding))
    shear = surface.tolist()
    memory = ahead = 0j  # of S, and S - T
    before = shear[0] if shear else 0j
    rows = zip(*fading_steps(seconds, time), surface[1:], slides[1:], slid[1:], limit[1:], strict=True)
    for frame, (fade, gain, told, slips, wanted, most) in enumerate(rows, start=1):
        if most <= 0:
            memory = ahead = before = 0j
            continue
        left = fade * memory - gain * before
        strain = told + ahead
        pull = strain + share * (left + gain * strain)
        size = abs(pull)
        if slips or size > (1 + ROUNDING) * most:
            pull = wanted if slips else pull * (most / size)
            strain = (pull - share * left) / (1 + share * gain)
            ahead = strain - told
        shear[frame] = pull
        memory, before = left + gain * strain, strain
    found = np.array(shear, dtype=complex)
    return np.column_stack([found.real, found.imag])
