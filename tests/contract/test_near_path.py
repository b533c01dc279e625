"""A path at which nothing is: its neighbour of nearly the same name is proposed, and nothing else."""

from pathlib import Path

import pytest

from tactiledata.contract.near_path import near_path


@pytest.fixture
def folder(tmp_path):
    for name in ("ds.zarr", "calibration.json", "calibration.html", "D20001.mcap", "D20002.mcap"):
        (tmp_path / name).touch()
    return tmp_path


@pytest.mark.parametrize(
    ("typed", "endings", "meant"),
    [
        ("ds.zar", [""], ["ds.zarr"]),
        ("calibratoin.json", [""], ["calibration.json"]),
        ("calibratoin.json", [".html"], ["calibration.html"]),
        ("D2001.mcap", [""], ["D20001.mcap", "D20002.mcap"]),
        ("calibration.jsn", [".json", ".yaml"], ["calibration.json"]),
        # another number, another word, an ending alone
        ("D20003", [""], []),
        ("D20003.bag", [""], []),
        ("D20003.mcap", [""], []),
        ("missing.json", [""], []),
        ("x.zarr", [""], []),
    ],
)
def test_a_slip_proposes_the_neighbour_that_is_meant(folder, typed, endings, meant):
    """The question names the neighbour with its folder; it is empty for a name that is no slip of a neighbour's."""
    said = near_path(folder / typed, endings)
    assert sorted(part for part in said.removeprefix("Did you mean ").rstrip("?").split(" or ") if part) == [
        str(folder / name) for name in meant
    ]


def test_where_no_folder_is_nothing_is_proposed(folder):
    """Neither a folder that is not there nor a file in its place is read."""
    assert near_path(folder / "nowhere" / "ds.zarr") == ""
    assert near_path(folder / "ds.zarr" / "ds.zarr") == ""
    assert near_path(Path("/")) == ""
    assert near_path(Path("a\0b") / "c") == ""


def test_a_link_that_leads_nowhere_says_where_to(tmp_path):
    """Its name stands in the folder, and what it names is not there: it does not propose itself."""
    (tmp_path / "ds.zarr").symlink_to(tmp_path / "gone")
    assert near_path(tmp_path / "ds.zarr") == f"It is a link to {tmp_path / 'gone'}, which is not there."
    assert near_path(tmp_path / "ds.zar") == f"Did you mean {tmp_path / 'ds.zarr'}?"
