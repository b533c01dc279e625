"""Fields of a touch that describe the motion of its tip about each frame, from a stream of poses."""

from __future__ import annotations

from tactiledata.arrays import Array
from tactiledata.effects.touch.earlier_places import earlier_places
from tactiledata.effects.touch.felt_acceleration import felt_accelerations
from tactiledata.effects.touch.last_move import last_move, last_ways


def moved_until(frames: Array, seconds: Array, places: Array) -> dict[str, Array]:
    """Return ``pace``, ``rest``, ``last_ways``, ``felt_accelerations`` and ``earlier_places`` of a `Touch`, by name.

    Parameters
    ----------
    frames : (n,) s
        Times of the frames.
    seconds : (m,) s, ascending
        Times of the positions, many to a move.
    places : (m, 3), m
        Positions of the tip, gel frame.
    """
    along = frames, seconds, places[:, :2]
    pace, rest = last_move(*along)
    return {
        "pace": pace,
        "rest": rest,
        "last_ways": last_ways(*along),
        "felt_accelerations": felt_accelerations(frames, seconds, places),
        "earlier_places": earlier_places(frames, seconds, places),
    }
