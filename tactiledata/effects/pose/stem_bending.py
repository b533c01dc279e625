"""The stem of the indenter bends under shear."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

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
    """A cantilever: the tip yields by c (F - (F . a) a), c = L^3 / (3 E I), with a the axis of the stem.

    Along its axis the stem is stiff. The axis is z of the indenter's frame: on a wedge, where it is not normal to the
    gel, the tip moves in depth, too, and the normal force bends the stem. The tip keeps its tilt.
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
        force, axis = state.felt[:, :3], np.nan_to_num(state.touch.poses[:, :3, 2])
        yielded = values["compliance"] * (force - (force * axis).sum(axis=1, keepdims=True) * axis)
        return state.moved(-yielded[:, 2], yielded[:, :2])
