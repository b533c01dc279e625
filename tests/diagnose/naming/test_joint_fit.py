"""When a joint fit ends: at its own best, or far behind another explanation that it cannot reach any more."""

import pytest
from tied_worlds import START, effect, recorded

from tactiledata.diagnose.naming import joint_fit as module
from tactiledata.diagnose.naming.joint_fit import joint_fit
from tactiledata.diagnose.naming.linearise import Linearised
from tactiledata.diagnose.naming.parameters import joint_model
from tactiledata.diagnose.touches.whitened import WhitenedTouches


@pytest.fixture(scope="module")
def fitting():
    """fit(settings, to_beat): of touches of a gel that relaxes, and how many rounds it took."""
    white = WhitenedTouches.of(recorded(effect("relaxation", share=0.4, time=1.0), touches=8, slide=1e-3))

    def fit(settings, **to_beat):
        start = joint_model(START, settings, len(white.starts), len(white.simulation_errors))
        rounds = []
        with pytest.MonkeyPatch.context() as patch:
            slopes = Linearised.slopes
            patch.setattr(Linearised, "slopes", lambda self, *at: rounds.append(1) or slopes(self, *at))
            found = joint_fit(white, start, **to_beat)
        return found, len(rounds)

    return fit


def test_what_is_far_behind_is_left(fitting):
    """Another explanation that costs much less than this one ever will."""
    start = effect("relaxation", share=0.1, time=0.5)
    whole, many = fitting(start)
    left, few = fitting(start, to_beat=whole.cost - 1e5)
    assert few < many
    assert left.cost > whole.cost


def test_the_wrong_effect_is_as_far_behind_whether_it_is_left_or_not(fitting):
    """A yielding arm in place of the relaxing gel is as far behind, whether it is left or not."""
    wrong = effect("arm_compliance", translation=1e-5)
    best, _ = fitting(effect("relaxation", share=0.1, time=0.5))
    whole, _ = fitting(wrong)
    left, _ = fitting(wrong, to_beat=best.cost)
    assert left.cost >= whole.cost > best.cost + module.BEHIND


def test_what_is_near_or_may_come_near_is_led_to_its_end(fitting):
    """A fit that is near, or may come near, is led to its end, also if a round stalls on the way."""
    start = effect("relaxation", share=0.1, time=0.5)
    whole, many = fitting(start)
    again, rounds = fitting(start, to_beat=whole.cost)
    assert (again.cost, rounds) == (whole.cost, many)
