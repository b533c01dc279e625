"""The order of items: seeded, parted between ranks, resumable."""

import itertools
import json

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from tactiledata.errors import UsageError
from tactiledata.loaders.order import Order

LENGTHS = st.integers(0, 60)
BATCHES = st.one_of(st.none(), st.integers(1, 9))


def assume_a_step(length, batch_size, world_size, drop_last):
    """Epochs without any step are refused; see `test_epochs_without_a_step_are_refused`."""
    assume(not drop_last or length == 0 or length >= (batch_size or 1) * world_size)


def flat(steps):
    return [number for step in steps for number in (step if isinstance(step, list) else [step])]


@given(LENGTHS, BATCHES, st.integers(1, 4), st.booleans(), st.booleans(), st.integers(0, 5))
@settings(deadline=None)
def test_ranks_part_the_items_without_overlap(length, batch_size, world_size, drop_last, shuffle, seed):
    """Ranks together visit no item twice, and every item where no tail is dropped."""
    assume_a_step(length, batch_size, world_size, drop_last)
    orders = [
        Order(
            length,
            seed=seed,
            shuffle=shuffle,
            batch_size=batch_size,
            rank=rank,
            world_size=world_size,
            drop_last=drop_last,
        )
        for rank in range(world_size)
    ]
    expected_steps = [len(order) for order in orders]
    walks = [list(order) for order in orders]
    assert [len(walk) for walk in walks] == expected_steps
    visited = list(itertools.chain(*(flat(walk) for walk in walks)))
    assert len(set(visited)) == len(visited)
    if drop_last:
        assert len(set(expected_steps)) == 1
        assert length - len(visited) < orders[0].stride
        assert all(len(step) == batch_size for walk in walks for step in walk if batch_size)
    else:
        assert sorted(visited) == list(range(length))


@given(LENGTHS, BATCHES, st.integers(1, 3), st.booleans(), st.integers(0, 40), st.integers(0, 5))
@settings(deadline=None)
def test_interrupted_and_resumed_equals_uninterrupted(length, batch_size, world_size, drop_last, stop, seed):
    """Three epochs, cut anywhere and resumed from a JSON state in a new object, give the same steps."""
    assume_a_step(length, batch_size, world_size, drop_last)
    for rank in range(world_size):

        def order(rank=rank):
            return Order(
                length, seed=seed, batch_size=batch_size, rank=rank, world_size=world_size, drop_last=drop_last
            )

        whole, walker = order(), order()
        uninterrupted = [step for _ in range(3) for step in whole]
        first = list(itertools.islice((step for _ in range(3) for step in walker), stop))
        state = json.loads(json.dumps(walker.state_dict()))
        resumed = order()
        resumed.load_state_dict(state)
        rest = [step for _ in range(3 - state["epoch"]) for step in resumed]
        assert first + rest == uninterrupted


@given(st.integers(1, 60), st.integers(1, 4), st.integers(1, 4), st.integers(0, 20))
@settings(deadline=None)
def test_resuming_with_other_ranks_still_visits_each_item_once(length, before, after, stop):
    """An epoch begun by some ranks and ended by another number of ranks visits every item once."""
    begun = [Order(length, seed=1, rank=rank, world_size=before, drop_last=False) for rank in range(before)]
    visited = [number for order in begun for number in itertools.islice(order, stop)]
    if len(visited) < min(length, stop * before):
        return
    state = begun[0].state_dict()
    if state["epoch"]:
        assert sorted(visited) == list(range(length))
        return
    ended = [Order(length, seed=1, rank=rank, world_size=after, drop_last=False) for rank in range(after)]
    for order in ended:
        order.load_state_dict(state)
        visited += list(order)
    assert sorted(visited) == list(range(length))


def test_seeds_and_epochs_give_different_orders():
    """Another seed or another epoch is another permutation; the same are the same."""
    first, again, other = Order(100, seed=1), Order(100, seed=1), Order(100, seed=2)
    epoch_0, epoch_1 = list(first), list(first)
    assert epoch_0 == list(again)
    assert epoch_0 != epoch_1
    assert epoch_0 != list(other)


def test_several_ranks_get_equal_steps_by_default():
    """With several ranks the tail is dropped unless asked otherwise; with one rank it is kept."""
    assert [len(list(Order(10, batch_size=4, rank=rank, world_size=2))) for rank in range(2)] == [1, 1]
    assert len(list(Order(10, batch_size=4))) == 3


@pytest.mark.parametrize("change", [{"seed": 3}, {"length": 11}, {"shuffle": False}, {"fingerprint": "b"}])
def test_a_foreign_state_is_refused(change):
    """A state of other items or another seed is refused and changes nothing."""
    order = Order(10, seed=1, fingerprint="a")
    with pytest.raises(UsageError, match="does not belong"):
        order.load_state_dict({**order.state_dict(), **change})
    assert (order.epoch, order.consumed) == (0, 0)
    with pytest.raises(UsageError, match="does not belong"):
        order.load_state_dict({})


@pytest.mark.parametrize("wrong", [{"batch_size": 0}, {"rank": 2, "world_size": 2}, {"world_size": 0}, {"seed": -1}])
def test_senseless_orders_are_refused(wrong):
    """Batches of nothing, ranks beyond the world and negative seeds are usage errors."""
    with pytest.raises(UsageError):
        Order(10, **wrong)


@pytest.mark.parametrize(("world_size", "batch_size"), [(8, None), (2, 4), (1, 8)])
def test_epochs_without_a_step_are_refused(world_size, batch_size):
    """Seven items that cannot fill one step are an error, not an epoch that silently does nothing."""
    options = {"world_size": world_size, "batch_size": batch_size}
    with pytest.raises(UsageError, match="every epoch is empty"):
        Order(7, drop_last=True, **options)
    kept = [list(Order(7, rank=rank, drop_last=False, **options)) for rank in range(world_size)]
    numbers = [number for steps in kept for step in steps for number in (step if batch_size else [step])]
    assert sorted(numbers) == list(range(7))
    assert Order(8, drop_last=True, **options)


@pytest.mark.parametrize(
    "change", [{"consumed": 6}, {"consumed": True}, {"consumed": 1.0}, {"consumed": "x"}, {"epoch": -1}]
)
def test_damaged_positions_are_refused(change):
    """A place that the order does not have; its last place is fine."""
    order = Order(5)
    with pytest.raises(UsageError, match="damaged"):
        order.load_state_dict({**order.state_dict(), **change})
    order.load_state_dict({**order.state_dict(), "consumed": 5})
    with pytest.raises(UsageError, match="state_dict"):
        order.load_state_dict(None)


@pytest.mark.parametrize(
    "options", [{"batch_size": 2.5}, {"batch_size": "4"}, {"seed": 1.5}, {"seed": True}, {"rank": 0.0}]
)
def test_numbers_that_are_none_are_refused(options):
    """Counts are whole numbers."""
    with pytest.raises(UsageError):
        Order(5, **options)
