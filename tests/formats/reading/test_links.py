"""Links below a folder: counted whether they lead anywhere or not, and never followed."""

from tactiledata.formats.reading.links import links_below


def test_links_to_files_folders_and_nowhere_are_found(tmp_path):
    """In natural order, each with its way from the folder; what lies behind a link to a folder is not looked at."""
    outside, inside = tmp_path / "outside", tmp_path / "inside"
    (inside / "a" / "b" / "c").mkdir(parents=True)
    outside.mkdir()
    (outside / "x.png").symlink_to("nowhere")
    (inside / "10.png").symlink_to(tmp_path / "nowhere")
    (inside / "9.png").symlink_to(outside / "x.png")
    (inside / "a" / "folder").symlink_to(outside)
    (inside / "a" / "b" / "c" / "deep.png").symlink_to("loop")
    (inside / "file.png").touch()
    assert links_below(inside, 3) == ["9.png", "10.png", "a/b/c/deep.png", "a/folder"]
    assert links_below(inside, 2) == ["9.png", "10.png", "a/folder"]
    assert links_below(inside, 0) == ["9.png", "10.png"]


def test_what_is_no_folder_has_none(tmp_path):
    """A file, and what is not there."""
    (tmp_path / "file").touch()
    assert links_below(tmp_path / "file", 3) == []
    assert links_below(tmp_path / "none", 3) == []
