"""What is found under a path: what lies there or is linked there, and nothing above it."""

import shutil
from pathlib import Path

import pytest
from copied_trees import copy_tree

from tactiledata.ingest.sources.discover import find_sources


@pytest.mark.slow
def test_links_that_lead_back_up_are_left(tiny_mcaps, tmp_path):
    """A link to the folder above would take in what was not named; one to a folder elsewhere is followed."""
    for place, log in zip(("named", "elsewhere"), tiny_mcaps, strict=True):
        (tmp_path / place).mkdir()
        shutil.copy(log, tmp_path / place)
    shutil.copy(tiny_mcaps[1], tmp_path / "above.mcap")
    (tmp_path / "named" / "up").symlink_to("..")
    (tmp_path / "named" / "itself").symlink_to("itself")
    (tmp_path / "named" / "here").symlink_to(".")
    sources, _ = find_sources([tmp_path / "named"])
    assert [Path(source.path).name for source in sources] == [tiny_mcaps[0].name]
    (tmp_path / "named" / "across").symlink_to(tmp_path / "elsewhere")
    sources, _ = find_sources([tmp_path / "named"])
    assert sorted(Path(source.path).name for source in sources) == sorted(log.name for log in tiny_mcaps)


@pytest.mark.slow
def test_links_up_are_left_between_folder_logs_too(tiny_folders, tmp_path):
    """Folders that no format claims are searched in another place than collections of bags."""
    copy_tree(tiny_folders[0], tmp_path / "named" / "log")
    copy_tree(tiny_folders[1], tmp_path / "above")
    (tmp_path / "named" / "up").symlink_to("..")
    sources, left = find_sources([tmp_path / "named"])
    assert [Path(source.path).name for source in sources] == ["log"]
    assert [path.name for path in left] == ["up"]
