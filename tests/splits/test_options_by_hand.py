"""Bounds and defaults of a split's options, units that are held out, and shares of the draw."""

import numpy as np
import pyarrow as pa
import pytest
from split_cases import MemoryStore, many, trajectories

from tactiledata.errors import UnknownName, UsageError
from tactiledata.splits.assign import assign, choose_held_out, part_of
from tactiledata.splits.make import make_split
from tactiledata.splits.manifest import Split, coverage_problem, load_split, part_rows
from tactiledata.splits.options import (
    SplitOptions,
    check_name,
    read_by,
    read_force,
    read_fractions,
    read_hold_out,
)

NONE = SplitOptions.checked(hold_out="none")
USUAL = {
    "by": ["trajectory", "sensor"], "hold_out": "auto", "fractions": [0.8, 0.1, 0.1], "force": [1.0, 13.0], "seed": 0,
}  # fmt: skip


def test_options_by_default(tmp_path):
    """The defaults are by sensor, some held out, 80/10/10, 1 to 13 N and seed 0, as a record and in a split."""
    assert SplitOptions().document() == SplitOptions.checked().document() == USUAL
    store = MemoryStore(tmp_path, trajectories(many(20)))
    make_split(store)
    assert load_split(store, "default").document["options"] == USUAL


@pytest.mark.parametrize("off", [9e-7, -9e-7])
def test_fractions_may_be_off_by_a_millionth(off):
    """Typed decimals are off by less than 1e-6; by more they are refused."""
    assert read_fractions((0.8, 0.1, 0.1 + off))[2] == 0.1 + off
    with pytest.raises(UsageError, match=r"fractions are .* \(sum 1|fractions are .* \(sum 0\.99"):
        read_fractions((0.8, 0.1, 0.1 + 1.2 * off))


@pytest.mark.parametrize("shares", [(1, 0, 0), (0, 0, 1), (0.5, 0.5, 0)])
def test_shares_of_nothing_are_allowed(shares):
    """A share of 0 is one, less is none."""
    assert read_fractions(shares) == shares
    with pytest.raises(UsageError, match="none negative"):
        read_fractions((1.1, -0.1, 0.0))


@pytest.mark.parametrize(("count", "words"), [(1, r"\(1 numbers\)"), (2, r"\(2 numbers\)"), (4, r"\(4 numbers\)")])
def test_three_shares_are_needed(count, words):
    """One, two and four are refused with their number, even where they sum to 1."""
    with pytest.raises(UsageError, match=words):
        read_fractions([1 / count] * count)


def test_forces_from_zero_up():
    """0 N is a bound; less, equal bounds and bounds that are no numbers are refused."""
    assert read_force((0, 1e-9)) == (0.0, 1e-9)
    assert read_force("0.5..0.75") == (0.5, 0.75)
    assert read_force(None) is None
    for wrong in ((-0.1, 1), (1, 1), (2, 1), (np.nan, 1), (0, np.inf), (1,), (1, 2, 3), "1", "a..b", 5):
        with pytest.raises(UsageError, match="force is"):
            read_force(wrong)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("sensor, trajectory", ("trajectory", "sensor")),
        ("indenter,trajectory,sensor,sensor", ("trajectory", "sensor", "indenter")),
        (["trajectory"], ("trajectory",)),
        (" trajectory ,,indenter", ("trajectory", "indenter")),
    ],
)
def test_what_a_split_goes_by_has_an_order(text, words):
    """Trajectory, sensor, indenter, each once, however they are typed."""
    assert read_by(text) == words
    assert SplitOptions.checked(by=text).strata == words[1:]


@pytest.mark.parametrize("word", ["frame", "image", "rows", "time", "frames", "images", "row"])
def test_frames_beside_trajectories_leak_too(word):
    """A split by trajectory and frame is one by frame."""
    with pytest.raises(UsageError, match=f"by trajectory,{word} would tear"):
        read_by(f"trajectory,{word}")


def test_a_misspelt_word_is_no_leak():
    """It is said to be unknown, with the nearest word; a known one without trajectories would tear them."""
    with pytest.raises(UnknownName, match=r"unknown --by 'sensors'.*Did you mean sensor"):
        read_by("sensors")
    with pytest.raises(UsageError, match="by sensor would tear"):
        read_by("sensor")
    with pytest.raises(UsageError, match="with two points between them"):
        SplitOptions.checked(force="1,13")


def test_units_to_hold_out_as_a_mapping():
    """One name or several, each once and in order; kinds in their order; names that are none are refused."""
    assert read_hold_out({"indenter": "star", "sensor": ["B", "A", "B"]}) == {
        "sensor": ("A", "B"),
        "indenter": ("star",),
    }
    assert read_hold_out(" sensor = A , B ; indenter = x ") == {"sensor": ("A", "B"), "indenter": ("x",)}
    assert read_hold_out(None) == "none"
    assert read_hold_out("auto") == "auto"
    for wrong in ({"sensor": [1]}, {"sensor": ["A", ""]}, {"sensor": ""}):
        with pytest.raises(UsageError, match="hold-out of sensor names"):
            read_hold_out(wrong)
    for wrong in ("A", "=A", "sensor=", "sensor=A,,B", "sensor=A;"):
        with pytest.raises(UsageError, match="Name the kind and the unit"):
            read_hold_out(wrong)
    with pytest.raises(UnknownName):
        read_hold_out({"robot": ["x"]})


def test_seeds_are_whole_numbers():
    """Negative ones too; a truth value or a fraction is none."""
    assert SplitOptions.checked(seed=-3).seed == -3
    for wrong in (True, False, 1.0, "1", None):
        with pytest.raises(UsageError, match="seed is"):
            SplitOptions.checked(seed=wrong)


def test_names_have_64_characters_at_most():
    """64 are taken, 65 not; one that begins with a sign is not taken either."""
    assert check_name("x" * 64) == "x" * 64
    assert check_name("9_a-B") == "9_a-B"
    for wrong in ("x" * 65, "_a", "-a", "a b", "a.b", "", "ä", 5):
        with pytest.raises(UsageError, match="cannot be a file name"):
            check_name(wrong)


@pytest.mark.parametrize(("units", "held"), [(1, 0), (2, 0), (3, 0), (4, 1), (7, 1), (8, 2), (12, 2), (13, 3), (20, 4)])
def test_a_fifth_of_four_units_or_more_is_held_out(units, held):
    """Rounded, at least one; fewer than four units are all needed, as is said; one alone cannot be held out."""
    rows = [{"source": k, "sensor": f"s{k % units}"} for k in range(40)]
    found, notes = choose_held_out(trajectories(rows), SplitOptions())
    assert len(found.get("sensor", ())) == held
    if not held:
        names = ", ".join(f"s{k}" for k in range(units))
        advice = "; --hold-out sensor=… holds some out all the same" if units > 1 else ""
        assert notes == [f"no sensor is held out: the store has {units} of them ({names}), and 4 are needed{advice}"]
    assert list(found.get("sensor", ())) == sorted(found.get("sensor", ()))


def test_sensors_without_a_serial_are_not_held_out():
    """One camera, recorded many times without its serial, is many names, none of them unseen. Named ones still are."""
    nameless = [{"source": k, "sensor": f"unknown-{k:08x}"} for k in range(8)]
    found, notes = choose_held_out(trajectories(nameless), SplitOptions())
    assert found == {}
    assert notes[0].startswith("8 sensors without a serial (unknown-00000000, ")
    assert "none is held out as unseen" in notes[0]
    named = [{"source": 8 + k, "sensor": f"s{k}"} for k in range(4)]
    (held,) = choose_held_out(trajectories([*nameless, *named]), SplitOptions())[0]["sensor"]
    assert held.startswith("s")
    asked = SplitOptions.checked(hold_out={"sensor": ["unknown-00000003"]})
    assert choose_held_out(trajectories(nameless), asked)[0] == {"sensor": ("unknown-00000003",)}


def test_units_of_derived_trajectories_count_only_where_nothing_is_recorded():
    """Styles that were made are no sensors to hold out; in a store of made ones alone they are."""
    made = [{"source": 9, "sensor": f"m{k}", "parent": f"{k:016x}"} for k in range(8)]
    real = [{"source": k, "sensor": f"s{k}"} for k in range(3)]
    assert choose_held_out(trajectories([*real, *made]), SplitOptions())[0] == {}
    assert len(choose_held_out(trajectories(made), SplitOptions())[0]["sensor"]) == 2
    nameless = trajectories([{"source": k, "sensor": ""} for k in range(5)])
    assert "0 of them (none named)" in choose_held_out(nameless, SplitOptions())[1][0]


def test_a_draw_at_a_border_belongs_to_the_next_part():
    """With 0.5, 0.25, 0.25 a draw from 0.5 on is val, from 0.75 on test; a share of 0 gets nobody."""
    draws = np.array([0.0, 0.499, 0.5, 0.7499, 0.75, 0.999])
    assert part_of(draws, (0.5, 0.25, 0.25)).tolist() == [0, 0, 1, 1, 2, 2]
    assert part_of(draws, (0.5, 0.0, 0.5)).tolist() == [0, 0, 2, 2, 2, 2]
    assert part_of(draws, (0.0, 0.0, 1.0)).tolist() == [2] * 6
    # typed shares may sum to a little less than 1: what is over belongs to the last part that has a share
    assert part_of(np.array([0.9999999]), (0.5, 0.4999995, 0.0)).tolist() == [1]


def test_a_table_of_nothing_is_assigned_to_nothing():
    """No trajectories give a table without rows; frames are 0 where none are given."""
    assert assign(trajectories([]), NONE, {}).num_rows == 0
    table = assign(trajectories([{}, {"source": 1}]), NONE, {})
    assert table["frames"].to_pylist() == [0, 0]
    assert assign(trajectories([{}, {"source": 1}]), NONE, {}, np.array([4, 2]))["frames"].to_pylist() == [4, 2]


@pytest.mark.parametrize(
    ("ours", "theirs", "words"),
    [
        ("ab", "ab", ""),
        ("ba", "ab", ""),
        ("ab", "abc", "the store has 1 new trajectory"),
        ("abc", "a", "2 trajectories of the split can no longer be found"),
        ("ab", "ac", "the store has 1 new trajectory and 1 trajectory of the split can no longer be found"),
        ("aab", "ab", "it has 3 rows for 2 trajectories"),
        ("ab", "", "2 trajectories of the split can no longer be found"),
        ("", "", ""),
        ("", "a", "the store has 1 new trajectory"),
    ],
)
def test_how_a_split_and_a_store_differ(ours, theirs, words):
    """New ones, lost ones, both, rows that stand twice; nothing where they are the same."""
    split = Split("x", pa.table({"uid": pa.array(list(ours), pa.string())}), {})
    assert coverage_problem(split, pa.chunked_array([pa.array(list(theirs), pa.string())])) == words


def test_rows_of_a_part_are_taken_frames_of_its_trajectories():
    """Frame 1 is outside any trajectory, frame 3 too strong; rows ascend."""
    table = pa.table(
        {
            "trajectory": pa.array([1, -1, 0, 0, 1], pa.int32()),
            "flags": pa.array([0, 0, 0, 0, 8], pa.uint32()),
            "contact_force": pa.array([5.0, 5.0, 5.0, 20.0, 5.0], pa.float32()),
        }
    )
    assert part_rows(table, np.array([True, True]), (1.0, 13.0)).tolist() == [0, 2, 4]
    assert part_rows(table, np.array([False, True]), (1.0, 13.0)).tolist() == [0, 4]
    assert part_rows(table, np.array([True, False]), None).tolist() == [2, 3]
