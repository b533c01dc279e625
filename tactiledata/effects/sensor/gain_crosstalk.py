"""The force sensor has errors of its gains, and cross-talk between components."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tactiledata.effects.base import Effect
from tactiledata.effects.parameter import strength
from tactiledata.effects.touch.state import TouchState

_STUDY = "iCub sensors recalibrated in situ (arXiv 2312.09846)"


class GainCrosstalk(Effect):
    """A linear and a quadratic error of the force, F -> (I + C) F + quadratic F |F| by component; torques stay.

    ``xz`` is the share of the true z that shows in x. Gains are on the diagonal; Young's modulus takes up that of z.
    Cross-talk of a torque looks like cross-talk of the force behind it, times the lever from contact to sensor: 3 %
    over a gauge's arm of 50 mm become 9 % at a lever of 150 mm, so that more than 3 % of a force can be believed.

    Source: affine and polynomial sensor models, e.g. arXiv 2312.09846.
    """

    name = "gain_crosstalk"
    title = "gain and cross-talk of the force sensor"
    slot = "sensor"
    parameters = (
        *(
            strength(
                row + column, "1",
                f"error of the gain of {row}" if row == column else f"share of {column} that shows in {row}",
                bounds=(-0.3, 0.3),
                plausible=(-0.05, 0.05),
                deviation=0.02,
                source=_STUDY + "; size: estimate",
            )
            for row in "xyz"
            for column in "xyz"
        ),
        strength(
            "quadratic", "1/N", "gain that grows with the force",
            bounds=(-0.02, 0.02), plausible=(-2e-3, 2e-3), deviation=1e-3, source="1 to 2 % at 10 N; estimate",
        ),
    )  # fmt: skip
    look_alikes = ("frame_rotation", "arm_compliance", "thickness")
    distinguishing_trial = "Known masses hung from the sensor in three orientations: gains need no gel at all."
    detectability = "2 % of 5 N is 0.1 N; E takes the gain of z exactly, and 91 % is hidden from a loss of norms."
    reference = "arXiv 2312.09846"

    def change(self, state: TouchState, values: Mapping[str, float]) -> TouchState:
        matrix = np.array([[values[row + column] for column in "xyz"] for row in "xyz"])
        wrench = state.wrench.copy()
        force = wrench[:, :3]
        wrench[:, :3] = force + force @ matrix.T + values["quadratic"] * force * np.abs(force)
        return state.with_reading(wrench)
