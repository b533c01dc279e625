"""Commands say simulated recordings of a rig's world, and never of logs that do not state it."""

import json

import pytest
import yaml
from command import run_command
from copied_trees import copy_tree

from tactiledata.ingest.pipeline import ingest

TERM = "imulated recordings"


@pytest.fixture(scope="module")
def unstated(tiny_folders, tmp_path_factory):
    """A store of the tiny world whose logs do not state what they are."""
    place = tmp_path_factory.mktemp("unstated")
    logs = []
    for folder in tiny_folders:
        logs.append(copy_tree(folder, place / folder.name))
        document = yaml.safe_load((logs[-1] / "log.yaml").read_text())
        del document["recorded_by"]
        (logs[-1] / "log.yaml").write_text(yaml.safe_dump(document, sort_keys=False))
    ingest(logs, place / "ds.zarr")
    return place / "ds.zarr"


COMMANDS = {
    "info": ("info",),
    "score": ("score", "--metric", "histogram_intersection", "--frames", "3"),
    "report": ("report", "--out", "page"),
}


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


def test_a_recorder_says_what_it_makes(tmp_path, capsys):
    """`record` itself says that its recordings are simulated."""
    code, printed, said = run_command(capsys, "record", "tiny", "--out", tmp_path / "logs", "--format", "folder")
    assert code == 0, said
    assert "2 logs of simulated recordings" in printed
