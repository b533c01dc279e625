"""Two stores, one of children of the other's trajectories: what stands apart is found, what stands together is not."""

import pytest
from copied_trees import copy_tree
from loaders.loader_stores import write_loader_store

from split_models.transfer.pixels import PIXEL_TRANSFERS
from split_models.transfer.transfer_store import transfer_store
from tactiledata.errors import UsageError
from tactiledata.splits.across import audit_across
from tactiledata.splits.make import make_split
from tactiledata.store.read.reader import Store
from tactiledata.store.read.targets import Target

SHARES = (0.5, 0.25, 0.25)


@pytest.fixture(scope="module")
def stores(tmp_path_factory):
    """A store of two sensors, and its children on a third, as folders."""
    folder = tmp_path_factory.mktemp("across")
    parents = write_loader_store(folder / "parents.zarr", n_sources=6)
    target = Target("T", parents.reference("D1").image, "made", model="gelsight_r15")
    transfer_store(parents, target, PIXEL_TRANSFERS["background_swap"], folder / "children.zarr")
    return folder


@pytest.fixture
def copied(stores, tmp_path):
    """Both, to be split."""
    copy_tree(stores, tmp_path / "both")
    return [Store.open(tmp_path / "both" / f"{name}.zarr") for name in ("children", "parents")]


@pytest.mark.slow
def test_the_same_draw_stands_together(copied):
    """Stores split alone with one seed and fractions have no child away from its parent."""
    for store in copied:
        make_split(store, fractions=SHARES, hold_out="none")
    assert audit_across(*copied) == []


def test_another_seed_parts_families(copied):
    """Drawn with another seed, families are parted; every one of them is counted."""
    for seed, store in enumerate(copied):
        make_split(store, fractions=SHARES, hold_out="none", seed=seed)
    (found,) = audit_across(*copied)
    assert (found.code, found.severity) == ("derived-away-from-parent", "damage")
    assert found.count > 1


def test_children_of_a_held_out_sensor_are_found(copied):
    """A sensor held out among the parents is not held out among the children, who bear another name: found."""
    children, parents = copied
    make_split(children, fractions=SHARES, hold_out="none")
    make_split(parents, fractions=SHARES, hold_out={"sensor": ["D2"]})
    (found,) = audit_across(children, parents)
    assert found.count == 9
    assert "test_unseen" in found.message


def test_strangers_are_refused(copied):
    """Two stores without a family in common cannot be compared."""
    children, parents = copied
    for store in copied:
        make_split(store, fractions=SHARES, hold_out="none")
    with pytest.raises(UsageError, match="was derived from one of"):
        audit_across(parents, children)
