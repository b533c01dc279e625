"""Findings are held against what the simulation itself may be off."""

import dataclasses

import numpy as np
import pytest
from planted import MODULUS, modulus_over, planted

from tactiledata.diagnose.locate.drifts import parameter_drifts
from tactiledata.diagnose.locate.event_effects import event_effects
from tactiledata.diagnose.locate.events import find_events
from tactiledata.diagnose.locate.gate import NoiseModel
from tactiledata.diagnose.locate.locate import LocateOptions, locate
from tactiledata.diagnose.locate.region_map import region_maps
from tactiledata.diagnose.locate.simulator_errors import beyond_errors
from tactiledata.diagnose.locate.tree import honest_tree
from tactiledata.diagnose.residuals.projection import project

EXACT = {"fx": 0.0, "fy": 0.0, "fz": 0.0, "E": 0.0, "mu": 0.0}
WIDE = dict.fromkeys(EXACT, 10.0)


@pytest.fixture(scope="module")
def world():
    """E grows with the depth by a fifth."""
    return planted(5, 60, plant=modulus_over("depth", 0.2, 0.1, 1.0), heavy=False, random_effects=False)


def findings(world):
    projection = project(world)
    return {
        "drifts": parameter_drifts(projection, 1, 199),
        "departures": event_effects(projection, find_events(world), 1, 199),
        "maps": region_maps(projection, seed=1, draws=199),
        "leaves": honest_tree(projection, 1, 199),
    }


def test_all_keep_their_p_where_errors_are_not_known(world):
    """Tables know none; and a mapping without a name says nothing of it."""
    for found in findings(world).values():
        assert beyond_errors(found, None) == tuple(found)
        assert [one.p for one in beyond_errors(found, {})] == sorted(one.p for one in found)


def test_no_p_falls_and_errors_as_large_as_the_finding_raise_it(world):
    """Small errors of the simulation make no finding more certain, and very large ones make p = 1."""
    for found in findings(world).values():
        before = min(one.p for one in found)
        assert min(one.p for one in beyond_errors(found, EXACT)) >= before
        assert all(one.p == 1.0 for one in beyond_errors(found, WIDE))


def test_what_is_far_beyond_the_errors_stays_certain(world):
    """A fifth of E, where the simulation may be off by one per cent; not where it may be off by a fifth."""
    drifts = parameter_drifts(project(world), 1, 499)
    first = beyond_errors(drifts, EXACT | {"E": 0.01})[0]
    assert (first.parameter, first.covariate) == ("E", "depth")
    assert first.p <= 0.05
    assert beyond_errors(drifts, WIDE | {"E": 0.2})[0].p > 0.05


def test_the_share_and_not_the_unit_of_a_parameter_counts(world):
    """E in Pa instead of kPa changes no p."""
    in_pascal = dataclasses.replace(
        world,
        parameters=(dataclasses.replace(world.parameters[0], unit="Pa", value=1e3 * MODULUS), *world.parameters[1:]),
        sensitivities=world.slopes * np.where(np.arange(world.slopes.shape[2]) == 0, 1e-3, 1.0),
    )
    ones, others = (beyond_errors(parameter_drifts(project(one), 1, 199), {"E": 0.05}) for one in (world, in_pascal))
    assert [one.p for one in ones] == pytest.approx([one.p for one in others])


@pytest.mark.slow
def test_locate_tells_no_error_of_the_simulation(world):
    """A drift is certain beside an exact simulation, and none beside one that may be off by as much."""
    noise = NoiseModel(0.5)
    exact, wide = (
        locate(world, LocateOptions(noise=noise, draws=499, is_fitted=True, errors=errors)) for errors in (EXACT, WIDE)
    )
    assert exact.is_certain("drifting parameters")
    assert exact.leading
    assert not wide.is_certain("drifting parameters")
    assert not wide.leading
