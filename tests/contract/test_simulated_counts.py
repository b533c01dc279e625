"""How many things are simulated, real, or do not state it."""

import pytest

from tactiledata.contract.simulated import SimulatedCount


@pytest.mark.parametrize(
    ("count", "total", "label"),
    [
        (SimulatedCount(), 0, ""),
        (SimulatedCount(0, 2, 1), 3, ""),
        (SimulatedCount(2), 2, "simulated recordings"),
        (SimulatedCount(2, 3, 5), 10, "simulated recordings: 2 of 10"),
        (SimulatedCount.of(["real", "simulated", "not stated", "real"]), 4, "simulated recordings: 1 of 4"),
    ],
)
def test_the_total_is_the_sum_and_the_label_a_share(count, total, label):
    """All three kinds count; nothing simulated has no label, all simulated no share."""
    assert (count.total, count.label) == (total, label)
