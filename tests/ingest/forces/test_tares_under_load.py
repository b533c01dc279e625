"""Stated tares at which the reading is that of a press: said where a recording names no trajectories."""

import re

import numpy as np
import pytest
from load_levels import START, made

from tactiledata.ingest.forces.tare import find_zero


def said(levels, tares, spans=()):
    """Findings on tares under load; tares are rows, and the reading is put to zero by the levels themselves."""
    t_ns, load = made(levels)
    load += np.random.default_rng(0).normal(0, 0.02, load.shape)
    found = find_zero(t_ns, load, list(spans), [int(t_ns[row]) for row in tares])
    return [one for one in found.findings if one.code == "tare-under-load"]


JUMPED = [(0, 300), (2.5, 100), (0, 300)]


def test_a_plateau_until_a_tare_is_said():
    """Free air, 2.5 N for a second, a stated tare: a press that was tared, or a zero that jumped in a pause."""
    [finding] = said(JUMPED, [400])
    assert (finding.severity, finding.count, finding.stream) == ("warning", 1, "wrench")
    assert finding.start_ns == START + 400 * 10_000_000
    assert "at 1 stated tare event" in finding.message
    assert "up to 2.5" in finding.message


def test_the_largest_of_several_is_named():
    """Tared under 2.5 N, let go (-2.5 N is read), pressed with 4 N (1.5 N is read), and tared under these."""
    [finding] = said([*JUMPED[:2], (0, 50), (-2.5, 250), (1.5, 100), (0, 300)], [400, 800])
    assert finding.count == 2
    assert finding.start_ns == START + 400 * 10_000_000
    assert f"at 2 stated tare events (the first at {finding.start_ns} ns)" in finding.message
    assert "zero after them" in finding.message
    assert re.search(r"up to (3\.9|4\.0)\d N", finding.message)


@pytest.mark.parametrize(
    ("levels", "tares"),
    [
        ([(0, 300), (2.5, 100), (0, 300)], [200]),
        ([(0, 300), (2.5, 100), (0, 300)], []),
        ([(0, 300), (2.5, 100), (0, 50), (0, 300)], [450]),
        ([(0, 300), *((0.0002 * k, 1) for k in range(4000)), (0, 300)], [4300]),
    ],
    ids=["in free air", "no tare", "after the press", "slow drift"],
)
def test_a_tare_in_free_air_is_not_said(levels, tares):
    """Negative controls: before a press, after it, and at the end of a drift to 0.8 N in 40 s."""
    assert not said(levels, tares)


def test_named_trajectories_have_zeros_of_their_own():
    """Each begins in free air, so that what a tare shows between them is not needed."""
    t_ns, _ = made(JUMPED)
    spans = [("a", int(t_ns[0]), int(t_ns[250])), ("b", int(t_ns[420]), int(t_ns[-1]))]
    assert not said(JUMPED, [400], spans)
