"""The rig's scales in numbers, and how much an effect at the end of its plausible range changes on it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactiledata.effects.base import Effect
from tactiledata.effects.closed_form.ball_on_layer import BallOnLayer
from tactiledata.effects.simulate.setting import EffectSetting
from tactiledata.effects.simulate.simulator import with_effects
from tactiledata.effects.touch.touch import Touch
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.indenters.sphere import Sphere
from tactiledata.sensors.digit import DIGIT
from tactiledata.sensors.robotiq_ft300s import ROBOTIQ_FT300S


@dataclass(frozen=True)
class RigScales:
    """What is usual on a UR5e that presses a DIGIT.

    Parameters
    ----------
    youngs_modulus : Pa, of the SPLIT paper's calibration
    poisson_ratio, friction : likewise, friction in the middle of its bounds
    radius, depth, slide : m, of a usual ball, press and slide
    speed : m/s
    noise : N, of one reading of one component
    """

    youngs_modulus: float = 0.88e6
    poisson_ratio: float = 0.48
    friction: float = 0.8
    radius: float = 0.004
    depth: float = 0.8e-3
    slide: float = 2e-3
    speed: float = 0.5e-3
    noise: float = ROBOTIQ_FT300S.force.force_noise if ROBOTIQ_FT300S.force else 0.1


RIG = RigScales()


def contact_stiffness(force: float, depth: float) -> float:
    """N/m: how the force of a ball grows with depth, 3/2 F / d; a thin layer adds to it."""
    return 1.5 * force / depth


def reference_touch(scales: RigScales = RIG) -> Touch:
    """A ball, 1 mm from the middle: press, dwell, slide to and half way back, dwell, leave; free air about it.

    It is the 200th at its place, ten minutes after power-on, five into its recording; a wrist joint turns by half a
    radian.
    """
    press, slide, back = 2.0, scales.slide / scales.speed, scales.slide / scales.speed / 2.0
    corners = np.cumsum([0.0, 0.5, press, 1.0, slide, back, 1.0, press, 0.5])
    depths = scales.depth * np.array([-0.2, -0.2, 1.0, 1.0, 1.0, 1.0, 1.0, -0.2, -0.2])
    ways = scales.slide * np.array([0.0, 0.0, 0.0, 0.0, 1.0, 0.5, 0.5, 0.5, 0.5])
    seconds = np.arange(0.0, corners[-1], 0.05)
    poses = np.tile(np.eye(4), (len(seconds), 1, 1))
    poses[:, :2, 3] = np.outer(1e-3 + np.interp(seconds, corners, ways), [0.8, 0.6])
    poses[:, 2, 3] = -np.interp(seconds, corners, depths)
    joints = np.zeros((len(seconds), 6))
    joints[:, 5] = np.linspace(0.0, 0.5, len(seconds))
    assert DIGIT.gel is not None
    return Touch(
        seconds=300.0 + seconds,
        poses=poses,
        indenter=Sphere(scales.radius),
        material=GelMaterial(scales.youngs_modulus, scales.poisson_ratio, scales.friction),
        geometry=DIGIT.gel,
        sensor="reference",
        indenter_name="ball",
        mount="first",
        gravity=np.tile([0.0, 0.0, -9.81], (len(seconds), 1)),
        joints=joints,
        powered=600.0 + seconds,
        earlier_depth=np.full(len(seconds), 1e-3),
        earlier_contacts=np.full(len(seconds), 200.0),
        selection=(1.0, 13.0),
    )


def largest_changes(effect: Effect, touch: Touch | None = None) -> dict[str, float]:
    """By strength: the largest change of the force, N, at the farther end of its plausible range.

    Shapes have their defaults. Of the ball on a layer, without tare: a size to hold against the noise, no prediction.
    """
    touch = reference_touch() if touch is None else touch
    plain = with_effects(BallOnLayer, []).play(touch).wrench
    changes = {}
    for parameter in effect.parameters:
        if parameter.null is None:
            continue
        farther = max(parameter.plausible, key=abs)
        setting = EffectSetting(effect.name, {parameter.name: farther})
        changed = with_effects(BallOnLayer, [setting]).play(touch).wrench
        changes[parameter.name] = float(np.linalg.norm(changed[:, :3] - plain[:, :3], axis=1).max())
    return changes
