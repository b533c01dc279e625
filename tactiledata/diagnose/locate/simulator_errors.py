"""What locators find is news only where the simulation's own errors do not leave as much.

Trajectories agree on an error of the simulation as they do on physics that is missing: signs thrown anew cannot tell
the two apart. Where it is known how far such errors go (`simulation_errors`), a finding has to be beyond them, too.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TypeVar

from scipy.stats import norm

from tactiledata.diagnose.locate.drifts import Drift
from tactiledata.diagnose.locate.event_effects import EventEffect
from tactiledata.diagnose.locate.region_map import RegionMap
from tactiledata.diagnose.locate.steps import ChangePoint
from tactiledata.diagnose.locate.tree import Leaf
from tactiledata.diagnose.residuals.slopes import Change

OF_95 = float(norm.ppf(0.975))
Found = TypeVar("Found", Drift, EventEffect, Leaf, RegionMap, ChangePoint)


def beyond_errors(found: Sequence[Found], errors: Mapping[str, float] | None) -> tuple[Found, ...]:
    """The same findings, each with the larger of its p and that of being an error of the simulation.

    Parameters
    ----------
    errors : dict, name of a component or parameter -> standard deviation, optional
        As `LocateOptions.errors`; what is not in it keeps its p. ``None``: all keep theirs.
    """
    if errors is None:
        return tuple(found)
    amended = [replace(one, p=max(one.p, _p(one, errors, len(found)))) for one in found]
    return tuple(sorted(amended, key=lambda one: one.p))


def _p(one: Drift | EventEffect | Leaf | RegionMap | ChangePoint, errors: Mapping[str, float], asked: int) -> float:
    """That errors of the simulation and noise leave so much in any of so many findings (Bonferroni)."""
    if isinstance(one, EventEffect):
        what, size, error = one.component, one.size, one.size / one.statistic if one.statistic else float("inf")
    elif isinstance(one, Leaf):
        what, size, error = one.component, one.effect, one.half_width / 2.0
    else:
        what, (size, error) = one.parameter, _of_change(one.change)
        asked *= one.statistic.size if isinstance(one, RegionMap) else 1
    if what not in errors:
        return 0.0
    scale = (error**2 + errors[what] ** 2) ** 0.5
    return float(min(1.0, 2.0 * asked * norm.sf(abs(size) / scale))) if scale > 0 else 0.0


def _of_change(change: Change) -> tuple[float, float]:
    """Size and standard error, as shares of the parameter's value where it has one."""
    unit = abs(change.parameter.value) if change.is_relative else 1.0
    return change.value / unit, change.half_width / OF_95 / unit
