"""What a person should know of a calibration, in words."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from tactiledata.calibrate.bounds import SYMBOLS, Bounds
from tactiledata.calibrate.fit import Fit
from tactiledata.contract.records import Finding
from tactiledata.contract.wording import counted

AT_BOUND = 0.01
"""Share of the box: a parameter this near its bound stands there."""
SINGULAR = 0.95
"""Correlation from which on two parameters are not told apart."""
WIDE = 0.8
"""Share of the box: an interval this wide says no more than the box did."""
MISFIT = 1.5
"""Root mean square of the whitened residual that noise does not explain."""
FAR = 3.0
"""Standard deviations of the prior."""


def remarks(
    fit: Fit, bounds: Bounds, prior: float, left_out: Mapping[str, int], has_vector: bool, shape_error: float = 0.0
) -> list[Finding]:
    """Findings of a fit, and what was left out."""
    found = [*_bound_hits(fit, bounds), *_unidentified(fit, bounds), *_singular_pairs(fit)]
    if has_vector:
        found += [*_misfit(fit), *_far_offsets(fit, prior), *_far_shapes(fit, shape_error)]
    return found + list(_left_out(left_out))


def _bound_hits(fit: Fit, bounds: Bounds) -> Iterator[Finding]:
    shares = bounds.shares(fit.parameters)
    for k, (name, low, high) in enumerate(bounds):
        for side, value, is_there in (
            ("lower", low, shares[k] < AT_BOUND),
            ("upper", high, shares[k] > 1 - AT_BOUND),
        ):
            if is_there:
                text = (
                    f"{SYMBOLS[name]} stands at its {side} bound, {in_words(name, value)}: the data would rather have "
                    "it further out. A bound that is hit is a symptom, not a result: something that is not modelled "
                    "may be absorbed, or the bounds are wrong for this gel; compare --bounds wide"
                )
                yield Finding("calibration-bound", "warning", text)


def _unidentified(fit: Fit, bounds: Bounds) -> Iterator[Finding]:
    widths = np.ptp(fit.intervals.ends, axis=1) / bounds.span
    for k, (name, _, _) in enumerate(bounds):
        if widths[k] > WIDE:
            text = (
                f"{SYMBOLS[name]} cannot be known from these data: its 95 % interval, {_interval(name, fit, k)}, "
                f"covers {100 * widths[k]:.0f} % of the bounds. {_ADVICE[name]}"
            )
            yield Finding("calibration-unidentified", "warning", text)


_ADVICE = {
    "youngs_modulus": "More, deeper touches help.",
    "poisson_ratio": "Flat indenters and deep touches on a thin pad tell it; spheres alone hardly do.",
    "friction": "Only touches that slip tell it: shear further than the gel sticks.",
}


def _singular_pairs(fit: Fit) -> Iterator[Finding]:
    names = list(SYMBOLS)
    for i in range(3):
        for j in range(i):
            together = float(fit.intervals.correlation[i, j])
            if abs(together) > SINGULAR:
                pair = f"{SYMBOLS[names[j]]} and {SYMBOLS[names[i]]}"
                text = (
                    f"{pair} are a singular pair (correlation {together:+.3f}): the data fix a combination of the two, "
                    "not each. Take neither for a property of the material"
                )
                if (names[j], names[i]) == ("youngs_modulus", "poisson_ratio"):
                    text += "; an error of the pad's thickness looks the same"
                yield Finding("calibration-singular", "warning", text)


def _misfit(fit: Fit) -> Iterator[Finding]:
    left = fit.losses["vector"].fitted
    if left > MISFIT:
        text = (
            f"the residual is {left:.1f} times the noise: the gel model leaves something out, and E, nu and mu may "
            "have absorbed a part of it. The intervals are widened for what trajectories disagree on, not for what "
            "all of them share"
        )
        yield Finding("calibration-misfit", "warning", text)


def _far_offsets(fit: Fit, prior: float) -> Iterator[Finding]:
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
    far = {name: factor for name, factor in fit.shape_factors.items() if abs(factor - 1.0) > FAR * share}
    if far:
        said = ", ".join(f"{name} {100 * (factor - 1):+.0f} %" for name, factor in sorted(far.items()))
        text = (
            f"measured forces are off those simulated by more than {100 * FAR * share:.0f} % for {said}: sizes, "
            "edges or the tilt of these indenters may not be as stated, or the simulation does not serve for them"
        )
        yield Finding("calibration-shape", "warning", text, count=len(far))


def _left_out(left_out: Mapping[str, int]) -> Iterator[Finding]:
    for reason, count in sorted(left_out.items()):
        yield Finding("calibration-left-out", "info", f"{counted(count, 'trajectory')} left out: {reason}", count=count)


def in_words(name: str, value: float) -> str:
    """A parameter's value with its unit."""
    return f"{value / 1e3:.1f} kPa" if name == "youngs_modulus" else f"{value:.3f}"


def _interval(name: str, fit: Fit, k: int) -> str:
    low, high = fit.intervals.ends[k]
    return f"{in_words(name, low)} to {in_words(name, high)}"
