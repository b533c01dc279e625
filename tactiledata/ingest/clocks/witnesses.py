"""Witnesses of a stream's clock: what other streams of a recording say of its steps, pauses or jumps."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tactiledata.contract.records import Times

LEAST_STEP = 300_000_000
"""ns. Smaller steps are jitter, or a queue that was emptied out of order."""
PERIODS = 20
"""Times the usual distance of samples, below which a step is no step."""
SILENT_PERIODS = 3
"""Times the usual distance of samples, from which on a witness that stops is seen to be silent."""
AGREE, AGREE_SHARE = 250_000_000, 0.1
"""ns, and share of the step: streams that are started and stopped together last equally long within these."""
SURE = 1_000_000_000
"""ns. Images and trajectories begin and end when they like, so that of shorter steps they tell little."""
SHARP_SHARE = 0.1
"""Share of such a step within which images must begin or end with a stream, to tell that its clock jumped."""
AS_WELL = 150_000_000
"""ns. Choices of jumps that explain a length within this of the best explain it as well: half of the least step."""


STAMPS, SIGNAL, IMAGES, TRAJECTORIES = range(4)
"""Kinds of witnesses; the first that can tell decides."""


@dataclass(frozen=True)
class Witness:
    """The first and last moment (ns) of what was recorded beside a stream, and its pauses as (place, length) in ns.

    The less ``rank``, the more it counts: `STAMPS` (the stream's own other ones), `SIGNAL`, `IMAGES`, `TRAJECTORIES`.
    Of steps shorter than ``shown_from`` (ns) nobody can say whether it was silent too.
    """

    rank: int
    start: int
    end: int
    pauses: tuple[tuple[int, int], ...] = ()
    shown_from: int = 0


def usual_distance(t_ns: Times) -> int:
    """Median distance (ns) of neighbouring samples that are in order; 0 where there are none."""
    steps = np.diff(t_ns)
    return int(np.median(steps[steps > 0])) if (steps > 0).any() else 0


def pauses_of(t_ns: Times) -> tuple[tuple[int, int], ...]:
    """Place and length (ns) of the steps forward that are pauses or jumps of a clock."""
    limit = max(LEAST_STEP, PERIODS * usual_distance(t_ns))
    steps = np.diff(t_ns)
    return tuple((int(t_ns[row]), int(steps[row])) for row in np.flatnonzero(steps > limit))


def shown_from(t_ns: Times) -> int:
    """Return the length (ns) of a step from which on a stream shows whether it was silent; 0 if it shows all steps."""
    limit = SILENT_PERIODS * usual_distance(t_ns)
    return limit if limit > LEAST_STEP else 0


def silences_of(t_ns: Times) -> tuple[tuple[int, int], ...]:
    """Place and length (ns) of the steps forward in which a stream, or the images of a camera, are silent."""
    limit = max(LEAST_STEP, shown_from(t_ns))
    steps = np.diff(t_ns)
    return tuple((int(t_ns[row]), int(steps[row])) for row in np.flatnonzero(steps > limit))


def witness_of(rank: int, t_ns: Times) -> Witness:
    """Return what signals or images at some times (two at least) witness of the streams beside them."""
    return Witness(rank, int(t_ns.min()), int(t_ns.max()), silences_of(t_ns), shown_from(t_ns))


def jumps_by_vote(
    t_ns: Times, size: dict[int, int], forward: list[int], back: list[int], witnesses: Sequence[Witness]
) -> tuple[set[int], bool]:
    """Return the rows before which the clock jumped, and whether any witness could tell; a step back is never a pause.

    Parameters
    ----------
    t_ns : (n,) int64
        Times of the stream's samples, in the order of the recording.
    size : dict, row -> ns
        By how much each step is longer than the usual one.
    forward, back : list of int
        Rows before which the time steps forward by far, and back.
    witnesses : sequence of Witness
        What was recorded beside the stream.
    """
    for _, group in itertools.groupby(sorted(witnesses, key=lambda witness: witness.rank), lambda entry: entry.rank):
        votes = []
        for witness in group:
            hidden = {row for row in forward if _is_hidden(witness, t_ns, row, size[row], witnesses)}
            vote = _vote(witness, t_ns, size, [row for row in forward if row not in hidden], forward, back)
            votes += [] if vote is None else [vote]
        if votes and votes.count(votes[0]) == len(votes):
            return set(votes[0]), True
        if votes:
            most = max(set(votes), key=votes.count)
            return (set(most), True) if 2 * votes.count(most) > len(votes) else (_returning(size, forward, back), False)
    # where all halt together, none is displaced against another
    is_halt = all(_is_halt(int(t_ns[row]), size[row], witnesses) for row in forward)
    return _returning(size, forward, back), any(witness.rank == SIGNAL for witness in witnesses) and is_halt


def _is_hidden(witness: Witness, t_ns: Times, row: int, step: int, witnesses: Sequence[Witness]) -> bool:
    """Whether a witness cannot tell a pause from a jump before a row.

    What pauses at the same moment shares the clock, or was halted together. What others were silent at is a pause, and
    no length of a third one makes it a jump: of images for all, of signals for other signals, which may be stopped
    early. The stream's own log times need nobody beside them.
    """
    place = int(t_ns[row])
    if shares_pause(witness, place, step) or step < witness.shown_from:
        return True
    if witness.rank == STAMPS:
        return False
    halting = (IMAGES, SIGNAL) if witness.rank == SIGNAL else (IMAGES,)
    if any(shares_pause(other, place, step) for other in witnesses if other.rank in halting):
        return True
    return _is_beyond(witness, t_ns, row, step, _showing(step, witnesses))


def _showing(step: int, witnesses: Sequence[Witness]) -> list[Witness]:
    """Signals that are fast enough to show that they were silent for as long as a step."""
    return [witness for witness in witnesses if witness.rank == SIGNAL and step >= witness.shown_from]


def _is_halt(place: int, step: int, witnesses: Sequence[Witness]) -> bool:
    """Whether images, or all signals that could show it, were silent at a step."""
    showing = _showing(step, witnesses)
    images = [witness for witness in witnesses if witness.rank == IMAGES]
    by_signals = bool(showing) and all(shares_pause(witness, place, step) for witness in showing)
    return by_signals or any(shares_pause(witness, place, step) for witness in images)


def _vote(
    witness: Witness, t_ns: Times, size: dict[int, int], able: list[int], forward: list[int], back: list[int]
) -> frozenset[int] | None:
    """The jumps that explain by how much a stream lasts longer than a witness; ``None`` where none do, or several.

    Parameters
    ----------
    witness : Witness
    t_ns : (n,) int64
    size : dict, row -> ns
        Of all steps.
    able : list of rows
        Steps forward of which the witness can tell.
    forward, back : list of rows
    """
    largest = max((abs(size[row]) for row in (*able, *back)), default=0)
    longer = int(t_ns[-1] - t_ns[0]) - (witness.end - witness.start)
    choices = [(*back, *rows) for count in range(len(able) + 1) for rows in itertools.combinations(able, count)]
    errors = [abs(longer - sum(size[row] for row in rows)) for rows in choices]
    if not largest or min(errors) > max(AGREE, int(AGREE_SHARE * largest)):
        return None
    near = [rows for rows, error in zip(choices, errors, strict=True) if error <= min(errors) + AS_WELL]
    if len(near) == 1:
        return frozenset(near[0])
    # several explain the length: the one with the fewest steps that the witness does not share counts, if it is one
    ranks = [(_unshared(witness, t_ns, size, rows, forward), len(rows)) for rows in near]
    return frozenset(near[ranks.index(min(ranks))]) if ranks.count(min(ranks)) == 1 else None


def _unshared(witness: Witness, t_ns: Times, size: dict[int, int], jumps: tuple[int, ...], forward: list[int]) -> int:
    """How many steps are jumps, or pauses that a witness does not share once the jumps are taken back.

    The jumps are taken back from the start or from the end of the stream, whichever leaves fewer.
    """
    pauses = [row for row in forward if row not in jumps]
    total = sum(size[row] for row in jumps)
    places = [int(t_ns[row]) - sum(size[jump] for jump in jumps if jump < row) for row in pauses]
    alone = [
        sum(not shares_pause(witness, place + off, size[row]) for place, row in zip(places, pauses, strict=True))
        for off in (0, total)
    ]
    return len(jumps) + min(alone)


def _returning(size: dict[int, int], forward: list[int], back: list[int]) -> set[int]:
    """Steps back, and before each the step forward that it takes back."""
    jumps = set(back)
    for row in back:
        near = [other for other in forward if other < row and abs(size[other] + size[row]) < AGREE]
        jumps.update(near[-1:])
    return jumps


def shares_pause(witness: Witness, place: int, step: int) -> bool:
    """Return whether a witness paused at the same place for as long as a step lasts.

    Parameters
    ----------
    witness : Witness
        What was recorded beside the stream.
    place : int
        Time of the sample before the step, ns.
    step : int
        Length of the step, ns.
    """
    return any(abs(at - place) < LEAST_STEP and abs(length - step) < LEAST_STEP for at, length in witness.pauses)


def _is_beyond(witness: Witness, t_ns: Times, row: int, step: int, signals: Sequence[Witness]) -> bool:
    """Whether a witness that begins and ends when it likes cannot tell if the clock jumped before a row.

    Where all signals halt together, a controller stalled, or its clock was set: images tell only where they begin or
    end with the signals and are off by the step at their other end.
    """
    if witness.rank < IMAGES:
        return False
    if witness.rank == TRAJECTORIES:
        return step < SURE
    if not signals or not all(shares_pause(signal, int(t_ns[row]), step) for signal in signals):
        return False
    ends = int(t_ns[0]) - witness.start, int(t_ns[-1]) - witness.end
    within = SHARP_SHARE * step if step < SURE else max(AGREE, AGREE_SHARE * step)
    return all(abs(ends[0] - off) > within or abs(ends[1] - off - step) > within for off in (0, -step))
