"""Arm, mount and fixture yield to the contact force."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tactiledata.effects.base import Effect
from tactiledata.effects.parameter import shape, strength
from tactiledata.effects.touch.state import TouchState

_LEAN = "off the diagonal of J K^-1 J^T as large as half of it; estimate"


class ArmCompliance(Effect):
    """Springs between the encoders and the tip.

    The tip yields by c F in all directions, and across by a further c_r L^2 F, as the wrist turns by c_r L F under a
    force at the distance L. Depth and force are in balance: d = d0 - c F(d).
    An arm that is pushed straight back also yields to a side, by a lean l F_z. The direction of the lean is fixed to
    the bench, and so to an indenter that stands on it.

    Source: Dumas et al., Robotics and Computer-Integrated Manufacturing 27 (2011), joint stiffness of industrial arms;
    the range is that of a UR5e's tool, 30 to 300 N/mm.
    """

    name = "arm_compliance"
    title = "compliance of arm and mount"
    slot = "pose"
    parameters = (
        strength(
            "translation", "m/N", "how far the tip yields per newton, in all directions",
            bounds=(0.0, 1e-4), plausible=(0.0, 3e-5), deviation=1e-5,
            source="30 to 300 N/mm that encoders do not see; estimate",
        ),
        strength(
            "rotation", "rad/(N m)", "how far the wrist turns per newton metre",
            bounds=(0.0, 2e-3), plausible=(0.0, 1e-3), deviation=4e-4, source="0.1 to 1 mrad/(N m); estimate",
        ),
        strength(
            "lean_x", "m/N", "how far the tip yields along x of the indenter's frame, per newton of normal force",
            bounds=(-2.5e-5, 2.5e-5), plausible=(-2e-5, 2e-5), deviation=5e-6, source=_LEAN,
        ),
        strength(
            "lean_y", "m/N", "how far the tip yields along y of the indenter's frame, per newton of normal force",
            bounds=(-2.5e-5, 2.5e-5), plausible=(-2e-5, 2e-5), deviation=5e-6, source=_LEAN,
        ),
        shape(
            "lever", "m", "from wrist to tip",
            default=0.15, bounds=(0.05, 0.3), grid=(0.15,), source="flange, force sensor and holder of a UR5e",
        ),
    )  # fmt: skip
    look_alikes = ("thickness", "gain_crosstalk", "strain_stiffening", "stem_bending", "mount_offset")
    distinguishing_trial = "A flat punch pressed on a steel block: only the arm yields."
    detectability = "0.01 mm/N at 10 N is 0.1 mm: 0.6 to 1.5 N, 96 % of which E and nu take."
    reference = "Dumas et al., Robot. Comput.-Integr. Manuf. 27, 2011"
    feeds_back = True

    def change(self, state: TouchState, values: Mapping[str, float]) -> TouchState:
        across = values["translation"] + values["rotation"] * values["lever"] ** 2
        bench = np.nan_to_num(state.touch.poses[:, :2, :2])
        lean = (bench @ [values["lean_x"], values["lean_y"]]) * state.felt[:, 2:3]
        return state.moved(-values["translation"] * state.felt[:, 2], across * state.felt[:, :2] + lean)
