"""Plans of touches for worlds of known truth: what the arm is told, the same in every world of a plan."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tactiledata.calibrate.bounds import LARGEST_NU, Bounds
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.gel.mesh.pad import PadMesh
from tactiledata.gel.mesh.structured_pad import GridPlan, pad_mesh, structured_pad
from tactiledata.replay.geometry import gel_geometry
from tactiledata.rig.scenario.scenario import Gel
from tactiledata.sensors.base import GelGeometry

INDENTERS: dict[str, dict[str, Any]] = {
    "ball3": {"shape": "sphere", "radius": 0.003},
    "ball5": {"shape": "sphere", "radius": 0.005},
    "ball8": {"shape": "sphere", "radius": 0.008},
    "punch": {"shape": "cylinder_flat", "radius": 0.0025},
    "bar": {"shape": "cylinder_side", "radius": 0.003, "width": 0.006},
}
DEPTHS = {"ball3": (5.5e-4, 8e-4), "ball5": (5.5e-4, 8e-4), "ball8": (5e-4, 7e-4), "punch": (4e-4, 6e-4),
          "bar": (4.5e-4, 6.5e-4)}  # fmt: skip
TILTS = {"punch": 0.03, "bar": 0.04}
UNITS = ("D20542", "D20571")
SPEEDS = (3e-4, 1e-3, 3e-3)
ENOUGH = 40.0
"""Limit of force, N: no touch of a plan comes near, so that no path depends on what the gel answers."""


@dataclass(frozen=True)
class WorldPlan:
    """Touches, and a gel that they are made with.

    Parameters
    ----------
    number : int
        Seed of the draws of touches, and of the gel's nu and mu.
    is_quick : bool
        Few touches, and a coarse pad of small strain.
    mounts : int
        How often each indenter is mounted, for one touch each time; a little oftener on the first unit.
    """

    number: int
    is_quick: bool = False
    mounts: int = 5

    @property
    def truth(self) -> GelMaterial:
        """The gel's nu and mu; each world draws its own E about the one given."""
        chance = np.random.default_rng([self.number, 51])
        return GelMaterial(0.9e6, round(chance.uniform(0.465, 0.485), 3), round(chance.uniform(0.55, 0.7), 2))

    @property
    def bounds(self) -> Bounds:
        """Bounds within which the gel is played: mu from that of a slow slide to that of a contact that was held."""
        return Bounds("naming", (2e5, 0.45, 0.4), (4e6, LARGEST_NU, 0.85), (0.4, 0.6, 0.85))

    @property
    def pitch(self) -> float:
        """Spacing, m, of the grid of the rig's layer."""
        return 8e-4 if self.is_quick else 4e-4

    @property
    def mesh(self) -> PadMesh:
        """The pad that is fitted, as a log of the rig describes it."""
        if self.is_quick:
            layers = (0.0, 0.5, 0.8, 1.0)
            return structured_pad("coarse", self.geometry, GridPlan(7, 9, 0.8e-3, (2.4e-3, 2.4e-3), layers))
        return pad_mesh("digit", self.geometry)

    @property
    def geometry(self) -> GelGeometry:
        """The shape of the rig's flat gel, as a log describes it."""
        gel = Gel()
        facts = {"outline": gel.outline, "thickness": gel.thickness, "edge_thickness": gel.thickness}
        found = gel_geometry({"model": "digit", "gel": facts})
        assert found is not None
        return found

    @property
    def touches(self) -> list[dict[str, Any]]:
        """The touches of the plan, in the order in which they are played, one unit after the other."""
        chance = np.random.default_rng([self.number, 52])
        told = []
        for sensor, mounts in zip(UNITS, (self.mounts - self.mounts * 2 // 5, self.mounts * 2 // 5), strict=True):
            for mount in range(mounts):
                for indenter in INDENTERS:
                    touch = _touch(chance, indenter)
                    told.append({"name": f"{sensor}-{mount}-{indenter}-0", "sensor": sensor, **touch})
        return told[:5] + told[-5:] if self.is_quick else told

    def scenario(self, seed: int, material: GelMaterial, hidden: list[dict[str, Any]]) -> dict[str, Any]:
        """Return the scenario of a world of this plan, as a document.

        Parameters
        ----------
        seed : int
            Seed of the world's noise and offsets.
        material : GelMaterial
            The real gel.
        hidden : list of dict
            Hidden effects as a scenario states them.
        """
        return {
            "format": "tactiledata-scenario/1",
            "title": f"naming, plan {self.number}",
            "seed": seed,
            "sensors": {serial: {"background": "digit-bg-0"} for serial in UNITS},
            "indenters": INDENTERS,
            "material": {
                "youngs_modulus": material.youngs_modulus,
                "poisson_ratio": material.poisson_ratio,
                "friction": material.friction,
            },
            "contact": "layer",
            "contact_pitch": self.pitch,
            "streams": {"joints": 0, "tcp": 125, "wrench": 100, "arm_wrench": 0},
            "imperfections": {"pose_repeatability": 3e-5, "remount": 2e-5, "force_drift": 0.02},
            "recordings": {"tare": "log", "pause": 2.0, "powered": 60},
            "trajectories": self.touches,
            "hidden": hidden,
        }


def _touch(chance: np.random.Generator, indenter: str) -> dict[str, Any]:
    """Return a touch: press and dwell, mostly shear, dwell and shear back, then out in two parts."""
    deepest = float(chance.uniform(*DEPTHS[indenter]))
    speed = float(chance.choice(SPEEDS))
    settle = float(chance.uniform(0.08, 0.15))
    dwell = float(np.exp(chance.uniform(0.0, np.log(4.0))))
    steps = path_steps(
        chance, deepest, speed, settle, dwell, slides=0.75, lengths=(6e-4, 1.4e-3), returns=0.75, last=0.55
    )
    tilt, toward = chance.uniform(0.0, TILTS.get(indenter, 0.1)), chance.uniform(0.0, 2 * np.pi)
    return {
        "indenter": indenter,
        "steps": steps,
        "position": [float(chance.uniform(-2.5e-3, 2.5e-3)), float(chance.uniform(-4e-3, 4e-3))],
        "tilt": [float(tilt * np.cos(toward)), float(tilt * np.sin(toward))],
        "yaw": float(chance.uniform(-1.2, 1.2)),
        "force_limit": ENOUGH,
    }


def path_steps(
    chance: np.random.Generator,
    deepest: float,
    speed: float,
    settle: float,
    dwell: float,
    *,
    slides: float,
    lengths: tuple[float, float],
    returns: float,
    last: float,
) -> list[dict[str, Any]]:
    """Return the steps of a touch: press and dwell, perhaps slide, dwell and slide back, then out in two parts.

    Parameters
    ----------
    chance : Generator
        Draws whether and how it slides.
    deepest : m
        Depth of the press.
    speed : m/s
        Speed of every step.
    settle, dwell : s
        Rest after each step, and at the depth.
    slides, returns : float
        Chance that it slides, and that a slide turns back.
    lengths : (low, high) m
        Between which the length of a slide is drawn.
    last : float
        Depth of the first part out, as a share of the deepest.
    """
    moving = {"speed": speed, "settle": settle}
    steps: list[dict[str, Any]] = [
        {"press": {"depth": deepest, "step": deepest / 4, **moving}},
        {"dwell": {"time": dwell, "captures": 3}},
    ]
    if chance.random() < slides:
        length, way = float(chance.uniform(*lengths)), float(chance.uniform(0.0, 2 * np.pi))
        by = [length * float(np.cos(way)), length * float(np.sin(way))]
        steps.append({"shear": {"by": by, "step": length / 3, **moving}})
        steps.append({"dwell": {"time": dwell / 2, "captures": 1}})
        if chance.random() < returns:
            steps.append({"reverse": {"step": length / 2, **moving}})
    steps.append({"press": {"depth": last * deepest, "step": deepest, **moving}})
    steps.append({"retreat": {"speed": speed}})
    return steps
