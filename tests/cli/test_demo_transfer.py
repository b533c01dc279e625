"""The demo's step between sensors: what it prints of one store, its target, and where it is left out."""

import json
from dataclasses import replace
from types import SimpleNamespace

import pytest
import typer.main
from transfer_stores import write_two_sensors

from tactiledata.cli.demo_steps import transfer as demo_transfer
from tactiledata.cli.demo_steps.transfer import transfer_touches, unused_target
from tactiledata.cli.main import app
from tactiledata.rig.scenario.scenario import load_scenario
from tactiledata.rig.scenario.worlds import find_scenario
from tactiledata.sensors.backgrounds import ALIASES, bundled_backgrounds


@pytest.fixture
def tiny_world():
    return load_scenario(find_scenario("tiny"))


@pytest.fixture
def commands():
    return dict(typer.main.get_command(app).commands)


@pytest.mark.slow
def test_a_person_sees_method_reason_scores_and_picture(tiny_store, tmp_path, tiny_world, commands):
    """The lines name source, target, method and reason, and their figures are those of the documents."""
    lines = []
    transferred, scored = transfer_touches(commands, tiny_store, tmp_path / "demo", tiny_world, lines.append)
    text = "\n".join(lines)
    assert "touches of D20001" in lines[0]
    assert "target: ycb-sensorA" in text
    assert f"{transferred['reason']}: {transferred['method'].replace('_', '-')}" in text
    (kept,) = transferred["kept_touch"]
    assert f"strength {kept['strength']:.2f}, correlation {kept['correlation']:.2f}" in text
    before, after = (next(line for line in lines if line.startswith(f"   {when}")) for when in ("before", "after "))
    style = {score["first"]: score["value"] for score in scored["scores"]}
    assert f": {style['D20001']:.3g}" in before
    assert f": {style[scored['kept'][0]['first']]:.3g}" in after
    assert "by construction" in text
    assert "D20001-ycb-sensorA.png: touches of simulated recordings" in lines[-1]


@pytest.mark.parametrize("name", ["demo", "tiny"])
def test_the_target_is_no_sensor_of_the_world(name):
    """The target of the transfer is a picture that no unit of the demo's worlds has."""
    scenario = load_scenario(find_scenario(name))
    assert unused_target(scenario) == "ycb-sensorA"
    assert ALIASES["ycb-sensorA"] not in {setup.background for setup in scenario.sensors.values()}


def test_a_used_picture_is_no_target(tiny_world):
    """A picture that a unit has, by its name or its alias, is passed over; where all are used there is no target."""
    first = next(iter(tiny_world.sensors.values()))
    for name in ("ycb-sensorA", "digit-bg-0"):
        assert unused_target(replace(tiny_world, sensors={"D1": replace(first, background=name)})) == "ycb-sensorB"
    every = {name: replace(first, background=name) for name in bundled_backgrounds()}
    assert unused_target(replace(tiny_world, sensors=every)) is None


@pytest.mark.slow
@pytest.mark.parametrize(
    ("missing", "says"),
    [
        ("torch", "a transfer needs torch, which is not installed"),
        ("commands", "no installed package adds the commands transfer and score"),
        ("target", "have all bundled pictures"),
    ],
)
def test_without_what_it_needs_it_is_left_out(tmp_path, tiny_world, commands, monkeypatch, missing, says):
    """Negative control: without PyTorch, the commands or a target there is a sentence, and nothing is written."""
    store = tmp_path / "ds.zarr"
    write_two_sensors(store, n_sources=2)
    if missing == "torch":
        monkeypatch.setattr(demo_transfer, "find_spec", lambda name: None)
    if missing == "commands":
        commands = {name: one for name, one in commands.items() if name not in ("transfer", "score")}
    if missing == "target":
        monkeypatch.setattr(demo_transfer, "unused_target", lambda scenario: None)
    lines = []
    out = tmp_path / "demo"
    assert transfer_touches(commands, store, out, tiny_world, lines.append) == (None, None)
    assert len(lines) == 2
    assert lines[1].startswith("   left out: ")
    assert says in lines[1]
    assert not out.exists()


@pytest.mark.slow
def test_a_store_without_backgrounds_leaves_it_out(tmp_path, tiny_world, commands):
    """A store that cannot be transferred ends the step with what is wrong, and does not end the demo."""
    store = tmp_path / "ds.zarr"
    write_two_sensors(store, n_sources=2, with_backgrounds=())
    lines = []
    assert transfer_touches(commands, store, tmp_path / "demo", tiny_world, lines.append) == (None, None)
    assert "left out: 1 sensor" in lines[-1]
    assert "without a picture without contact" in lines[-1]


def test_figures_are_printed_with_their_intervals():
    """What a person reads is the documents' numbers; too few touches have no interval."""
    score = {"value": 0.25, "low": 0.2, "high": 0.31}
    assert demo_transfer._interval(score) == "0.25 [0.2, 0.31]"
    assert demo_transfer._interval({**score, "low": None, "high": None}) == "0.25"


def test_a_command_is_run_as_it_is_typed():
    """The words and ``--json`` reach the command, and its document comes back."""
    typed = []
    command = SimpleNamespace(main=lambda words, standalone_mode: (typed.append(words), print(json.dumps({"a": 1}))))
    assert demo_transfer._document(command, "ds.zarr", "--to", "x") == {"a": 1}
    assert typed == [["ds.zarr", "--to", "x", "--json"]]
