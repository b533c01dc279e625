"""Confidence interval of a share."""

from __future__ import annotations

Z = 1.959964
"""Half-width of a normal distribution's 95 % interval, in standard deviations."""


def interval(successes: int, count: int) -> tuple[float, float]:
    """Wilson's 95 % interval of a share."""
    if count == 0:
        return 0.0, 1.0
    share, square = successes / count, Z**2 / count
    middle = (share + square / 2) / (1 + square)
    half = Z / (1 + square) * (share * (1 - share) / count + square / (4 * count)) ** 0.5
    return middle - half, middle + half
