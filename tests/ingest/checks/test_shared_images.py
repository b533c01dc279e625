"""Copies whose times were moved are found by their images: most of them of the same bytes, in another recording."""

import shlex

import numpy as np
import pytest
from cli.command import run_command
from hypothesis import given
from hypothesis import strategies as st
from moved_copy import moved_copy

from tactiledata.errors import TactileDataError
from tactiledata.ingest.checks.shared_images import IMAGE_COLUMNS, touches_of_same_images
from tactiledata.ingest.checks.twins import need_touches_once, twins_of_store
from tactiledata.ingest.pipeline import ingest
from tactiledata.store.change.flag import flag_trajectories
from tactiledata.store.read.flags import flagged_trajectories
from tactiledata.store.read.named_trajectories import full_names
from tactiledata.store.read.reader import Store
from tests.ingest.made_takes import frames


def images(*touches, **columns):
    """A table of frames: for each touch the checksums of its images."""
    rows = [(touch, crc) for touch, held in enumerate(touches) for crc in held]
    made = {"trajectory": [row[0] for row in rows], "crc32c": [row[1] for row in rows], "height": 8, "width": 6}
    return frames(len(rows), **{"encoding": "png", **made, **columns}).select(IMAGE_COLUMNS)


def found(*touches, source=None, **columns):
    rows = np.arange(len(touches)) if source is None else np.array(source)
    return touches_of_same_images(images(*touches, **columns), rows)


def test_a_copy_shares_most_of_its_images():
    """Half of the images of one of the two are enough: a copy may have lost some, and a cut one holds a part."""
    assert found([1, 2, 3, 4, 5, 6], [1, 2, 3, 7, 8, 9]) == {(0, 1), (1, 0)}
    assert found([1, 2, 3, 4, 5, 6, 7, 8, 9], [9, 1, 5]) == {(0, 1), (1, 0)}
    assert found([1, 2, 3, 4, 5, 6, 7], [1, 2, 3, 8, 9, 10, 11]) == set()


@pytest.mark.parametrize(
    ("touches", "options"),
    [
        (([1, 1, 1, 1], [1, 1, 1, 1]), {}),
        (([1, 2], [1, 2]), {}),
        (([1, 2, 3], [4, 5, 6]), {}),
        (([1, 2, 3], [1, 2, 3]), {"source": [4, 4]}),
        (([1, 2, 3], [1, 2, 3]), {"encoding": "missing"}),
        (([1, 2, 3], [1, 2, 3]), {"height": [8, 8, 8, 9, 9, 9]}),
        (([1, 2, 3],) * 21, {}),
        ((), {}),
    ],
    ids=["one blank picture", "two images", "others", "one recording", "missing", "size", "of too many", "nothing"],
)
def test_others_are_no_copies(touches, options):
    """One picture over and over, few, other or lost ones, those of one recording, and those that all touches hold."""
    assert found(*touches, **options) == set()


@given(st.lists(st.sets(st.integers(0, 12), max_size=8), max_size=6))
def test_it_agrees_with_a_comparison_of_all_pairs(touches):
    """The pairs of copied touches are those that a comparison of each touch with each other one finds."""
    expected = {
        (i, j)
        for i, one in enumerate(touches)
        for j, other in enumerate(touches)
        if i != j and len(one & other) >= 3 and len(one & other) >= 0.5 * min(len(one), len(other))
    }
    assert found(*touches) == expected


@pytest.mark.slow
def test_a_copy_whose_times_were_moved_is_said(tiny_folders, tmp_path):
    """Ingest says it, a fit refuses it with the command that flags it, and after that command it is no obstacle."""
    place = tmp_path / "ds.zarr"
    ingest(tiny_folders, place)
    assert twins_of_store(Store.open(place)) == {}
    moved = moved_copy(tiny_folders[0], tmp_path / "moved", hours=1)
    (source,) = ingest([moved], place).sources
    (twin,) = [finding for finding in source.findings if finding.code == "recording-twin"]
    assert tiny_folders[0].name in twin.message
    with pytest.raises(TactileDataError, match="with the same images") as refused:
        need_touches_once(Store.open(place))
    assert f"flag {place} moved --reason" in refused.value.remedy
    rows = Store.open(place).trajectories(["uid", "source"]).to_pylist()
    flag_trajectories(str(place), [row["uid"] for row in rows if row["source"] == 2], "a copy")
    need_touches_once(Store.open(place))


@pytest.mark.slow
def test_a_touch_that_is_bad_is_bad_in_a_copy(tiny_folders, tmp_path, capsys):
    """A copy of a flagged touch is told with the reason, and the command flags it; so does a fit that is refused."""
    place = tmp_path / "ds.zarr"
    ingest(tiny_folders[:1], place)
    bad = full_names(Store.open(place))[0]
    flag_trajectories(place, [bad], "gel slipped")
    copy = moved_copy(tiny_folders[0], tmp_path / "hour", hours=1)
    (source,) = ingest([copy], place).sources
    (twin,) = [finding for finding in source.findings if finding.code == "recording-twin"]
    assert "1 trajectory of it is flagged there (gel slipped) and not here" in twin.message
    command = twin.message[twin.message.index("tactiledata flag ") :]
    assert shlex.split(command)[1:4] == ["flag", str(place), "hour"]
    # flagged one by one, the last that is left is the bad one
    copies = [name for name in full_names(Store.open(place)) if name.startswith("hour/")]
    flag_trajectories(place, copies[1:], f"a copy of {tiny_folders[0].name}")
    with pytest.raises(TactileDataError, match=r"flagged there .gel slipped. and not here") as refused:
        need_touches_once(Store.open(place))
    assert f"flag {place} hour --reason" in refused.value.remedy
    code, out, _ = run_command(capsys, "flag", place, "hour", "--reason", f"a copy of {tiny_folders[0].name}")
    assert (code, "to flag these, too" in out) == (0, False)
    need_touches_once(Store.open(place))
    assert twins_of_store(Store.open(place)) == {}


@pytest.mark.slow
def test_a_reason_is_not_lost_to_that_of_a_copy(tiny_folders, tmp_path, capsys):
    """A touch that is bad keeps its reason where its recording is flagged as a copy; another reason says the old."""
    place = tmp_path / "ds.zarr"
    ingest(tiny_folders, place)
    bad = full_names(Store.open(place))[0]
    flag_trajectories(place, [bad], "gel slipped")
    recording = bad.partition("/")[0]
    assert flag_trajectories(place, [recording], "a copy of another") == [
        name for name in full_names(Store.open(place)) if name.startswith(f"{recording}/") and name != bad
    ]
    reasons = {flag.name: flag.reason for flag in flagged_trajectories(Store.open(place)).values()}
    assert reasons.pop(bad) == "gel slipped"
    assert set(reasons.values()) == {"a copy of another"}
    _, out, _ = run_command(capsys, "flag", place, bad, "--reason", "torn gel")
    assert f"flagged: {bad} (before: gel slipped)" in out


@pytest.mark.slow
def test_split_and_audit_say_where_copies_are_told(tiny_folders, tmp_path, capsys):
    """A split of a store with copies says so, and an audit that finds their images names the command to look at."""
    place = tmp_path / "ds.zarr"
    ingest(tiny_folders, place)
    drawn = ("split", place, "--hold-out", "none", "--force", "none", "--fractions", "0.5,0.25,0.25")
    _, out, _ = run_command(capsys, *drawn)
    assert "touches of each other" not in out
    ingest([moved_copy(log, tmp_path / f"copy{row}", hours=row + 1) for row, log in enumerate(tiny_folders)], place)
    _, out, _ = run_command(capsys, *drawn, "--replace")
    assert "copy0" in out[out.index("touches of each other") :]
    code, out, _ = run_command(capsys, "audit", place)
    assert code == 1
    assert "identical-image" in out
    assert f"copies of images: `tactiledata info {place}` names" in " ".join(out.split())


@pytest.mark.slow
def test_all_copies_are_named_at_once(tiny_folders, tmp_path):
    """Two copies of two recordings are refused in one sentence with one command."""
    place = tmp_path / "ds.zarr"
    copies = [moved_copy(log, tmp_path / f"copy{row}", hours=row) for row, log in enumerate(tiny_folders)]
    ingest([*tiny_folders, *copies], place)
    with pytest.raises(TactileDataError, match="these recordings are copies") as refused:
        need_touches_once(Store.open(place))
    assert f"flag {place} copy0 copy1 --reason" in refused.value.remedy
