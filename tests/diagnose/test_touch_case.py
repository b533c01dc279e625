"""Playing trajectories: what the gel answered before is used again only where the same is asked of it."""

import dataclasses

import numpy as np
from tied_worlds import START, effect, recorded

from tactiledata.effects.simulator import Simulator


def test_what_is_played_before_changes_nothing():
    """Materials, contacts, sensors and offsets in any order give the bytes of a set that has played nothing yet."""
    cases = recorded(touches=8, slide=1e-3)
    deeper = np.linspace(-1e-5, 1e-5, 8)
    asked = [
        (START, effect("arm_compliance", translation=1e-5), None),
        (START, [*effect("arm_compliance", translation=1e-5), *effect("gain_crosstalk", zz=0.02)], None),
        (START, effect("gain_crosstalk", zz=0.02), None),
        (START, effect("gain_crosstalk", zz=0.02), deeper),
        (dataclasses.replace(START, friction=0.5), effect("gain_crosstalk", zz=0.02), deeper),
        (START, [], None),
    ]
    for one in [*asked, *asked[::-1]]:
        np.testing.assert_array_equal(cases.play(*one), dataclasses.replace(cases).play(*one))


def test_the_gel_is_asked_once_for_all_that_the_sensor_does(monkeypatch):
    """Ten gains of the sensor beside a yielding arm: one balance of springs and gel for each trajectory."""
    asked = []
    contact = Simulator.contact
    monkeypatch.setattr(Simulator, "contact", lambda self, touch: asked.append(touch) or contact(self, touch))
    cases = recorded(touches=8)
    asked.clear()
    cases = dataclasses.replace(cases)
    for gain in np.linspace(0.0, 0.02, 10):
        cases.play(START, [*effect("arm_compliance", translation=1e-5), *effect("gain_crosstalk", xx=gain)])
    assert len(asked) == 8
