"""What cannot be read among recordings is told, and the others are taken."""

import os
import shutil
from pathlib import Path

import pytest

from tactiledata.contract.records import Source
from tactiledata.errors import BrokenLog, MissingFile
from tactiledata.ingest.pipeline import ingest
from tactiledata.ingest.sources.discover import find_sources, unclaimed_findings
from tactiledata.ingest.sources.preview import preview
from tactiledata.ingest.sources.refused import refusals_told, refuse_folder, refused_findings, why_shut


@pytest.fixture
def logs(tiny_mcaps, tmp_path):
    """A folder with two different recordings."""
    folder = tmp_path / "logs"
    folder.mkdir()
    for name, log in zip(("a", "z"), tiny_mcaps, strict=True):
        shutil.copy(log, folder / f"{name}.mcap")
    return folder


def shut(monkeypatch, name, method):
    """Let the system refuse a method of paths of this name."""
    before = getattr(Path, method)

    def refused(self, *arguments, **options):
        if self.name == name:
            raise PermissionError(13, "Permission denied", str(self))
        return before(self, *arguments, **options)

    monkeypatch.setattr(Path, method, refused)


def test_a_file_that_is_refused_stops_no_other(logs, tmp_path, monkeypatch):
    """Ingest takes the other recordings, tells the file with the reason of the system, and falls short."""
    shut(monkeypatch, "a.mcap", "open")
    report = ingest([logs], tmp_path / "ds.zarr")
    assert [(source.key, source.state) for source in report.sources] == [
        ("logs/a.mcap", "failed"),
        ("logs/z.mcap", "added"),
    ]
    assert f"{logs / 'a.mcap'} cannot be read (Permission denied)" in report.sources[0].error
    assert report.fell_short


def test_a_folder_that_is_refused_is_named_itself(logs, tmp_path, monkeypatch):
    """It is told as it is called, not as a file that a format looked for in it."""
    (logs / "shut").mkdir()
    shut(monkeypatch, "shut", "iterdir")
    shut(monkeypatch, "tactile_data.pkl", "is_file")
    report = ingest([logs], tmp_path / "ds.zarr")
    assert [source.state for source in report.sources] == ["added", "added"]
    assert [(one.code, one.severity) for one in report.findings] == [("place-unreadable", "damage")]
    assert f"the folder {logs / 'shut'} cannot be read (Permission denied)" in report.findings[0].message
    assert report.fell_short
    assert report.unclaimed == ()


def test_a_folder_that_is_named_and_refused_is_an_error(tmp_path, monkeypatch):
    """A folder that a user names, and that cannot be listed, is an error: there is nothing else to read."""
    (tmp_path / "shut").mkdir()
    shut(monkeypatch, "shut", "iterdir")
    with pytest.raises(BrokenLog, match="shut cannot be read"):
        find_sources([tmp_path / "shut"])


def test_a_folder_of_recordings_is_whole(logs, tmp_path):
    """Files of no known format in folders that can be read are listed as left, without a finding of damage."""
    (logs / "sub").mkdir()
    (logs / "sub" / "notes.txt").write_text("pressed it")
    report = ingest([logs], tmp_path / "ds.zarr")
    assert [source.state for source in report.sources] == ["added", "added"]
    assert (report.findings, report.fell_short) == ((), False)
    assert why_shut(logs) == ""
    refuse_folder(logs)


def test_a_shut_folder_is_found_a_few_levels_down(tmp_path, monkeypatch):
    """What a format met below a folder of its own is the reason that is told."""
    (tmp_path / "a" / "b" / "shut").mkdir(parents=True)
    shut(monkeypatch, "shut", "iterdir")
    assert why_shut(tmp_path) == f"the folder {tmp_path / 'a' / 'b' / 'shut'} cannot be read (Permission denied)"


def test_a_dead_link_is_told_as_one(logs, tmp_path):
    """The finding says where it leads, and the link is no file that no format claims; a link to a log is read."""
    (logs / "broken.mcap").symlink_to("nowhere.mcap")
    (logs / "m.mcap").symlink_to(logs / "a.mcap")
    sources, unclaimed = find_sources([logs])
    assert [source.key for source in sources] == ["a.mcap", "z.mcap"]
    left, [finding] = unclaimed_findings(unclaimed)
    assert (left, finding.code, finding.severity) == ([], "dead-link", "warning")
    assert "broken.mcap leads nowhere: it is a link to nowhere.mcap, which is not there" in finding.message
    (logs / "other.mcap").symlink_to("nowhere.mcap")
    _, [finding] = refused_findings([logs / "broken.mcap", logs / "other.mcap"])
    assert finding.message.endswith("; so do 1 more")
    assert finding.count == 2


def test_a_folder_of_dead_links_is_an_error_that_says_so(tmp_path):
    """Not that the folder were in no known format."""
    (tmp_path / "broken.mcap").symlink_to("nowhere.mcap")
    with pytest.raises(BrokenLog, match=r"it is a link to nowhere\.mcap, which is not there"):
        find_sources([tmp_path])


def test_a_name_that_is_no_text_is_told(logs, tmp_path):
    """The recording is refused by its name, for ingest and inspect alike, and the others are taken."""
    odd = os.fsdecode(os.fsencode(logs) + b"/\xff.mcap")
    shutil.move(logs / "a.mcap", odd)
    report = ingest([logs], tmp_path / "ds.zarr")
    assert sorted(source.state for source in report.sources) == ["added", "failed"]
    [error] = [source.error for source in report.sources if source.error]
    assert f"the name {logs}/\\xff.mcap holds bytes that are not UTF-8" in error
    with pytest.raises(BrokenLog, match="not UTF-8"):
        preview(*find_sources([Path(odd)])[0])


def test_names_of_other_scripts_are_text(logs, tmp_path):
    """Any name that is UTF-8 is taken."""
    shutil.move(logs / "a.mcap", logs / "měření 測定.mcap")
    assert not ingest([logs], tmp_path / "ds.zarr").fell_short


def test_errors_of_our_own_pass():
    """Only what the system refuses becomes another error."""
    source = Source("run.mcap", "run.mcap", "mcap", ("run.mcap",))
    with pytest.raises(MissingFile), refusals_told(source):
        raise MissingFile("run.mcap vanished")
    with pytest.raises(BrokenLog, match=r"run\.mcap cannot be read \(Input/output error\)"), refusals_told(source):
        raise OSError(5, "Input/output error")
