"""Plans of touches of seven indenters on wedges: flat ones are tilted, and speeds, dwells and slides are drawn."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.prove.worlds.plan import ENOUGH, UNITS, WorldPlan, path_steps

INDENTERS: dict[str, dict[str, Any]] = {
    "ball3": {"shape": "sphere", "radius": 0.003},
    "ball6": {"shape": "sphere", "radius": 0.006},
    "punch": {"shape": "cylinder_flat", "radius": 0.002},
    "bar": {"shape": "cylinder_side", "radius": 0.003, "width": 0.008},
    "box": {"shape": "box", "width": 0.005, "breadth": 0.005, "length": 0.008},
    "cone": {"shape": "cone", "half_angle": 1.0, "tip_radius": 0.001},
    "dome": {"shape": "dome", "curvature_radius": 0.010, "radius": 0.004},
}
DEPTHS = {"ball3": (5e-4, 1.0e-3), "ball6": (5e-4, 0.9e-3), "punch": (3.5e-4, 6.5e-4), "bar": (4e-4, 8e-4),
          "box": (3.5e-4, 6e-4), "cone": (6e-4, 1.0e-3), "dome": (4e-4, 7e-4)}  # fmt: skip
"""Depths, m, between which a touch's deepest is drawn."""
WEDGES = {"ball3": 0.0, "ball6": 0.10, "punch": 0.04, "bar": 0.05, "box": 0.04, "cone": 0.08, "dome": 0.06}
"""Angle, rad, of the wedge under each indenter."""
COUNT, ON_FIRST = 36, 22
"""Number of touches of a whole plan, and of those on the first unit."""


@dataclass(frozen=True)
class WedgePlan(WorldPlan):
    """Touches of indenters on wedges.

    Parameters
    ----------
    number, is_quick, mounts
        See `WorldPlan`; the number of mounts has no meaning here.
    count : int
        Number of touches; a smaller plan has the first ones of a larger one.
    """

    count: int = COUNT

    @property
    def touches(self) -> list[dict[str, Any]]:
        """The touches of the plan, in the order in which they are played, one unit after the other."""
        chance = np.random.default_rng([self.number, 152])
        names = list(INDENTERS)
        told = []
        for number in range(self.count):
            name, sensor = names[number % len(names)], UNITS[0 if number * COUNT < ON_FIRST * self.count else 1]
            told.append({"name": f"{sensor}-{number}-{name}", "sensor": sensor, **_touch(chance, name)})
        return told

    def scenario(self, seed: int, material: GelMaterial, hidden: list[dict[str, Any]]) -> dict[str, Any]:
        """Return the scenario of a world of this plan, as a document; see `WorldPlan.scenario`.

        Parameters
        ----------
        seed, material, hidden
            See `WorldPlan.scenario`.
        """
        return {**super().scenario(seed, material, hidden), "indenters": INDENTERS}


def _touch(chance: np.random.Generator, indenter: str) -> dict[str, Any]:
    """Return a touch: press and dwell, mostly shear, dwell and shear back, then out in two parts."""
    deepest = float(chance.uniform(*DEPTHS[indenter]))
    speed = float(np.exp(chance.uniform(np.log(3e-4), np.log(4e-3))))
    settle = float(chance.uniform(0.08, 0.2))
    dwell = float(np.exp(chance.uniform(0.0, np.log(5.0))))
    steps = path_steps(chance, deepest, speed, settle, dwell, slides=0.8, lengths=(4e-4, 1.2e-3), returns=0.6, last=0.5)
    toward = chance.uniform(0.0, 2 * np.pi)
    tilt = WEDGES[indenter] + chance.uniform(-0.01, 0.01)
    return {
        "indenter": indenter,
        "steps": steps,
        "position": [float(chance.uniform(-3e-3, 3e-3)), float(chance.uniform(-4.5e-3, 4.5e-3))],
        "tilt": [float(tilt * np.cos(toward)), float(tilt * np.sin(toward))],
        "yaw": float(chance.uniform(-1.2, 1.2)),
        "force_limit": ENOUGH,
    }
