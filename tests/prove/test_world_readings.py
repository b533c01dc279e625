"""Readings of a world's logs: one play gives them with noise and without."""

from dataclasses import replace

import numpy as np
import pytest

from tactiledata.prove.worlds.generators import closed_form
from tactiledata.prove.worlds.plan_names import named_plan
from tactiledata.prove.worlds.recorder import WorldMaker

DRIFT = {"effect": "ft_drift", "strength": "strong"}


@pytest.fixture(scope="module")
def maker(tmp_path_factory):
    return replace(WorldMaker.of(named_plan("coarse-0"), tmp_path_factory.mktemp("bank")), solve=closed_form)


def values(readings):
    return np.concatenate([one.values for one in readings])


@pytest.mark.parametrize("hidden", [[], [DRIFT]])
def test_logs_that_were_played_once_read_as_those_of_two_plays(maker, hidden):
    """Readings with noise do not change those without, whichever are taken first, to the last byte."""
    logs = maker.played(7, maker.plan.truth, hidden)
    noisy, exact = values([log.readings() for log in logs]), values([log.readings(0.0) for log in logs])
    np.testing.assert_array_equal(exact, values(maker.readings(7, maker.plan.truth, hidden, is_exact=True)))
    np.testing.assert_array_equal(noisy, values(maker.readings(7, maker.plan.truth, hidden)))


def test_noise_is_in_proportion_to_its_factor(maker):
    """Twice the factor is twice the deviation from readings without noise; its size is that which the rig states."""
    (log, *_) = maker.played(7, maker.plan.truth, [])
    exact = log.readings(0.0).values
    once, twice = (log.readings(factor).values - exact for factor in (1.0, 2.0))
    stated = log.rig_setup.scenario.imperfections.force_noise
    assert once[:, :3].std() == pytest.approx(stated, rel=0.2)
    assert (twice[:, :3].std(axis=0) / once[:, :3].std(axis=0)) == pytest.approx([2.0] * 3, rel=0.05)


def test_noise_of_a_maker_is_that_of_its_readings(maker):
    """The factor of a configuration reaches the readings."""
    quiet = values(replace(maker, noise=0.1).readings(7, maker.plan.truth, []))
    exact = values(maker.readings(7, maker.plan.truth, [], is_exact=True))
    usual = values(maker.readings(7, maker.plan.truth, []))
    assert np.abs(quiet - exact).mean() == pytest.approx(0.1 * np.abs(usual - exact).mean(), rel=0.1)
