"""Draws of ambiguous worlds: strengths at which data do not tell an effect from another one that resembles it."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tactiledata.prove.cases import draw
from tactiledata.prove.cases.configuration import Configuration
from tactiledata.prove.cases.draw import CaseRequest, drawn_case
from tactiledata.prove.cases.kinds import LEAST_SIGNAL, TOLD_APART, Sight
from tactiledata.prove.cases.strengths import drawn_parameters, weakened
from tactiledata.rig.hidden.effects import HIDDEN_EFFECTS

REQUEST = CaseRequest(0, "ambiguous", Configuration("layer", "wedge-2"), 5, bank=None, only=("frame_rotation",))
PER_RADIAN = 3000.0
"""Signal of a turn by a radian in the worlds of these tests."""


class StandInWorld:
    """A world of which only the turn of the force frame can be seen, in proportion to it."""

    alike: dict[str, float]

    def __init__(self, *given):
        del given

    def recorded(self, hidden):
        """What is hidden stands for its readings."""
        return SimpleNamespace(hidden=hidden, readings=[])

    def loss_ratio(self, recorded):
        """A calibration sees nothing of it."""
        del recorded
        return 1.0

    def sight(self, recorded, loss_ratio, with_alike=False):
        """The signal is that of the turn."""
        assert with_alike
        turn = np.hypot(*(recorded.hidden[0]["parameters"][key] for key in ("yaw", "tilt")))
        return Sight(PER_RADIAN * turn, 0.1, loss_ratio, self.alike)

    def case(self, kind, hidden, sight):
        """The case holds what was hidden and seen."""
        return SimpleNamespace(kind=kind, hidden=hidden, sight=sight)


@pytest.fixture
def drawn(monkeypatch):
    """Draw cases of worlds in which a turn can be taken for other effects."""
    monkeypatch.setattr(draw, "played_plan", lambda *given: SimpleNamespace(effects=("frame_rotation",)))
    monkeypatch.setattr(draw, "DrawnWorld", StandInWorld)

    def of(alike, count=40):
        monkeypatch.setattr(StandInWorld, "alike", alike, raising=False)
        return [drawn_case(replace(REQUEST, number=number)) for number in range(count)]

    return of


def test_what_another_effect_resembles_is_hidden_too_weak_to_be_told_from_it(drawn):
    """Signals that are drawn beside another effect of cosine 0.99 fill the range from 8 to 28 units of noise.

    Of a signal of 28 the other effect leaves 4, from which data tell the two apart.
    """
    cases = drawn({"frame_rotation": 1.0, "gain_crosstalk": 0.99})
    assert all(one.case is not None and one.case.sight.imitators for one in cases)
    signals = np.array([one.case.sight.signal for one in cases])
    largest = TOLD_APART / np.sqrt(1.0 - 0.99**2)
    assert LEAST_SIGNAL <= signals.min() < 10.0
    assert 0.85 * largest < signals.max() < largest
    # a few strengths are drawn below what can be seen; hardly any draw is lost otherwise
    assert sum(sum(one.rejected.values()) for one in cases) < len(cases)


def test_an_effect_that_only_resembles_itself_is_never_ambiguous(drawn):
    """A cosine of an effect with itself says nothing, and one of 0.8 leaves too much wherever it can be seen."""
    for alike in ({"frame_rotation": 1.0}, {"frame_rotation": 1.0, "gain_crosstalk": 0.8}):
        assert all(one.case is None for one in drawn(alike, count=3))


def test_a_weaker_effect_keeps_its_form():
    """Strengths are multiplied; places, times and what else no strength states stay."""
    for name in ("frame_rotation", "delamination", "clock_skew"):
        stated = HIDDEN_EFFECTS[name].STRENGTHS["weak"]
        numbers = drawn_parameters(name, 3)
        weaker = weakened(name, numbers, 0.5)
        assert weaker == {key: value * (0.5 if key in stated else 1.0) for key, value in numbers.items()}
