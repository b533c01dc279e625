"""What a touch tells of each of its frames: covariates, and the phase in which a frame lies."""

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
"""Of a trajectory's median step: a tip that moves less dwells."""
VARIES = 1e-6
"""Of its size, by which a covariate must vary to be one."""


def contacts(cases: TouchSet, material: GelMaterial, offsets: Array) -> list[ContactResponse]:
    """What the plain simulation says of each contact, every trajectory deeper by its offset (t,), m."""
    base = with_effects(cases.base(material), [])
    found = []
    for case, offset in zip(cases.touches, offsets, strict=True):
        moved = base.with_effects([EffectSetting("mount_offset", {"deeper": float(offset)})])
        found.append(moved.play(replace(case.touch, material=material)).contact)
    return found


def case_covariates(cases: TouchSet, answers: Sequence[ContactResponse]) -> dict[str, Covariate]:
    """Covariates (N,) that all touches tell and that vary; where a value is unknown, that of the frame before.

    Parameters
    ----------
    answers : one for each trajectory
        Of the simulation: depth, contact radius and normal force are its own, as noise must not choose the frames.
    """
    told = [
        {**_of_motion(case), **_of_contact(case, answer), **_of_rig(case), "index": _constant(case, float(number))}
        for number, (case, answer) in enumerate(zip(cases.touches, answers, strict=True))
    ]
    slowest = _slowest(cases)
    found = {}
    for name, (_, unit) in told[0].items():
        if all(name in one for one in told):
            values = np.concatenate([_filled(one[name][0]) for one in told])
            if name == "lateral speed":
                # rest counts as the slowest motion: what goes with a rate goes with its logarithm
                values = np.maximum(values, slowest)
            if np.ptp(values) > VARIES * np.abs(values).max():
                found[name] = Covariate(values, unit)
    return found


def phases(case: TouchCase) -> Names:
    """The phase (n,) of each frame, from free-air flags and the recorded path.

    "free air", "approach" (nothing is flagged, the tip is above the gel), "press", "dwell", "shear", "reverse" (against
    the first direction of shear) and "leave".
    """
    tips = _filled(case.touch.tips)
    steps = np.diff(tips, axis=0, prepend=tips[:1])
    along, up = np.linalg.norm(steps[:, :2], axis=1), steps[:, 2]
    size = np.hypot(along, up)
    moving = size[size > 0]
    still = STILL * float(np.median(moving)) if len(moving) else 0.0
    dwells, shears = size <= still, along > np.abs(up)
    first = steps[np.flatnonzero(shears & ~dwells & ~case.free_air)[:1], :2].sum(axis=0)
    named = np.where(up < 0, "press", "leave").astype("<U8")
    named[shears] = np.where(steps[shears][:, :2] @ first < 0, "reverse", "shear")
    named[dwells] = "dwell"
    named[(named == "press") & (tips[:, 2] > 0)] = "approach"
    named[case.free_air] = "free air"
    return named


def _slowest(cases: TouchSet) -> float:
    """The slowest shear, mm/s, but for a few frames."""
    shears = [case.touch.lateral_speed[np.isin(phases(case), ("shear", "reverse"))] for case in cases.touches]
    speeds = 1e3 * np.concatenate(shears)
    speeds = speeds[speeds > 0]
    return float(np.quantile(speeds, 0.05)) if len(speeds) else 0.0


def _of_motion(case: TouchCase) -> dict[str, tuple[Array, str]]:
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
    """Depth (n,) over the largest that the gel has felt there so far, 1 before anything has touched."""
    depth = _filled(depth)
    largest = np.maximum.accumulate(depth)
    if earlier is not None:
        largest = np.maximum(largest, _filled(earlier))
    return np.divide(depth, largest, out=np.ones_like(depth), where=largest > 0)


def _of_rig(case: TouchCase) -> dict[str, tuple[Array, str]]:
    touch, told = case.touch, {}
    if touch.powered is not None:
        told["time since power-on"] = (touch.powered / 60.0, "min")
    if touch.gravity is not None:
        size = np.linalg.norm(touch.gravity, axis=1)
        tilt = np.arccos(np.clip(-touch.gravity[:, 2] / np.maximum(size, 1e-300), -1.0, 1.0))
        told["tilt"] = (np.degrees(tilt), "deg")
        # a sensor that was zeroed reads the turn of a weight, not the weight
        zeroed = case.free_air if touch.tare is None else touch.tare
        turned = touch.gravity - touch.gravity[zeroed if zeroed.any() else slice(1)].mean(axis=0)
        for axis, column in zip("xyz", turned.T, strict=True):
            told[f"gravity along {axis} since the zero"] = (column, "m/s^2")
    if touch.joints is not None:
        told["last joint"] = (np.degrees(touch.joints[:, -1]), "deg")
    if touch.earlier_depth is not None:
        told["earlier depth"] = (1e3 * touch.earlier_depth, "mm")
    if touch.earlier_contacts is not None:
        told["earlier contacts"] = (touch.earlier_contacts, "1")
    return told


def _constant(case: TouchCase, value: float) -> tuple[Array, str]:
    return np.full(len(case.touch), value), "1"


def _filled(values: Array) -> Array:
    """Values (n, …) with those that are not finite taken from the frame before, or the first that is known."""
    known = np.isfinite(values.reshape(len(values), -1)).all(axis=1)
    if known.all() or not known.any():
        return np.nan_to_num(values)
    rows = np.maximum.accumulate(np.where(known, np.arange(len(values)), -1))
    filled: Array = values[np.where(rows < 0, int(np.flatnonzero(known)[0]), rows)]
    return filled
