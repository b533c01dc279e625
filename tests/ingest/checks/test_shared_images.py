"""Copies whose times were moved are found by their images: most of them of the same bytes, in another recording."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from moved_copy import moved_copy

from tactiledata.errors import TactileDataError
from tactiledata.ingest.checks.shared_images import IMAGE_COLUMNS, touches_of_same_images
from tactiledata.ingest.checks.twins import need_touches_once, twins_of_store
from tactiledata.ingest.pipeline import ingest
from tactiledata.store.change.flag import flag_trajectories
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
    """The same pairs as a plain comparison of each touch with each other one."""
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
def test_all_copies_are_named_at_once(tiny_folders, tmp_path):
    """Two copies of two recordings are refused in one sentence with one command."""
    place = tmp_path / "ds.zarr"
    copies = [moved_copy(log, tmp_path / f"copy{row}", hours=row) for row, log in enumerate(tiny_folders)]
    ingest([*tiny_folders, *copies], place)
    with pytest.raises(TactileDataError, match="these recordings are copies") as refused:
        need_touches_once(Store.open(place))
    assert f"flag {place} copy0 copy1 --reason" in refused.value.remedy
