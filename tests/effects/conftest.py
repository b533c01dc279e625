"""Touches and simulators that the tests of effects share."""

import dataclasses

import numpy as np
import pytest
from example_effect import EXAMPLE, add_by_line

from tactiledata.effects import EFFECTS
from tactiledata.effects.closed_form.ball_on_layer import BallOnLayer
from tactiledata.effects.simulate.reference_touch import reference_touch
from tactiledata.effects.simulate.setting import EffectSetting
from tactiledata.effects.simulate.simulator import with_effects


@pytest.fixture
def name(request, monkeypatch):
    """The name of an effect; the example's is in the table as long as its test takes."""
    if request.param == EXAMPLE:
        add_by_line(monkeypatch)
    return request.param


@pytest.fixture(scope="session")
def touch():
    """The reference touch; nobody may write into it."""
    touch = reference_touch()
    for field in dataclasses.fields(touch):
        value = getattr(touch, field.name)
        if isinstance(value, np.ndarray):
            value.setflags(write=False)
    return touch


@pytest.fixture(scope="session")
def play(touch):
    """play(effect, touch=…, **values): the state at the end of a touch on the ball on a layer."""

    def played(effect="", on=touch, base=BallOnLayer, **values):
        return with_effects(base, [EffectSetting(effect, values)] if effect else []).play(on)

    return played


@pytest.fixture(scope="session")
def medium():
    """Values of an effect at half of its plausible range, shapes at their defaults."""

    def values(name):
        return {
            parameter.name: max(parameter.plausible, key=abs) / 2
            for parameter in EFFECTS[name].parameters
            if parameter.null is not None
        }

    return values


@pytest.fixture(scope="session")
def moved():
    """moved(touch, seconds=…, depth=…, x=…, y=…, **fields): the touch on another path, straight down."""

    def another(touch, seconds, depth, x=0.0, y=0.0, **fields):
        n = len(seconds)
        poses = np.tile(np.eye(4), (n, 1, 1))
        poses[:, 0, 3], poses[:, 1, 3], poses[:, 2, 3] = x, y, -np.asarray(depth)
        arrays = {
            "gravity": np.tile([0.0, 0.0, -9.81], (n, 1)),
            "joints": np.zeros((n, 6)),
            "powered": np.asarray(seconds, dtype=float),
            "earlier_depth": np.zeros(n),
            "earlier_contacts": np.zeros(n),
        }
        return dataclasses.replace(touch, seconds=np.asarray(seconds, float), poses=poses, **{**arrays, **fields})

    return another
