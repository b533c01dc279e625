"""Numbers of effects: as docs/effect-numbers.md has them, and in an order that makes sense."""

import math

import pytest
from effect_numbers import PAGE, page

from tactiledata.effects import EFFECTS
from tactiledata.effects.parameter import FARTHER, shape, strength
from tactiledata.errors import UsageError

PARAMETERS = [(name, parameter) for name in EFFECTS for parameter in EFFECTS[name]().parameters]
WEIGHT = strength("weight", "N", "a force", bounds=(-4.0, 8.0), plausible=(-1.0, 2.0), deviation=0.5, source="by hand")
TIME = shape("time", "s", "a time", default=1.0, bounds=(0.1, 10.0), grid=(0.1, 1.0), source="by hand")


def test_the_page_has_every_number():
    """No number of an effect changes unless the page does: ``python tests/effects/effect_numbers.py``."""
    assert PAGE.read_text(encoding="utf-8") == page()


@pytest.mark.parametrize(("name", "parameter"), PARAMETERS, ids=[f"{n}-{p.name}" for n, p in PARAMETERS])
def test_ranges_lie_within_one_another(name, parameter):
    """Plausible values lie within the bounds, the default within both, a grid ascends within the bounds."""
    low, high = parameter.bounds
    assert low < high
    assert low <= parameter.plausible[0] < parameter.plausible[1] <= high
    assert parameter.plausible[0] <= parameter.default <= parameter.plausible[1]
    assert list(parameter.grid) == sorted(set(parameter.grid))
    assert all(low <= value <= high for value in parameter.grid)
    if parameter.null is not None:
        # of what is plausible, a prior leaves at least a tenth and at most all within a deviation
        widest = max(abs(parameter.plausible[0]), abs(parameter.plausible[1]))
        assert 0.1 * widest <= parameter.deviation <= widest


@pytest.mark.parametrize(
    ("value", "beyond"),
    [(0.0, 0.0), (2.0, 0.0), (4.0, 0.0), (5.0, 1.0), (8.0, 4.0), (-1.0, 0.0), (-2.0, 0.0), (-2.5, 0.5), (-4.0, 2.0)],
)
def test_what_is_beyond_twice_the_plausible_range(value, beyond):
    """The range -1 to 2 is left at -2 and at 4."""
    assert FARTHER == 2.0
    assert WEIGHT.beyond(value) == beyond


def test_a_range_of_positive_numbers_is_left_at_its_own_lower_end():
    """Twice the lower end of a range that does not hold 0 would lie inside it."""
    assert TIME.beyond(0.1) == 0.0
    assert TIME.beyond(0.05) == pytest.approx(0.05)
    assert TIME.beyond(20.0) == 0.0
    assert TIME.beyond(21.0) == 1.0


def test_the_prior_of_a_strength_is_normal_and_that_of_a_shape_flat():
    """One deviation from nothing costs a half, two cost two; beyond the bounds nothing is possible."""
    assert [WEIGHT.log_prior(value) for value in (0.0, 0.5, -0.5, 1.0)] == [0.0, -0.5, -0.5, -2.0]
    assert WEIGHT.log_prior(8.0) == -128.0
    assert WEIGHT.log_prior(8.1) == WEIGHT.log_prior(-4.1) == -math.inf
    assert TIME.log_prior(0.1) == TIME.log_prior(10.0) == 0.0
    assert TIME.log_prior(0.09) == TIME.log_prior(10.1) == -math.inf


@pytest.mark.parametrize("value", [-4.01, 8.01, math.nan, math.inf, True, "1", None])
def test_values_outside_the_bounds_are_refused(value):
    """A number beyond the bounds, no number, and a truth value are wrong usage; the ends are allowed."""
    assert (WEIGHT.check(-4, "e"), WEIGHT.check(8.0, "e")) == (-4.0, 8.0)
    with pytest.raises(UsageError, match="from -4 to 8"):
        WEIGHT.check(value, "e")


def test_what_can_be_believed_includes_the_ends():
    """The plausible range from -1 to 2 includes both ends."""
    assert [WEIGHT.is_plausible(value) for value in (-1.01, -1.0, 0.0, 2.0, 2.01)] == [False, True, True, True, False]


def test_a_refusal_says_what_can_be_believed():
    """Bounds, unit, meaning and the plausible range are told; the name and the value travel with the error."""
    with pytest.raises(UsageError, match=r"weight of effect 'e' is 9\.0") as found:
        WEIGHT.check(9.0, "e")
    for part in ("a number from -4 to 8 [N]: a force", "between -1 and 2."):
        assert part in str(found.value)


AXES = {
    **{("cable_drag", f"f{axis}"): f"force along {axis} of" for axis in "xyz"},
    **{("cable_drag", f"t{axis}"): f"torque about {axis} of" for axis in "xyz"},
    **{("sensor_drift", f"f{axis}"): f"force along {axis}" for axis in "xyz"},
    **{("sensor_drift", f"t{axis}"): f"torque about {axis}" for axis in "xyz"},
    **{("tool_weight", f"moment_{axis}"): f"along {axis} of" for axis in "xyz"},
    **{("frame_rotation", f"tilt_{axis}"): f"about {axis} of" for axis in "xy"},
    **{("gain_crosstalk", axis + axis): f"error of the gain of {axis}" for axis in "xyz"},
    **{
        ("gain_crosstalk", row + column): f"share of {column} that shows in {row}"
        for row, column in ("xy", "xz", "yx", "yz", "zx", "zy")
    },
    **{("gain_crosstalk", f"m{axis}"): f"error of the gain of the torque about {axis}" for axis in "xyz"},
    **{
        ("gain_crosstalk", f"m{row}_{column}"): f"torque about {row} that a force along {column} shows"
        for row in "xyz"
        for column in "xyz"
    },
    **{
        ("gain_crosstalk", f"{row}_m{column}"): f"force along {row} that a torque about {column} shows"
        for row in "xyz"
        for column in "xyz"
    },
}
"""What the meaning of a component says."""


def test_components_are_told_by_their_axis():
    """A component named after an axis says that axis, and cross-talk which of the two shows in the other."""
    meanings = {(name, parameter.name): parameter.meaning for name, parameter in PARAMETERS}
    assert [key for key, words in AXES.items() if words not in meanings[key]] == []
    assert [name for name, parameter in PARAMETERS if name == "gain_crosstalk"] == ["gain_crosstalk"] * 31
