"""Flagged trajectories: who is left out of a split, what an audit finds, and what loaders say."""

import json

import numpy as np
import pytest
from command import run_command
from copied_trees import copy_tree
from hypothesis import given
from hypothesis import strategies as st
from split_cases import trajectories

from tactiledata.contract.sealed import sealed_json
from tactiledata.errors import SchemaError, UnknownName, UsageError
from tactiledata.ingest.sources.overview import page
from tactiledata.loaders.numpy import TactileArrays
from tactiledata.loaders.selection import FlaggedTrajectoriesWarning
from tactiledata.splits.assign import assign
from tactiledata.splits.audit import audit
from tactiledata.splits.leaks import unlike_drawn
from tactiledata.splits.make import make_split
from tactiledata.splits.manifest import load_split, read_split_document
from tactiledata.splits.options import EXCLUDED, SplitOptions
from tactiledata.store.change.flag import flag_trajectories, remove_flags
from tactiledata.store.check.check import check
from tactiledata.store.layout.places import FLAGS
from tactiledata.store.read.flags import flag_origins, flagged_trajectories, stored_flags
from tactiledata.store.read.named_trajectories import full_names
from tactiledata.store.read.reader import Store

NONE = SplitOptions.checked(hold_out="none")


@pytest.fixture
def place(tiny_store, tmp_path):
    """A copy of the tiny store, with its split."""
    copy_tree(tiny_store, tmp_path / "ds.zarr")
    return tmp_path / "ds.zarr"


def parts(place, name="default"):
    table = load_split(Store.open(place), name).table
    return dict(zip(table["uid"].to_pylist(), table["partition"].to_pylist(), strict=True))


def codes(place):
    return [finding.code for finding in audit(Store.open(place), images=False).findings]


@given(st.sets(st.integers(0, 29)), st.integers(0, 1000))
def test_a_flag_moves_nobody_else(flagged, seed):
    """Flagged trajectories are in no part; every other one is where it is without flags, whatever is flagged."""
    table = trajectories([{"source": number} for number in range(30)])
    options = SplitOptions.checked(hold_out="none", seed=seed)
    uids = table["uid"].to_pylist()
    before = assign(table, options, {})["partition"].to_pylist()
    try:
        after = assign(table, options, {}, flagged={uids[row] for row in flagged})["partition"].to_pylist()
    except UsageError:
        assert not {before[row] for row in range(30) if row not in flagged} - {EXCLUDED}
        return
    assert after == [EXCLUDED if row in flagged else before[row] for row in range(30)]


@given(st.lists(st.tuples(st.integers(0, 39), st.booleans()), min_size=40, max_size=40), st.sets(st.integers(-5, 39)))
def test_what_is_derived_from_flagged_is_flagged(links, flagged):
    """A trajectory is flagged where it, or any ancestor, carries a flag; its origin is the nearest; circles end."""
    uids = [f"u{number}" for number in range(40)]
    parents = [f"u{to}" if is_child else "" for to, is_child in links]
    parents[0] = "u-1"  # of another store
    carries = {f"u{number}" for number in flagged}
    found = flag_origins(uids, parents, carries)
    parent_of = dict(zip(uids, parents, strict=True))
    for uid in uids:
        chain, at = [], uid
        while at and at not in chain:
            chain.append(at)
            at = parent_of.get(at, "")
        wanted = next((one for one in chain if one in carries), None)
        assert found.get(uid) == wanted


def test_drawn_without_flagged_is_as_drawn():
    """A table drawn without flagged trajectories is as its document says; without the document's list it is not."""
    table = trajectories([{"source": number} for number in range(12)])
    uid = table["uid"][0].as_py()
    drawn = assign(table, NONE, {}, flagged=[uid])
    says = np.asarray(drawn["partition"].to_pylist(), object)
    assert unlike_drawn(table, drawn, says, NONE, {}, [uid]) == []
    assert [finding.code for finding in unlike_drawn(table, drawn, says, NONE, {})] == ["not-as-drawn"]


def test_flag_split_audit(place):
    """Flagged after the split: the audit finds it and names the command; drawn again it is out; unflagged it is back
    where it was, and nobody else ever moved.
    """
    before = parts(place)
    uid = next(iter(before))
    assert "flagged-in-split" not in codes(place)
    flag_trajectories(place, [uid], "slipped")
    report = audit(Store.open(place), images=False)
    (found,) = [finding for finding in report.findings if finding.code == "flagged-in-split"]
    assert (found.severity, found.count) == ("damage", 1)
    assert "slipped" in found.message
    assert "it holds flagged trajectories" in report.lines()[0]
    assert "0 kinds" not in report.lines()[0]
    assert parts(place) == before  # a flag alone changes no split
    drawn = make_split(Store.open(place), hold_out="none")
    assert any("1 flagged trajectory" in note and "slipped" in note for note in drawn.notes)
    assert any("left its part" in note for note in drawn.notes)
    assert not any("what it was derived from" in note for note in drawn.notes)
    assert parts(place) == {**before, uid: EXCLUDED}
    assert read_split_document(Store.open(place), "default")["flagged"] == [uid]
    assert not set(codes(place)) & {"flagged-in-split", "not-as-drawn"}
    remove_flags(place, [uid])
    assert "flag-taken-off" in codes(place)
    back = make_split(Store.open(place), hold_out="none")
    assert any("in a part again" in note for note in back.notes)
    assert parts(place) == before
    assert "flagged" not in read_split_document(Store.open(place), "default")


def test_with_flagged_takes_them(place):
    """Asked for, flagged trajectories are taken; notes and audit say it, and the command that repeats it does, too."""
    before = parts(place)
    flag_trajectories(place, [next(iter(before))], "slipped")
    report = make_split(Store.open(place), hold_out="none", with_flagged=True, replace=True)
    assert parts(place) == before
    assert any("as was asked for" in note for note in report.notes)
    findings = {finding.code: finding.severity for finding in audit(Store.open(place), images=False).findings}
    assert findings["flagged-taken"] == "info"
    with pytest.raises(UsageError, match="--with-flagged"):
        make_split(Store.open(place), hold_out="none")


def test_nobody_left_is_refused(place):
    """With all trajectories flagged no split is drawn, and the split that was there stays."""
    before = parts(place)
    flag_trajectories(place, list(before), "all bad")
    with pytest.raises(UsageError, match="flagged"):
        make_split(Store.open(place), hold_out="none")
    assert parts(place) == before


def test_loaders_say_it(place):
    """A part that holds a flagged trajectory is loaded with a warning that names it; drawn again, without one."""
    uid = next(uid for uid, part in parts(place).items() if part == "train")
    whole = TactileArrays(place, split="default/train", streams=["contact_wrench"])
    flag_trajectories(place, [uid], "slipped")
    with pytest.warns(FlaggedTrajectoriesWarning, match="slipped"):
        warned = TactileArrays(place, split="default/train", streams=["contact_wrench"])
    assert len(warned) == len(whole)
    assert "flagged since" in str(warned.report)
    make_split(Store.open(place), hold_out="none")
    assert len(TactileArrays(place, split="default/train", streams=["contact_wrench"])) < len(whole)


def test_names_that_are_taken(place):
    """A trajectory is named by uid, name or recording and name; unknown ones are refused; all or none is flagged."""
    store = Store.open(place)
    uid, full = store.trajectories(["uid"])["uid"][1].as_py(), full_names(store)[1]
    for name in (uid, full, full.rpartition("/")[2]):
        assert flag_trajectories(place, [name], "bad") == [full]
        assert flag_trajectories(place, [name], "bad") == []  # the same again is no change
        assert remove_flags(place, [name]) == [full]
    with pytest.raises(UnknownName):
        flag_trajectories(place, [uid, "nobody"], "bad")
    assert stored_flags(store) == {}
    for reason in ("", "  \n", "x" * 501):
        with pytest.raises(UsageError):
            flag_trajectories(place, [uid], reason)
    with pytest.raises(UsageError, match=f"{full.rpartition('/')[2]} is not flagged; expected one that is; none of"):
        remove_flags(place, [full.rpartition("/")[2]])


@pytest.mark.slow
def test_a_damaged_file_of_flags_is_refused(place):
    """Each changed byte of the file is found by `check` and refused by whatever reads flags; a sound file is not."""
    uid = next(iter(parts(place)))
    flag_trajectories(place, [uid], "slipped")
    assert "store-flags" not in [finding.code for finding in check(place, images=False)]
    sound = (place / FLAGS).read_bytes()
    for at in range(0, len(sound), 37):
        damaged = bytearray(sound)
        damaged[at] ^= 1
        (place / FLAGS).write_bytes(damaged)
        with pytest.raises(SchemaError):
            flagged_trajectories(Store.open(place))
    assert "store-flags" in [finding.code for finding in check(place, images=False)]
    with pytest.raises(SchemaError):
        flag_trajectories(place, [uid], "again")
    # a file with its seal that says something else is refused, too
    (place / FLAGS).write_bytes(sealed_json({"format": "tactiledata-flags/1", "flags": {uid: {"reason": "x"}}}))
    with pytest.raises(SchemaError):
        flagged_trajectories(Store.open(place))


def test_command(place, capsys, monkeypatch):
    """The command flags, lists and takes off; `info` and its JSON show it; wrong usage exits with 2."""
    monkeypatch.chdir(place.parent)
    name = full_names(Store.open(place))[0]
    assert run_command(capsys, "flag", "--list")[1].startswith("ds.zarr: 0 flagged")
    code, printed, _ = run_command(capsys, "flag", name, "--reason", "slipped")
    assert code == 0
    assert f"flagged: {name}" in printed
    assert "draw it again: tactiledata split ds.zarr --name default --hold-out none" in printed
    assert f"  {name}: slipped" in run_command(capsys, "info", "ds.zarr")[1]
    (listed,) = json.loads(run_command(capsys, "info", "ds.zarr", "--json")[1])["flagged"]
    assert (listed["name"], listed["reason"]) == (name, "slipped")
    assert run_command(capsys, "audit", "--no-images")[0] == 1
    assert "slipped" in run_command(capsys, "flag", "ds.zarr", "--list")[1]
    for bad in (["ds.zarr"], [name], [name, "--list"], [name, "--remove", "--reason", "x"], ["--reason", "x"]):
        assert run_command(capsys, "flag", *bad)[0] == 2
    assert run_command(capsys, "flag", name, "--remove")[0] == 0
    assert run_command(capsys, "audit", "--no-images")[0] == 0


def test_the_report_lists_them(place):
    """The page on a store names flagged trajectories with their reasons, as text and not as markup, and the command for
    a split that holds one; a page on a store without flags has no such section.
    """
    assert "Flagged trajectories" not in page(Store.open(place), None, "default")
    flag_trajectories(place, [next(iter(parts(place)))], "slipped <script>alert(1)</script>")
    html = page(Store.open(place), None, "default")
    assert "Flagged trajectories" in html
    assert "slipped &lt;script&gt;" in html
    assert "<script>alert(1)" not in html
    assert "Flagged since it was drawn" in html
