"""The force sensor has errors of its gains, and cross-talk between components."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tactiledata.effects.base import Effect
from tactiledata.effects.parameter import strength
from tactiledata.effects.touch.state import TouchState

_STUDY = "iCub sensors recalibrated in situ (arXiv 2312.09846)"


class GainCrosstalk(Effect):
    """A linear and a quadratic error of what the force sensor reads: L -> (I + C) L, and quadratic F |F| on forces.

    L (6,) is the load in the sensor's own frame, force F and torque M; where a touch does not state that frame it
    counts as that of the gel. ``xz`` is the share of the true force along z that shows in x, ``mx`` the error of the
    gain of the torque about x, ``mx_z`` the torque about x that a newton along z shows, ``x_mz`` the force along x that
    a newton metre about z shows. Gains are on the diagonal; Young's modulus takes up that of z. Cross-talk of a torque
    looks like cross-talk of the force behind it, times the lever from contact to sensor: 3 % over a gauge's arm of
    50 mm become 9 % at a lever of 150 mm, so that more than 3 % of a force can be believed.

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
        *(
            strength(
                f"m{axis}", "1", f"error of the gain of the torque about {axis}",
                bounds=(-0.3, 0.3), plausible=(-0.05, 0.05), deviation=0.02, source=_STUDY + "; size: estimate",
            )
            for axis in "xyz"
        ),
        *(
            strength(
                f"m{row}_{column}", "m", f"torque about {row} that a force along {column} shows",
                bounds=(-0.015, 0.015),
                plausible=(-0.0025, 0.0025),
                deviation=0.001,
                source="cross-talk of a force, times a gauge's arm of 50 mm; estimate",
            )
            for row in "xyz"
            for column in "xyz"
        ),
        *(
            strength(
                f"{row}_m{column}", "1/m", f"force along {row} that a torque about {column} shows",
                bounds=(-6.0, 6.0),
                plausible=(-1.0, 1.0),
                deviation=0.4,
                source="cross-talk of a force, over a gauge's arm of 50 mm; estimate",
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
        forces = [[values[row + column] for column in "xyz"] for row in "xyz"]
        of_torques = [[values[f"{row}_m{column}"] for column in "xyz"] for row in "xyz"]
        of_forces = [[values[f"m{row}_{column}"] for column in "xyz"] for row in "xyz"]
        torques = np.diag([values[f"m{axis}"] for axis in "xyz"])
        matrix = np.block([[np.array(forces), np.array(of_torques)], [np.array(of_forces), torques]])
        load = state.touch.to_sensor(state.wrench)
        reading = load + load @ matrix.T
        reading[:, :3] += values["quadratic"] * load[:, :3] * np.abs(load[:, :3])
        return state.with_reading(state.touch.from_sensor(reading))
