"""docs/reliability.md shows the list of faults, and the list names tests that exist."""

import pytest
from fault_table import FAULTS, PAGE, absent, drawn_page, listed, reasons
from faults.writers import WRITERS

CASES = "tests/faults/test_writers_under_faults.py"
TESTS = {
    "killed": "test_killed_it_goes_on",
    "full": "test_on_a_full_disk_it_says_so_and_goes_on",
    "read-only": "test_read_only_it_says_so_and_changes_nothing",
    "two": "test_two_at_once_end_the_same",
}
"""Tests that every writer of tests/faults goes through."""


def test_the_page_shows_the_list():
    """The table is as the list has it; ``python tests/fault_table.py --write`` draws it anew."""
    text = PAGE.read_text(encoding="utf-8")
    assert drawn_page(text) == text


@pytest.mark.slow
def test_every_test_of_the_list_exists():
    """Each name is that of a test function, or of a reason; cells of tests/faults are of a writer there."""
    for name, entry in listed().items():
        assert set(entry) <= set(FAULTS), name
        for found in entry.values():
            if isinstance(found, str):
                assert found in reasons(), f"{name}: {found} is no reason of the list"
                continue
            for node in found:
                assert not absent(node), f"{name}: {node} {absent(node)}"
                if node.startswith(f"{CASES}::"):
                    assert node.partition("[")[2].rstrip("]") in WRITERS, node


def test_every_writer_of_the_tests_is_in_the_list():
    """What tests/faults tries stands in the list, all four faults of each writer."""
    named = {node for entry in listed().values() for found in entry.values() for node in found}
    wanted = {f"{CASES}::{test}[{writer}]" for writer in WRITERS for test in TESTS.values()}
    assert wanted <= named, sorted(wanted - named)


def test_a_test_that_does_not_exist_is_found():
    """Control: names of other files, other functions and no tests at all are said so."""
    assert absent("tests/test_house.py::test_no_such") == "is in no function"
    assert absent("tests/test_no_such.py::test_a") == "is in no file"
    assert absent("docs/reliability.md") == "is no name of a test"
    assert absent(f"{CASES}::{TESTS['killed']}[split]") == ""
