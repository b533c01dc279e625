"""Tests of how the misses of printed ensembles are counted by what keeps them from being named."""

import re
from pathlib import Path

import pytest
from proof_objections import OBJECTIONS, PAGE, misses, print_tables

from tactiledata.diagnose.naming import decide, evidence

SHARE = "only 43 % of the excess over the noise is gone, and more than the noise is left."
EVIDENCE = "the evidence is 5.4, and errors of the simulation alone can bring up to 53; "
PAGE_OF_FOUR = f"""
miss: 284d728256882f99 (visible; analytic wedge-13 mismatch 0 noise 1): dome with a signal of 123.3 was answered with \
'not explained', no name: unnamed. Nearest: dome. Against it: {SHARE}
miss: 3f9dfd05d291497e (pairs; layer wedge-13 mismatch 1 noise 1): ft_drift + dome with a signal of 20.0 was answered \
with 'not explained', no name: unnamed. Nearest: dome + wear. Against it: {SHARE}
miss: 123456789abcdef0 (visible; layer wedge-2 mismatch 0 noise 1): delamination with a signal of 9.0 was answered \
with 'nothing found', no name: missed. Nearest: soft_region. Against it: {EVIDENCE}{SHARE}
miss: 223456789abcdef0 (visible; layer wedge-2 mismatch 0 noise 1): lag with a signal of 9.0 was answered with \
'explained', clock_skew: wrong. Nearest: clock_skew.
"""


def test_misses_are_counted_by_the_first_objection(capsys):
    """The first objection counts; right is what names nothing that is not hidden, by the catalogue's words."""
    found = misses(PAGE_OF_FOUR)
    assert [(miss.objection, miss.is_right) for miss in found] == [
        ("share", True),
        ("share", False),
        ("evidence", True),
    ]
    assert found[2].hidden == ("soft_region",)
    print_tables(found, "evidence")
    lines = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert lines[2:4] == [["share", "2", "1", "72"], ["evidence", "1", "1", "9"]]
    assert ["12345678", "layer", "wedge-2", "mismatch", "0", "noise", "1", "soft_region", "soft_region", "9"] in lines


@pytest.mark.parametrize("word", OBJECTIONS)
def test_each_objection_is_one_that_is_printed(word):
    """The words that are looked for stand in the sentences of the diagnosis, but for what is put in."""
    spoken = "".join(re.sub(r'"\n\s+f?"', "", Path(module.__file__).read_text()) for module in (decide, evidence))
    assert re.search(OBJECTIONS[word].replace("stands", ".*stands"), spoken)


def test_the_page_has_misses_of_all_kinds():
    """Every miss of the page to which there is an objection is read."""
    text = PAGE.read_text()
    assert len(misses(text)) == len(set(re.findall(r"(?m)^miss: (\w+) .*Against it: .*$", text))) > 100
