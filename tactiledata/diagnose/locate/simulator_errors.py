"""p-values of findings that allow for the simulation's own errors.

All trajectories agree on an error of the simulation, as they do on missing physics: sign flips cannot tell the two
apart. Where the size of such errors is known, a finding must exceed them, too.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeVar

from scipy.stats import norm

from tactiledata.diagnose.locate.drifts import Drift
from tactiledata.diagnose.locate.event_effects import EventEffect
from tactiledata.diagnose.locate.region_map import RegionMap
from tactiledata.diagnose.locate.steps import ChangePoint
from tactiledata.diagnose.locate.tree import Leaf
from tactiledata.diagnose.residuals.slopes import Change

Z_95 = float(norm.ppf(0.975))
"""Half width of a 95 % interval in standard errors."""
Finding = TypeVar("Finding")
SIZED = (Drift, EventEffect, Leaf, RegionMap, ChangePoint)
"""Findings whose size can be held against errors of the simulation."""


def beyond_errors(findings: Sequence[Finding], errors: Mapping[str, float] | None) -> tuple[Finding, ...]:
    """Return the findings, their p-values raised to those of noise and simulation errors; the most certain first.

    Parameters
    ----------
    findings : sequence
        Findings of one locator. Those of a kind that is not in ``SIZED`` keep their p-value; none is left out.
    errors : dict, name of a component or parameter -> float, optional
        Standard deviation by errors of the simulation, as in `LocateOptions.errors`: times the noise for components;
        for parameters a share of the value where that is known and not 0, else in the parameter's unit. What has no
        entry keeps its p-value; ``None``: all findings are returned unchanged, in their order.
    """
    if errors is None:
        return tuple(findings)
    amended: list[Any] = [
        replace(finding, p=max(finding.p, _p(finding, errors, len(findings))))
        if isinstance(finding, SIZED)
        else finding
        for finding in findings
    ]
    return tuple(sorted(amended, key=lambda finding: finding.p))


def _p(finding: Drift | EventEffect | Leaf | RegionMap | ChangePoint, errors: Mapping[str, float], tests: int) -> float:
    """Return the p-value of so large a finding in so many tests by noise and simulation errors (Bonferroni).

    Parameters
    ----------
    finding
        A finding of any of these locators.
    errors : dict
        Standard deviation by errors of the simulation; the p-value is 0 for what has no entry.
    tests : int
        Number of findings of the locator.
    """
    # size and standard error of the finding, in the unit of ``errors``
    if isinstance(finding, EventEffect):
        name, size, error = (
            finding.component,
            finding.size,
            finding.size / finding.statistic if finding.statistic else float("inf"),
        )
    elif isinstance(finding, Leaf):
        name, size, error = finding.component, finding.effect, finding.half_width / 2.0
    else:
        name, (size, error) = finding.parameter, _of_change(finding.change)
        tests *= finding.statistic.size if isinstance(finding, RegionMap) else 1
    if name not in errors:
        return 0.0
    scale = (error**2 + errors[name] ** 2) ** 0.5
    return float(min(1.0, 2.0 * tests * norm.sf(abs(size) / scale))) if scale > 0 else 0.0


def _of_change(change: Change) -> tuple[float, float]:
    """Return the size and standard error of a change, as shares of the parameter's value where it is known."""
    unit = abs(change.parameter.value) if change.is_relative else 1.0
    return change.value / unit, change.half_width / Z_95 / unit
