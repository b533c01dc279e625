"""How much of a gap is closed, in words."""

from __future__ import annotations

import math

from tactiledata.diagnose.gap import Gap
from tactiledata.diagnose.wording import percent


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
