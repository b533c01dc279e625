"""The pad is softer near its border, and the rim of the housing stands beyond it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tactiledata.effects.base import Effect
from tactiledata.effects.parameter import shape, strength
from tactiledata.effects.touch.state import TouchState, wrench_at


class PadEdge(Effect):
    """A border that is softer than simulated, and a housing on which a wide indenter comes to rest.

    Within about one contact radius a of the border the stiffness falls: factor 1 - drop exp(-b / a), b the distance of
    the contact's centre from the nearest side of the outline, less an inset where the pad ends before it. Where the
    indenter reaches below the rim at the border, the housing pushes with k times the overlap, at the border.

    Source: geometry; the reach of one contact radius is that of the elastic half space's border.
    """

    name = "pad_edge"
    title = "edge of the pad and housing"
    slot = "geometry"
    parameters = (
        strength(
            "drop", "1", "share of the stiffness that is lost at the border",
            bounds=(-0.5, 0.9), plausible=(-0.2, 0.5), deviation=0.2, source="estimate",
        ),
        strength(
            "housing", "N/m", "stiffness of the housing's rim under an indenter that reaches it",
            bounds=(0.0, 1e6), plausible=(0.0, 2e5), deviation=5e4, source="estimate: plastic on a plastic rim",
        ),
        shape(
            "inset", "m", "by how much the pad is smaller than its stated outline, on every side",
            default=0.0, bounds=(0.0, 8e-3), grid=(0.0, 2e-3, 4e-3, 6e-3), source="gels cut or cast short; estimate",
        ),
    )  # fmt: skip
    look_alikes = ("dome", "soft_region", "thickness")
    distinguishing_trial = "The same press at 1, 2, 4 and 8 mm from the border: only the nearest differ."
    detectability = (
        "A drop of 30 % is 0.5 N of 5 at one contact radius (1 to 2 mm) from the border; 8 mm further in nothing."
    )
    reference = "geometry"

    def material_of(self, values: Mapping[str, float]) -> Mapping[str, str]:
        return {"E": "the gel away from its border"}

    def change(self, state: TouchState, values: Mapping[str, float]) -> TouchState:
        contact, geometry = state.contact, state.touch.geometry
        # softer gel within about one contact radius of the nearest side
        half = np.asarray(geometry.outline) / 2.0
        room = half - np.abs(contact.centre)
        side = np.argmin(room, axis=1)
        distance = np.maximum(room[np.arange(len(room)), side] - values["inset"], 0.0)
        reach = np.where(contact.touching, contact.radius, 1.0)
        state = state.stiffened(np.where(contact.touching, 1.0 - values["drop"] * np.exp(-distance / reach), 1.0))
        if values["housing"] == 0.0:
            return state
        # the rim under that side, where the indenter reaches below it
        border = contact.centre.copy()
        rows = np.arange(len(border))
        border[rows, side] = np.where(border[rows, side] < 0, -half[side], half[side])
        above = state.touch.indenter.height(*(border - contact.centre).T)
        overlap = contact.depth - above - (geometry.thickness - geometry.edge_thickness)
        push = np.zeros((len(border), 3))
        push[:, 2] = values["housing"] * np.maximum(overlap, 0.0)
        return state.with_interface(wrench_at(push, border))
