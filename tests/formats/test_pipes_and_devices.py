"""A pipe or a device where a file should be is said; nobody waits for it."""

import os
import signal
from contextlib import contextmanager
from pathlib import Path

import pytest
from generators.folder_log import SENSOR, write
from generators.mcap_files import touch

from tactiledata.errors import SchemaError, TactileDataError, UsageError
from tactiledata.formats import FORMATS
from tactiledata.ingest.sources.discover import find_sources


@contextmanager
def soon():
    """The block fails where it takes longer than anything but waiting for a pipe could."""

    def stop(*_):
        raise AssertionError("waited for a pipe")

    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(20)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def inspections(path):
    sources, _ = find_sources([path])
    return [FORMATS[source.format]().inspect(source) for source in sources]


@pytest.mark.parametrize("name", ["log.yaml", "trajectories.csv", "wrench.csv", "frames.csv"])
def test_a_pipe_for_a_table_is_an_error(name, tmp_path):
    """A log whose description or table is a pipe is refused with its name; the same log with files is read."""
    write(tmp_path / "log")
    assert inspections(tmp_path / "log")
    (tmp_path / "log" / name).unlink()
    os.mkfifo(tmp_path / "log" / name)
    with soon(), pytest.raises(TactileDataError, match=name):
        inspections(tmp_path / "log")


@pytest.mark.parametrize("name", ["frames/t0_0.png", f"backgrounds/{SENSOR}.png"])
def test_a_pipe_for_a_picture_is_damage(name, tmp_path):
    """A picture that is a pipe is a finding."""
    write(tmp_path / "log")
    (tmp_path / "log" / name).unlink()
    os.mkfifo(tmp_path / "log" / name)
    with soon():
        [inspection] = inspections(tmp_path / "log")
    assert any(name in finding.message and finding.severity == "damage" for finding in inspection.findings)


def test_a_pipe_beside_recordings_is_left_alone(tmp_path):
    """In a folder of recordings a pipe is listed, not opened, whatever its name; named alone it is an error."""
    touch(tmp_path / "a.mcap", count=4)
    for name in ("b.mcap", "a.yaml", "log.yaml"):
        os.mkfifo(tmp_path / name)
    with soon():
        sources, unclaimed = find_sources([tmp_path])
        assert [Path(source.path).name for source in sources] == ["a.mcap"]
        assert {path.name for path in unclaimed} == {"b.mcap", "a.yaml", "log.yaml"}
        for path in (tmp_path / "b.mcap", Path("/dev/zero")):
            with pytest.raises(UsageError, match="a pipe or a device"):
                find_sources([path])


def test_a_pipe_for_a_mapping_is_an_error(tmp_path):
    """Documents are read from files only."""
    from tactiledata.contract.schema import read_document

    os.mkfifo(tmp_path / "mapping.yaml")
    with soon(), pytest.raises(SchemaError, match="is no file"):
        read_document(tmp_path / "mapping.yaml")
