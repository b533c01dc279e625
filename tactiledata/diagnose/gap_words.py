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
    return share_words(gap.closed, gap.interval)


def share_words(share: float, interval: tuple[float, float]) -> str:
    """A share of the whole with its interval; beyond the whole is the whole."""
    closed, low, high = (percent(min(end, 1.0)) for end in (share, *interval))
    return f"{closed} ({low} to {high})"
