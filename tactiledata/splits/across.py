"""Leaks between two stores: derived trajectories in one, what they were made of in the other, each with its split."""

from __future__ import annotations

import numpy as np

from tactiledata.contract.records import Finding
from tactiledata.errors import UsageError
from tactiledata.splits.flagged import flagged_parent_findings
from tactiledata.splits.groups import family_roots
from tactiledata.splits.leaks import leak, partition_codes
from tactiledata.splits.manifest import load_split, partition_rows
from tactiledata.splits.options import PARTITIONS
from tactiledata.store.read.reader import Store


def audit_across(
    children: Store, parents: Store, name: str = "default", parents_name: str | None = None
) -> list[Finding]:
    """Derived trajectories of one store that stand in another part than their recorded root in the other store, or
    whose origin is flagged there.

    Parameters
    ----------
    children, parents : Store
    name : str
        Split of the children's store.
    parents_name : str, optional
        Split of the parents' store; of the same name by default.

    Raises
    ------
    MissingSplit, UnknownName, LeakError
        A store has no split of that name, or one that is out of date.
    UsageError
        No trajectory of the first store was derived from one of the second.
    """
    ours, theirs = load_split(children, name), load_split(parents, parents_name or name)
    table = children.trajectories(["uid", "parent"])
    roots = family_roots(table["uid"].to_pylist(), table["parent"].to_pylist())
    known = parents.trajectories(["uid"])["uid"]
    place = {uid: row for row, uid in enumerate(known.to_pylist())}
    rows = np.array([row for row, root in enumerate(roots) if root in place], np.int64)
    if not len(rows):
        raise UsageError(
            f"no trajectory of {children.location} was derived from one of {parents.location}",
            "the store that the derived ones were made of",
            "Name the store that `tactiledata transfer` was given.",
        )
    own = partition_codes(partition_rows(ours, table["uid"]))[rows]
    origin = partition_codes(partition_rows(theirs, known))[[place[roots[row]] for row in rows]]
    bad = np.flatnonzero((own >= 0) & (origin >= 0) & (own != origin))
    cases = (
        f"{table['uid'][int(rows[at])].as_py()} in {PARTITIONS[own[at]]}, its root {roots[rows[at]]} in "
        f"{PARTITIONS[origin[at]]} of {parents.location}"
        for at in bad
    )
    return [
        *leak("derived-away-from-parent", "derived trajectories stand apart from what they come from", cases, len(bad)),
        *flagged_parent_findings(children, parents, ours),
    ]
