"""docs/effects.md says of every effect what the code says, sizes on the reference touch included."""

import json
from pathlib import Path

import pytest

from tactiledata.effects import EFFECTS
from tactiledata.effects.simulate.reference_touch import RIG, contact_stiffness, largest_changes
from tests.cli.command import run_command

PAGE = Path(__file__).parents[3] / "docs" / "effects.md"


def row(name):
    """The effect's row in the table of the page."""
    effect = EFFECTS[name]()
    changes = largest_changes(effect)
    parts = []
    for parameter in effect.parameters:
        low, high = parameter.plausible
        size = changes.get(parameter.name, 0.0)
        shown = f": {size:.2g} N" if size >= 1e-3 else ""
        parts.append(f"`{parameter.name}` [{parameter.unit}] {low:g} … {high:g}{shown}")
    listed = ", ".join(f"`{other}`" for other in effect.look_alikes)
    return f"| {effect.number} | `{name}` | {effect.slot} | {effect.title} | {'; '.join(parts)} | {listed} |"


@pytest.mark.parametrize("name", EFFECTS)
def test_the_page_has_the_row(name):
    """A row as it stands in the code; where it does not, the message holds the right one."""
    assert row(name) in PAGE.read_text(encoding="utf-8").splitlines()


@pytest.mark.parametrize("name", EFFECTS)
def test_the_page_says_what_is_seen_and_what_tells_apart(name):
    """Detectability and the trial, in the words of the code."""
    effect = EFFECTS[name]
    needs = f" Needs {', '.join(f'`{field}`' for field in effect.needs)}." if effect.needs else ""
    line = f"- `{name}`: {effect.detectability} *{effect.distinguishing_trial}*{needs}"
    assert line in PAGE.read_text(encoding="utf-8").splitlines()


def test_scales_are_those_of_the_rig():
    """A press of the reference touch is some newtons on some newtons per millimetre, far above the noise."""
    assert 6e3 <= contact_stiffness(RIG.noise * 40, RIG.depth) <= 15e3
    assert RIG.noise == 0.1


def test_the_command_lists_all(capsys):
    """For people one block each, for machines everything."""
    code, printed, _ = run_command(capsys, "effects")
    assert code == 0
    assert all(f"\n{name} (" in f"\n{printed}" for name in EFFECTS)
    code, printed, _ = run_command(capsys, "effects", "--json")
    listed = json.loads(printed)
    assert code == 0
    assert [entry["name"] for entry in listed] == list(EFFECTS)
    relaxation = next(entry for entry in listed if entry["name"] == "relaxation")
    assert relaxation["parameters"][0]["plausible"] == [0.0, 0.3]
    assert relaxation["played_by_gel_engine"] == []
