"""What a record holds where it is not told: units from the table, stamps that say "none"; shapes that must agree."""

import numpy as np
import pytest

from tactiledata.contract.records import Finding, Image, Signal, Stamps
from tactiledata.contract.take import findings_of, findings_table

STAMPS = Stamps(np.arange(2, dtype=np.int64))


def test_units_come_from_the_table_only_where_none_are_given():
    """Forces and torques are N and N m by the table; units that are given stay as they are."""
    values = np.zeros((2, 2))
    assert Signal("wrench", STAMPS, values, ("fx", "tx")).units == ("N", "N m")
    assert Signal("wrench", STAMPS, values, ("fx", "tx"), units=("kN", "kN m")).units == ("kN", "kN m")


@pytest.mark.parametrize("shape", [(1, 2), (3, 2), (2, 1), (2, 3), (2,)])
def test_values_have_a_row_for_each_stamp_and_a_column_for_each_name(shape):
    """Of two stamps and two names only (2, 2) is accepted."""
    with pytest.raises(AssertionError):
        Signal("wrench", STAMPS, np.zeros(shape), ("fx", "tx"))


def test_stamps_that_an_image_lacks_are_minus_one():
    """An image with a log stamp alone has -1 for the two others."""
    image = Image("digit", b"", "missing", 0, 0, log_ns=5)
    assert (image.log_ns, image.publish_ns, image.header_ns) == (5, -1, -1)


def test_a_finding_concerns_one_thing_and_the_whole_recording_unless_it_says_more():
    """Equal facts make equal findings; the defaults are no place, no span and a count of one."""
    assert Finding("chunk-crc", "damage", "x") == Finding("chunk-crc", "damage", "x", "", "", None, None, 1)
    assert Finding("chunk-crc", "damage", "x") != Finding("chunk-crc", "damage", "x", count=2)


def test_findings_as_a_table_come_back_and_name_the_first_source():
    """A table of findings gives the same findings again; its rows belong to source 0 until a store numbers them."""
    findings = (
        Finding("gap", "warning", "a gap", "wrench", "t3", 5, 9, 4),
        Finding("chunk-crc", "damage", "a lost chunk"),
    )
    table = findings_table(findings)
    assert findings_of(table) == findings
    assert table["source"].to_pylist() == [0, 0]
    assert findings_of(findings_table([])) == ()
