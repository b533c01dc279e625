"""What every effect of the table keeps."""

import dataclasses
import importlib
import math
import pkgutil

import numpy as np
import pytest
from example_effect import EVERY_EFFECT

from tactiledata import effects
from tactiledata.diagnose.naming.signatures import shape_grids
from tactiledata.effects import EFFECTS
from tactiledata.effects.base import CONTACT_SLOTS, SLOTS
from tactiledata.effects.closed_form.ball_on_layer import BallOnLayer
from tactiledata.effects.closed_form.on_layer import OnLayer
from tactiledata.effects.parameter import DIMENSIONS
from tactiledata.effects.simulate.reference_touch import largest_changes
from tactiledata.effects.simulate.setting import EffectSetting, in_order
from tactiledata.effects.simulate.simulator import with_effects
from tactiledata.effects.touch.response import GelVariant
from tactiledata.effects.touch.state import TouchState
from tactiledata.effects.touch.touch import Touch
from tactiledata.errors import UnknownName, UsageError

every_effect = pytest.mark.parametrize("name", EVERY_EFFECT, indirect=True)


def null_values(name, rng):
    """Strengths at null, shapes anywhere."""
    return {p.name: p.null if p.null is not None else rng.uniform(*p.bounds) for p in EFFECTS[name].parameters}


@pytest.mark.parametrize("name", EFFECTS._table)
def test_it_lies_in_the_folder_of_its_slot(name):
    """The slot of an effect of this package is the name of its folder."""
    assert EFFECTS[name].slot == EFFECTS[name].__module__.split(".")[-2]


@every_effect
def test_it_describes_itself(name):
    """Slot, words and look-alikes are there; what it needs are optional fields of a touch."""
    effect = EFFECTS[name]
    assert effect.name == name
    assert effect.slot in SLOTS
    for text in (effect.title, effect.distinguishing_trial, effect.detectability, effect.reference):
        assert text.strip()
    assert any(character.isdigit() for character in effect.detectability)
    assert "Source: " in effect.__doc__
    assert effect.look_alikes
    assert set(effect.look_alikes) <= set(EFFECTS) - {name}
    optional = {field.name for field in dataclasses.fields(Touch) if field.default is None}
    assert set(effect.needs) <= optional


@every_effect
def test_parameters_are_sound(name):
    """Units are known; the null is plausible, what is plausible in the bounds, grids too; no design point is null."""
    effect = EFFECTS[name]
    names = [parameter.name for parameter in effect.parameters]
    assert len(set(names)) == len(names)
    assert any(parameter.null is not None for parameter in effect.parameters)
    for parameter in effect.parameters:
        low, high = parameter.bounds
        assert parameter.unit in DIMENSIONS
        assert parameter.meaning
        assert parameter.source
        assert low <= parameter.plausible[0] < parameter.plausible[1] <= high
        assert low <= parameter.default <= high
        assert all(low <= value <= high for value in parameter.grid)
        if parameter.null is None:
            assert parameter.grid
        else:
            assert parameter.plausible[0] <= parameter.null <= parameter.plausible[1]
            assert 0 < parameter.deviation <= max(map(abs, parameter.plausible))
            assert parameter.log_prior(parameter.null) == 0.0
        assert parameter.log_prior(high + 1.0) == -math.inf
    assert set(effect.designs) <= {parameter.name for parameter in effect.parameters if parameter.null == 0.0}
    assert all(0.0 not in places for places in effect.designs.values())
    assert EFFECTS[name]().variant({}).together_with(GelVariant()) == EFFECTS[name]().variant({})
    for parameter, places in effect.designs.items():
        assert all(EFFECTS[name]().variant({parameter: place}) != GelVariant() for place in places)


@every_effect
def test_shapes_that_no_screen_varies_default_to_their_grid_value(name):
    """A shape with fewer than two grid values keeps its default in a screen, which is then its only grid value."""
    effect = EFFECTS[name]
    fixed = [p for p in effect.parameters if p.null is None and len(p.grid) < 2]
    assert [p.grid for p in fixed] == [(p.default,) for p in fixed]
    varied = {shape for shapes in shape_grids(effect) for shape in shapes}
    assert not varied & {p.name for p in fixed}


@every_effect
def test_null_is_the_identity(name, touch):
    """Null strengths with any shapes give back the very same object."""
    state = TouchState.start(touch, BallOnLayer(touch))
    rng = np.random.default_rng(1)
    assert EFFECTS[name]().apply(state, {}) is state
    assert EFFECTS[name]().apply(state, null_values(name, rng)) is state


def test_all_effects_at_null_leave_every_bit(touch):
    """All of them together, at null, give the bytes of the plain simulation, zeroed or not."""
    rng = np.random.default_rng(2)
    settings = [EffectSetting(name, null_values(name, rng)) for name in EFFECTS]
    for tare in (None, np.arange(len(touch)) < 8):
        on = dataclasses.replace(touch, tare=tare)
        plain = with_effects(BallOnLayer, []).play(on)
        both = with_effects(BallOnLayer, settings).play(on)
        assert both.wrench.tobytes() == plain.wrench.tobytes()
        assert both.moved_poses.tobytes() == plain.moved_poses.tobytes()


@every_effect
def test_null_is_approached_smoothly(name, touch, play, medium):
    """A millionth of a medium strength changes at most ten millionths; the null is no special case of the code."""
    plain = play().wrench
    for parameter, value in medium(name).items():
        full = np.abs(play(name, **{parameter: value}).wrench - plain).max()
        tiny = np.abs(play(name, **{parameter: 1e-6 * value}).wrench - plain).max()
        assert tiny <= 1e-5 * full + 1e-9, parameter


@every_effect
def test_it_does_something_somewhere(name, play, medium):
    """At medium strength the reference touch changes by more than rounding."""
    if name == "clipping":  # the limit lies above the touch's force; noise alone shows
        assert largest_changes(EFFECTS[name]())["noise"] > 0.1
    change = np.abs(play(name, **medium(name)).wrench - play().wrench).max()
    assert change > 1e-4


@every_effect
def test_it_is_pure_and_deterministic(name, touch, play, medium):
    """The touch, which is read-only, is untouched, the state before too, and twice the same comes out."""
    state = TouchState.start(touch, BallOnLayer(touch))
    state = state.with_reading(state.contact.wrench)
    before = {field.name: np.copy(getattr(state, field.name)) for field in dataclasses.fields(state)[2:]}
    EFFECTS[name]().apply(state, medium(name))
    assert all(np.array_equal(getattr(state, key), value) for key, value in before.items())
    assert play(name, **medium(name)).wrench.tobytes() == play(name, **medium(name)).wrench.tobytes()


@every_effect
def test_frames_that_are_unknown_stay_unknown(name, touch, medium):
    """A frame that the base could not solve is NaN at the end, and spoils no other."""

    class Holey(BallOnLayer):
        def respond(self, offset, shift, friction):
            answer = super().respond(offset, shift, friction)
            wrench = answer.wrench.copy()
            wrench[[50, 100]] = np.nan
            return dataclasses.replace(answer, wrench=wrench)

    wrench = with_effects(Holey, [EffectSetting(name, medium(name))]).play(touch).wrench
    bad = np.isnan(wrench).any(axis=1)
    assert np.flatnonzero(bad).tolist() == [50, 100]


@every_effect
def test_missing_covariates_are_said(name, touch, medium):
    """Without a field that it needs, it says which; fields that it does not name may be missing."""
    effect = EFFECTS[name]
    optional = {field.name for field in dataclasses.fields(Touch) if field.default is None}
    simulator = with_effects(BallOnLayer, [EffectSetting(name, medium(name))])
    simulator.play(dataclasses.replace(touch, **dict.fromkeys(optional - set(effect.needs))))
    for field in effect.needs:
        with pytest.raises(UsageError, match=f"depends on '{field}'"):
            simulator.play(dataclasses.replace(touch, **{field: None}))


@every_effect
def test_wrong_values_are_refused(name):
    """Unknown parameters, numbers out of bounds, and what is no number."""
    parameter = EFFECTS[name].parameters[0]
    with pytest.raises(UnknownName, match=f"parameter of effect '{name}' 'nonsense'"):
        EffectSetting(name, {"nonsense": 1.0})
    for value in (parameter.bounds[1] * 1.01 + 1e-9, parameter.bounds[0] - 1.0, math.nan, math.inf, "0", None, True):
        with pytest.raises(UsageError, match=f"{parameter.name} of effect '{name}'"):
            EffectSetting(name, {parameter.name: value})


def test_unknown_effects_and_places_are_refused():
    """A slip of the pen gets the right name proposed."""
    with pytest.raises(UnknownName, match="Did you mean relaxation"):
        EffectSetting("relaxatoin", {})
    with pytest.raises(UnknownName, match="place of an effect"):
        EffectSetting("thickness", {}, {"camera": "left"})


def test_slots_decide_the_order():
    """Whatever the order given, effects act by slot and then as the table has them."""
    names = [setting.effect for setting in in_order(EffectSetting(name) for name in reversed(list(EFFECTS)))]
    assert names == list(EFFECTS)
    assert [EFFECTS[name].slot for name in names] == sorted((EFFECTS[name].slot for name in names), key=SLOTS.index)


def test_springs_alone_are_searched_for_their_balance():
    """Only arm and stem depend on the wrench that they change."""
    assert [name for name in EFFECTS if EFFECTS[name].feeds_back] == ["arm_compliance", "stem_bending"]


def test_what_effects_hand_on_cannot_be_changed():
    """Every dataclass of the package is frozen: a state, a touch or a setting may be shared."""
    for module in pkgutil.walk_packages(effects.__path__, "tactiledata.effects."):
        for name, member in vars(importlib.import_module(module.name)).items():
            if dataclasses.is_dataclass(member) and member.__module__ == module.name:
                assert member.__dataclass_params__.frozen, name


def test_a_closed_form_without_an_answer_is_none(touch):
    """A class that does not say how it responds cannot be made."""
    with pytest.raises(TypeError, match="abstract"):
        OnLayer(touch)


def test_the_first_four_slots_are_in_contact():
    """Effects of time and sensor work on the answer of the gel, all others change what it is asked."""
    assert CONTACT_SLOTS == ("pose", "geometry", "material", "interface")
    assert (*CONTACT_SLOTS, "time", "sensor") == SLOTS


def test_where_the_gel_engine_plays_beforehand():
    """The design points that the descriptions of the effects tell; answers that are kept belong to these."""
    assert {name: dict(EFFECTS[name].designs) for name in EFFECTS if EFFECTS[name].designs} == {
        "mount_offset": {"radius_error": (-0.03, 0.03)},
        "thickness": {"error": (-0.15, 0.15)},
        "dome": {"curvature": (-2000.0, 2000.0)},
        "strain_stiffening": {"c20": (-0.05, 0.2), "c30": (0.05,)},
        "skin": {"excess": (2e-4, 6e-4)},
    }


@every_effect
def test_a_variant_is_that_of_its_own_parameters(name):
    """Parameters that are not given are null: a gel that is told one of them is nominal but for it."""
    effect = EFFECTS[name]()
    both = effect.variant({parameter: places[0] for parameter, places in effect.designs.items()})
    alone = GelVariant()
    for parameter, places in effect.designs.items():
        alone = alone.together_with(effect.variant({parameter: places[0]}))
    if effect.designs:
        assert both == alone
        assert effect.variant({}) == GelVariant()
