"""Numbers, quantities, changes and p-values as text for sentences."""

from __future__ import annotations

import math

from tactiledata.diagnose.residuals.gap import Gap

VERBS = {True: "rises", False: "falls"}
"""Verb of a change, by whether it is positive."""
ABOVE = {True: "above", False: "below"}
"""Where the measured value lies, by whether measured minus simulated is positive."""
TOO = {True: "too low", False: "too high"}
"""What is wrong with a parameter, by whether the refit increases it."""


def rounded(value: float, digits: int = 2) -> str:
    """Return a number as text with ``digits`` significant digits; very large and small ones with an exponent."""
    if value == 0 or not math.isfinite(value):
        return f"{value:g}"
    places = digits - 1 - math.floor(math.log10(abs(value)))
    if -5 < places <= 4:
        return f"{value:.{max(places, 0)}f}"
    return f"{value:.{digits - 1}e}"


def quantity(value: float, unit: str) -> str:
    """Return a value with its unit, such as ``"0.30 mm"``; the unit is left out where it is 1 or not known."""
    return rounded(value) if unit in ("", "1", "?") else f"{rounded(value)} {unit}"


def with_interval(value: float, half_width: float, unit: str) -> str:
    """Return a value with its interval, such as ``"11 ± 2 %"``, both rounded to the precision of the interval.

    Parameters
    ----------
    value, half_width : float
        The interval is value ± half_width; a half width that is 0 or not finite is left out.
    unit : str
        Unit of both; left out where it is 1 or not known.
    """
    if not math.isfinite(half_width) or half_width <= 1e-9 * abs(value):
        return quantity(value, unit)
    places = max(-3, (0 if half_width >= 2 * 10 ** math.floor(math.log10(half_width)) else 1)
                 - math.floor(math.log10(half_width)))  # fmt: skip
    digits = max(places, 0)
    text = f"{round(value, places):.{digits}f} ± {round(half_width, places):.{digits}f}"
    return text if unit in ("", "1", "?") else f"{text} {unit}"


def signed_change(name: str, value: float, half_width: float, unit: str) -> str:
    """Return a clause such as ``"E falls by 11 ± 2 %"``.

    A change of 0 "falls". Rounding, and where half width and unit are left out, are as in `with_interval`.

    Parameters
    ----------
    name : str
        Name of the parameter.
    value, half_width : float
        Change and half width of its interval, in ``unit``.
    unit : str
        Unit of both.
    """
    return f"{name} {VERBS[value > 0]} by {with_interval(abs(value), half_width, unit)}"


def departs(name: str, size: float, half_width: float, unit: str) -> str:
    """Return a clause such as ``"measured fz is 2.2 ± 0.3 times the noise below the simulated one"``.

    A size of 0 lies "below". Rounding, and where half width and unit are left out, are as in `with_interval`.

    Parameters
    ----------
    name : str
        Name of the component.
    size, half_width : float
        Measured minus simulated value and half width of its interval, in ``unit``.
    unit : str
        Unit of both, such as ``"times the noise"``.
    """
    return f"measured {name} is {with_interval(abs(size), half_width, unit)} {ABOVE[size > 0]} the simulated one"


def percent(share: float) -> str:
    """Return a share from 0 to 1 as a percentage, such as ``"62 %"``."""
    return f"{100 * share:.0f} %"


def p_text(value: float) -> str:
    """Return a p-value as text, such as ``"0.012"`` or ``"< 0.001"``."""
    return "< 0.001" if value < 0.001 else rounded(value)


def p_words(value: float) -> str:
    """Return a p-value with its symbol, such as ``"p = 0.012"`` or ``"p < 0.001"``."""
    text = p_text(value)
    return f"p {text}" if text.startswith("<") else f"p = {text}"


def gap_words(gap: Gap, has_gap: bool) -> str:
    """Return the closed share of a gap, as ``"82 % (70 % to 90 %)"`` or ``"all"``; a dash where there is no gap."""
    if not has_gap or not math.isfinite(gap.closed):
        return "-"
    if gap.interval[0] >= 1.0:
        return "all"
    closed, low, high = (percent(min(end, 1.0)) for end in (gap.closed, *gap.interval))
    return f"{closed} ({low} to {high})"


def growth_words(gap: Gap) -> str:
    """Return the relative growth of a gap that a correction widens, such as ``"150 % (50 % to 250 %)"``."""
    grown, low, high = (percent(-end) for end in (gap.closed, *reversed(gap.interval)))
    return f"{grown} ({low} to {high})"


def change_words(gap: Gap) -> str:
    """Return a clause that says which share of the gap is closed, or by how much the gap grows."""
    if gap.closed < 0:
        return f"the gap to the noise grows by {growth_words(gap)}"
    return f"{gap_words(gap, True)} of the gap is closed"
