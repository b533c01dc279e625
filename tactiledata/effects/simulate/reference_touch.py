"""A usual touch of the rig, and how much each effect changes its force."""

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
    """Usual values of a UR5e that presses a DIGIT.

    Parameters
    ----------
    youngs_modulus : float
        Young's modulus of the gel, Pa, as the SPLIT paper calibrated it.
    poisson_ratio : float
        Poisson's ratio, from the same calibration.
    friction : float
        Coefficient of friction, in the middle of the bounds of that calibration.
    radius : float
        Radius of the ball, m.
    depth : float
        Depth of the press, m.
    slide : float
        Length of the slide, m.
    speed : float
        Speed of the slide, m/s.
    noise : float
        Standard deviation of one reading of one component of the force, N.
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
"""The usual values."""


def contact_stiffness(force: float, depth: float) -> float:
    """Stiffness, N/m, of the press of a ball at a force, N, and a depth, m: 3/2 F / d; a thin layer adds to it."""
    return 1.5 * force / depth


def reference_touch(scales: RigScales = RIG) -> Touch:
    """Return a touch of a ball, 1 mm from the middle of a DIGIT, that shows every effect.

    Free air, press, dwell, slide, half of the slide back, dwell, leave, free air. The place was touched 200 times
    before. The touch begins ten minutes after power-on, five minutes into its recording. A wrist joint turns by half a
    radian.
    """
    # corners of the path in time, depth and distance along the gel
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
    """Return the largest change of the force, N, at the farther end of the plausible range, by strength.

    Shapes have their defaults. The base is the ball on a layer, without tare: a size to compare with the noise, no
    prediction.

    Parameters
    ----------
    effect : Effect
        The effect; its name is in the table.
    touch : Touch, optional
        The touch, `reference_touch` by default.
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
