"""Playing trajectories: what the gel answered before is used again only where the same is asked of it."""

import dataclasses

import numpy as np
from tied_worlds import START, effect, recorded

from tactiledata.effects.simulate.simulator import Simulator


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
    """Ten gains of the sensor beside a yielding arm need one balance of springs and gel for each trajectory."""
    asked = []
    contact = Simulator.contact_near
    monkeypatch.setattr(Simulator, "contact_near", lambda self, *at: asked.append(at) or contact(self, *at))
    cases = recorded(touches=8)
    asked.clear()
    cases = dataclasses.replace(cases)
    for gain in np.linspace(0.0, 0.02, 10):
        cases.play(START, [*effect("arm_compliance", translation=1e-5), *effect("gain_crosstalk", xx=gain)])
    assert len(asked) == 8


def test_a_balance_that_is_near_is_found_sooner_and_is_the_same():
    """The balance beside a softer spot is as if looked for anew, and asks the gel fewer questions."""
    cases = recorded(touches=8, slide=1e-3)
    arm = effect("arm_compliance", translation=1e-5)
    before = cases.played(START, arm)
    spot = [*arm, *effect("soft_region", normal_loss=0.1, x=1e-3, y=0.0, radius=2e-3)]
    for settings, share in ((effect("arm_compliance", translation=1.01e-5), 0.7), (spot, 1.0)):
        asked = []
        for near in (before, None):
            fresh, questions = counted(cases)
            asked.append((fresh.play(START, settings, near=near), len(questions)))
        (found, few), (expected, many) = asked
        np.testing.assert_allclose(found, expected, atol=1e-5 * np.abs(expected).max())
        assert few < share * many


def test_what_is_played_near_does_not_depend_on_what_was_played_last():
    """Wrenches that start from a stated balance do not depend on what was simulated in between."""
    cases = recorded(touches=8, slide=1e-3)
    arm, stiffer = (effect("arm_compliance", translation=one) for one in (1e-5, 0.9e-5))
    before = cases.played(START, arm)
    first = cases.play(START, stiffer, near=before)
    cases.play(START, stiffer)
    np.testing.assert_array_equal(cases.play(START, stiffer, near=before), first)
    assert cases.play(START, arm, near=before).tobytes() == before.wrench.tobytes()


def counted(cases):
    """The trajectories on a base that tells how often it is asked."""
    questions = []

    def base(material):
        start = cases.base(material)

        def answer(touch):
            response = start(touch)
            respond = response.respond

            class Counted:
                def respond(self, *asked):
                    questions.append(1)
                    return respond(*asked)

            return Counted()

        return answer

    return dataclasses.replace(cases, base=base), questions
