"""Touches of a world that is the simulation itself, but for planted errors of that simulation and a little noise."""

import dataclasses
from functools import cache

import numpy as np
from touch_worlds import START, World, world_cases

from tactiledata.diagnose.touches.touch_case import TouchSet
from tactiledata.diagnose.touches.whitened import WhitenedTouches
from tactiledata.nuisance.noise import WrenchNoise

NOISE = WrenchNoise(np.diag([0.01**2] * 3 + [2e-5**2] * 3), 1.0, "planted")


@cache
def _blank():
    """Whitened touches of four balls without errors and noise, the simulated wrenches, and the fields of the errors."""
    world = world_cases(World(mismatch=0.0, jitter=0.0), 3, 24)
    cases = [dataclasses.replace(case, measured=np.zeros_like(case.measured), noise=NOISE) for case in world.touches]
    simulated = TouchSet(cases, world.base).play(START, [])
    white = WhitenedTouches.of(_measured(TouchSet(cases, world.base), simulated))
    return white, simulated, white.simulation_error_wrenches(START)


def _measured(touch_set, wrench):
    """A touch with other measured wrenches (N, 6)."""
    rows = np.split(wrench, np.cumsum(touch_set.counts)[:-1])
    cases = [dataclasses.replace(case, measured=part) for case, part in zip(touch_set.touches, rows, strict=True)]
    return TouchSet(cases, touch_set.base)


def planted_errors(sizes, seed=0, only=None):
    """Whitened touches of which each error of the simulation is drawn: `sizes`, family -> standard deviations.

    With ``only`` the name of an indenter, errors are drawn under it alone.
    """
    white, simulated, fields = _blank()
    chance = np.random.default_rng(seed)
    drawn = np.array([sizes.get(error.family, 0.0) * chance.normal() for error in white.simulation_errors])
    if only is not None:
        drawn *= [error.indenter == only for error in white.simulation_errors]
    noise = chance.normal(size=simulated.shape) * NOISE.deviations
    return WhitenedTouches.of(_measured(white.touch_set, simulated + fields @ drawn + noise))


def planted_factors(sizes, seed=0):
    """Whitened touches whose forces are each multiplied by a factor about 1: `sizes`, indenter -> its deviation."""
    white, simulated, _ = _blank()
    chance = np.random.default_rng(seed)
    factors = [1.0 + sizes.get(case.touch.indenter_name, 0.0) * chance.normal() for case in white.touch_set.touches]
    noise = chance.normal(size=simulated.shape) * NOISE.deviations
    wrench = simulated * np.array(factors)[white.trajectory][:, None] + noise
    return WhitenedTouches.of(_measured(white.touch_set, wrench))
