"""Signals whose numbers are most likely in another unit than the one they are kept with."""

from __future__ import annotations

import numpy as np

from tactiledata.contract.records import Finding, Values
from tactiledata.contract.take import StoredSignal, Take

FARTHEST_REACH = 5.0
"""m. No arm of these reaches farther; tcp positions beyond it are in millimetres."""
LARGEST_ANGLE = 4 * np.pi
"""rad. Joints of a UR turn by one revolution each way; larger numbers are degrees."""
SMALLEST_CHANGE = 0.02
"""N. A force sensor's own noise is larger; touches that change less are in kilonewtons."""
LONGEST_LEVER = 3.0
"""m. Torque over force; no tool is that long, so larger ratios are newton millimetres."""
FELT = 1.0
"""N. Change of force above which the lever is judged."""
COLDEST = 200.0
"""K. Gels are used at room temperature; smaller numbers are degrees Celsius."""


def unit_findings(take: Take) -> list[Finding]:
    """Findings on the signals of a take; each says which unit would make the numbers plausible."""
    found = []
    has_touches = bool(take.trajectories.num_rows)
    for name, signal in sorted(take.signals.items()):
        if "derived_from" not in signal.attributes and (text := _doubt(signal, has_touches)):
            found.append(Finding("unit-implausible", "warning", f"{name}: {text}", name))
    return found


def _doubt(signal: StoredSignal, has_touches: bool) -> str:
    """Why the numbers are not in the unit they are kept with; empty where they may be."""
    sound = signal.values[np.isfinite(signal.values).all(axis=1)]
    if not len(sound):
        return ""
    if signal.columns[:3] == ("x", "y", "z"):
        far = float(np.median(np.abs(sound[:, :3]).max(axis=1)))
        return f"positions are {far:.4g} m from the base; millimetres?" if far > FARTHEST_REACH else ""
    if signal.columns == tuple(f"q{joint}" for joint in range(6)):
        turned = float(np.median(np.abs(sound).max(axis=1)))
        return f"joints are turned by {turned:.4g} rad; degrees?" if turned > LARGEST_ANGLE else ""
    if signal.columns == ("fx", "fy", "fz", "tx", "ty", "tz"):
        return _wrench_doubt(sound, has_touches)
    kelvin = [column for column, unit in enumerate(signal.units) if unit == "K"]
    cold = float(np.median(sound[:, kelvin])) if kelvin else COLDEST
    return f"temperatures are {cold:.4g} K; degrees Celsius?" if cold < COLDEST else ""


def _wrench_doubt(values: Values, has_touches: bool) -> str:
    change = values - np.median(values, axis=0)
    force, torque = np.linalg.norm(change[:, :3], axis=1), np.linalg.norm(change[:, 3:], axis=1)
    largest = float(force.max())
    if has_touches and 0 < largest < SMALLEST_CHANGE:
        return f"forces change by no more than {largest:.2g} N in the whole recording; kilonewtons?"
    felt = force > FELT
    lever = float(np.median(torque[felt] / force[felt])) if felt.any() else 0.0
    return f"torques are {lever:.4g} m times the forces; newton millimetres?" if lever > LONGEST_LEVER else ""
