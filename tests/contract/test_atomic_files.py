"""A file written atomically is the old one or the new one, whenever the writer dies."""

import json
import signal
import subprocess
import sys
import time

import pytest

from tactiledata.contract import atomic
from tactiledata.contract.atomic import write_atomic, write_json_atomic

WRITER = """
import sys
from pathlib import Path
from tactiledata.contract.atomic import write_atomic
place = Path(sys.argv[1])
print("ready", flush=True)
number = 0
while True:
    number += 1
    write_atomic(place, str(number % 10).encode() * 400_000)
"""


def test_a_killed_writer_leaves_one_whole_content(tmp_path):
    """A writer killed at arbitrary moments leaves a file of one generation, of full length."""
    place = tmp_path / "deep" / "state.bin"
    for wait in (0.0, 0.003, 0.011, 0.04):
        writer = subprocess.Popen([sys.executable, "-c", WRITER, str(place)], stdout=subprocess.PIPE)
        assert writer.stdout.readline() == b"ready\n"
        while not place.exists():
            time.sleep(0.001)
        time.sleep(wait)
        writer.send_signal(signal.SIGKILL)
        writer.communicate()
        content = place.read_bytes()
        assert len(content) == 400_000
        assert content == content[:1] * 400_000
    assert {path.name for path in place.parent.iterdir() if not path.name.endswith(".part")} == {"state.bin"}


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path, monkeypatch):
    """Where the disk fails, the old content stays and no partial file is left behind."""
    place = tmp_path / "state.json"
    write_atomic(place, b"old")

    def full(descriptor):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(atomic.os, "fsync", full)
    with pytest.raises(OSError, match="No space"):
        write_atomic(place, b"new")
    assert place.read_bytes() == b"old"
    assert [path.name for path in tmp_path.iterdir()] == ["state.json"]


def test_only_what_must_outlast_a_power_failure_waits_for_the_disk(tmp_path, monkeypatch):
    """A file and its folder are synced; a file of a cache is not, and is whole or not there all the same."""
    synced = []
    monkeypatch.setattr(atomic.os, "fsync", synced.append)
    write_atomic(tmp_path / "kept", b"kept")
    assert len(synced) == 2
    write_atomic(tmp_path / "cached", b"cached", synced=False)
    assert len(synced) == 2
    assert (tmp_path / "cached").read_bytes() == b"cached"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["cached", "kept"]


def test_long_names_and_missing_folders(tmp_path):
    """A name as long as the file system allows works, and folders are made."""
    place = tmp_path / "a" / "b" / ("x" * 250)
    write_atomic(place, b"1")
    write_atomic(place, b"22")
    assert place.read_bytes() == b"22"
    assert len(list(place.parent.iterdir())) == 1


def test_long_names_of_wide_characters(tmp_path):
    """A name of 63 characters of four bytes each, 252 of the 255 bytes that a name may have, works too."""
    place = tmp_path / ("\N{GRINNING FACE}" * 63)
    write_atomic(place, b"1")
    assert place.read_bytes() == b"1"
    assert list(tmp_path.iterdir()) == [place]


def test_json_for_people_is_canonical(tmp_path):
    """Sorted keys, a line break at the end, the same bytes for equal values; what JSON cannot say is refused."""
    write_json_atomic(tmp_path / "one.json", {"b": "é", "a": [1, 2.5, None]})
    write_json_atomic(tmp_path / "two.json", {"a": [1, 2.5, None], "b": "é"})
    content = (tmp_path / "one.json").read_bytes()
    assert content == (tmp_path / "two.json").read_bytes()
    assert content.endswith(b"}\n")
    assert json.loads(content) == {"a": [1, 2.5, None], "b": "é"}
    with pytest.raises(ValueError, match="JSON compliant"):
        write_json_atomic(tmp_path / "one.json", {"a": float("nan")})
    assert (tmp_path / "one.json").read_bytes() == content
