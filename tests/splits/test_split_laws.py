"""Laws of the draw: who stands where depends on the trajectory alone."""

import numpy as np
import pytest
from few_examples import few
from hypothesis import given
from hypothesis import strategies as st
from split_cases import frames, many, parts, trajectories

from tactiledata.errors import StoreError, UnknownName, UsageError
from tactiledata.splits.assign import assign, choose_held_out, describe_held, draw, part_of
from tactiledata.splits.groups import family_roots, overlapping_touches
from tactiledata.splits.make import split_tables
from tactiledata.splits.options import EXCLUDED, PARTITIONS, SplitOptions
from tactiledata.splits.twins import ABSOLUTE_NS

FEW = few(40)
NONE = SplitOptions.checked(hold_out="none")


@st.composite
def stores(draw_from, orphans=False):
    """Trajectories of a few sources, some derived, some overlapping, some of clocks that tell absolute time."""
    n = draw_from(st.integers(2, 40))
    clock = draw_from(st.sampled_from([0, ABSOLUTE_NS]))
    rows = []
    for number in range(n):
        row = {
            "source": draw_from(st.integers(0, 3)),
            "sensor": draw_from(st.sampled_from(["A", "B", "C", "D", ""])),
            "indenter": draw_from(st.sampled_from(["ball", "star", "edge", ""])),
            "start_ns": clock + draw_from(st.integers(0, 50)) * 1000,
        }
        row["end_ns"] = row["start_ns"] + draw_from(st.sampled_from([0, 500, 1000, 3000]))
        above = [f"{k:016x}" for k in range(number)] + (["f" * 16] if orphans else [])
        if above and draw_from(st.booleans()):
            row["parent"] = draw_from(st.sampled_from(above))
        rows.append(row)
    return rows


held = st.sampled_from([{}, {"sensor": ("A",)}, {"indenter": ("star",)}, {"sensor": ("B", "C"), "indenter": ("ball",)}])


def assigned(rows, held_out, options=NONE):
    try:
        return assign(trajectories(rows), options, held_out)
    except UsageError:
        return None  # everybody is held out: nothing to split


@FEW
@given(stores(orphans=True), held)
def test_every_trajectory_is_in_one_part_or_none(rows, held_out):
    """Each trajectory has exactly one known partition."""
    table = assigned(rows, held_out)
    if table is not None:
        assert table["uid"].to_pylist() == trajectories(rows)["uid"].to_pylist()
        assert set(table["partition"].to_pylist()) <= {*PARTITIONS, EXCLUDED}


@pytest.mark.slow
@FEW
@given(stores(orphans=True), held, st.randoms(use_true_random=False))
def test_order_moves_nobody(rows, held_out, random):
    """Rows in another order get the same partitions."""
    table = assigned(rows, held_out)
    if table is None:
        return
    mixed = trajectories(rows).to_pylist()
    random.shuffle(mixed)
    again = assign(trajectories(mixed), NONE, held_out)
    assert parts(again) == parts(table)


@FEW
@given(stores(), stores(), held)
def test_growth_moves_nobody(rows, others, held_out):
    """More sources, with derived trajectories of old ones among them, leave everyone where they were."""
    before = assigned(rows, held_out)
    if before is None:
        return
    grown = trajectories(rows).to_pylist()
    for number, row in enumerate(trajectories(others).to_pylist()):
        # parents by number: half of the new ones come from old trajectories
        old_parent = number % 2 and int(row["parent"] or "0", 16) < len(rows) and row["parent"]
        uid, parent = f"b{row['uid'][1:]}", row["parent"] and f"b{row['parent'][1:]}"
        grown.append({**row, "uid": uid, "source": row["source"] + 10, "parent": old_parent or parent})
    after = parts(assign(trajectories(grown), NONE, held_out))
    assert {uid: after[uid] for uid in parts(before)} == parts(before)


@FEW
@given(stores(orphans=True), held)
def test_children_stand_with_their_parents_or_nowhere(rows, held_out):
    """A derived trajectory is in its root's partition, or in none."""
    table = assigned(rows, held_out)
    if table is None:
        return
    where = parts(table)
    for row in table.to_pylist():
        if row["root"] in where:
            assert row["partition"] in (where[row["root"]], EXCLUDED)


@FEW
@given(stores(orphans=True), held)
def test_held_out_units_are_seen_nowhere(rows, held_out):
    """Train, val and test hold no trajectory with a held-out unit."""
    table = assigned(rows, held_out)
    if table is None:
        return
    for row in table.to_pylist():
        for kind, names in held_out.items():
            if row[kind] in names:
                assert row["partition"] in ("test_unseen", EXCLUDED)
                assert row[f"unseen_{kind}"]


@FEW
@given(stores(orphans=True), held)
def test_overlapping_touches_stand_together(rows, held_out):
    """Recorded trajectories of one sensor that overlap in time share a partition, in one source and, by absolute
    times, in several; only those of a later source may be in none instead. Of the first source, only what a held-out
    unit touches may be in none: others may have learned from its moment.
    """
    table = assigned(rows, held_out)
    if table is None:
        return
    where = parts(table)
    recorded = [row for row in trajectories(rows).to_pylist() if not row["parent"]]
    for one in recorded:
        for other in recorded:
            is_shared = one["sensor"] == other["sensor"] != "" and one["start_ns"] >= ABSOLUTE_NS
            same = one["source"] == other["source"] and one["sensor"] == other["sensor"]
            if (same or is_shared) and max(one["start_ns"], other["start_ns"]) < min(one["end_ns"], other["end_ns"]):
                found = {where[one["uid"]], where[other["uid"]]}
                assert len(found) == 1 or (one["start_ns"] >= ABSOLUTE_NS and len(found - {EXCLUDED}) == 1)
    first = min((row["source"] for row in recorded), default=0)
    is_unseen = {row["uid"]: any(row[f"unseen_{kind}"] for kind in held_out) for row in table.to_pylist()}
    of_first = [row["uid"] for row in recorded if row["source"] == first]
    assert all(where[uid] != EXCLUDED or is_unseen[uid] for uid in of_first)


@FEW
@given(st.lists(st.tuples(st.integers(0, 2), st.integers(0, 20), st.integers(0, 6)), max_size=30))
def test_overlaps_agree_with_their_slow_twin(spans):
    """The sweep finds the same connected intervals as comparing all pairs."""
    place, start, length = (
        (np.array(column, np.int64) for column in zip(*spans, strict=True)) if spans else [np.empty(0, np.int64)] * 3
    )
    end = start + length
    group = list(range(len(spans)))
    for _ in spans:
        for i in range(len(spans)):
            for j in range(len(spans)):
                if place[i] == place[j] and max(start[i], start[j]) < min(end[i], end[j]):
                    group[i] = group[j] = min(group[i], group[j])
    leader = overlapping_touches(place, start, end)
    assert [[a == b for a in leader] for b in leader] == [[a == b for a in group] for b in group]


@few(20)
@given(st.integers(0, 2**63), st.tuples(st.floats(0, 1), st.floats(0, 1)).filter(lambda pair: sum(pair) <= 1))
def test_fractions_converge(seed, pair):
    """Realised shares of 4000 draws are within five standard deviations of the fractions."""
    fractions = (*pair, 1 - sum(pair))
    draws = np.array([draw(f"{number:016x}", seed) for number in range(4000)])
    share = np.bincount(part_of(draws, fractions), minlength=3) / 4000
    for found, wanted in zip(share, fractions, strict=True):
        assert abs(found - wanted) <= 5 * np.sqrt(max(wanted * (1 - wanted), 1e-4) / 4000)
        assert found == 0 or wanted > 0


def test_each_stratum_gets_the_fractions():
    """Every sensor and indenter has near 80/10/10 of its own trajectories."""
    options = SplitOptions.checked(by="trajectory,sensor,indenter", hold_out="none")
    table = trajectories(many(10_000))
    report, _ = split_tables("x", table, frames(table, 1), options)
    assert len(report.strata) == 25
    for stratum in report.strata:
        total = sum(count.trajectories for count in stratum.counts.values())
        assert abs(stratum.counts["train"].trajectories / total - 0.8) < 5 * np.sqrt(0.16 / total)


def test_draws_are_for_ever():
    """Golden values: changing the draw would move everybody's data. Generator: draw() of the first version."""
    assert [round(draw(uid, seed), 6) for uid, seed in (("00f1", 0), ("00f1", 1), ("", 0))] == [
        0.823504,
        0.080056,
        0.108594,
    ]


def test_seeds_and_purposes_are_independent():
    """Other seeds give other draws, and being held out says nothing of the part."""
    uids = [f"{number:x}" for number in range(2000)]
    one, other = (np.array([draw(uid, seed) for uid in uids]) for seed in (0, 1))
    third = np.array([draw(uid, 0, "hold-out") for uid in uids])
    assert abs(np.corrcoef(one, other)[0, 1]) < 0.1
    assert abs(np.corrcoef(one, third)[0, 1]) < 0.1


def test_changing_fractions_moves_only_the_border():
    """From 80/10/10 to 70/15/15 nobody moves into train."""
    rows = trajectories(many())
    wide, narrow = (
        parts(assign(rows, SplitOptions.checked(hold_out="none", fractions=f), {}))
        for f in ((0.8, 0.1, 0.1), (0.7, 0.15, 0.15))
    )
    assert all(wide[uid] == "train" for uid, part in narrow.items() if part == "train")


def test_orphans_fall_where_their_parents_do():
    """A store of derived trajectories alone is split as the store of their parents."""
    rows = many(200)
    derived = [{**row, "uid": f"d{k:015x}", "parent": f"{k:016x}", "sensor": "Z"} for k, row in enumerate(rows)]
    here, there = parts(assign(trajectories(rows), NONE, {})), parts(assign(trajectories(derived), NONE, {}))
    assert all(there[f"d{k:015x}"] == here[f"{k:016x}"] for k in range(200))


def test_transfer_to_a_held_out_sensor_is_in_no_part():
    """A train touch redrawn in the style of a held-out sensor is neither train nor unseen."""
    rows = [*many(50, "AB"), {"uid": "e" * 16, "parent": f"{0:016x}", "sensor": "C", "source": 99}]
    assert parts(assign(trajectories(rows), NONE, {"sensor": ("C",)}))["e" * 16] == EXCLUDED


def test_auto_holds_out_a_fifth_of_enough_units():
    """Five sensors: one is held out; thirteen indenters: three; three sensors: none, and that is said."""
    options = SplitOptions.checked(by="trajectory,sensor,indenter")
    table = trajectories(many(300, indenters=tuple(f"i{k}" for k in range(13))))
    found, notes = choose_held_out(table, options)
    assert (len(found["sensor"]), len(found["indenter"]), notes) == (1, 3, [])
    found, notes = choose_held_out(trajectories(many(300, "ABC")), SplitOptions.checked())
    assert found == {}
    assert "3 of them (A, B, C)" in notes[0]


def test_families_end_at_the_first_recorded():
    """Chains are followed, unknown parents end them, circles are refused."""
    assert family_roots(["c", "b", "a"], ["b", "a", ""]) == ["a", "a", "a"]
    assert family_roots(["c", "b"], ["b", "gone"]) == ["gone", "gone"]
    with pytest.raises(StoreError, match="derived from itself"):
        family_roots(["a", "b"], ["b", "a"])


def test_unknown_units_are_refused_with_near_names():
    """A misspelt sensor names the near ones."""
    options = SplitOptions.checked(hold_out="sensor=D2054")
    with pytest.raises(UnknownName, match="D20542"):
        choose_held_out(trajectories(many(10, ["D20542", "X1"])), options)


@pytest.mark.parametrize(
    ("held_out", "words"),
    [
        ({}, "nobody"),
        ({"sensor": ()}, "nobody"),
        ({"sensor": ("A", "B"), "indenter": ()}, "sensor A, B"),
        ({"sensor": ("A",), "indenter": ("star",)}, "sensor A; indenter star"),
    ],
)
def test_held_out_units_in_words(held_out, words):
    """Kinds with their names; where there is no name, nobody."""
    assert describe_held(held_out) == words
