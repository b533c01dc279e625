"""A locator of one's own is one file and one line: it is tested, corrected for, listed and said like all others."""

import numpy as np
import pytest
from planted import planted

from tactiledata.diagnose.answer.locator_rows import findings, located_document
from tactiledata.diagnose.locate import LOCATORS
from tactiledata.diagnose.locate.locate import LEVEL, locate

TITLE = "halves of trajectories"


@pytest.fixture
def added(monkeypatch):
    """The line in the table, as an entry point of another package adds it."""
    outside = {"late_frames": "tests.examples.late_frames_locator:LOCATOR"}
    monkeypatch.setitem(vars(LOCATORS), "_outside", outside)


def late(world):
    """The second halves of trajectories feel 0.8 deviations more in the first component."""
    place = np.concatenate([np.arange(count) / count for count in world.counts])
    change = np.zeros_like(world.values)
    change[:, 0] = np.where(place < 0.5, -0.4, 0.4)
    return change


def test_without_its_line_nothing_is_asked():
    """The table has four members, and the title is in no document."""
    assert len(LOCATORS) == 4
    assert TITLE not in locate(planted(1)).p


def test_what_it_finds_is_listed_and_said(added):
    """A planted difference of halves is certain among all locators, a row of the document, and a sentence."""
    located = locate(planted(1, 60, plant=late))
    assert located.is_certain(TITLE)
    rows = [row for row in findings(located) if row["locator"] == TITLE]
    assert rows
    assert rows[0]["component"] == located.projection.residuals.components[0]
    assert rows[0]["p"] <= LEVEL
    assert "differs between the halves of a trajectory." in " ".join(located.sentences())
    assert located_document(located)["p"][TITLE] == located.p[TITLE]


@pytest.mark.slow
def test_it_counts_among_the_tests_where_nothing_is_there(added, monkeypatch):
    """Without a difference the locator is not certain, and Holm's correction of the others counts it."""
    with_it = locate(planted(5))
    assert not with_it.is_certain(TITLE)
    monkeypatch.undo()
    without = locate(planted(5))
    assert set(with_it.p) - set(without.p) == {TITLE}
    assert all(with_it.p[name] >= without.p[name] for name in without.p)
