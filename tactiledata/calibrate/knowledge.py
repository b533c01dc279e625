"""What a calibration knows of each parameter: identified, bounded on one side, or not told by these data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from enum import StrEnum

import numpy as np
from scipy.spatial.transform import Rotation

from tactiledata.calibrate.bounds import Bounds
from tactiledata.calibrate.intervals import Intervals
from tactiledata.calibrate.touches import MeasuredTouch

WIDE = 0.8
"""Width of an interval, as a share of the box, above which the data add nothing to the box."""
PRESSED = 0.2
"""Share of a touch's largest force from which the indenter surely presses."""
MOVED = 1e-4
"""Least way along the gel, m, of a touch that may slide."""
TURNED = 0.05
"""Least turn about the gel's normal, rad, of a touch that may slide."""

ADVICE = {
    "youngs_modulus": "More and deeper touches help.",
    "poisson_ratio": "Flat indenters and deep touches on a thin pad determine it; spheres alone hardly do.",
    "friction": "Only touches that slip determine it: shear further than the gel sticks, or turn the indenter.",
}
"""What to record where a parameter cannot be known."""


class Knowledge(StrEnum):
    """What data say of a parameter."""

    IDENTIFIED = "identified"
    BOUNDED = "bounded"
    NOT_TOLD = "not told by these data"


@dataclass(frozen=True)
class KnownParameter:
    """What a calibration knows of one parameter.

    Parameters
    ----------
    verdict : Knowledge
        A bounded parameter has an interval that ends at a bound of the search on one side: the
        data say "at least" or "at most".
    record : str
        Which touches would tell more; empty where it is identified.
    """

    verdict: Knowledge
    record: str

    @property
    def document(self) -> dict[str, str]:
        """The verdict as it stands in ``calibration.json`` (schemas/calibration.json)."""
        return asdict(self)


def known_parameters(intervals: Intervals, bounds: Bounds, is_slid: bool) -> dict[str, KnownParameter]:
    """Return what is known of E, nu and mu, by name.

    Parameters
    ----------
    intervals : Intervals
        95 % intervals of the three.
    bounds : Bounds
        The box that was searched.
    is_slid : bool
        Whether any touch may slide (`may_slide`). Presses alone never tell mu, whatever its interval.
    """
    widths = np.ptp(intervals.ends, axis=1) / bounds.span
    found = {}
    for k, (name, _, _) in enumerate(bounds):
        is_told = widths[k] <= WIDE and (name != "friction" or is_slid)
        is_open = bool(intervals.is_open[k].any())
        verdict = Knowledge.NOT_TOLD if not is_told else Knowledge.BOUNDED if is_open else Knowledge.IDENTIFIED
        found[name] = KnownParameter(verdict, "" if verdict is Knowledge.IDENTIFIED else ADVICE[name])
    return found


def may_slide(touches: Sequence[MeasuredTouch]) -> bool:
    """Return whether any touch moves along the gel or turns while it presses, so that it may slide."""
    return any(_moves_along(touch) for touch in touches)


def _moves_along(touch: MeasuredTouch) -> bool:
    """Return whether a touch moves by ``MOVED`` along the gel, or turns by ``TURNED``, while it presses."""
    force = np.nan_to_num(np.linalg.norm(touch.wrench[:, :3], axis=1))
    poses = touch.touch.poses[(force > PRESSED * force.max()) & np.isfinite(touch.touch.poses).all(axis=(1, 2))]
    if len(poses) < 2:
        return False
    turns = Rotation.from_matrix(poses[0, :3, :3].T @ poses[:, :3, :3]).as_rotvec()[:, 2]
    return bool(np.ptp(poses[:, :2, 3], axis=0).max() > MOVED or np.ptp(turns) > TURNED)
