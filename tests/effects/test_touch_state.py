"""What is asked of the simulation below: as often as it can answer otherwise, no more."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from tactiledata.effects import EFFECTS
from tactiledata.effects.closed_form.ball_on_layer import BallOnLayer
from tactiledata.effects.touch.response import ContactResponse
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
    """Changes of stiffness, force and reading are applied to the first answer of the gel, which is asked once."""
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
    """A change of place or friction asks the gel again, and gives bit for bit what a new state gives."""
    before = state.contact.wrench
    after = change(state.with_elastic(np.zeros_like(before)))
    fresh = change(TouchState.start(state.touch, Counted(state.touch)))
    assert np.abs(after.contact.wrench - before).max() > 1e-4
    assert after.contact.wrench.tobytes() == fresh.contact.wrench.tobytes()
    assert Counted.asked == 3


def test_a_state_to_which_nothing_was_added_has_every_bit_of_the_answer(touch):
    """The state has every bit of the answer, the sign of a zero included."""
    answered = np.full((len(touch), 6), -0.0)

    class Zero(BallOnLayer):
        def respond(self, offset, shift, friction):
            return dataclasses.replace(super().respond(offset, shift, friction), wrench=answered)

    assert TouchState.start(touch, Zero(touch)).contact.wrench.tobytes() == answered.tobytes()


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("static_friction", {"excess": 0.3, "ageing": 0.1, "length": 5e-4}),
        ("partial_slip", {"share": 0.7}),
        ("relaxation", {"share": 0.3, "time": 1.0}),
    ],
)
def test_half_the_friction_by_an_effect_is_half_of_mu(touch, name, values):
    """What acts before, and rubs by a half, is to a later effect as a gel of half the coefficient."""
    smooth = dataclasses.replace(touch, material=dataclasses.replace(touch.material, friction=0.4))
    effect = EFFECTS[name]()
    rubbed = TouchState.start(touch, BallOnLayer(touch)).rubbed(np.full(len(touch), 0.5))
    found, wanted = (effect.apply(state, values) for state in (rubbed, TouchState.start(smooth, BallOnLayer(smooth))))
    assert touch.material.friction == 0.8
    np.testing.assert_allclose(found.wrench, wanted.wrench, atol=1e-12)


def test_friction_is_never_negative(touch):
    """A factor below 0 counts as 0."""
    state = TouchState.start(touch, BallOnLayer(touch)).rubbed(np.full(len(touch), -0.5))
    assert not state.friction.any()


def test_a_frame_that_could_not_be_solved_does_not_touch():
    """An area that is unknown is no contact; its radius is unknown, too."""
    area = np.array([0.0, np.pi, np.nan])
    nothing = np.zeros(3)
    answer = ContactResponse(np.zeros((3, 6)), area, np.zeros((3, 2)), nothing, nothing > 0, nothing)
    assert answer.touching.tolist() == [False, True, False]
    np.testing.assert_array_equal(answer.radius, [0.0, 1.0, np.nan])


@pytest.mark.parametrize(
    ("name", "values", "played"),
    [
        ("strain_stiffening", {"c20": 0.1}, 2),
        ("strain_stiffening", {"c30": 0.02}, 1),
        ("strain_stiffening", {"c20": 0.1, "c30": 0.02}, 3),
        ("mount_offset", {"deeper": 1e-4}, 0),
        ("mount_offset", {"radius_error": 0.01}, 2),
    ],
)
def test_only_what_is_not_null_is_played_at_its_design_points(touch, name, values, played):
    """The gel engine's answers are fetched for those parameters alone."""
    asked = []

    class Told(BallOnLayer):
        def difference(self, variant):
            asked.append(variant)
            return super().difference(variant)

    EFFECTS[name]().apply(TouchState.start(touch, Told(touch)), values)
    assert len(asked) == played
