"""Values with intervals and units as sentences have them."""

import pytest

from tactiledata.diagnose.residuals.wording import departs, signed_change, with_interval


@pytest.mark.parametrize("half_width", [0.0, float("nan"), float("inf"), 0.5])
@pytest.mark.parametrize("unit", ["", "1", "?"])
def test_a_unit_that_is_1_or_not_known_is_left_out(unit, half_width):
    """No unit stands behind a number that has none, whether the number has an interval or not."""
    text = "3.0 ± 0.5" if half_width == 0.5 else "3.0"
    assert with_interval(3.0, half_width, unit) == text
    assert signed_change("E", 3.0, half_width, unit) == f"E rises by {text}"


@pytest.mark.parametrize(("half_width", "text"), [(0.0, "3.0 mm"), (float("nan"), "3.0 mm"), (0.5, "3.0 ± 0.5 mm")])
def test_a_known_unit_stands_with_and_without_an_interval(half_width, text):
    """A unit in words or symbols follows the number, and its interval where there is one."""
    assert with_interval(3.0, half_width, "mm") == text


def test_no_change_falls_and_lies_below():
    """A change of 0 falls and a size of 0 lies below; negative ones lose their sign to the verb."""
    assert signed_change("E", 0.0, 2.0, "%") == "E falls by 0 ± 2 %"
    assert signed_change("E", -11.0, 2.0, "%") == "E falls by 11 ± 2 %"
    assert departs("fz", 0.0, 0.3, "N") == "measured fz is 0.0 ± 0.3 N below the simulated one"
