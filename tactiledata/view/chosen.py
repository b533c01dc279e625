"""Which trajectories of a store are shown, and which of their frames."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from tactiledata.arrays import Indices
from tactiledata.errors import UnknownName, UsageError
from tactiledata.store.read.flags import flagged_trajectories
from tactiledata.store.read.named_trajectories import named_trajectories
from tactiledata.store.read.reader import Store
from tactiledata.view.options import ViewOptions


def chosen_trajectories(store: Store, options: ViewOptions) -> tuple[list[int], int]:
    """Rows of the trajectories that are shown, and how many there are that the options describe.

    Trajectories that are named are all shown; else the first ones of the store are.

    Raises
    ------
    UnknownName
        The store holds no such trajectory, sensor or indenter.
    UsageError
        A name that several trajectories have, or nothing is left to show.
    """
    table = store.trajectories(["uid", "sensor", "indenter"])
    rows: Iterable[int] = (
        named_trajectories(store, options.names, whole_recordings=True) if options.names else range(table.num_rows)
    )
    for kind, wanted in (("sensor", options.sensor), ("indenter", options.indenter)):
        if wanted is not None:
            known = table[kind].to_pylist()
            if wanted not in known:
                raise UnknownName(kind, wanted, {name for name in known if name})
            rows = [row for row in rows if known[row] == wanted]
    if options.flagged:
        flags, uids = flagged_trajectories(store), table["uid"].to_pylist()
        rows = [row for row in rows if uids[row] in flags]
    found = list(rows)
    if not found:
        raise UsageError(
            f"nothing to show: no trajectory of {store.location} is like that"
            if table.num_rows
            else f"nothing to show: the store {store.location} holds no trajectories",
            "at least one trajectory",
            "`tactiledata info` shows what the store holds.",
        )
    is_cut = not options.names and options.most
    return (found[: options.most] if is_cut else found), len(found)


def thinned(count: int, stride: int, most: int) -> Indices:
    """Numbers (k,), ascending, of the frames or samples that are shown: first and last are among them.

    Parameters
    ----------
    count : int
        How many there are.
    stride : int
        Every how manieth is taken.
    most : int
        Largest number that is taken, evenly; 0 for all.

    Examples
    --------
    >>> thinned(10, 3, 0).tolist(), thinned(10, 1, 4).tolist()
    ([0, 3, 6, 9], [0, 3, 6, 9])
    """
    taken = np.arange(0, count, stride)
    if len(taken) and taken[-1] != count - 1:
        taken = np.append(taken, count - 1)
    if most and len(taken) > most:
        taken = taken[np.unique(np.rint(np.linspace(0, len(taken) - 1, most)).astype(np.int64))]
    return taken
