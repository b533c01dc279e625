"""Tests of the laws that neither the rig nor the catalogue has, and of how their answers are counted."""

from types import SimpleNamespace

import laws
import numpy as np
import pytest
from laws import LAWS
from laws_named import print_tables

from tactiledata.effects import EFFECTS
from tactiledata.rig.contact.contact import CONTACT_RATE
from tactiledata.rig.hidden.base import Slide

RATE = 1000.0
SECONDS = np.arange(500) / RATE
DEPTH = 1e-3 * np.sin(np.pi * SECONDS / SECONDS[-1])
TOUCH = SimpleNamespace(
    depth=DEPTH,
    radius=np.sqrt(4e-3 * DEPTH),
    positions=np.column_stack([np.full((500, 2), [-1.5e-3, 1e-3]), DEPTH]),
    times=SECONDS,
    facts=SimpleNamespace(seconds=100.0, seconds_on=150.0),
    setup=SimpleNamespace(thickness=3e-3),
)
FORCE = 4e3 * DEPTH
LOADS = np.random.default_rng(5).normal(0.0, 6.0, (500, 6))


def rng():
    """Return a generator that gives the same random numbers after every call."""
    return np.random.default_rng(7)


def everything(law):
    """All that a law changes, as arrays."""
    friction = law.friction(TOUCH)
    late = law.delayed(LOADS, RATE)
    deflection = law.compliance(None, None, None)
    return {
        "normal": law.normal(FORCE, TOUCH),
        "friction": np.array([friction(Slide(2e-3, 2e5, 0.7, 0.3)) if friction else 1.0]),
        "sensed": law.sensed(LOADS, SECONDS, rng()),
        "delayed": LOADS if late is None else late,
        "reported": law.reported(LOADS),
        "stamped": law.stamped("wrench", np.arange(500), SECONDS).astype(float),
        "compliance": np.zeros((3, 3)) if deflection is None else deflection,
    }


PLAIN = {
    "normal": FORCE, "friction": np.ones(1), "sensed": LOADS, "delayed": LOADS, "reported": LOADS,
    "stamped": np.arange(500.0), "compliance": np.zeros((3, 3)),
}  # fmt: skip


@pytest.mark.parametrize("kind", LAWS)
def test_a_law_changes_nothing_at_no_strength_and_something_at_its_least(kind):
    """Strength 0 is a world without it; the weakest that is drawn is seen where it acts."""
    for place, values in everything(kind(0.0)).items():
        np.testing.assert_allclose(values, PLAIN[place], atol=1e-9, err_msg=place)
    weakest = everything(kind(kind.DRAWN[0]))
    assert any(not np.allclose(values, PLAIN[place], atol=1e-9) for place, values in weakest.items())


@pytest.mark.parametrize("kind", LAWS)
def test_a_law_is_an_effect_of_the_catalogue_or_of_none(kind):
    """Names are the catalogue's, strengths are drawn upwards of 0."""
    assert not kind.EFFECT or kind.EFFECT in EFFECTS
    assert 0 < kind.DRAWN[0] < kind.DRAWN[1]


def test_laws_by_hand():
    """A moving mean is late by half its width, a play by its half width, a knee shows a third of what lies beyond."""
    ramp = np.tile(np.arange(500.0)[:, None], (1, 6))
    assert laws.MovingMeanLag(0.011).delayed(ramp, RATE)[400] == pytest.approx([395.0] * 6)
    assert laws.Hysteresis(2.0).sensed(ramp, SECONDS, rng())[400, 0] == pytest.approx(398.0)
    assert laws.Knee(0.1).reported(np.full((1, 6), -16.0))[0].tolist() == pytest.approx([-12.0] * 3 + [-16.0] * 3)
    step = np.where(np.arange(5000) < 10, 0.0, 1.0)
    left = 1.0 + 0.2 * np.expm1(-np.sqrt(4989 / CONTACT_RATE / 2.0))
    assert laws.StretchedRelaxation(0.2).normal(step, TOUCH)[-1] == pytest.approx(left)
    assert laws.ExponentialStiffening(1.0).normal(FORCE, TOUCH)[250] == pytest.approx(
        FORCE[250] * np.exp(1 / 3), rel=1e-4
    )


def world(effect, outcome, said=(), signal=20.0):
    """What is kept of a world."""
    return {
        "law": "Law", "effect": effect, "signal": signal, "verdict": "explained", "said": list(said),
        "nearest": ["lag"], "outcome": outcome,
    }  # fmt: skip


def test_answers_are_counted_apart_from_those_outside_the_catalogue(capsys):
    """Two of three are named, one is wrong; of two outside the catalogue one gets a name; one world is not seen."""
    print_tables([
        world("lag", "named", ["lag"]), world("relaxation", "in the set", ["lag", "relaxation"]),
        world("lag", "wrong", ["inertia"]), world("", "wrong", ["lag"]), world("", "abstained"),
        {"law": "Law", "effect": "lag", "outcome": "too weak to be seen"},
    ])  # fmt: skip
    out = capsys.readouterr().out
    assert "Effects of the catalogue by other laws: 2 of 3 named, 1 with a wrong name." in out
    assert "Effects outside the catalogue: 1 of 2 get a name." in out
    assert "Too weak to be seen at any strength that was drawn: 1." in out
