"""Covariates of each frame of a touch (depth, speed, time and others), and the phase in which the frame lies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.residuals.residuals import Covariate, Names
from tactiledata.diagnose.touches.touch_case import TouchCase, TouchSet
from tactiledata.effects.simulate.setting import EffectSetting
from tactiledata.effects.simulate.simulator import with_effects
from tactiledata.effects.touch.response import ContactResponse
from tactiledata.gel.elasticity.material import GelMaterial

STILL = 0.1
"""Share of a trajectory's median step up to which the tip counts as dwelling."""
VARIES = 1e-6
"""Range of a covariate over its largest absolute value up to which it counts as constant and is left out."""


def contacts(touch_set: TouchSet, material: GelMaterial, offsets: Array) -> list[ContactResponse]:
    """Return the contact of each trajectory in the plain simulation.

    Parameters
    ----------
    touch_set : TouchSet
        Trajectories, and the simulation without effects.
    material : GelMaterial
        Material of the gel.
    offsets : (t,) m
        By how much each trajectory is deeper than recorded.
    """
    base = with_effects(touch_set.base(material), [])
    responses = []
    for case, offset in zip(touch_set.touches, offsets, strict=True):
        moved = base.with_effects([EffectSetting("mount_offset", {"deeper": float(offset)})])
        responses.append(moved.play(replace(case.touch, material=material)).contact)
    return responses


def case_covariates(touch_set: TouchSet, answers: Sequence[ContactResponse]) -> dict[str, Covariate]:
    """Return covariates (N,), by name, that every trajectory has and that vary.

    An unknown value is replaced by that of the frame before.

    Parameters
    ----------
    touch_set : TouchSet
        The t trajectories.
    answers : sequence of t ContactResponse
        Contacts in the simulation. Depth, contact radius and normal force are taken from them and not from the
        measurement, as noise must not choose the frames.
    """
    by_trajectory = [
        {**_of_motion(case), **_of_contact(case, answer), **_of_rig(case), "index": _constant(case, float(number))}
        for number, (case, answer) in enumerate(zip(touch_set.touches, answers, strict=True))
    ]
    slowest = _slowest(touch_set)
    covariates = {}
    for name, (_, unit) in by_trajectory[0].items():
        if all(name in columns for columns in by_trajectory):
            values = np.concatenate([_filled(columns[name][0]) for columns in by_trajectory])
            if name == "lateral speed":
                # rest counts as the slowest motion, because effects of rate follow the logarithm of the speed
                values = np.maximum(values, slowest)
            if np.ptp(values) > VARIES * np.abs(values).max():
                covariates[name] = Covariate(values, unit)
    return covariates


def phases(case: TouchCase) -> Names:
    """Return the phase (n,), as text, of each frame, from its free-air flag and its motion since the frame before.

    The motion is that of the indenter's tip as recorded, in the gel frame; a rotation about the tip does not count. The
    first condition that holds decides:

    - "free air": the frame is flagged in ``case.free_air``.
    - "dwell": the tip moves by at most ``STILL`` times the median step of the trajectory's moving frames. The first
      frame, which has no frame before it, dwells; so does a frame of unknown pose, which keeps the last known place.
    - "shear" or "reverse": the tip moves more along the gel than up or down. A reverse has a part against the
      trajectory's first shear; a slide at right angles to it is a shear.
    - "approach": the tip goes down and is still above the undeformed surface in the middle (z > 0).
    - "press": the tip goes down below it.
    - "leave": the tip goes up, below or above the surface.
    """
    tips = _filled(case.touch.tips)
    steps = np.diff(tips, axis=0, prepend=tips[:1])
    along, up = np.linalg.norm(steps[:, :2], axis=1), steps[:, 2]
    size = np.hypot(along, up)
    moving = size[size > 0]
    still = STILL * float(np.median(moving)) if len(moving) else 0.0
    dwells, shears = size <= still, along > np.abs(up)
    first = steps[np.flatnonzero(shears & ~dwells & ~case.free_air)[:1], :2].sum(axis=0)
    # where several conditions hold, the last one decides
    named = np.where(up < 0, "press", "leave").astype("<U8")
    named[shears] = np.where(steps[shears][:, :2] @ first < 0, "reverse", "shear")
    named[dwells] = "dwell"
    named[(named == "press") & (tips[:, 2] > 0)] = "approach"
    named[case.free_air] = "free air"
    return named


def _slowest(touch_set: TouchSet) -> float:
    """Return the speed in mm/s below which 5 % of the moving frames of shear lie; 0 where nothing shears."""
    shears = [case.touch.lateral_speed[np.isin(phases(case), ("shear", "reverse"))] for case in touch_set.touches]
    speeds = 1e3 * np.concatenate(shears)
    speeds = speeds[speeds > 0]
    return float(np.quantile(speeds, 0.05)) if len(speeds) else 0.0


def _of_motion(case: TouchCase) -> dict[str, tuple[Array, str]]:
    """Return covariates of time and path: name -> values (n,) and unit."""
    touch = case.touch
    in_contact = np.where(case.free_air, 0.0, 1.0)
    return {
        "seconds": (touch.seconds - touch.seconds[0], "s"),
        "time step": (np.append(touch.time_steps[1:2], touch.time_steps[1:]), "s"),
        "lateral speed": (1e3 * touch.lateral_speed, "mm/s"),
        "shear travel": (1e3 * np.cumsum(np.nan_to_num(touch.lateral_steps) * in_contact), "mm"),
        "x": (1e3 * touch.tips[:, 0], "mm"),
        "y": (1e3 * touch.tips[:, 1], "mm"),
        "distance from the middle": (1e3 * np.hypot(touch.tips[:, 0], touch.tips[:, 1]), "mm"),
    }


def _of_contact(case: TouchCase, answer: ContactResponse) -> dict[str, tuple[Array, str]]:
    """Return covariates of the simulated contact: name -> values (n,) and unit."""
    force, steps, depth = _filled(answer.wrench[:, 2]), case.touch.time_steps, np.maximum(answer.depth, 0.0)
    rate = np.divide(np.diff(force, prepend=force[:1]), steps, out=np.zeros_like(force), where=steps > 0)
    return {
        "depth": (1e3 * depth, "mm"),
        "share of the largest depth": (_share_of_largest(depth, case.touch.earlier_depth), "1"),
        "contact radius": (1e3 * answer.radius, "mm"),
        "normal force": (force, "N"),
        "loading rate": (rate, "N/s"),
    }


def _share_of_largest(depth: Array, earlier: Array | None) -> Array:
    """Return the depth (n,) over the largest depth of the gel here so far; 1 before the first contact."""
    depth = _filled(depth)
    largest = np.maximum.accumulate(depth)
    if earlier is not None:
        largest = np.maximum(largest, _filled(earlier))
    return np.divide(depth, largest, out=np.ones_like(depth), where=largest > 0)


def _of_rig(case: TouchCase) -> dict[str, tuple[Array, str]]:
    """Return covariates of sensor, arm and earlier touches, as far as they are known: name -> values (n,) and unit."""
    touch, columns = case.touch, {}
    if touch.powered is not None:
        columns["time since power-on"] = (touch.powered / 60.0, "min")
    if touch.gravity is not None:
        size = np.linalg.norm(touch.gravity, axis=1)
        tilt = np.arccos(np.clip(-touch.gravity[:, 2] / np.maximum(size, 1e-300), -1.0, 1.0))
        columns["tilt"] = (np.degrees(tilt), "deg")
        # a sensor that was set to zero reads how gravity has turned since, not the whole weight
        zeroed = case.free_air if touch.tare is None else touch.tare
        turned = touch.gravity - touch.gravity[zeroed if zeroed.any() else slice(1)].mean(axis=0)
        for axis, column in zip("xyz", turned.T, strict=True):
            columns[f"gravity along {axis} since the zero"] = (column, "m/s^2")
    if touch.joints is not None:
        columns["last joint"] = (np.degrees(touch.joints[:, -1]), "deg")
    if touch.earlier_depth is not None:
        columns["earlier depth"] = (1e3 * touch.earlier_depth, "mm")
    if touch.earlier_contacts is not None:
        columns["earlier contacts"] = (touch.earlier_contacts, "1")
    return columns


def _constant(case: TouchCase, value: float) -> tuple[Array, str]:
    """Return one value for all frames (n,), without a unit."""
    return np.full(len(case.touch), value), "1"


def _filled(values: Array) -> Array:
    """Return values (n, ...) with rows not finite replaced by the last known row, at the beginning by the first."""
    known = np.isfinite(values.reshape(len(values), -1)).all(axis=1)
    if known.all() or not known.any():
        return np.nan_to_num(values)
    rows = np.maximum.accumulate(np.where(known, np.arange(len(values)), -1))
    filled: Array = values[np.where(rows < 0, int(np.flatnonzero(known)[0]), rows)]
    return filled
