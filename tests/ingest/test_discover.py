"""What is found under a path: what lies there or is linked there, and nothing above it."""

import shutil

from tactiledata.ingest.discover import find_sources


def test_links_that_lead_back_up_are_left(tiny_mcaps, tmp_path):
    """A link to the folder above would take in what was not named; one to a folder elsewhere is followed."""
    for place, log in zip(("named", "elsewhere"), tiny_mcaps, strict=True):
        (tmp_path / place).mkdir()
        shutil.copy(log, tmp_path / place)
    shutil.copy(tiny_mcaps[1], tmp_path / "above.mcap")
    (tmp_path / "named" / "up").symlink_to("..")
    sources, left = find_sources([tmp_path / "named"])
    assert [source.key for source in sources] == [tiny_mcaps[0].name]
    assert [path.name for path in left] == ["up"]
    (tmp_path / "named" / "across").symlink_to(tmp_path / "elsewhere")
    sources, _ = find_sources([tmp_path / "named"])
    assert len(sources) == 2
