"""Numbers just below and just above what their unit makes plausible."""

import numpy as np
import pytest

from tactiledata.contract.take import StoredSignal
from tactiledata.ingest.checks.units_seen import unit_findings
from tests.ingest.made_takes import signal, take, told, touch


def doubt(name, values, touches=1, columns=None, **attributes):
    """What is said of a signal's unit; empty where nothing is."""
    made = take(None, [touch()] * touches, {name: signal(name, range(len(values)), values, columns, **attributes)})
    found = unit_findings(made)
    assert told(found) == [("unit-implausible", "warning", name, 1)] * len(found)
    return "".join(one.message for one in found)


def poses(*places):
    return [[*place, 0, 0, 0, 1] for place in places]


def test_positions_are_judged_by_the_median_of_the_farthest_axis():
    """5 m are a reach and more are millimetres, whichever axis and sign; one pose of many says nothing."""
    assert doubt("tcp", poses((5, 0, 0), (-5, 0, 0), (0, 5, 4))) == ""
    for axis in range(3):
        far = np.zeros(3)
        far[axis] = -5.01
        assert doubt("tcp", poses(far, far, (0, 0, 0))) == "tcp: positions are 5.01 m from the base; millimetres?"
        assert doubt("tcp", poses(far, (0, 0, 0), (0, 0, 0))) == ""
    assert doubt("tcp", [[0, 0, 0, 9, 9, 9, 9.0]]) == ""
    assert "positions are 7 m" in doubt("marker", [[7, 0, 0], [7, 0, 0]], columns=("x", "y", "z"))


def test_joints_turn_by_two_revolutions_at_most():
    """4 pi rad and less are radians."""
    limit = 4 * np.pi
    for joint in (0, 5):
        turned = np.zeros((3, 6))
        turned[:2, joint] = -limit
        assert doubt("joints", turned) == ""
        turned[:2, joint] = -limit - 0.01
        assert doubt("joints", turned) == "joints: joints are turned by 12.58 rad; degrees?"


@pytest.mark.parametrize(("change", "is_doubted"), [(0.0199, True), (0.02, False), (0.0, False)])
def test_forces_that_hardly_change_are_kilonewtons(change, is_doubted):
    """Below 0.02 N over a recording with touches, but for a sensor that reads a constant."""
    wrench = np.tile([1.0, 2.0, 3.0, 0, 0, 0], (5, 1))
    wrench[4, 1] += change
    assert bool(doubt("wrench", wrench)) == is_doubted
    assert doubt("wrench", wrench, touches=0) == ""
    if is_doubted:
        assert "change by no more than 0.02 N" in doubt("wrench", wrench)


@pytest.mark.parametrize(("torque", "words"), [(5.99, ""), (6.0, ""), (6.01, "torques are 3.005 m times the forces")])
def test_a_lever_is_at_most_three_metres(torque, words):
    """A change of 2 N with a torque of more than 6 N m is in newton millimetres, whichever axes they have."""
    wrench = np.zeros((9, 6))
    wrench[:, :] = [4.0, 4, 4, 9, 9, 9]
    wrench[7:, 2] -= 2.0
    wrench[7:, 3] -= torque
    assert doubt("wrench", wrench).startswith(f"wrench: {words}" if words else "")
    assert bool(doubt("wrench", wrench)) == bool(words)


def test_the_lever_is_judged_where_a_force_is_felt():
    """A change of 1 N is not felt; the median over those that are counts."""
    wrench = np.zeros((9, 6))
    wrench[8] = [1.0, 0, 0, 99, 0, 0]
    assert doubt("wrench", wrench) == ""
    wrench[6:, 0], wrench[6:, 3] = 1.01, [1, 1, 99]
    assert doubt("wrench", wrench) == ""
    wrench[6:, 3] = [1, 99, 99]
    assert "torques are 98.02 m" in doubt("wrench", wrench)


def kelvin(values, units, columns):
    values = np.asarray(values, float)
    t_ns = np.arange(len(values))
    made = StoredSignal(t_ns, values, columns, units, "", None)
    return "".join(one.message for one in unit_findings(take(signals={"gel": made})))


def test_gels_are_warmer_than_200_kelvin():
    """Colder numbers are degrees Celsius; only columns in kelvin are judged."""
    assert kelvin([[200.0]], ("K",), ("temperature",)) == ""
    assert kelvin([[199.0]], ("K",), ("temperature",)) == "gel: temperatures are 199 K; degrees Celsius?"
    assert kelvin([[25.0, 300.0]], ("N", "K"), ("load", "temperature")) == ""
    assert kelvin([[300.0, 25.0]], ("N", "K"), ("load", "temperature")) != ""
    assert kelvin([[25.0]], ("N",), ("load",)) == ""


def test_samples_that_are_not_finite_are_left_out():
    """And derived signals are not judged at all."""
    assert doubt("tcp", poses((np.nan, 0, 0), (np.inf, 0, 0), (6, 0, 0))) != ""
    assert doubt("tcp", poses((np.nan, 0, 0))) == ""
    assert doubt("wrench", np.full((2, 6), np.nan)) == ""
    assert doubt("tcp", poses((6, 0, 0)), derived_from="joints") == ""
