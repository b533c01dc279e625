"""What a recording lacks for the weight of its tool."""

import numpy as np

from tactiledata.contract.description import LogDescription
from tactiledata.contract.records import Stamps
from tactiledata.contract.take import StoredSignal
from tactiledata.ingest.forces.gravity import what_weight_needs

ROBOT = {"tool": {"mass": 0.5}, "tcp_from_ft": {"xyz": [0.0, 0.0, -0.06]}}


def poses(rows):
    """Poses of the tool centre point, the same at all times."""
    t_ns = 10_000_000 * np.arange(rows, dtype=np.int64)
    values = np.tile([0.0, 0, 0, 0, 0, 0, 1], (rows, 1))
    columns = ("x", "y", "z", "qx", "qy", "qz", "qw")
    return StoredSignal(t_ns, values, columns, ("m",) * 3 + ("1",) * 4, "base", Stamps(t_ns), {})


def test_only_what_is_missing_is_named():
    """Mass, transform and poses are each named where they are missing, and nothing is where all are there."""
    assert what_weight_needs(LogDescription({"robot": ROBOT}), poses(4)) == []
    assert what_weight_needs(LogDescription({"robot": ROBOT}), poses(0)) == ["a tcp stream with sound poses"]
    assert what_weight_needs(LogDescription({"robot": ROBOT}), None) == ["a tcp stream with sound poses"]
    for name, words in (("tool", "robot.tool with its mass"), ("tcp_from_ft", "robot.tcp_from_ft")):
        others = {key: value for key, value in ROBOT.items() if key != name}
        assert what_weight_needs(LogDescription({"robot": others}), poses(4)) == [words]


def test_poses_without_a_number_are_no_poses():
    """A stream that holds nothing but gaps does not tell how the tool is turned."""
    lost = poses(4)
    lost.values[:] = np.nan
    assert what_weight_needs(LogDescription({"robot": ROBOT}), lost) == ["a tcp stream with sound poses"]
