"""What is asked of the simulation below: as often as it can answer otherwise, no more."""

from __future__ import annotations

import numpy as np
import pytest

from tactiledata.effects.closed_form.ball_on_layer import BallOnLayer
from tactiledata.effects.touch.state import TouchState


class Counted(BallOnLayer):
    """Counts what it is asked."""

    asked = 0

    def respond(self, offset, shift, friction):
        type(self).asked += 1
        return super().respond(offset, shift, friction)


@pytest.fixture
def state(touch):
    Counted.asked = 0
    return TouchState.start(touch, Counted(touch))


def test_what_neither_moves_nor_rubs_asks_nothing_again(state):
    ones, wrench = np.ones(len(state.touch)), np.ones((len(state.touch), 6))
    plain = state.contact.wrench
    changed = state.stiffened(2.0 * ones).with_elastic(wrench).with_interface(wrench).with_reading(wrench)
    np.testing.assert_array_equal(changed.contact.wrench, (plain + wrench) * 2.0 + wrench)
    assert Counted.asked == 1


@pytest.mark.parametrize(
    "change",
    [
        lambda state: state.moved(1e-4),
        lambda state: state.moved(0.0, [1e-4, 0.0]),
        lambda state: state.rubbed(0.5 * np.ones(len(state.touch))),
    ],
    ids=["deeper", "along", "smoother"],
)
def test_what_moves_or_rubs_asks_anew(state, change):
    before = state.contact.wrench
    after = change(state.with_elastic(np.zeros_like(before)))
    fresh = change(TouchState.start(state.touch, Counted(state.touch)))
    assert np.abs(after.contact.wrench - before).max() > 1e-4
    assert after.contact.wrench.tobytes() == fresh.contact.wrench.tobytes()
    assert Counted.asked == 3
