"""The rooms of `diagnose`, in the order in which a store passes through them on its way to the page."""

import sys
from itertools import groupby

import pytest
from recorded_touches import recorded_store

from tactiledata.diagnose.answer.documents import store_document, write_store_diagnosis
from tactiledata.diagnose.options import DiagnosisOptions
from tactiledata.diagnose.store import diagnose_store
from tactiledata.gel.mesh import structured_pad
from tactiledata.gel.mesh.structured_pad import GridPlan
from tactiledata.store.read.reader import Store

COARSE = GridPlan(5, 6, 1.2e-3, (4.8e-3, 6.0e-3), (0.0, 0.6, 1.0))
PACKAGE = "tactiledata.diagnose."
LEADER = f"{PACKAGE}store"
ENTRIES = 2
"""Most times that a room is entered."""
IN_TURN = ["touches", "naming", "unseen", "formula", "next_trial", "zeros"]
"""Rooms in the order in which a store first enters them, as the docstring of `tactiledata.diagnose` has them."""


class Walk:
    """The rooms that a program enters from outside: from this test, or from the module that leads a diagnosis.

    What a room calls in other rooms while it works is not an entry: it stays the errand of that room.
    """

    def __init__(self):
        self.calls = []

    def __call__(self, frame, event, _):
        """Note the room of a function that is called; a tracing function of `sys.settrace`."""
        caller = frame.f_back
        if event != "call" or caller is None:
            return
        room = room_of(frame)
        if room and caller.f_globals.get("__name__") in (LEADER, __name__):
            self.calls.append(room)

    @property
    def rooms(self):
        """Rooms in the order in which they are entered; calls of one room in a row are one entry."""
        return [room for room, _ in groupby(self.calls)]


def room_of(frame):
    """The room to which the module of a frame belongs; empty outside of all rooms."""
    package, _, inside = frame.f_globals.get("__name__", "").partition(PACKAGE)
    room, dot, _ = inside.partition(".")
    return "" if package or not dot else room


@pytest.fixture
def walk(tmp_path, tmp_path_factory, monkeypatch):
    """Rooms in the order in which a small store enters them: the arm yields, and only clipping is tried."""
    monkeypatch.setitem(structured_pad.PLANS, "low", COARSE)
    # what other tests of a diagnosis have played of the same touches serves here, too
    monkeypatch.setenv("TACTILEDATA_CACHE", str(tmp_path_factory.getbasetemp() / "cache"))
    store = Store.open(recorded_store(tmp_path, hidden=[{"effect": "arm_compliance", "strength": "strong"}]))
    options = DiagnosisOptions(fidelity="linear", effects=("clipping",), pairs=False)
    found, before = Walk(), sys.gettrace()
    sys.settrace(found)
    try:
        diagnosis = diagnose_store(store, options)
        write_store_diagnosis(tmp_path / "out", "a store", diagnosis, store_document(diagnosis))
    finally:
        sys.settrace(before)
    assert (tmp_path / "out" / "report.html").is_file()
    return found.rooms


@pytest.mark.nightly
def test_a_store_enters_each_room_once_or_twice(walk):
    """A store whose missing physics has no name enters every room that it passes once or twice, the answer last."""
    assert list(dict.fromkeys(room for room in walk if room in IN_TURN)) == IN_TURN
    assert set(walk) - set(IN_TURN) == {"answer"}
    assert walk[-1] == "answer"
    assert max(walk.count(room) for room in walk) <= ENTRIES, ", ".join(walk)
