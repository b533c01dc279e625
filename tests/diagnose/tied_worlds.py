"""Recordings in which two effects look alike, because what would tell them apart was not recorded."""

import dataclasses

import numpy as np
from touch_worlds import START, base

from tactiledata.diagnose.naming.joint_fit import joint_fit
from tactiledata.diagnose.naming.parameters import joint_model
from tactiledata.diagnose.touches.touch_case import TouchCase, TouchSet
from tactiledata.diagnose.touches.whitened import WhitenedTouches
from tactiledata.effects.simulate.setting import EffectSetting
from tactiledata.effects.touch.touch import Touch
from tactiledata.indenters.sphere import Sphere
from tactiledata.nuisance.noise import WrenchNoise
from tactiledata.sensors.digit import DIGIT

NOISE = WrenchNoise(np.diag([0.1**2] * 3 + [0.003**2] * 3), 1.0, "stated")


def recorded(settings=(), touches=10, slide=0.0, turned=False, pace=1.0, seed=0):
    """Presses and slides at one speed, without a dwell; what was missing is played by the toolkit's own effects."""
    rng = np.random.default_rng(seed)
    blank = [_touch(number, slide, turned, pace) for number in range(touches)]
    zeros = [TouchCase(one, np.zeros((len(one), 6)), NOISE, one.tips[:, 2] > 0, 60.0) for one in blank]
    wrench = TouchSet(zeros, base).play(START, settings)
    rows = np.split(wrench, np.cumsum([len(one) for one in blank])[:-1])
    return TouchSet(
        [
            dataclasses.replace(case, measured=part + rng.normal(size=part.shape) * NOISE.deviations, name=f"D-{place}")
            for place, (case, part) in enumerate(zip(zeros, rows, strict=True))
        ],
        base,
    )


def _touch(number, slide, turned, pace):
    depth = (0.5 + 0.5 * (number % 5) / 4) * 1e-3
    marks = pace * np.cumsum([0.0, 0.5, 0.8, 2.0 if slide else 0.02, 0.8, 0.3])
    seconds = np.linspace(0.0, marks[-1], 40)
    depths = np.interp(seconds, marks, depth * np.array([-0.2, -0.2, 1.0, 1.0, -0.2, -0.2]))
    poses = np.tile(np.eye(4), (len(seconds), 1, 1))
    poses[:, 0, 3] = np.interp(seconds, marks, slide * np.array([0.0, 0.0, 0.0, 1.0, 1.0, 1.0]))
    poses[:, 2, 3] = -depths
    # the arm leans further over as the day goes on
    lean = 0.3 * (seconds - 2.0) / 4.0 if turned else np.zeros(len(seconds))
    gravity = 9.81 * np.column_stack([np.sin(lean), 0.0 * lean, -np.cos(lean)])
    kind = number % 2
    return Touch(
        seconds=seconds, poses=poses, indenter=Sphere((0.003, 0.004)[kind]), material=START, geometry=DIGIT.gel,
        sensor="D1", indenter_name=f"ball {kind}", mount=f"ball {kind}", gravity=gravity,
        joints=np.zeros((len(seconds), 6)), powered=600.0 + 30.0 * number + seconds,
        earlier_depth=np.full(len(seconds), 1e-3), earlier_contacts=np.full(len(seconds), float(number)),
        tare=seconds < 0.5 * pace,
    )  # fmt: skip


def fitted(cases, starts):
    """Fits of one effect each, from starts (effect, values); of the plain simulation where ``None``."""
    white = WhitenedTouches.of(cases)
    errors = len(white.simulation_errors)
    return [
        joint_fit(white, joint_model(START, [EffectSetting(*one)] if one else [], len(white.starts), errors))
        for one in starts
    ]


def effect(name, **values):
    return [EffectSetting(name, values)]
