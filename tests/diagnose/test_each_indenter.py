"""An effect that is another one for each indenter: strengths of its own for each, named as one effect."""

import dataclasses

import numpy as np
import pytest
from touch_worlds import START, null

from tactiledata.diagnose.answer.sentences import Answer
from tactiledata.diagnose.naming.name_effects import name_effects
from tactiledata.diagnose.naming.options import NamingOptions
from tactiledata.diagnose.naming.signatures import effect_signatures
from tactiledata.diagnose.touches.touch_case import TouchSet
from tactiledata.diagnose.touches.whitened import WhitenedTouches
from tactiledata.effects.simulate.setting import EffectSetting
from tactiledata.errors import UsageError

FEW = ("mount_offset", "frame_rotation", "lag")


@pytest.fixture(scope="module")
def quiet():
    return null(3000, trajectories=30)


def elsewhere(cases, deeper):
    """The recordings with poses in the log that lack by how much deeper each indenter really is, m."""
    told = []
    for case in cases.touches:
        poses = case.touch.poses.copy()
        poses[:, 2, 3] += deeper[case.touch.indenter_name]
        told.append(dataclasses.replace(case, touch=dataclasses.replace(case.touch, poses=poses)))
    return TouchSet(told, cases.base, cases.box)


@pytest.mark.slow
def test_each_indenter_gets_its_own_offset_back(quiet):
    """Indenters that sit 0.15 mm higher or lower than told are named as one effect, with a number for each."""
    names = sorted(set(quiet.indenters))
    deeper = {name: 1.5e-4 * (-1) ** number for number, name in enumerate(names)}
    naming = name_effects(elsewhere(quiet, deeper), START, NamingOptions(effects=FEW, profile=False))
    found = Answer(naming)
    assert found.names == ("mount_offset",)
    settings = naming.decision.best.fit.model.settings
    assert sorted(setting.place for setting in settings) == names
    for setting in settings:
        assert setting.values["deeper"] == pytest.approx(deeper[setting.place], abs=5e-5)
    numbers = [one.name for one in naming.intervals[3:]]
    assert len(set(numbers)) == len(numbers) >= 2 * len(names)
    assert f"mount_offset deeper of {names[0]}" in numbers
    assert np.isnan(naming.decision.best.indenter_gain)
    said = next(sentence for sentence in found.sentences if sentence.startswith("Fitted values"))
    assert said.endswith("numbers may be 0.")


@pytest.mark.slow
def test_nothing_is_missing_where_every_indenter_sits_as_told(quiet):
    """What two contact laws disagree in is given no name, however many numbers there are."""
    found = Answer(name_effects(quiet, START, NamingOptions(effects=FEW, profile=False)))
    assert found.naming.decision.verdict == "nothing found"


def test_only_what_a_setting_acts_on_is_played_again(quiet):
    """Rows of other indenters are those before; the others are those of a whole play."""
    name = quiet.indenters[0]
    setting = EffectSetting("mount_offset", {"deeper": 1e-4}, {"indenter_name": name})
    before = quiet.played(START, [])
    found = quiet.simulate_where(setting, before, START, [setting]).wrench
    assert found.tobytes() == quiet.play(START, [setting]).tobytes()
    owner = np.repeat(quiet.indenters, quiet.counts)
    assert (found[owner != name] == before.wrench[owner != name]).all()
    assert (found[owner == name] != before.wrench[owner == name]).any()


def test_touches_that_do_not_tell_their_indenter_share_one_offset(quiet):
    """Touches without names of indenters share one number."""
    unnamed = [
        dataclasses.replace(case, touch=dataclasses.replace(case.touch, indenter_name="")) for case in quiet.touches
    ]
    white = WhitenedTouches.of(TouchSet(unnamed, quiet.base))
    (found,) = effect_signatures(white, START, ["mount_offset"])
    assert {one.place for one in found.strengths} == {""}


def test_a_strength_at_which_nothing_balances_is_looked_at_smaller(quiet, monkeypatch):
    """Springs that find no balance at half a standard deviation are taken at less, in proportion; else left out."""
    white = WhitenedTouches.of(quiet)
    (whole,) = effect_signatures(white, START, ["stem_bending"])
    played, limit = TouchSet.simulate_where, 0.0

    def unbalanced(self, changed, *rest):
        if changed.values["compliance"] > limit:
            raise UsageError("no balance", "stiffer springs", "Lessen the compliances.")
        return played(self, changed, *rest)

    monkeypatch.setattr(TouchSet, "simulate_where", unbalanced)
    assert effect_signatures(white, START, ["stem_bending"]) == []
    limit = 0.3 * 0.5 * float(whole.scales[0])
    (part,) = effect_signatures(white, START, ["stem_bending"])
    sizes = np.linalg.norm(part.field), np.linalg.norm(whole.field)
    assert (part.field * whole.field).sum() > 0.9 * sizes[0] * sizes[1]
    assert sizes[0] == pytest.approx(sizes[1], rel=0.5)
