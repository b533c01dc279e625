"""A simulation that answers for touches that nobody has played: balls and flat punches in closed form."""

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


def closed_form(material: GelMaterial) -> Callable[[Touch], BaseResponse]:
    """A `BaseFamily`; forces are 5 to 20 % off at 1 mm depth, which hardly moves what separates two effects.

    Raises
    ------
    UsageError
        When it is asked for another shape.
    """
    return _respond


def _respond(touch: Touch) -> BaseResponse:
    shape = touch.indenter.shape
    if shape not in SHAPES:
        raise UsageError(
            f"indenter {shape!r} has no closed form here", f"one of: {', '.join(SHAPES)}", "Give a gel that plays it."
        )
    return SHAPES[shape](touch)


Place = tuple[float, float]

FORCE_LIMIT = 13.0
"""N, of the protocol."""
RESERVE = 0.85
"""Share of the limit that is used: what is to be found may make the gel stiffer than thought."""
DEEPEST, DEEPEST_SHARE = 1.0e-3, 0.25
"""m, and share of the gel's thickness."""
MARGIN = 1e-3
"""m between the rim of a contact and that of the pad."""
RADII = (0.002, 0.004, 0.008)
"""m, of balls that tell layer, coating and strain apart; those at hand serve where they are near."""


@dataclass(frozen=True)
class TrialBench:
    """The rig on which a trial would be recorded.

    Parameters
    ----------
    touch : Touch
        One that was recorded there: its sensor, gel, orientation and joints.
    indenters : dict
        At hand, by name.
    material : GelMaterial
    noise : WrenchNoise
    free_samples : float
        Readings from which a zero is taken.
    visited : (p, 2) m
        Places on the gel that were touched.
    base : BaseFamily
    force_limit : N
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
        """The rig of recorded trajectories; the sensor of the first."""
        first = cases.touches[0]
        own = [case.touch for case in cases.touches if case.touch.sensor == first.touch.sensor]
        places = [touch.tips[np.argmin(np.nan_to_num(touch.tips[:, 2], nan=np.inf)), :2] for touch in own]
        named = zip(cases.indenters, (case.touch.indenter for case in cases.touches), strict=True)
        known = np.array(places).reshape(-1, 2)
        return TrialBench(
            first.touch, dict(named), material, first.noise, first.free_samples, known, base or closed_form
        )

    @cached_property
    def ball(self) -> str:
        """Name of the ball nearest to 4 mm."""
        return self.ball_near(0.004)

    @property
    def balls(self) -> tuple[str, ...]:
        """Of three radii, ascending."""
        return tuple(dict.fromkeys(self.ball_near(radius) for radius in RADII))

    def ball_near(self, radius: float) -> str:
        """A ball at hand within a third of a radius, m; the name of one to be made where there is none."""
        radii = {name: one.radius for name, one in self.indenters.items() if isinstance(one, Sphere)}
        near = min(radii, key=lambda name: abs(np.log(radii[name] / radius)), default="")
        if near and abs(np.log(radii[near] / radius)) < 0.3:
            return near
        return self._free_name(f"ball_{1e3 * radius:g}mm")

    @cached_property
    def punch(self) -> str:
        """Name of a flat punch; of one to be made where there is none."""
        found = [name for name, one in self.indenters.items() if isinstance(one, CylinderFlat)]
        return found[0] if found else self._free_name("punch_3mm")

    def _free_name(self, name: str) -> str:
        return name if name not in self.indenters else f"{name}_new"

    def indenter(self, name: str) -> Indenter:
        """At hand, or to be made."""
        if name in self.indenters:
            return self.indenters[name]
        if name.startswith("punch"):
            return CylinderFlat(0.003)
        return Sphere(float(name.removeprefix("ball_").removesuffix("_new").removesuffix("mm")) * 1e-3)

    def depth(self, name: str) -> float:
        """m: how deep an indenter may go under the limits of force and depth, friction reckoned in."""
        most = min(DEEPEST, DEEPEST_SHARE * self.touch.geometry.thickness)
        depths = np.linspace(0.0, most, 41)
        poses = np.tile(np.eye(4), (len(depths), 1, 1))
        poses[:, 2, 3] = -depths
        touch = Touch(
            np.arange(float(len(depths))), poses, self.indenter(name), self.material, self.touch.geometry,
            self.touch.sensor, self.touch.indenter_name, self.touch.mount,
        )  # fmt: skip
        n = len(depths)
        pressed = self.base(self.material)(touch).respond(np.zeros(n), np.zeros((n, 2)), np.ones(n)).wrench[:, 2]
        size = np.nan_to_num(pressed, nan=np.inf) * float(np.hypot(1.0, self.material.friction))
        return float(depths[size <= RESERVE * self.force_limit][-1])

    def reach(self, name: str, slide: float = 0.0) -> Place:
        """(x, y) m from the middle of the pad within which an indenter may touch, and slide."""
        radius = self.indenter(name).sizes["radius"]
        contact = min(radius, float(np.sqrt(2.0 * radius * self.depth(name))))
        x, y = (max(side / 2.0 - contact - MARGIN - slide, 0.0) for side in self.touch.geometry.outline)
        return x, y

    def fresh(self, name: str, count: int) -> list[Place]:
        """Places that are farthest from all that were touched, and from one another."""
        x, y = self.reach(name)
        grid = np.stack(np.meshgrid(np.linspace(-x, x, 9), np.linspace(-y, y, 13)), axis=-1).reshape(-1, 2)
        taken, found = self.visited, []
        for _ in range(count):
            away = np.linalg.norm(grid[:, None] - taken[None], axis=2).min(axis=1, initial=np.inf)
            best = grid[int(np.argmax(np.round(away, 9)))]
            found.append((round(float(best[0]), 6), round(float(best[1]), 6)))
            taken = np.vstack([taken, best])
        return found
