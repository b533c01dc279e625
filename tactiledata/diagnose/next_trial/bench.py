"""The rig on which a trial would be recorded, and a simulation in closed form that plays touches there."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.touches.touch_case import BaseFamily, TouchSet
from tactiledata.effects.closed_form.ball_on_layer import BallOnLayer
from tactiledata.effects.closed_form.punch_on_layer import PunchOnLayer
from tactiledata.effects.touch.response import BaseResponse
from tactiledata.effects.touch.touch import Touch
from tactiledata.errors import UsageError
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.indenters.base import Indenter
from tactiledata.indenters.cylinder_flat import CylinderFlat
from tactiledata.indenters.sphere import Sphere
from tactiledata.nuisance.noise import WrenchNoise

SHAPES: dict[str, Callable[[Touch], BaseResponse]] = {"sphere": BallOnLayer, "cylinder_flat": PunchOnLayer}
"""Shapes of indenters with a closed form."""


def closed_form(material: GelMaterial) -> Callable[[Touch], BaseResponse]:
    """Return the simulation of balls and flat punches in closed form (a `BaseFamily`).

    Its forces are 5 to 20 % off at a depth of 1 mm, which hardly changes how far two effects are apart.

    Raises
    ------
    UsageError
        The touch is of another shape: raised by what is returned.
    """
    return _respond


def _respond(touch: Touch) -> BaseResponse:
    """Return the closed form that answers for a touch."""
    shape = touch.indenter.shape
    if shape not in SHAPES:
        raise UsageError(
            f"indenter {shape!r} has no closed form here", f"one of: {', '.join(SHAPES)}", "Give a gel that plays it."
        )
    return SHAPES[shape](touch)


Place = tuple[float, float]

FORCE_LIMIT = 13.0
"""Largest force of the recording protocol, N."""
RESERVE = 0.85
"""Share of the force limit that is used: the missing effect may make the gel stiffer than expected."""
DEEPEST, DEEPEST_SHARE = 1.0e-3, 0.25
"""Largest depth, m, and as a share of the gel's thickness."""
MARGIN = 1e-3
"""Smallest distance between the rim of a contact and the rim of the pad, m."""
RADII = (0.002, 0.004, 0.008)
"""Radii of balls, m, that separate layer, coating and strain; balls at hand serve where their radius is near."""


@dataclass(frozen=True)
class TrialBench:
    """The rig on which a trial would be recorded.

    Parameters
    ----------
    touch : Touch
        A recorded touch: gives sensor, gel, orientation and joints.
    indenters : dict, name -> Indenter
        Indenters at hand.
    material : GelMaterial
    noise : WrenchNoise
    free_samples : float
        Number of readings in free air from which a zero is taken.
    visited : (p, 2) m
        Places on the gel that were touched before.
    base : BaseFamily
        The simulation that plays trials.
    force_limit : float
        Largest force, N.
    """

    touch: Touch
    indenters: Mapping[str, Indenter]
    material: GelMaterial
    noise: WrenchNoise
    free_samples: float
    visited: Array
    base: BaseFamily = closed_form
    force_limit: float = FORCE_LIMIT

    @staticmethod
    def of(cases: TouchSet, material: GelMaterial, base: BaseFamily | None = None) -> TrialBench:
        """Return the rig of recorded trajectories, with the sensor of the first one.

        Parameters
        ----------
        cases : TouchSet
            The recorded trajectories.
        material : GelMaterial
            The fitted gel.
        base : BaseFamily, optional
            The simulation that plays trials; the closed form by default.
        """
        first = cases.touches[0]
        own = [case.touch for case in cases.touches if case.touch.sensor == first.touch.sensor]
        # the place of a touch is where it is deepest
        places = [touch.tips[np.argmin(np.nan_to_num(touch.tips[:, 2], nan=np.inf)), :2] for touch in own]
        named = zip(cases.indenters, (case.touch.indenter for case in cases.touches), strict=True)
        known = np.array(places).reshape(-1, 2)
        return TrialBench(
            first.touch, dict(named), material, first.noise, first.free_samples, known, base or closed_form
        )

    @cached_property
    def ball(self) -> str:
        """Name of the ball whose radius is nearest to 4 mm."""
        return self.ball_near(0.004)

    @property
    def balls(self) -> tuple[str, ...]:
        """Names of balls near the radii `RADII`, ascending."""
        return tuple(dict.fromkeys(self.ball_near(radius) for radius in RADII))

    def ball_near(self, radius: float) -> str:
        """Return the name of a ball at hand within a third of a radius, m; else the name of a ball to be made."""
        radii = {name: indenter.radius for name, indenter in self.indenters.items() if isinstance(indenter, Sphere)}
        near = min(radii, key=lambda name: abs(np.log(radii[name] / radius)), default="")
        if near and abs(np.log(radii[near] / radius)) < 0.3:
            return near
        return self._free_name(f"ball_{1e3 * radius:g}mm")

    @cached_property
    def punch(self) -> str:
        """Name of a flat punch at hand; of a punch to be made where there is none."""
        punches = [name for name, indenter in self.indenters.items() if isinstance(indenter, CylinderFlat)]
        return punches[0] if punches else self._free_name("punch_3mm")

    def _free_name(self, name: str) -> str:
        """Return a name that no indenter at hand has."""
        return name if name not in self.indenters else f"{name}_new"

    def indenter(self, name: str) -> Indenter:
        """Return the indenter of a name: at hand, or to be made."""
        if name in self.indenters:
            return self.indenters[name]
        if name.startswith("punch"):
            return CylinderFlat(0.003)
        return Sphere(float(name.removeprefix("ball_").removesuffix("_new").removesuffix("mm")) * 1e-3)

    def depth(self, name: str) -> float:
        """Return how deep an indenter may press, m, under the limits of force (friction included) and depth."""
        # the force at 41 depths
        most = min(DEEPEST, DEEPEST_SHARE * self.touch.geometry.thickness)
        depths = np.linspace(0.0, most, 41)
        poses = np.tile(np.eye(4), (len(depths), 1, 1))
        poses[:, 2, 3] = -depths
        touch = Touch(
            np.arange(float(len(depths))), poses, self.indenter(name), self.material, self.touch.geometry,
            self.touch.sensor, self.touch.indenter_name, self.touch.mount,
        )  # fmt: skip
        # the deepest that keeps within the limit, with the force of full sliding
        n = len(depths)
        pressed = self.base(self.material)(touch).respond(np.zeros(n), np.zeros((n, 2)), np.ones(n)).wrench[:, 2]
        size = np.nan_to_num(pressed, nan=np.inf) * float(np.hypot(1.0, self.material.friction))
        return float(depths[size <= RESERVE * self.force_limit][-1])

    def reach(self, name: str, slide: float = 0.0) -> Place:
        """Return the distances (x, y), m, from the middle of the pad within which an indenter may touch and slide."""
        radius = self.indenter(name).sizes["radius"]
        contact = min(radius, float(np.sqrt(2.0 * radius * self.depth(name))))
        x, y = (max(side / 2.0 - contact - MARGIN - slide, 0.0) for side in self.touch.geometry.outline)
        return x, y

    def fresh(self, name: str, count: int) -> list[Place]:
        """Return places (x, y), m, for an indenter, each farthest from all touched places and from the others."""
        x, y = self.reach(name)
        grid = np.stack(np.meshgrid(np.linspace(-x, x, 9), np.linspace(-y, y, 13)), axis=-1).reshape(-1, 2)
        taken, places = self.visited, []
        for _ in range(count):
            away = np.linalg.norm(grid[:, None] - taken[None], axis=2).min(axis=1, initial=np.inf)
            best = grid[int(np.argmax(np.round(away, 9)))]
            places.append((round(float(best[0]), 6), round(float(best[1]), 6)))
            taken = np.vstack([taken, best])
        return places
