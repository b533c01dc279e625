"""Numbers, quantities and changes as people say them."""

from __future__ import annotations

import math

from tactiledata.diagnose.residuals.gap import Gap

VERBS = {True: "rises", False: "falls"}
ABOVE = {True: "above", False: "below"}
TOO = {True: "too low", False: "too high"}
"""Of what was predicted, where what was measured is more, or is not."""


def rounded(value: float, digits: int = 2) -> str:
    """A number with so many significant digits, whole ones whole, without exponent where it can be read without."""
    if value == 0 or not math.isfinite(value):
        return f"{value:g}"
    places = digits - 1 - math.floor(math.log10(abs(value)))
    if -5 < places <= 4:
        return f"{value:.{max(places, 0)}f}"
    return f"{value:.{digits - 1}e}"


def quantity(value: float, unit: str) -> str:
    """``"0.30 mm"``; without a unit where there is none."""
    return rounded(value) if unit in ("", "1", "?") else f"{rounded(value)} {unit}"


def with_interval(value: float, half_width: float, unit: str) -> str:
    """``"11 ± 2 %"``: both to the digits that the interval leaves."""
    if not math.isfinite(half_width) or half_width <= 1e-9 * abs(value):
        return f"{rounded(value)} {unit}".strip()
    places = max(-3, (0 if half_width >= 2 * 10 ** math.floor(math.log10(half_width)) else 1)
                 - math.floor(math.log10(half_width)))  # fmt: skip
    digits = max(places, 0)
    said = f"{round(value, places):.{digits}f} ± {round(half_width, places):.{digits}f}"
    return said if unit in ("", "1", "?") else f"{said} {unit}"


def signed_change(name: str, value: float, half_width: float, unit: str) -> str:
    """``"E falls by 11 ± 2 %"``."""
    return f"{name} {VERBS[value > 0]} by {with_interval(abs(value), half_width, unit)}"


def departs(name: str, size: float, half_width: float, unit: str) -> str:
    """``"measured fz is 2.2 ± 0.3 times the noise below the simulated one"``: of measured less simulated."""
    return f"measured {name} is {with_interval(abs(size), half_width, unit)} {ABOVE[size > 0]} the simulated one"


def percent(share: float) -> str:
    """``"62 %"``."""
    return f"{100 * share:.0f} %"


def p_text(value: float) -> str:
    """``"0.012"``, or ``"< 0.001"``."""
    return "< 0.001" if value < 0.001 else rounded(value)


def p_words(value: float) -> str:
    """``"p = 0.012"``, or ``"p < 0.001"``."""
    text = p_text(value)
    return f"p {text}" if text.startswith("<") else f"p = {text}"


def gap_words(gap: Gap, has_gap: bool) -> str:
    """``"82 % (70 % to 90 %)"``, ``"all"`` where it is surely closed, or a dash where there is nothing to close."""
    if not has_gap or not math.isfinite(gap.closed):
        return "-"
    if gap.interval[0] >= 1.0:
        return "all"
    closed, low, high = (percent(min(end, 1.0)) for end in (gap.closed, *gap.interval))
    return f"{closed} ({low} to {high})"


def growth_words(gap: Gap) -> str:
    """By how much of itself a gap grows: ``"150 % (50 % to 250 %)"``."""
    grown, low, high = (percent(-end) for end in (gap.closed, *reversed(gap.interval)))
    return f"{grown} ({low} to {high})"


def change_words(gap: Gap) -> str:
    """``"82 % (70 % to 90 %) of the gap is closed"``, or by how much it grows."""
    if gap.closed < 0:
        return f"the gap to the noise grows by {growth_words(gap)}"
    return f"{gap_words(gap, True)} of the gap is closed"
