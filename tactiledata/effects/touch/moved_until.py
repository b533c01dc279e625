"""All that a touch tells of how its tip moved until each frame, from a stream of poses."""

from __future__ import annotations

from tactiledata.arrays import Array
from tactiledata.effects.touch.felt_acceleration import felt_accelerations
from tactiledata.effects.touch.last_move import last_move, last_ways


def moved_until(frames: Array, seconds: Array, places: Array) -> dict[str, Array]:
    """``pace``, ``rest``, ``last_ways`` and ``felt_accelerations`` of a `Touch`.

    Parameters
    ----------
    frames : (n,) s
    seconds : (m,) s, ascending
        Of the positions, many to a move.
    places : (m, 3), m
        Of the tip, gel frame.
    """
    along = frames, seconds, places[:, :2]
    pace, rest = last_move(*along)
    return {
        "pace": pace,
        "rest": rest,
        "last_ways": last_ways(*along),
        "felt_accelerations": felt_accelerations(frames, seconds, places),
    }
