"""How near the parts of a small split come to their shares, against counts by hand and the draw itself."""

import re

import numpy as np
import pyarrow as pa
import pytest
from split_cases import MemoryStore, many, trajectories

from tactiledata.splits.assign import draw, part_of
from tactiledata.splits.make import make_split
from tactiledata.splits.options import SHARES, SplitOptions
from tactiledata.splits.shares import astray_note, filling_seeds, group_sizes

NONE = SplitOptions.checked(hold_out="none")
THIRDS = SplitOptions.checked(hold_out="none", fractions=(0.6, 0.2, 0.2))


def shares_with(sizes, options, seed):
    """Shares of the parts, trajectory by trajectory."""
    part = {name: part_of(np.array([draw(name, seed)]), options.fractions)[0] for name in sizes}
    total = sum(sizes.values())
    return [sum(n for name, n in sizes.items() if part[name] == k) / total for k in range(3)]


def far(sizes, options, seed):
    """How far they are from what was asked, summed."""
    return sum(abs(a - b) for a, b in zip(shares_with(sizes, options, seed), options.fractions, strict=True))


def fixed_draw(monkeypatch, draws):
    """Let each seed draw what is given for it, whatever the group; others draw train alone."""
    monkeypatch.setattr("tactiledata.splits.shares.draw", lambda group, seed: draws.get(seed, {}).get(group, 0.0))


@pytest.mark.parametrize("n", [6, 10, 40])
def test_the_nearest_of_the_seeds_that_fill_every_part_are_named(n):
    """The three seeds that are named fill every part, and no other of the seeds 0 to 63 comes nearer to the shares."""
    sizes = {f"{k:016x}": 1 for k in range(n)}
    filling = [seed for seed in range(64) if min(shares_with(sizes, THIRDS, seed)) > 0]
    assert len(filling) > 3
    assert filling_seeds(sizes, THIRDS) == sorted(filling, key=lambda seed: (far(sizes, THIRDS, seed), seed))[:3]


def test_groups_count_by_their_trajectories(monkeypatch):
    """A group of six touches fills train; the seed that sends it to a part of two tenths is farther."""
    sizes = {"big": 6, "a": 2, "b": 2}
    one = {"big": 0.7, "a": 0.1, "b": 0.9}
    other = {"big": 0.1, "a": 0.7, "b": 0.9}
    fixed_draw(monkeypatch, {1: one, 2: other})
    assert filling_seeds(sizes, THIRDS) == [2, 1]


def test_seeds_are_looked_for_among_sixty_four_and_in_small_stores(monkeypatch):
    """Seeds 62 and 63 are found, 64 is not looked at; a group for each part is needed; beyond 1,000 groups none."""
    draws = {"a": 0.1, "b": 0.85, "c": 0.95}
    fixed_draw(monkeypatch, {62: draws, 63: draws, 64: draws})
    assert filling_seeds(dict.fromkeys("abc", 1), NONE) == [62, 63]
    assert filling_seeds({"a": 1}, NONE) == []
    monkeypatch.undo()
    assert len(filling_seeds({f"{k:016x}": 1 for k in range(1000)}, NONE)) == 3
    assert filling_seeds({f"{k:016x}": 1 for k in range(1001)}, NONE) == []


def test_a_part_without_a_share_need_not_be_filled(monkeypatch):
    """With no share for test, train and val are every part."""
    fixed_draw(monkeypatch, {5: {"a": 0.1, "b": 0.9}})
    assert filling_seeds({"a": 1, "b": 1}, SplitOptions.checked(hold_out="none", fractions=(0.8, 0.2, 0))) == [5]


def test_shares_far_from_what_was_asked_are_told_with_a_nearer_seed(monkeypatch):
    """Three touches of which each part has one: told in per cent; a seed that is nearer is named with what it gives."""
    even = {"a": 0.1, "b": 0.7, "c": 0.9, "d": 0.7, "e": 0.9}
    near = {"a": 0.1, "b": 0.1, "c": 0.1, "d": 0.7, "e": 0.9}
    sizes = dict.fromkeys("abcde", 1)
    fixed_draw(monkeypatch, {0: even, 9: near})
    assert astray_note([1, 2, 2], sizes, THIRDS, True) == (
        "the parts are drawn by chance, and 5 trajectories are few: train has 20% of them (asked: 60%), "
        "val has 40% of them (asked: 20%), test has 40% of them (asked: 20%); "
        "the same command with --seed 9 --replace gives train 60%, val 20%, test 20%"
    )
    # which units `auto` holds out goes by the seed, so that no other seed can be told
    assert astray_note([1, 2, 2], sizes, THIRDS, False).endswith("test has 40% of them (asked: 20%)")


def test_no_seed_is_named_that_is_no_nearer(monkeypatch):
    """Of three touches each part can only have one."""
    fixed_draw(monkeypatch, {seed: {"a": 0.1, "b": 0.7, "c": 0.9} for seed in (0, 3, 8)})
    note = astray_note([1, 1, 1], dict.fromkeys("abc", 1), THIRDS, True)
    assert note.endswith("test has 33% of them (asked: 20%)")


def test_shares_as_asked_are_not_told():
    """Within 0.05 of each share nothing is said, and beyond a thousand groups neither."""
    sizes = {f"{k}": 1 for k in range(100)}
    assert astray_note([80, 10, 10], sizes, NONE, True) == ""
    assert astray_note([84, 6, 10], sizes, NONE, True) == ""
    assert astray_note([86, 4, 10], sizes, NONE, True) != ""
    assert astray_note([1001, 0, 0], {f"{k}": 1 for k in range(1001)}, NONE, True) == ""


def test_sizes_are_of_the_rows_that_were_taken():
    """Groups of rows that count, with their number, by name."""
    table = pa.table({"group": ["b", "a", "b", "c"]})
    assert list(group_sizes(table, np.array([True, True, True, False])).items()) == [("a", 1), ("b", 2)]


def test_the_seed_that_a_split_names_gives_what_the_note_says(tmp_path):
    """The command that a note names is run: the parts come out with the shares that it told."""
    store = MemoryStore(tmp_path, trajectories(many(10)))
    for seed in range(30):
        report = make_split(store, seed=seed, hold_out="none", replace=True)
        told = [re.search(r"--seed (\d+) --replace gives (.*)", note) for note in report.notes]
        if any(told):
            seed, parts = next(match for match in told if match).groups()
            counts = make_split(store, seed=int(seed), hold_out="none", replace=True).counts
            assert parts == ", ".join(f"{part} {counts[part].trajectories / 10:.0%}" for part in SHARES)
            return
    pytest.fail("no seed of 30 led a split of 10 trajectories astray")
