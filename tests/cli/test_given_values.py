"""Places and ports that cannot serve are refused before a command does any work."""

import json
import socket

import pytest
from command import run_command

from tactiledata.cli.given_values import need_writable_folder
from tactiledata.errors import TactileDataError, UsageError
from tactiledata.view.serve import need_port


@pytest.mark.parametrize(
    "words",
    [
        ["calibrate", "STORE", "--out", "file/c.json"],
        ["replay", "STORE", "--out", "file", "--youngs-modulus", "9e5", "--poisson-ratio", "0.4", "--friction", "0.6"],
        ["report", "STORE", "--out", "file"],
        ["view", "STORE", "--out", "file/v.rrd"],
        ["view", "STORE", "--web", "--port", "99999"],
        ["view", "STORE", "--web", "--port", "TAKEN"],
    ],
    ids=lambda words: " ".join(words[:1] + words[-2:]),
)
def test_a_place_that_cannot_serve_is_refused_at_once(tiny_store, tmp_path, monkeypatch, capsys, words):
    """A file in the place of a folder, or a port that is taken or none, ends the command; nothing is written."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").touch()
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        given = {"STORE": str(tiny_store), "TAKEN": str(taken.getsockname()[1])}
        code, _, text = run_command(capsys, *(given.get(word, word) for word in words))
    assert code == 2, text
    assert "cannot be written to: file is a file" in text or "cannot be used" in text
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_a_folder_without_rights_is_refused(tmp_path, monkeypatch):
    """Rights are asked for at the nearest folder that exists, since the others are made in it."""
    asked = []
    monkeypatch.setattr("os.access", lambda place, mode: bool(asked.append(place)))
    with pytest.raises(TactileDataError, match="Permission denied"):
        need_writable_folder(tmp_path / "a" / "b")
    assert asked == [tmp_path]


def test_a_folder_in_the_place_of_a_file_is_refused(tmp_path):
    """A folder that has the name of a page cannot be replaced by it; other names are no matter."""
    (tmp_path / "page.html").mkdir()
    with pytest.raises(UsageError, match=r"page\.html in it is a folder"):
        need_writable_folder(tmp_path, "page.html")
    need_writable_folder(tmp_path, "other.html")


def test_a_port_that_is_free_is_taken_as_it_is():
    """Zero, which means any port, and a port that nobody listens to are accepted."""
    need_port(0)
    with socket.socket() as tried:
        tried.bind(("127.0.0.1", 0))
        port = tried.getsockname()[1]
    need_port(port)


@pytest.mark.parametrize(
    ("words", "found", "expected"),
    [
        (["transfer", "STORE"], "--to is not given", "the target sensor: a name that `tactiledata sensors` lists"),
        (["export-data", "STORE"], "--to is not given", "format: lerobot, huggingface, "),
        (["record"], "SCENARIO is not given", "a scenario file, or a bundled scenario: concealed, "),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_what_must_be_given_is_asked_for_with_its_help(
    tiny_store, tmp_path, monkeypatch, capsys, words, found, expected
):
    """A required option or argument that is missing is named with what it takes; `--help` asks for nothing."""
    monkeypatch.chdir(tmp_path)
    typed = [str(tiny_store) if word == "STORE" else word for word in words]
    code, said, _ = run_command(capsys, *typed, "--json")
    document = json.loads(said)
    assert (code, document["error"]) == (2, found)
    assert document["expected"].startswith(expected)
    code, said, text = run_command(capsys, *typed, "--help")
    assert code == 0, text
    assert found not in said + text
    assert not list(tmp_path.iterdir())
