"""How far the zeros of one recording's trajectories lie apart: in newtons, of forces alone."""

import numpy as np

from tactiledata.ingest.forces.zero_findings import drift_findings


def test_torques_are_no_newtons():
    """Zeros that differ by 0, 2 and 1 N in x, by 0.5 N in z and by 5 N m about every axis: 2.06 N."""
    zeros = [np.array([x, 0.0, z, m, m, m]) for x, z, m in ((0.0, 0.0, 0.0), (2.0, 0.5, 5.0), (1.0, 0.0, -5.0))]
    [finding] = drift_findings(zeros)
    assert "moves by 2.06 N over 3 trajectories" in finding.message
    assert drift_findings([zero * [0, 0, 0, 1, 1, 1] for zero in zeros]) == []
    assert drift_findings(zeros[:1]) == drift_findings([]) == []
