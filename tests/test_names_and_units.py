"""Names are looked up lazily and units are one table."""

import subprocess
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tactiledata.errors import UnknownName
from tactiledata.registry import Registry
from tactiledata.units import FIELDS, SIGNAL_COLUMNS, TO_METRES, metres, signal_units


def test_listing_names_imports_nothing():
    """A table may name modules that do not exist, until such a name is looked up."""
    table = Registry("format", {"good": "math:sqrt", "bad": "no_such_package.at_all:Thing"})
    assert list(table) == ["good", "bad"]
    assert len(table) == 2
    assert "bad" in table
    assert table["good"](9.0) == 3.0
    with pytest.raises(ModuleNotFoundError):
        table["bad"]


def test_an_unknown_name_is_a_key_error_with_a_hint():
    """It lists what there is; ``get`` and ``in`` behave as those of a mapping."""
    table = Registry("format", {"folder": "math:sqrt"})
    with pytest.raises(UnknownName, match=r"unknown format 'foldr'.*Did you mean folder"):
        table["foldr"]
    assert table.get("foldr") is None
    assert "foldr" not in table


def test_the_table_is_a_copy():
    """Changing the dictionary afterwards changes no family."""
    source = {"a": "math:sqrt"}
    table = Registry("thing", source)
    source["b"] = "math:sin"
    assert list(table) == ["a"]


def test_other_packages_add_and_never_replace(tmp_path):
    """An entry point adds a member; one with a name of ours does not win."""
    (tmp_path / "guest.py").write_text("mine = 'guest'\n")
    info = tmp_path / "guest-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: guest\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[things]\nours = guest:mine\nnew = guest:mine\n")
    program = (
        "from tactiledata.registry import Registry\n"
        "table = Registry('thing', {'ours': 'math:pi'}, 'things')\n"
        "assert list(table) == ['ours', 'new'], list(table)\n"
        "assert table['ours'] > 3 and table['new'] == 'guest' and 'new' in table\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True, check=False,
        env={"PYTHONPATH": f"{tmp_path}:{':'.join(sys.path)}"},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr


@given(st.floats(-1e6, 1e6), st.sampled_from(sorted(TO_METRES)))
def test_lengths_become_metres(value, unit):
    """A length scales with its unit; metres stay as they are."""
    assert metres(value, unit) == value * TO_METRES[unit]
    assert metres(value, "m") == value


def test_lengths_agree_with_one_another():
    """Ten millimetres are a centimetre, an inch is 25.4 mm, a thousand micrometres a millimetre."""
    assert metres(10, "mm") == pytest.approx(metres(1, "cm"))
    assert metres(1, "in") == pytest.approx(metres(25.4, "mm"))
    assert metres(1000, "um") == pytest.approx(metres(1, "mm"))


@pytest.mark.parametrize("unit", ["", "M", "MM", "km", "metre"])
def test_a_unit_that_is_not_known_is_refused(unit):
    """No unit is guessed."""
    with pytest.raises(UnknownName, match="length unit"):
        metres(1.0, unit)


def test_every_column_of_a_known_signal_has_a_unit_and_a_label():
    """Signals known by name have SI units throughout; other columns say that theirs is not known."""
    for name, columns in SIGNAL_COLUMNS.items():
        assert "?" not in signal_units(columns), name
        assert all(FIELDS[column].label for column in columns)
    assert signal_units(("fx", "gain")) == ("N", "?")
    assert signal_units(()) == ()
