"""A new effect is one file and one line: everything else follows from its class."""

import json

import numpy as np
import pytest
from effects_page import PAGE, page, row, trial
from example_effect import EXAMPLE, add_by_entry_point, add_by_line

from tactiledata.effects import EFFECTS
from tactiledata.effects.closed_form.ball_on_layer import BallOnLayer
from tactiledata.effects.simulate.setting import EffectSetting, effects_document, in_order, settings_of
from tactiledata.effects.simulate.simulator import with_effects
from tests.cli.command import run_command


@pytest.fixture(params=[add_by_line, add_by_entry_point])
def added(request, monkeypatch):
    """The example is an effect as all others, by a line in the table or by an entry point."""
    request.param(monkeypatch)


def test_it_is_played_in_its_slot(added, touch):
    """Given last, it acts with the effects of its slot, and lifts the tip by its gap wherever it presses."""
    settings = [EffectSetting("lag", {"delay": 0.01}), EffectSetting(EXAMPLE, {"gap": 5e-5})]
    assert [setting.effect for setting in in_order(settings)] == [EXAMPLE, "lag"]
    plain = with_effects(BallOnLayer, []).play(touch)
    state = with_effects(BallOnLayer, settings[1:]).play(touch)
    presses = plain.wrench[:, 2] > 0
    np.testing.assert_array_equal(state.offset, np.where(presses, -5e-5, 0.0))
    assert 0.3 < (plain.wrench - state.wrench)[:, 2].max() < 0.7  # as its detectability says


def test_at_its_null_no_bit_changes(added, touch):
    """Beside all other effects at null, the effect leaves the bytes of the plain simulation."""
    plain = with_effects(BallOnLayer, []).play(touch)
    state = with_effects(BallOnLayer, [EffectSetting(name) for name in EFFECTS]).play(touch)
    assert EXAMPLE in EFFECTS
    assert state.wrench.tobytes() == plain.wrench.tobytes()
    assert state.moved_poses.tobytes() == plain.moved_poses.tobytes()


def test_files_hold_it(added):
    """A document of settings takes it and gives it back."""
    settings = (EffectSetting(EXAMPLE, {"gap": 5e-5}, {"mount": "first"}),)
    assert settings_of(effects_document(settings), "example") == settings


def test_the_command_lists_it(added, capsys):
    """`tactiledata effects` shows what its class declares."""
    code, printed, _ = run_command(capsys, "effects", "--json")
    entry = json.loads(printed)[-1]
    assert code == 0
    assert (entry["name"], entry["slot"], entry["title"]) == (EXAMPLE, "pose", "play of the wrist")
    assert [parameter["name"] for parameter in entry["parameters"]] == ["gap"]


def test_its_rows_on_the_page_follow_from_its_class(monkeypatch):
    """Its row has the size on the reference touch, its line the trial; the page is written with both."""
    add_by_line(monkeypatch)
    assert row(EXAMPLE) == (
        "| `backlash` | pose | play of the wrist | `gap` [m] 0 … 0.0001: 1.1 N | `mount_offset`, `arm_compliance` |"
    )
    assert trial(EXAMPLE).startswith("- `backlash`: 0.05 mm is 0.3 to 0.7 N. *Press on a steel block:")
    written = page(PAGE.read_text(encoding="utf-8")).splitlines()
    assert row(EXAMPLE) in written
    assert trial(EXAMPLE) in written
