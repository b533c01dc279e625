"""The indenter sits elsewhere than stated, or is larger."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from tactiledata.effects.base import Effect
from tactiledata.effects.parameter import strength
from tactiledata.effects.touch.response import GelVariant
from tactiledata.effects.touch.state import TouchState

_PRINT = "estimate: tolerance of a printed part in a holder"


class MountOffset(Effect):
    """A rigid displacement of the tip and an error of the radius, both different for each indenter.

    d -> d + deeper, (x, y) -> (x, y) + R (x0, y0), R the turn of the indenter over the gel; all lengths of the
    indenter times 1 + radius_error. The displacement is kinematics; the gel engine plays the radius at -3 % and +3 %.

    Source: rigid-body kinematics.
    """

    name = "mount_offset"
    title = "indenter offset and radius"
    slot = "pose"
    parameters = (
        strength(
            "deeper", "m", "how much deeper the tip is than stated",
            bounds=(-1e-3, 1e-3), plausible=(-2e-4, 2e-4), deviation=1e-4, source=_PRINT,
        ),
        strength(
            "x", "m", "how much further along x of its own frame it is",
            bounds=(-3e-3, 3e-3), plausible=(-5e-4, 5e-4), deviation=3e-4, source=_PRINT,
        ),
        strength(
            "y", "m", "how much further along y of its own frame it is",
            bounds=(-3e-3, 3e-3), plausible=(-5e-4, 5e-4), deviation=3e-4, source=_PRINT,
        ),
        strength(
            "radius_error", "1", "share by which the indenter is larger than stated",
            bounds=(-0.1, 0.1), plausible=(-0.03, 0.03), deviation=0.015, source=_PRINT,
        ),
    )  # fmt: skip
    look_alikes = ("arm_compliance", "thickness", "heating", "dome")
    distinguishing_trial = (
        "The same press with two mountings of one indenter: the onset of contact moves with the mounting."
    )
    detectability = "0.1 mm is 0.6 to 1.5 N; a depth offset fitted for each trajectory hides it completely."
    reference = "rigid-body kinematics"
    designs: ClassVar = {"radius_error": (-0.03, 0.03)}
    varies_by = "indenter_name"

    def change(self, state: TouchState, values: Mapping[str, float]) -> TouchState:
        aside = state.touch.poses[:, :2, :2] @ np.array([values["x"], values["y"]])
        return state.moved(values["deeper"], aside)

    def variant(self, values: Mapping[str, float]) -> GelVariant:
        return GelVariant(indenter_scale=1.0 + values.get("radius_error", 0.0))
