"""Tests of the evidence that an exact formula brings, and of how it is counted beside what a claim needs."""

import numpy as np
import pytest
from proof_ceilings import ceiling, print_tables
from touch_worlds import START, World, world_cases

from tactiledata.diagnose.naming.name_effects import name_effects
from tactiledata.diagnose.naming.options import NamingOptions

TOUCHES = 16


def measured(world):
    """Wrenches of a world of touches, one touch after the other."""
    return np.concatenate([case.measured for case in world.touches])


@pytest.fixture(scope="module")
def worlds():
    """A world whose gel relaxes, and the same without that."""
    return world_cases(World(relaxing=0.3), 1, TOUCHES), world_cases(World(), 1, TOUCHES)


def test_an_exact_formula_has_more_evidence_than_that_of_the_catalogue(worlds):
    """It takes all that is hidden, where a refit of the catalogue's relaxation, by another law, leaves a part."""
    relaxing, without = worlds
    found = ceiling(relaxing, measured(relaxing) - measured(without), "relaxation")
    naming = name_effects(relaxing, START, NamingOptions(effects=("relaxation",), pairs=False, profile=False))
    (refitted,) = naming.scored
    assert found["evidence"] > refitted.evidence > found["need"] > 0


def test_the_ceiling_grows_with_what_is_hidden_and_is_nothing_without(worlds):
    """No change brings no evidence; half of a change brings less than the whole one, beside the same readings."""
    relaxing, without = worlds
    change = measured(relaxing) - measured(without)
    nothing, half, whole = (ceiling(relaxing, share * change, "relaxation")["evidence"] for share in (0.0, 0.5, 1.0))
    assert abs(nothing) < 1.0 < half < whole


def test_a_change_that_a_calibration_takes_up_has_no_ceiling(worlds):
    """A gel that is stiffer by a twentieth is another E, and no formula finds more."""
    _, without = worlds
    stiffer = 0.05 * without.play(START, [])
    found = ceiling(without, stiffer, "relaxation")["evidence"]
    assert abs(found) < 3.0 < 0.02 * float(((stiffer / 0.1) ** 2).sum())


def case(name, effect, evidence, is_named, need=20.0, own=None):
    """A case with a ceiling."""
    return {
        "case": f"{name}0123456789", "generator": "layer", "mismatch": 0.0, "hidden": effect, "effect": effect,
        "signal": 20.0, "evidence": evidence, "need": need, "error_size": 1.2, "error_size_with": 1.6,
        "own_evidence": own, "is_named": is_named,
    }  # fmt: skip


def test_cases_are_counted_on_either_side_of_the_need(capsys):
    """A ceiling that equals the need is no hindrance; effects stand in the slot in which they act."""
    print_tables([
        case("a", "lag", 100.0, True, own=90.0), case("b", "lag", 20.0, False), case("c", "rate_friction", 10.0, False),
        case("d", "skin", 19.9, False), case("e", "rate_friction", 50.0, True),
    ])  # fmt: skip
    lines = [line.split() for line in capsys.readouterr().out.splitlines()]
    shown = [line[0][0] for line in lines if line and line[0].endswith("0123456")]
    assert shown == ["a", "e", "b", "d", "c"]
    assert ["a0123456", "layer", "0", "lag", "20", "200", "100", "20", "90", "1.6", "to", "1.2", "named"] in lines
    assert ["sensor", "1", "of", "2", "0", "of", "0", "0.30"] in lines
    assert ["interface", "1", "of", "1", "0", "of", "1", "0.15"] in lines
    assert ["constitutive", "law", "0", "of", "0", "0", "of", "1", "0.10"] in lines
