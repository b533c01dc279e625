"""The audit's table checks between every two parts that matter, in tables small enough to read."""

import numpy as np
import pytest
from split_cases import trajectories

from tactiledata.splits.leaks import held_out_elsewhere, parted_families
from tactiledata.splits.options import PARTITIONS


def codes(*parts):
    return np.array([PARTITIONS.index(part) if part else -1 for part in parts])


@pytest.mark.parametrize("child", PARTITIONS)
@pytest.mark.parametrize("parent", PARTITIONS)
def test_child_and_parent_in_any_two_parts(child, parent):
    """A child apart from its parent is one leak, in train of a parent in test too; beside its parent it is none."""
    table = trajectories([{"uid": "p"}, {"uid": "c", "parent": "p"}, {"uid": "other"}])
    found = parted_families(table, codes(parent, child, "val"))
    assert [finding.count for finding in found] == ([1] if child != parent else [])
    if found:
        named = " and ".join(part for part in PARTITIONS if part in (child, parent))
        assert found[0].message.endswith(f"family of p in {named}")


def test_a_child_of_a_parent_in_no_part_is_no_leak():
    """What no part takes cannot leak."""
    table = trajectories([{"uid": "p"}, {"uid": "c", "parent": "p"}])
    assert parted_families(table, codes(None, "train")) == []


@pytest.mark.parametrize(("part", "is_leak"), [("train", 1), ("val", 1), ("test", 1), ("test_unseen", 0), (None, 0)])
@pytest.mark.parametrize("kind", ["sensor", "indenter"])
def test_held_out_units_in_any_part(part, is_leak, kind):
    """A held-out unit in train, val or test is a leak that names the part; unseen or in no part it is none."""
    table = trajectories([{}, {kind: "H"}])
    found = held_out_elsewhere(table, codes("train", part), {kind: ("H",)})
    assert [finding.code for finding in found] == [f"held-out-{kind}-seen"] * is_leak
    if is_leak:
        assert found[0].count == 1
        assert found[0].message.endswith(f"'t1' of {kind} H in {part}")
