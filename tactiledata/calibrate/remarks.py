"""Findings on a calibration: bounds that were hit, parameters that stay unknown, misfit, offsets, what was left out."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping

import numpy as np

from tactiledata.calibrate.bounds import BOUNDS, SYMBOLS, Bounds
from tactiledata.calibrate.fit import Fit
from tactiledata.calibrate.knowledge import Knowledge, known_parameters
from tactiledata.contract.records import Finding
from tactiledata.contract.wording import counted, left_out_words

AT_BOUND = 0.01
"""Largest distance from a bound, as a share of the box, at which a parameter counts as being at it."""
SINGULAR = 0.95
"""Smallest correlation (absolute) at which two parameters cannot be distinguished."""
MISFIT = 1.5
"""Root mean square of the whitened residual above which noise does not explain it."""
FAR = 3.0
"""Standard deviations of the prior beyond which an offset or a factor is reported."""


def remarks(
    fit: Fit,
    bounds: Bounds,
    prior: float,
    left_out: Mapping[str, int],
    has_vector: bool,
    shape_error: float = 0.0,
    is_slid: bool = True,
    sensors: Collection[str] = (),
) -> list[Finding]:
    """Return the findings of a fit.

    Parameters
    ----------
    fit : Fit
        Parameters, intervals, offsets and losses.
    bounds : Bounds
        The box that was searched.
    prior : m
        Standard deviation of the contact offsets; 0 where they were not fitted.
    left_out : mapping, reason -> number of trajectories
        Why trajectories took no part.
    has_vector : bool
        Whether the vector loss was minimised; only then are there offsets and factors.
    shape_error : float
        Standard deviation of the force factors of indenters about 1.
    is_slid : bool
        Whether any touch may slide.
    sensors : collection of str
        Names of the sensors whose touches were fitted.
    """
    findings = [*_bound_hits(fit, bounds), *_not_told(fit, bounds, is_slid), *_singular_pairs(fit)]
    if has_vector:
        findings += [*_misfit(fit), *_far_offsets(fit, prior), *_far_shapes(fit, shape_error)]
    return [*findings, *_one_gel(sensors), *_left_out(left_out)]


def _bound_hits(fit: Fit, bounds: Bounds) -> Iterator[Finding]:
    """Yield a warning for each parameter at a bound of the box."""
    shares, wide = bounds.shares(fit.parameters), BOUNDS["wide"]
    for k, (name, low, high) in enumerate(bounds):
        for side, value, is_there, is_farthest in (
            ("lower", low, shares[k] < AT_BOUND, low <= wide.low[k]),
            ("upper", high, shares[k] > 1 - AT_BOUND, high >= wide.high[k]),
        ):
            if is_there:
                farther = "No bounds go farther: `tactiledata diagnose` looks for what is missing"
                advice = farther if is_farthest else "Compare --bounds wide"
                text = (
                    f"{SYMBOLS[name]} stands at its {side} bound, {in_words(name, value)}: the data favour a value "
                    "beyond it. A bound that is hit is a symptom, not a result: the parameter may have absorbed "
                    f"something that is not modelled, or the bounds are wrong for this gel. {advice}"
                )
                yield Finding("calibration-bound", "warning", text)


def _not_told(fit: Fit, bounds: Bounds, is_slid: bool) -> Iterator[Finding]:
    """Yield a warning for each parameter that the data do not tell, with advice on what to record."""
    widths = np.ptp(fit.intervals.ends, axis=1) / bounds.span
    known = known_parameters(fit.intervals, bounds, is_slid)
    for k, (name, _, _) in enumerate(bounds):
        if known[name].verdict != Knowledge.NOT_TOLD:
            continue
        why = (
            f"its 95 % interval, {_interval(name, fit, k)}, covers {100 * widths[k]:.0f} % of the bounds"
            if is_slid or name != "friction"
            else "no touch moves along the gel or turns while it presses"
        )
        text = f"{SYMBOLS[name]} cannot be known from these data: {why}. {known[name].record}"
        yield Finding("calibration-unidentified", "warning", text)


def _singular_pairs(fit: Fit) -> Iterator[Finding]:
    """Yield a warning for each pair of parameters of which the data fix only a combination."""
    names = list(SYMBOLS)
    for i in range(3):
        for j in range(i):
            correlation = float(fit.intervals.correlation[i, j])
            if abs(correlation) > SINGULAR:
                pair = f"{SYMBOLS[names[j]]} and {SYMBOLS[names[i]]}"
                text = (
                    f"{pair} are a singular pair (correlation {correlation:+.3f}): the data fix a combination of the "
                    "two, not each. Take neither for a property of the material"
                )
                if (names[j], names[i]) == ("youngs_modulus", "poisson_ratio"):
                    text += "; an error of the pad's thickness looks the same"
                yield Finding("calibration-singular", "warning", text)


def _misfit(fit: Fit) -> Iterator[Finding]:
    """Yield a warning where the residual is larger than the noise explains."""
    residual = fit.losses["vector"].fitted
    if residual > MISFIT:
        text = (
            f"the residual is {residual:.1f} times the noise: the gel model leaves something out, and E, nu and mu may "
            "have absorbed a part of it. The intervals are widened for errors in which trajectories differ, not for "
            "errors that all of them share"
        )
        yield Finding("calibration-misfit", "warning", text)


def _far_offsets(fit: Fit, prior: float) -> Iterator[Finding]:
    """Yield warnings for contact offsets far beyond their prior, and for a mean offset that all share."""
    if prior <= 0:
        return
    far = np.abs(fit.offsets) > FAR * prior
    farthest = 1e3 * fit.offsets[np.abs(fit.offsets).argmax()]
    if far.any():
        text = (
            f"{counted(int(far.sum()), 'trajectory')} of {len(far)} begin more than {FAR * prior * 1e3:.2f} mm from "
            f"where their poses say (the farthest {farthest:+.3f} mm): more than the "
            "arm's repeatability explains"
        )
        yield Finding("calibration-offset", "warning", text, count=int(far.sum()))
    mean = float(fit.offsets.mean())
    if abs(mean) > FAR * prior / np.sqrt(len(fit.offsets)):
        text = (
            f"the contact offsets share {mean * 1e3:+.3f} mm: tcp_from_gel, base_from_indenter or the pad's thickness "
            "is off by about as much"
        )
        yield Finding("calibration-common-offset", "warning", text)


def _far_shapes(fit: Fit, share: float) -> Iterator[Finding]:
    """Yield a warning that lists the indenters whose force factor is far from 1."""
    far = {name: factor for name, factor in fit.shape_factors.items() if abs(factor - 1.0) > FAR * share}
    if far:
        indenters = ", ".join(f"{name} {100 * (factor - 1):+.0f} %" for name, factor in sorted(far.items()))
        is_common = len(far) == len(fit.shape_factors) > 1 and len({factor > 1 for factor in far.values()}) == 1
        if is_common:
            why = "all in one direction, so that it is hardly their sizes: E is held by a bound, or physics is missing"
        else:
            why = (
                "sizes, edges or the tilt of these indenters may not be as stated, or the simulation is not valid for "
                "them"
            )
        text = (
            f"measured forces differ from simulated ones by more than {100 * FAR * share:.0f} % for {indenters}: {why}"
        )
        yield Finding("calibration-shape", "warning", text, count=len(far))


def _one_gel(sensors: Collection[str]) -> Iterator[Finding]:
    """Yield a note where the gels of several sensors were fitted as one."""
    if len(sensors) > 1:
        named = ", ".join(sorted(sensors)[:4]) + (", ..." if len(sensors) > 4 else "")
        text = (
            f"the gels of {len(sensors)} sensors ({named}) are fitted as one. Where gels may differ, as after a change "
            "of the gel, calibrate each with --sensor"
        )
        yield Finding("calibration-one-gel", "info", text, count=len(sensors))


def _left_out(left_out: Mapping[str, int]) -> Iterator[Finding]:
    """Yield the number of trajectories left out under each reason."""
    for reason, count in sorted(left_out.items()):
        yield Finding("calibration-left-out", "info", left_out_words(count, reason), count=count)


def in_words(name: str, value: float) -> str:
    """Text of a parameter's value: kPa for ``youngs_modulus`` (given in Pa), else a number."""
    return f"{value / 1e3:.1f} kPa" if name == "youngs_modulus" else f"{value:.3f}"


def _interval(name: str, fit: Fit, k: int) -> str:
    """Text of the 95 % interval of parameter k."""
    low, high = fit.intervals.ends[k]
    return f"{in_words(name, low)} to {in_words(name, high)}"
