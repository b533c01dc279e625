"""A disk that takes nothing is told in the same words by every command: one wording for each cause."""

import errno
import os

import pytest
from bench import command

from tactiledata.cli.failure import report_failure
from tactiledata.cli.given_values import need_writable_folder
from tactiledata.contract.atomic import refusal
from tactiledata.errors import TactileDataError

CAUSES = {
    errno.ENOSPC: "Make room there",
    errno.EROFS: "Read-only file system",
    errno.EACCES: "Check your rights there",
}
"""What the system says, and a part of what the command says then."""
COMMANDS = {
    "report": ["STORE", "--out", "page"],
    "scene": ["STORE", "--trajectory", "t00000", "--out", "scene.xml"],
    "record": ["tiny", "--out", "logs"],
    "ingest": ["LOG", "--store", "new.zarr"],
    "export-data": ["STORE", "--to", "webdataset", "--out", "exported"],
}


@pytest.mark.parametrize("number", CAUSES)
@pytest.mark.parametrize("name", COMMANDS)
def test_a_cause_has_one_wording(name, number, bench, monkeypatch, capsys):
    """Exit 1, the words of the system, and a remedy for that cause; nobody is told to make room on a read-only disk."""
    words = [{"STORE": bench.store, "LOG": bench.log}.get(word, word) for word in COMMANDS[name]]

    def refuse(*given, **options):
        raise OSError(number, os.strerror(number), "there")

    for call in ("replace", "rename"):
        monkeypatch.setattr(os, call, refuse)
    code, text = command(capsys, name, *words)
    flat = " ".join(text.split())
    assert code == 1, text
    assert os.strerror(number) in flat
    found, expected, remedy = refusal(OSError(number, os.strerror(number)), "there")
    assert f"{found}; expected {expected}. {remedy}" in flat
    others = [said for other, said in CAUSES.items() if other != number]
    assert not [said for said in others if said in flat]


@pytest.mark.parametrize(("flag", "said"), [(0, "Permission denied"), (os.ST_RDONLY, "Read-only file system")])
def test_a_read_only_disk_is_not_a_matter_of_rights(tmp_path, monkeypatch, flag, said):
    """Before any work, too, a disk that is mounted read-only is called so, and a folder of others is not."""
    mounted = os.statvfs(tmp_path)

    class Mounted:
        f_flag = (mounted.f_flag & ~os.ST_RDONLY) | flag

    monkeypatch.setattr("os.access", lambda place, mode: False)
    monkeypatch.setattr("os.statvfs", lambda place: Mounted)
    with pytest.raises(TactileDataError, match=f"cannot be written: {said}"):
        need_writable_folder(tmp_path / "page")


def test_a_file_that_may_not_be_read_is_not_one_that_cannot_be_written(tmp_path, monkeypatch, capsys):
    """Negative control: what may not be read is told in the words of what may not be written."""
    closed = tmp_path / "closed"
    closed.touch()
    monkeypatch.setattr("os.access", lambda place, mode: False)
    report_failure(PermissionError(errno.EACCES, "Permission denied", str(closed)), as_json=False)
    said = " ".join(capsys.readouterr().err.split())
    assert f"{closed} cannot be read: Permission denied; expected a place that you may read." in said
    assert "written" not in said
