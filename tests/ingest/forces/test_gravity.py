"""The tool's weight in numbers worked out by hand."""

import numpy as np
import pytest

from tactiledata.contract.description import LogDescription
from tactiledata.contract.records import Stamps
from tactiledata.contract.take import StoredSignal
from tactiledata.ingest.forces.gravity import tool_weight
from tactiledata.units import SIGNAL_COLUMNS, signal_units


def test_two_kilograms_weigh_their_newtons():
    """2 kg at 0.1 m along x of an upright sensor give 2 x 9.80665 N down, and a tenth of it in N m about y."""
    same = {"xyz": [0.0, 0.0, 0.0], "xyzw": [0.0, 0.0, 0.0, 1.0]}
    robot = {"tcp_from_ft": same, "tool": {"mass": 2.0, "centre_of_gravity": [0.1, 0.0, 0.0]}}
    t_ns = np.arange(3) * 10_000_000
    columns = SIGNAL_COLUMNS["tcp"]
    poses = np.tile([0.4, 0.0, 0.3, 0.0, 0.0, 0.0, 1.0], (3, 1))
    tcp = StoredSignal(t_ns, poses, columns, signal_units(columns), "", Stamps(t_ns))
    weight = tool_weight(LogDescription({"robot": robot}, "test"), tcp, t_ns)
    assert weight == pytest.approx(np.tile([0.0, 0.0, -19.6133, 0.0, 1.96133, 0.0], (3, 1)), abs=1e-12)
