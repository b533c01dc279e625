"""Refits and ends of intervals that are found by several processes."""

import pytest
from touch_worlds import PLANTS, START, world_cases

from tactiledata.compute import make_scheduler
from tactiledata.diagnose.naming.name_effects import name_effects, with_profiles
from tactiledata.diagnose.naming.options import NamingOptions


@pytest.mark.slow
def test_two_processes_find_the_intervals_of_one():
    """Both find the same ends, which differ from those by the curvature and hold the best value."""
    cases = world_cases(PLANTS["relaxation"], 0, trajectories=24)
    options = NamingOptions(effects=("relaxation",), profile=False, pairs=False)
    naming = name_effects(cases, START, options)
    assert naming.decision.claimed == ("relaxation",)
    alone, together = (with_profiles(naming, runner=runner) for runner in (None, make_scheduler(2)))
    assert together.intervals == alone.intervals
    assert together.intervals_before == alone.intervals_before
    assert alone.intervals != naming.intervals
    for found in (*alone.intervals, *alone.intervals_before):
        assert found.low <= found.value <= found.high
        assert found.low < found.high


@pytest.mark.slow
def test_two_processes_give_the_answer_of_one():
    """Evidence, numbers and answer are the same to the last bit, pairs and held-out squares too."""
    cases = world_cases(PLANTS["relaxation"], 0, trajectories=24)
    options = NamingOptions(effects=("relaxation", "lag", "arm_compliance", "rate_friction"), profile=False)
    alone, together = (name_effects(cases, START, options, runner=runner) for runner in (None, make_scheduler(2)))
    assert len(alone.scored) >= 3
    for one, other in zip(alone.scored, together.scored, strict=True):
        assert one.label == other.label
        assert one.evidence == other.evidence
        assert (one.gains == other.gains).all()
        assert one.indenter_gain == other.indenter_gain
        assert (one.fit.model.vector == other.fit.model.vector).all()
    assert together.decision.claimed == alone.decision.claimed == ("relaxation",)
