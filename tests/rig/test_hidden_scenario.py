"""The `hidden` section: what it takes and refuses, that without strength it changes no byte, and that no log tells."""

import filecmp
import json
import re
from dataclasses import asdict, fields
from pathlib import Path

import numpy as np
import pytest
from hidden_worlds import PRESS, SLIDE, played, stated, touch, world

from tactiledata.errors import SchemaError
from tactiledata.rig.hidden.effects import HIDDEN_EFFECTS, is_null, name_of
from tactiledata.rig.record import log_groups, record
from tactiledata.rig.scenario.scenario import load_scenario
from tactiledata.rig.scenario.worlds import find_scenario

PLACES = {"pose", "contact", "force", "load", "sensor", "clock"}
TWICE = [
    touch(steps=[PRESS, {"dwell": {"time": 0.3}}, SLIDE], tilt=[0.1, 0.0]),
    touch("two", "punch", steps=[PRESS, SLIDE], yaw=1.0, tilt=[0.0, 0.1]),
]


@pytest.mark.parametrize("name", HIDDEN_EFFECTS)
def test_every_effect_keeps_the_contract_of_the_table(name):
    """Number, place, source, three strengths within the ranges and rising, defaults that are the null."""
    kind = HIDDEN_EFFECTS[name]
    assert kind.NUMBER == "outside" or 1 <= int(kind.NUMBER) <= 29
    assert kind.ACTS in PLACES
    assert kind.SOURCE
    assert list(kind.STRENGTHS) == ["weak", "medium", "strong"]
    assert set(kind.RANGES) == {item.name for item in fields(kind)}
    assert is_null(kind())
    assert name_of(kind()) == name
    null = asdict(kind())
    distances = []
    for parameters in kind.STRENGTHS.values():
        assert not is_null(kind(**parameters))
        assert all(kind.RANGES[key][0] <= value <= kind.RANGES[key][1] for key, value in parameters.items())
        distances.append([abs(value - null[key]) for key, value in parameters.items()])
    assert (np.diff(distances, axis=0) > 0).all()


def test_the_page_lists_every_effect():
    """The page has a row for each effect, with its number."""
    page = (Path(__file__).parents[2] / "docs/rig.md").read_text(encoding="utf-8")
    rows = dict(re.findall(r"^\| `(\w+)` \| (\d+|–) \|", page, re.MULTILINE))
    numbers = {name: HIDDEN_EFFECTS[name].NUMBER.replace("outside", "–") for name in HIDDEN_EFFECTS}
    assert rows == numbers


def test_the_catalogue_is_covered():
    """Every row but the numerics of the fitted simulator (28), once; four effects stand outside it."""
    numbers = [HIDDEN_EFFECTS[name].NUMBER for name in HIDDEN_EFFECTS]
    assert sorted(int(number) for number in numbers if number != "outside") == [*range(1, 28), 29]
    assert numbers.count("outside") == 4


@pytest.fixture(scope="module")
def plain():
    """The two touches without effects."""
    return played(trajectories=TWICE)


@pytest.mark.slow
@pytest.mark.parametrize("name", HIDDEN_EFFECTS)
def test_every_effect_changes_the_readings_or_the_stamps(name, plain):
    """Each effect at its strongest changes a log of two touches, and the same seed gives the same numbers."""
    entry = {"effect": name, "strength": "strong"}
    first, second = played([entry], TWICE), played([entry], TWICE)
    np.testing.assert_array_equal(first.readings, second.readings)
    np.testing.assert_array_equal(first.stamps, second.stamps)
    assert np.isfinite(first.readings).all()
    same_length = len(first.readings) == len(plain.readings)
    assert not (
        same_length
        and np.allclose(first.readings, plain.readings, atol=1e-4)
        and np.array_equal(first.stamps, plain.stamps)
    )


@pytest.mark.slow
def test_effects_of_all_places_play_together():
    """One of each kind at once; forces stay finite and within reason."""
    names = ("relaxation", "tool_weight", "thickness", "arm_compliance", "rate_friction", "cross_talk", "clock_skew")
    log = played([{"effect": name, "strength": "medium"} for name in names], TWICE)
    assert np.isfinite(log.readings).all()
    assert np.abs(log.readings[:, :3]).max() < 20


def test_without_strength_no_byte_changes(tmp_path):
    """Effects whose parameters are their nulls record what the same world records without any."""
    nulls = [stated("relaxation", alpha=0.0), stated("arm_compliance", softness=0.0), stated("lag", delay=0.0)]
    folders = [tmp_path / "plain", tmp_path / "nulls"]
    for folder, hidden in zip(folders, ([], nulls), strict=True):
        record(world(hidden), folder, "folder")
    files = sorted(path.relative_to(folders[0]) for path in folders[0].rglob("*") if path.is_file())
    assert files
    _, mismatch, errors = filecmp.cmpfiles(*folders, [str(path) for path in files], shallow=False)
    assert not mismatch
    assert not errors


def test_only_the_truth_tells(tmp_path):
    """Name and parameters stand in truth/, and in no file of the log; there, next to nothing changes but readings."""
    hidden = [{"effect": "cross_talk", "strength": "medium"}, stated("relaxation", alpha=0.0437)]
    record(world(hidden), tmp_path, "folder")
    truth = json.loads((tmp_path / "truth" / "D1.json").read_text())
    assert [(entry["effect"], entry["number"]) for entry in truth["hidden"]] == [
        ("cross_talk", "14"),
        ("relaxation", "1"),
    ]
    assert truth["hidden"][1]["parameters"] == {"alpha": 0.0437, "onset": 0.02}
    for path in (tmp_path / "D1").rglob("*"):
        if path.suffix in {".yaml", ".csv"}:
            text = path.read_text()
            assert not any(word in text for word in ("0.0437", "cross_talk", "relaxation", "hidden"))


@pytest.mark.parametrize(
    ("entry", "path"),
    [
        ({"effect": "gremlins", "strength": "weak"}, "$.hidden[1].effect"),
        ({"effect": "lag", "strength": "huge"}, "$.hidden[1].strength"),
        ({"effect": "lag"}, "$.hidden[1]"),
        ({"strength": "weak"}, "$.hidden[1]"),
        ({"effect": "lag", "parameters": {"tau": 0.1}}, "$.hidden[1].parameters.tau"),
        ({"effect": "lag", "parameters": {"delay": -0.1}}, "$.hidden[1].parameters.delay"),
        ({"effect": "lag", "parameters": {"delay": "long"}}, "$.hidden[1].parameters.delay"),
        ({"effect": "wear", "strength": "weak"}, "$.hidden[1].effect"),
    ],
)
def test_a_bad_entry_is_refused_by_its_place(entry, path):
    """An unknown effect, strength, parameter or value, and the same effect twice, are refused."""
    with pytest.raises(SchemaError) as caught:
        world([{"effect": "wear", "strength": "weak"}, entry])
    assert caught.value.facts["path"] == path


def test_the_world_for_development_has_what_a_diagnosis_needs():
    """It has sixty touches, three speeds, two units, dwells of 1 to 4 s, shears and ways back, and hides nothing."""
    scenario = load_scenario(find_scenario("develop"))
    drawn = [member for _, group in log_groups(scenario) for member in group]
    assert len(drawn) == 60
    assert not scenario.hidden
    steps = [step for member in drawn for step in member.steps]
    assert {step.speed for step in steps if step.kind == "press"} == {0.0003, 0.001, 0.003}
    assert all(1.0 <= step.time <= 4.0 for step in steps if step.kind == "dwell")
    assert {member.sensor for member in drawn} == {"D20542", "D20571"}
    assert len({member.indenter for member in drawn}) == 4
    assert sum(step.kind == "shear" for step in steps) > 30
    assert sum(step.kind == "reverse" for step in steps) > 15
