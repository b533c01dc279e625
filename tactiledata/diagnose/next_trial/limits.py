"""What recordings cannot tell, whatever physics is missing, and which recording would."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tactiledata.diagnose.touches.touch_case import TouchCase, TouchSet
from tactiledata.gel.elasticity.material import GelMaterial

STILL = 1e-5
"""m: a tip that moves less from one frame to the next dwells."""
LONG = 0.5
"""s: shorter stops are none."""
RANGE = 1.5
"""Times by which depths, or speeds, are to differ to tell one law from another."""
TOGETHER = 0.05
"""Share of readings in contact that stand at one extreme value: more is no chance."""
FEWEST = 20
"""Readings, to speak of a share."""


def limits(cases: TouchSet, material: GelMaterial) -> list[str]:
    """In sentences: what cannot be concluded, and what to record; empty where nothing stands in the way.

    Parameters
    ----------
    material : GelMaterial
        Of the plain simulation, for what slides.
    """
    said = [sentence for check in _CHECKS if (sentence := check(cases))]
    base = cases.base(material)
    asked = [
        base(case.touch).respond(np.zeros(len(case.touch)), np.zeros((len(case.touch), 2)), np.ones(len(case.touch)))
        for case in cases.touches
    ]
    if not any(answer.sliding.any() for answer in asked):
        said.append(
            "Nothing slides: mu, and all that changes friction, cannot be told. Press, then move 1 mm along the gel."
        )
    deepest = np.array([answer.depth.max() for answer in asked])
    if deepest.max() < RANGE * deepest.min():
        said.append(
            f"All touches are about equally deep ({1e3 * deepest.min():.2f} to {1e3 * deepest.max():.2f} mm): E, nu,"
            " thickness and stiffening cannot be told from one another. Press to 0.3, 0.6 and 1.0 mm."
        )
    return said


def _one_indenter(cases: TouchSet) -> str:
    if len(set(cases.indenters)) > 1:
        return ""
    return (
        f"All touches are of one indenter ({cases.indenters[0]}): its radius, the gel's thickness and stiffening cannot"
        " be told apart, and nothing is shown on an indenter that was not fitted. Record another one."
    )


def _no_dwell(cases: TouchSet) -> str:
    if any(_dwells(case) for case in cases.touches):
        return ""
    return (
        "No touch rests in contact for half a second: relaxation cannot be told from a lag of the sensor. Hold some"
        " presses still for 10 s, with frames."
    )


def _dwells(case: TouchCase) -> bool:
    """Whether the tip stands still in contact for long enough."""
    is_still = (np.linalg.norm(np.diff(case.touch.tips, axis=0), axis=1) < STILL) & ~case.free_air[1:]
    seconds = 0.0
    for still, step in zip(is_still, np.diff(case.touch.seconds), strict=True):
        seconds = seconds + step if still else 0.0
        if seconds > LONG:
            return True
    return False


def _no_free_air(cases: TouchSet) -> str:
    without = sum(not case.free_air.any() for case in cases.touches)
    if without < len(cases.touches):
        return ""
    return (
        "No trajectory has a frame in free air: a drifting zero, the tool's weight and the cable's drag cannot be told"
        " from the gel. Begin and end recordings above the gel."
    )


def _no_free_samples(cases: TouchSet) -> str:
    without = sum(case.free_samples < 1 for case in cases.touches)
    if not without:
        return ""
    return (
        f"{without} of {len(cases.touches)} trajectories have no readings before contact: their zero is a guess, and"
        " constant forces cannot be seen in them. Begin recordings half a second before the touch."
    )


def _one_speed(cases: TouchSet) -> str:
    speeds = np.concatenate([case.touch.lateral_speed[~case.free_air] for case in cases.touches])
    moving = speeds[speeds > 1e-4]
    if not len(moving):
        return ""
    low, high = np.quantile(moving, [0.05, 0.95])
    if high > RANGE * low:
        return ""
    return (
        f"All sliding is at about {1e3 * low:.2g} mm/s: friction that depends on speed cannot be told from mu. Slide at"
        " 0.3, 1 and 3 mm/s."
    )


def _clipped(cases: TouchSet) -> str:
    readings = np.concatenate([case.measured[~case.free_air] for case in cases.touches])[:, :3]
    readings = readings[np.isfinite(readings).all(axis=1)]
    if len(readings) < FEWEST:
        return ""
    for axis, column in zip("xyz", readings.T, strict=True):
        extreme = max(column.min(), column.max(), key=abs)
        share = float(np.mean(column == extreme))
        if share > TOGETHER and extreme != 0.0:
            return (
                f"f{axis} stands at {extreme:.2f} N in {100 * share:.0f} % of the frames in contact: readings are cut"
                " there, and what happens beyond is not known. Press less, or widen the sensor's range."
            )
    return ""


def _dead(cases: TouchSet) -> str:
    readings = np.concatenate([case.measured for case in cases.touches])
    dead = [
        name
        for name, column in zip(("fx", "fy", "fz", "tx", "ty", "tz"), readings.T, strict=True)
        if np.nanmax(column) - np.nanmin(column) == 0.0
    ]
    if not dead:
        return ""
    return (
        f"{', '.join(dead)} never changes: that part of the force sensor is not recorded, and nothing can be said about"
        " it. See `tactiledata check` on the store and the recorder's topics."
    )


_CHECKS: tuple[Callable[[TouchSet], str], ...] = (
    _dead,
    _one_indenter,
    _no_dwell,
    _no_free_air,
    _no_free_samples,
    _one_speed,
    _clipped,
)
