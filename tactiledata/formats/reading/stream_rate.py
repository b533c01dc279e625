"""The rate of a stream from its first and last stamp, where these are times at all."""

from __future__ import annotations

SHORTEST_STEP = 1_000
"""ns. Stamps that lie closer on average are no times: they count images (0, 1, 2 ns), or are all alike."""


def has_times(count: int, first_ns: int, last_ns: int) -> bool:
    """Whether ``count`` stamps from the first to the last can be times; a single one can.

    Parameters
    ----------
    count : int
        Number of stamps.
    first_ns, last_ns : int
        The first and the last of them, ns.
    """
    return count < 2 or last_ns - first_ns >= (count - 1) * SHORTEST_STEP


def rate_of(count: int, first_ns: int, last_ns: int) -> float | None:
    """Hz, from the first stamp to the last; ``None`` of fewer than two, and of stamps that are no times.

    Parameters
    ----------
    count : int
        Number of stamps.
    first_ns, last_ns : int
        The first and the last of them, ns.

    Examples
    --------
    >>> rate_of(11, 0, 10**9), rate_of(5, 0, 4), rate_of(1, 7, 7)
    (10.0, None, None)
    """
    if count < 2 or not has_times(count, first_ns, last_ns):
        return None
    return (count - 1) * 1e9 / (last_ns - first_ns)
