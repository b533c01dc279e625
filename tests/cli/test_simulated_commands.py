"""Commands say simulated recordings of a rig's world, and never of logs that do not state it."""

import json

import pytest
from command import run_command

TERM = "imulated recordings"


COMMANDS = {
    "info": ("info",),
    "score": ("score", "--metric", "histogram_intersection", "--frames", "3"),
    "report": ("report", "--out", "page"),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", COMMANDS)
def test_commands_say_it_of_a_rigs_world_only(name, tiny_store, unstated, tmp_path, monkeypatch, capsys):
    """Text and JSON say it of the recordings that state it, and not of the same recordings without the statement."""
    monkeypatch.chdir(tmp_path)
    command, *options = COMMANDS[name]
    for store, simulated in ((tiny_store, 2), (unstated, 0)):
        code, printed, said = run_command(capsys, command, store, *options)
        assert code == 0, said
        assert (TERM in printed) == bool(simulated)
        code, printed, said = run_command(capsys, command, store, *options, "--json")
        counts = {"simulated": simulated, "real": 0, "not_stated": 2 - simulated}
        assert json.loads(printed)["simulated_recordings"] == counts


@pytest.mark.slow
def test_a_recorder_says_what_it_makes(tmp_path, capsys):
    """`record` itself says that its recordings are simulated."""
    code, printed, said = run_command(capsys, "record", "tiny", "--out", tmp_path / "logs", "--format", "folder")
    assert code == 0, said
    assert "2 logs of simulated recordings" in printed
