"""Contrasts: silent where noise and the simulation's own errors are all, and what is planted with its size."""

import dataclasses

import numpy as np
import pytest
from planted import MODULUS, planted

from tactiledata.diagnose.answer.locator_rows import findings
from tactiledata.diagnose.locate.contrasts import IN_CONTACT, contrasts, instruments_of, sizes_of
from tactiledata.diagnose.locate.gate import NoiseModel
from tactiledata.diagnose.locate.locate import LocateOptions, locate
from tactiledata.diagnose.residuals.projection import project
from tactiledata.diagnose.residuals.residuals import Covariate
from tactiledata.diagnose.unseen.touch_residuals import scatter_beyond_noise

EXACT = {"fx": 0.0, "fy": 0.0, "fz": 0.0, "E": 0.0, "mu": 0.0, "offset": 0.0}


def white(seed=0, trajectories=40, plant=None, correlation=0.0):
    return planted(seed, trajectories, plant=plant, correlation=correlation, heavy=False, random_effects=False)


def slope_of(world, name):
    return world.slopes[:, :, [one.name for one in world.parameters].index(name)]


def modulus_at_ball(world, share=0.2):
    return slope_of(world, "E") * share * MODULUS * (world.labels["indenter"] == "ball")[:, None]


def offset_at_cone(world, deeper=0.15):
    return slope_of(world, "offset") * deeper * (world.labels["indenter"] == "cone")[:, None]


@pytest.mark.slow
def test_white_noise_is_no_contrast():
    """A contrast is found in at most 5 % and three standard errors of 60 nulls."""
    alarms = [contrasts(project(white(seed)), EXACT)[0].p <= 0.05 for seed in range(60)]
    assert np.mean(alarms) <= 0.05 + 3 * np.sqrt(0.05 * 0.95 / 60)


@pytest.mark.slow
def test_noise_with_memory_is_none_if_its_memory_is_told():
    """An AR(1) of 0.5 triples the variance of sums; where that is kept back, a quarter of nulls alarms."""
    worlds = [project(white(seed, correlation=0.5)) for seed in range(30)]
    told = [contrasts(one, EXACT, inflation=3.0)[0].p <= 0.05 for one in worlds]
    kept_back = [contrasts(one, EXACT)[0].p <= 0.05 for one in worlds]
    assert np.mean(told) <= 0.1
    assert np.mean(kept_back) >= 0.25


def test_a_modulus_of_one_indenter_is_told_with_its_size():
    """E, at that indenter, by its share; and nothing else is certain once it is fitted."""
    found = contrasts(project(white(1, plant=modulus_at_ball)), EXACT)
    first = found[0]
    assert (first.what, first.along) == ("E", "indenter")
    assert "at indenter ball, against all others" in first.words
    assert abs(first.size - 0.2) < 1.5 * first.half_width
    assert all(other.p > 0.05 for other in found[1:])


def test_an_offset_of_one_mount_is_told_though_each_trajectory_has_its_own():
    """Own parameters are asked too, where the simulation's errors are known for them."""
    first = contrasts(project(white(2, plant=offset_at_cone)), EXACT)[0]
    assert (first.what, first.along) == ("offset", "indenter")
    assert first.shares["fz"] > 0.9
    assert sum(first.shares.values()) == pytest.approx(1.0)
    assert "it shows in fz" in first.words


def test_two_are_told_one_after_the_other():
    """The second is sought with the first one fitted."""

    def both(world):
        sideways = np.zeros_like(world.values)
        sideways[:, 0] = 1.5 * (world.labels["phase"] == "dwell")
        return modulus_at_ball(world, 0.3) + sideways

    found = [one for one in contrasts(project(white(3, plant=both)), EXACT) if one.p <= 0.05]
    assert {(one.what, one.along) for one in found[:2]} == {("E", "indenter"), ("fx", "phase")}


def test_a_covariate_that_tells_it_nearly_as_well_is_named_beside_it():
    """Depth and its square root; the time, which has nothing to do with it, is not."""

    def plant(world):
        return slope_of(world, "E") * (0.3 * MODULUS * world.covariates["depth"].values)[:, None]

    world = white(6, plant=plant)
    bent = Covariate(np.sqrt(world.covariates["depth"].values), "mm")
    turned = Covariate(-world.covariates["minutes"].values, "min")
    world = dataclasses.replace(world, covariates={**world.covariates, "bent": bent, "turned": turned})
    first = contrasts(project(world), EXACT)[0]
    assert first.what == "E"
    assert {"depth", "bent"} <= {first.along, *first.alike, *first.alternatives}
    assert {"minutes", "turned"}.isdisjoint(first.alternatives)
    assert first.along not in first.alternatives
    if first.alternatives:
        assert f"also explained by {first.alternatives[0]}" in first.words


def test_no_parameter_changes_its_sign(monkeypatch):
    """Shear that would ask for a friction of minus twice itself at one indenter is no change of friction."""

    def plant(world):
        return slope_of(world, "mu") * (-3.0 * 0.8 * (world.labels["indenter"] == "ball"))[:, None]

    projection = project(white(7, plant=plant))
    assert all(abs(one.size) <= 1.0 for one in contrasts(projection, EXACT) if one.what in ("E", "mu"))
    monkeypatch.setattr("tactiledata.diagnose.locate.contrasts.MOST_CHANGE", np.inf)
    assert contrasts(projection, EXACT)[0].size == pytest.approx(-3.0, abs=0.2)


def test_what_a_simulation_may_be_off_is_none_however_many_trajectories_show_it():
    """The p-value stays at 1 if the simulation may be that wrong; without such an error the contrast's value grows."""
    allowed = EXACT | dict.fromkeys(("E", "fz", "offset", "mu"), 10.0) | {"E": 0.2}
    few, many = (project(white(4, count, plant=modulus_at_ball)) for count in (40, 160))
    assert abs(contrasts(many, EXACT)[0].value) > 1.5 * abs(contrasts(few, EXACT)[0].value)
    assert all(one.p == 1.0 for one in contrasts(many, allowed))


def test_what_has_no_error_is_not_asked():
    """A direction of unknown error tells nothing."""
    world = project(white(1, plant=modulus_at_ball))
    assert {one.what for one in sizes_of(world, instruments_of(world.residuals), {"fx": 0.0})} == {"fx"}
    assert contrasts(world, {}) == ()


def test_instruments_are_silent_before_contact():
    """What stands in free air has a locator of its own."""
    world = white()
    instruments = instruments_of(world)
    assert instruments.names[0] == IN_CONTACT
    assert (instruments.columns[world.labels["phase"] == "free air"] == 0).all()
    assert len(instruments.names) == len(instruments.places) == instruments.columns.shape[1]


@pytest.mark.parametrize("error", [0.0, 0.3, 2.0])
def test_scatter_beyond_noise_is_found_again(error):
    """One error on top of known variances is found again from sizes."""
    rng = np.random.default_rng(5)
    variances = rng.uniform(0.01, 1.0, 4000)
    sizes = rng.normal(0.0, np.sqrt(variances + error**2))
    assert scatter_beyond_noise(sizes, variances) == pytest.approx(error, abs=0.1)
    assert scatter_beyond_noise(np.zeros(0), np.zeros(0)) == 0.0


def test_a_way_is_no_parameter_in_the_document():
    """What goes with the slide is told as a component, as departures tell it; E as a parameter."""
    way = np.tile([0.6, 0.8, 0.0], (600, 1))
    world = white(6, plant=lambda one: 2.0 * way * (one.labels["phase"] == "shear")[:, None])
    told = dataclasses.replace(world, ways={"shear along the slide": way})
    options = LocateOptions(noise=NoiseModel(0.0), draws=199, errors={"shear along the slide": 0.0})
    rows = [one for one in findings(locate(told, options)) if one["locator"] == "contrasts"]
    assert rows[0]["component"] == "shear along the slide"
    assert "parameter" not in rows[0]


@pytest.mark.slow
def test_locate_asks_them_only_where_errors_and_noise_are_known():
    """A table tells neither."""
    world = white(1, plant=modulus_at_ball)
    known = LocateOptions(noise=NoiseModel(0.0), draws=199, errors=EXACT)
    found = locate(world, known)
    assert found.is_certain("contrasts")
    assert any("E rises by" in one and "indenter ball" in one for one in found.sentences())
    for unknown in (
        dataclasses.replace(known, errors=None),
        dataclasses.replace(known, noise=None),
        dataclasses.replace(known, noise=NoiseModel(None)),
    ):
        assert "contrasts" not in locate(world, unknown).p


@pytest.mark.slow
def test_a_drift_is_said_once():
    """E over depth is a drift and a contrast: one sentence."""

    def plant(world):
        return slope_of(world, "E") * (0.4 * MODULUS * world.covariates["depth"].values)[:, None]

    options = LocateOptions(noise=NoiseModel(0.0), is_fitted=True, errors=EXACT)
    located = locate(white(8, trajectories=60, plant=plant), options)
    assert located.is_certain("drifting parameters")
    assert ("E", "depth") in {(one.what, one.along) for one in located.contrasts if one.p <= 0.05}
    assert len([one for one in located.sentences() if one.startswith("E ") and "depth" in one]) == 1
