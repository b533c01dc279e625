"""How near the parts of a small split come to the shares that were asked for, and which seed brings them nearer."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from tactiledata.contract.wording import counted
from tactiledata.splits.assign import draw, part_of
from tactiledata.splits.options import SHARES, SplitOptions

SEEDS_TRIED = 64
"""Seeds looked at for one that fills every part of a small store."""
NAMED = 3
"""Seeds that are named, the nearest first."""
MANY_GROUPS = 1000
"""Number of groups above which no seed is looked for: of so many, chance hardly leaves a part empty."""
ASTRAY = 0.05
"""How far a part's share may be from what was asked for before a note says so."""


def group_sizes(table: pa.Table, taken: NDArray[np.bool_]) -> dict[str, int]:
    """Trajectories of each group that is drawn, of the rows that were taken.

    Parameters
    ----------
    table : pa.Table
        ``SPLIT_SCHEMA``, n rows.
    taken : (n,) bool
        Rows that count.
    """
    rows = zip(table["group"].to_pylist(), taken.tolist(), strict=True)
    return dict(sorted(Counter(group for group, is_taken in rows if is_taken).items()))


def filling_seeds(sizes: Mapping[str, int], options: SplitOptions) -> list[int]:
    """The seeds that leave no part empty, at most three, those nearest to the shares first.

    Parameters
    ----------
    sizes : dict, group -> trajectories
    options : SplitOptions
        Its fractions count; its seed does not.
    """
    if len(sizes) > MANY_GROUPS:
        return []
    wanted = sum(share > 0 for share in options.fractions)
    near = []
    for seed in range(SEEDS_TRIED):
        shares = _shares(sizes, options, seed)
        if np.count_nonzero(shares) == wanted:
            near.append((_distance(shares, options), seed))
    return [seed for _, seed in sorted(near)[:NAMED]]


def astray_note(dealt: Sequence[int], sizes: Mapping[str, int], options: SplitOptions, is_free: bool) -> str:
    """Say how far parts that are all filled are from their shares; empty where each is within 0.05 of it.

    Parameters
    ----------
    dealt : (3,) int
        Trajectories of train, val and test; at least one of them has some.
    sizes : dict, group -> trajectories
        All that is drawn.
    options : SplitOptions
    is_free : bool
        Whether another seed would hold the same units out, so that its shares can be told.
    """
    shares = np.asarray(dealt) / sum(dealt)
    if len(sizes) > MANY_GROUPS or np.abs(shares - options.fractions).max() <= ASTRAY:
        return ""
    note = f"the parts are drawn by chance, and {counted(sum(dealt), 'trajectory')} are few: "
    note += ", ".join(
        f"{part} has {share:.0%} of them (asked: {asked:.0%})"
        for part, share, asked in zip(SHARES, shares, options.fractions, strict=True)
        if share or asked
    )
    seeds = filling_seeds(sizes, options) if is_free else []
    nearest = _shares(sizes, options, seeds[0]) if seeds else shares
    # a tie, and what differs by rounding alone, is no reason to draw again
    if _distance(nearest, options) < _distance(shares, options) - 1e-9:
        parts = ", ".join(f"{part} {share:.0%}" for part, share in zip(SHARES, nearest, strict=True) if share)
        note += f"; the same command with --seed {seeds[0]} --replace gives {parts}"
    return note


def _shares(sizes: Mapping[str, int], options: SplitOptions, seed: int) -> NDArray[np.float64]:
    """Share of the trajectories (3,) that each part gets with a seed."""
    parts = part_of(np.array([draw(group, seed) for group in sizes], float), options.fractions)
    return np.bincount(parts, list(sizes.values()), len(SHARES)) / sum(sizes.values())


def _distance(shares: NDArray[np.float64], options: SplitOptions) -> float:
    """How far shares (3,) are from those that were asked for, summed over the parts."""
    return float(np.abs(shares - options.fractions).sum())
