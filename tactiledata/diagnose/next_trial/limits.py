"""What the recordings at hand cannot show, whatever physics is missing, and which recording would show it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tactiledata.diagnose.touches.touch_case import TouchCase, TouchSet
from tactiledata.gel.elasticity.material import GelMaterial

STILL = 1e-5
"""Motion from one frame to the next, m, below which the tip rests."""
LONG = 0.5
"""Shortest rest that counts, s."""
RANGE = 1.5
"""Smallest ratio of depths, or speeds, that separates one law from another."""
TOGETHER = 0.05
"""Share of readings in contact at one extreme value from which on they are cut off there, not there by chance."""
FEWEST = 20
"""Fewest readings from which a share is computed."""


def limits(cases: TouchSet, material: GelMaterial) -> list[str]:
    """Return sentences on what cannot be concluded and what to record instead; empty where nothing is in the way.

    Parameters
    ----------
    cases : TouchSet
        The recorded touches.
    material : GelMaterial
        Gel of the plain simulation, which decides what slides.
    """
    sentences = [sentence for check in _CHECKS if (sentence := check(cases))]
    base = cases.base(material)
    answers = [
        base(case.touch).respond(np.zeros(len(case.touch)), np.zeros((len(case.touch), 2)), np.ones(len(case.touch)))
        for case in cases.touches
    ]
    if not any(answer.sliding.any() for answer in answers):
        sentences.append(
            "Nothing slides: these data do not show mu, nor any effect that changes friction. Press, then move 1 mm"
            " along the gel."
        )
    deepest = np.array([answer.depth.max() for answer in answers])
    if deepest.max() < RANGE * deepest.min():
        sentences.append(
            f"All touches are about equally deep ({1e3 * deepest.min():.2f} to {1e3 * deepest.max():.2f} mm): E, nu,"
            " thickness and stiffening cannot be told from one another. Press to 0.3, 0.6 and 1.0 mm."
        )
    return sentences


def _one_indenter(cases: TouchSet) -> str:
    """Return what a single indenter cannot show; empty where there are several."""
    if len(set(cases.indenters)) > 1:
        return ""
    return (
        f"All touches are of one indenter ({cases.indenters[0]}): its radius, the gel's thickness and stiffening cannot"
        " be told apart, and nothing is shown on an indenter that was not fitted. Record another one."
    )


def _no_dwell(cases: TouchSet) -> str:
    """Return what touches without a rest in contact cannot show; empty where one rests."""
    if any(_dwells(case) for case in cases.touches):
        return ""
    return (
        "No touch rests in contact for half a second: relaxation cannot be told from a lag of the sensor. Hold some"
        " presses still for 10 s, with frames."
    )


def _dwells(case: TouchCase) -> bool:
    """Return whether the tip rests in contact for more than `LONG` seconds."""
    is_still = (np.linalg.norm(np.diff(case.touch.tips, axis=0), axis=1) < STILL) & ~case.free_air[1:]
    seconds = 0.0
    for still, step in zip(is_still, np.diff(case.touch.seconds), strict=True):
        seconds = seconds + step if still else 0.0
        if seconds > LONG:
            return True
    return False


def _no_free_air(cases: TouchSet) -> str:
    """Return what recordings without frames in free air cannot show; empty where one has such frames."""
    without = sum(not case.free_air.any() for case in cases.touches)
    if without < len(cases.touches):
        return ""
    return (
        "No trajectory has a frame in free air: a drifting zero, the tool's weight and the cable's drag cannot be told"
        " from the gel. Begin and end recordings above the gel."
    )


def _no_free_samples(cases: TouchSet) -> str:
    """Return what trajectories without readings before contact cannot show; empty where all have some."""
    without = sum(case.free_samples < 1 for case in cases.touches)
    if not without:
        return ""
    return (
        f"{without} of {len(cases.touches)} trajectories have no readings before contact: their zero is a guess, and"
        " constant forces cannot be seen in them. Begin recordings half a second before the touch."
    )


def _one_speed(cases: TouchSet) -> str:
    """Return what slides at a single speed cannot show; empty where speeds differ or nothing moves."""
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
    """Return which component of force is cut off at a limit of the sensor; empty where none is."""
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
    """Return which components of the force sensor never change; empty where all do."""
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


# the order in which the sentences follow one another
_CHECKS: tuple[Callable[[TouchSet], str], ...] = (
    _dead,
    _one_indenter,
    _no_dwell,
    _no_free_air,
    _no_free_samples,
    _one_speed,
    _clipped,
)
