"""docs/effects.md says of every effect what the code says, sizes on the reference touch included."""

import json

from effects_page import PAGE, TABLE, TRIALS, page

from tactiledata.effects import EFFECTS
from tactiledata.effects.simulate.reference_touch import RIG, contact_stiffness
from tests.cli.command import run_command


def test_the_page_has_every_row_and_line():
    """Rows and lines as the classes have them: ``python tests/effects/effects_page.py`` writes them."""
    text = PAGE.read_text(encoding="utf-8")
    assert text.count(TABLE) == text.count(TRIALS) == 1
    assert page(text) == text


def test_scales_are_those_of_the_rig():
    """A press of the reference touch is some newtons on some newtons per millimetre, far above the noise."""
    assert 6e3 <= contact_stiffness(RIG.noise * 40, RIG.depth) <= 15e3
    assert RIG.noise == 0.1


def test_the_command_lists_all(capsys):
    """The command lists every effect, in a block each for people and with everything for machines."""
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
