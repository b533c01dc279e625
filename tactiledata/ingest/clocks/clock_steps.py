"""Jumps of one stream's clock, told from pauses by how long the other streams of the recording last.

A stream that pauses lasts as long as the others; one whose clock jumps by some seconds lasts longer (or shorter) by
exactly these. Samples whose time is off cannot be placed among the other streams, and are left out.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactiledata.contract.records import Finding, Times, Values
from tactiledata.ingest.clocks.witnesses import (
    AGREE,
    AGREE_SHARE,
    IMAGES,
    LEAST_STEP,
    PERIODS,
    SIGNAL,
    SILENT_PERIODS,
    Witness,
    jumps_by_vote,
    shares_pause,
    usual_distance,
)

MOST_STEPS = 8
"""The largest pauses that are looked at together."""
MOST_BLOCKS = 64
"""The largest steps, forward and back, between which displaced stretches are looked for."""
BLOCK = 10
"""Samples, at least, of a stretch that stands elsewhere as a whole."""
LEFT_OUT = "samples whose time is off were left out, because their forces or poses would stand in other touches"
CROWDED = 1.5
"""Times the usual number of samples in a stretch, from which on two stretches of real time lie there."""


@dataclass(frozen=True)
class BelievedTimes:
    """A mask (n,) of samples whose time can be believed, and the findings on the others."""

    kept: NDArray[np.bool_]
    findings: tuple[Finding, ...]


def judge_steps(
    stream: str,
    t_ns: Times,
    values: Values,
    witnesses: Sequence[Witness],
    lost: str = LEFT_OUT,
    pauses: bool = True,
) -> BelievedTimes:
    """Return which samples of a stream have a time that can be believed: not those after its clock jumped.

    Steps of the clock are looked for here; `witnesses.jumps_by_vote` decides which of them are jumps.

    Parameters
    ----------
    stream : str
        For messages.
    t_ns : (n,) int64
        In the order of the recording.
    values : (n, k)
    witnesses : sequence of Witness
        What was recorded beside it.
    lost : str
        What becomes of samples whose time is off, in words.
    pauses : bool
        Whether a step forward may be a jump. Of a stream that pauses again and again it is none; a stretch of time
        that stands twice is a jump of any stream.
    """
    everything = np.ones(len(t_ns), dtype=bool)
    usual = usual_distance(t_ns)
    steps = np.diff(t_ns)
    limit = max(LEAST_STEP, PERIODS * usual)
    large = np.flatnonzero(steps > limit)
    large = large[np.argsort(-steps[large], kind="stable")[:MOST_BLOCKS]]
    blocks = _displaced_blocks(t_ns, limit, usual) if pauses else set()
    forward = _judged_steps(t_ns, large, usual, witnesses) if pauses else []
    least_back = max(LEAST_STEP, SILENT_PERIODS * usual)
    back = np.array([row for row in np.flatnonzero(steps < -least_back) if _runs_again(t_ns, values, int(row), usual)])
    certain = sorted({*(int(row) for row in back), *blocks})
    if not forward and not certain:
        return BelievedTimes(everything, ())
    size = {row: int(steps[row]) - usual for row in (*forward, *certain)}
    open_rows = [row for row in forward if row not in blocks]
    jumps, is_known = jumps_by_vote(t_ns, size, open_rows, certain, witnesses)
    if not jumps:
        said = () if is_known else (_undecided(stream, t_ns, size),)
        return BelievedTimes(everything, said)
    off = _displacement(t_ns, {row: size[row] for row in jumps}, witnesses)
    kept = np.abs(off) < LEAST_STEP
    return BelievedTimes(kept, _findings(stream, t_ns, off, kept, [(row, size[row]) for row in sorted(jumps)], lost))


def _judged_steps(t_ns: Times, rows: NDArray[np.intp], usual: int, witnesses: Sequence[Witness]) -> list[int]:
    """Return the steps forward that are looked at together: of ``rows``, those that nobody shares before others."""
    size = {int(row): int(t_ns[row + 1] - t_ns[row]) - usual for row in rows}
    halts = [witness for witness in witnesses if witness.rank in (SIGNAL, IMAGES)]
    shared = {row for row in size if any(shares_pause(witness, int(t_ns[row]), size[row]) for witness in halts)}
    return sorted(sorted(size, key=lambda row: row in shared)[:MOST_STEPS])


def _displaced_blocks(t_ns: Times, limit: int, usual: int) -> set[int]:
    """Rows before which the clock jumps away or comes back, around stretches that leave a hole of just their length.

    A stretch that lies wholly inside another hole of the stream is none: its rows may have come late.
    """
    steps = np.diff(t_ns)
    large = np.flatnonzero(np.abs(steps) > limit)
    large = np.sort(large[np.argsort(-np.abs(steps[large]), kind="stable")[:MOST_BLOCKS]])
    is_elsewhere = np.zeros(len(t_ns), dtype=bool)
    stretches = []
    for away, home in itertools.pairwise(large.tolist()):
        stretch = slice(away + 1, home + 1)
        block = t_ns[stretch]
        if np.sign(steps[away]) == np.sign(steps[home]) or len(block) < BLOCK:
            continue
        lasted = int(block[-1] - block[0])
        hole = int(t_ns[home + 1] - t_ns[away]) - 2 * usual
        if abs(hole - lasted) <= max(3 * usual, int(AGREE_SHARE * lasted)):
            stretches.append((away, home, block))
            is_elsewhere[stretch] = True
    # several that stand elsewhere together say nothing of where the stream begins and ends
    sound = t_ns[~is_elsewhere]
    found: set[int] = set()
    for away, home, block in stretches:
        first, last = block.min(), block.max()
        n_others = ((t_ns >= first) & (t_ns <= last)).sum() - len(block)
        if n_others > 2 or first < sound.min() or last > sound.max():
            found |= {away, home}
    return found


def _runs_again(t_ns: Times, values: Values, row: int, usual: int) -> bool:
    """Whether a stretch of time stands twice after a step back: not rows that come late into a hole, nor copies."""
    first, last = int(t_ns[row + 1]), int(t_ns[: row + 1].max())
    last = min(last, int(t_ns[row + 1 :].max()))
    before = np.flatnonzero((t_ns[: row + 1] >= first) & (t_ns[: row + 1] <= last))
    if len(before):
        # a stream whose beginning was off stands twice only where that beginning was put
        first = int(t_ns[before].min())
    after = row + 1 + np.flatnonzero((t_ns[row + 1 :] >= first) & (t_ns[row + 1 :] <= last))
    if last <= first or len(before) + len(after) < CROWDED * (last - first) / max(usual, 1):
        return False
    both, left, right = np.intersect1d(t_ns[before], t_ns[after], return_indices=True)
    is_copy = np.array_equal(values[before[left]], values[after[right]], equal_nan=True)
    return not (is_copy and len(both) > 0.9 * len(after))


def _displacement(t_ns: Times, jumps: dict[int, int], witnesses: Sequence[Witness]) -> Times:
    """Return how many ns the time of each sample (n,) is off: 0 at the start, or at the end if only that one fits."""
    off = np.zeros(len(t_ns), dtype=np.int64)
    for row, step in jumps.items():
        off[row + 1 :] += step
    total = int(off[-1])
    tolerance = max(AGREE, int(AGREE_SHARE * abs(total)))
    ranked = sorted(witnesses, key=lambda witness: witness.rank)
    for witness in ranked:
        is_first_right = abs(int(t_ns[0]) - witness.start) <= tolerance
        is_last_right = abs(int(t_ns[-1]) - witness.end) <= tolerance
        if is_first_right != is_last_right:
            return off if is_first_right else off - total
    return off


def _findings(
    stream: str, t_ns: Times, off: Times, kept: NDArray[np.bool_], jumps: list[tuple[int, int]], lost: str
) -> tuple[Finding, ...]:
    where = ", ".join(f"{step / 1e9:+.3f} s after {(t_ns[row] - t_ns[0]) / 1e9:.3f} s" for row, step in jumps[:5])
    left_out = int((~kept).sum())
    true_ns = (t_ns - off)[~kept]
    text = (
        f"{stream}: its clock jumps against the other streams ({where}); the {left_out} {lost}. Mend the times in the "
        "recording, and ingest it again"
    )
    start, end = (int(true_ns.min()), int(true_ns.max())) if left_out else (None, None)
    return (Finding("clock-jump", "damage", text, stream, start_ns=start, end_ns=end, count=left_out),)


def _undecided(stream: str, t_ns: Times, size: dict[int, int]) -> Finding:
    row = max(size, key=lambda place: size[place])
    text = (
        f"{stream}: no samples for {size[row] / 1e9:.3f} s, {(t_ns[row] - t_ns[0]) / 1e9:.3f} s after its start; "
        "whether it paused or its clock jumped cannot be told, because no other stream lasts as long as either says"
    )
    start, end = int(t_ns[row]), int(t_ns[row + 1])
    return Finding("pause-or-jump", "warning", text, stream, start_ns=start, end_ns=end, count=len(size))
