"""The command that an out-of-date split names is the one that brings it up to date."""

import re
import shlex

import numpy as np
import pytest
from split_cases import MemoryStore, frames, many, parts, trajectories

from tactiledata.contract.take import FrameFlag
from tactiledata.errors import LeakError, StoreError, UnknownName, UsageError
from tactiledata.splits.audit import audit
from tactiledata.splits.make import make_split
from tactiledata.splits.manifest import load_split

WORDS = {"--by": "by", "--hold-out": "hold_out", "--fractions": "fractions", "--force": "force", "--name": "name"}


def typed(line):
    """Arguments of `make_split` from a command line."""
    words = shlex.split(line)
    assert words[:2] == ["tactiledata", "split"]
    pairs = dict(zip(words[3::2], words[4::2], strict=True))
    seed = int(pairs.pop("--seed", 0))
    return {"seed": seed, **{WORDS[option]: text for option, text in pairs.items()}}


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"fractions": (1 / 3, 1 / 3, 1 / 3), "seed": -4},
        {"by": "trajectory,sensor,indenter", "hold_out": {"sensor": ["a b"], "indenter": ["star", "it's"]}},
        {"force": None, "hold_out": "none", "name": "other"},
        {"force": (0.1, 12.5)},
    ],
    ids=repr,
)
def test_the_command_that_is_named_brings_it_up_to_date(tmp_path, options):
    """Whatever options it was made with; and who has a part keeps it."""
    rows = many(60, sensors=["a b", "B", "C", "D", "E"], indenters=("ball", "star", "it's", "cross"))
    store = MemoryStore(tmp_path, trajectories(rows[:50]))
    make_split(store, **options)
    name = options.get("name", "default")
    before = parts(load_split(store, name).table)
    bigger = MemoryStore(tmp_path, trajectories(rows))
    with pytest.raises(LeakError) as refused:
        load_split(bigger, name)
    make_split(bigger, **typed(re.search("`(.*)`", str(refused.value))[1]))
    now = parts(load_split(bigger, name).table)
    assert len(now) == 60
    assert {uid: now[uid] for uid in before} == before


def test_the_audit_names_the_command_that_brings_it_up_to_date(tmp_path):
    """The store, the name of the split and its options stand in the finding and in the sentence for people."""
    rows = many(60)
    make_split(MemoryStore(tmp_path / "my store.zarr", trajectories(rows[:50])), seed=7, name="other")
    bigger = MemoryStore(tmp_path / "my store.zarr", trajectories(rows))
    report = audit(bigger, "other", images=False)
    [finding] = [one for one in report.findings if one.code == "split-out-of-date"]
    for said in (finding.message, report.lines()[0]):
        line = re.search("`(.*?)`", said)[1]
        assert shlex.split(line)[2] == str(tmp_path / "my store.zarr")
        assert typed(line) == {"seed": 7, "name": "other"}
    make_split(bigger, **typed(line))
    assert not audit(bigger, "other", images=False).findings


def test_other_options_are_refused_with_those_that_were_meant(tmp_path):
    """A split with other options is refused, and the message holds the options of the split that exists."""
    store = MemoryStore(tmp_path, trajectories(many(50)))
    make_split(store, seed=7)
    with pytest.raises(UsageError) as refused:
        make_split(store)
    assert typed(re.search("`(.*)`", str(refused.value))[1]) == {"name": "default", "seed": 7}


def test_a_slip_is_said_before_a_split_that_exists(tmp_path):
    """A name that the store does not hold is the error, and not the options of the split of that name."""
    store = MemoryStore(tmp_path, trajectories(many(50)))
    make_split(store)
    with pytest.raises(UnknownName, match="unknown sensor 'D9'"):
        make_split(store, hold_out="sensor=D9")


def test_options_that_differ_are_told_as_they_are_typed(tmp_path):
    """No list and no dictionary of Python stands in the message; options that are the same are left out."""
    store = MemoryStore(tmp_path, trajectories(many(50)))
    make_split(store)
    sensor = store.trajectories(["sensor"])["sensor"][0].as_py()
    with pytest.raises(UsageError) as refused:
        make_split(store, fractions=(0.5, 0.25, 0.25), hold_out=f"sensor={sensor}", force=None, with_flagged=True)
    said = refused.value.found
    for words in (
        "--fractions 0.8,0.1,0.1 there, --fractions 0.5,0.25,0.25 here",
        f"--hold-out auto there, --hold-out sensor={sensor} here",
        "--force 1.0..13.0 there, --force none here",
        "no --with-flagged there, --with-flagged here",
    ):
        assert words in said
    assert not set("[]{}") & set(said)
    assert "--seed" not in said


@pytest.mark.parametrize("force", [(1, 13), None])
def test_images_that_are_all_broken_are_not_blamed_on_the_force(tmp_path, force):
    """Forces lie within the bounds; there is no whole image."""
    table = trajectories(many(50))
    broken = np.full(3 * table.num_rows, int(FrameFlag.BROKEN))
    store = MemoryStore(tmp_path, table, frames(table, flags=broken))
    with pytest.raises(StoreError, match="has a whole image"):
        make_split(store, force=force)
