"""What tables of a calibration say, against values by hand: bounds in both intervals, and a loss that rose."""

from types import SimpleNamespace

import numpy as np
import pytest

from tactiledata.calibrate.bounds import BOUNDS
from tactiledata.calibrate.page import other_loss, result_rows

PAPER = BOUNDS["paper"]


def calibration(loss="vector", vector=(9.0, 2.0), norm=(1.0, 0.5), reach=((0.9e6, 0.95e6), (0.46, 0.48), (0.6, 0.7))):
    """Return a stand-in with what tables read of a calibration; ``reach`` holds the ends of both intervals."""
    losses = {
        "vector": SimpleNamespace(start=vector[0], fitted=vector[1]),
        "norm": SimpleNamespace(start=norm[0], fitted=norm[1]),
    }
    names = ("youngs_modulus", "poisson_ratio", "friction")
    return SimpleNamespace(
        options=SimpleNamespace(loss=loss),
        bounds=PAPER,
        known={name: SimpleNamespace(verdict="identified") for name in names},
        fit=SimpleNamespace(
            losses=losses,
            parameters=np.array([0.92e6, 0.47, 0.65]),
            start=np.array([0.9e6, 0.47, 0.7]),
            intervals=SimpleNamespace(ends=np.array(reach), is_open=np.zeros((3, 2), bool)),
            simulation_error=SimpleNamespace(ends=np.array(reach)),
        ),
    )


def test_a_loss_that_rose_is_explained():
    """The loss that was not minimised is told where it is larger than at the start, and only there."""
    assert other_loss(calibration()) == ""
    assert "The fit lowers the vector loss. The norm loss is larger" in other_loss(calibration(norm=(1.0, 1.2)))
    assert other_loss(calibration(vector=(2.0, 2.5))) == ""
    assert "The vector loss is larger" in other_loss(calibration(loss="norm", vector=(2.0, 2.5)))


@pytest.mark.parametrize("k", range(3))
def test_a_bound_is_marked_in_the_interval_with_simulation_error(k):
    """An end at a bound of the search is marked in that interval as in the other; ends inside are not."""
    reach = [[0.9e6, 0.95e6], [0.46, 0.48], [0.6, 0.7]]
    assert not any("(bound)" in row[3] for row in result_rows(calibration(reach=reach)))
    _, low, high = list(PAPER)[k]
    for side, bound in enumerate((low, high)):
        at_bound = [list(ends) for ends in reach]
        at_bound[k][side] = bound
        rows = result_rows(calibration(reach=at_bound))
        assert [row[3].count("(bound)") for row in rows] == [int(other == k) for other in range(3)]
        assert rows[k][3].split(" to ")[side].endswith("(bound)")
