"""Events, steps, maps, trees, shares, free air: each finds what was planted, and is silent where nothing was."""

import dataclasses

import numpy as np
import pytest
from planted import MODULUS, modulus_over, planted

from tactiledata.diagnose.locate.common_offset import offsets
from tactiledata.diagnose.locate.energy import energy_shares
from tactiledata.diagnose.locate.event_effects import event_effects
from tactiledata.diagnose.locate.event_locked import event_locked
from tactiledata.diagnose.locate.events import find_events
from tactiledata.diagnose.locate.free_air import free_air
from tactiledata.diagnose.locate.region_map import region_maps
from tactiledata.diagnose.locate.steps import change_points, series_of
from tactiledata.diagnose.locate.tree import honest_tree
from tactiledata.diagnose.residuals.projection import project

NULLS = 200


def rate_of(smallest, level=0.05):
    return float(np.mean(np.array(smallest) <= level))


def is_level(rate, level=0.05):
    """Whether a share of `NULLS` draws is above the level by no more than three standard errors."""
    return rate <= level + 3.0 * np.sqrt(level * (1 - level) / NULLS)


@pytest.fixture(scope="module")
def nulls():
    """Worlds in which nothing is planted, and their projections."""
    worlds = [planted(seed, 24, 10) for seed in range(NULLS)]
    return [(world, project(world)) for world in worlds]


def decay_in_dwell(world):
    """The normal force falls from the start of the dwell on."""
    values = np.zeros_like(world.values)
    for rows in np.split(np.arange(len(values)), world.starts[1:]):
        since = np.cumsum(np.cumsum(world.labels["phase"][rows] == "dwell") > 0)
        values[rows, 2] = -2.0 * (1.0 - np.exp(-since / 1.5))
    return values


def drop_at_slip(world):
    """The shear force drops where slip begins."""
    values = np.zeros_like(world.values)
    values[:, 0] = -2.0 * (world.labels["contact"] == "slip")
    return values


def test_events_are_named():
    """Labels that change become the moments that people know."""
    names = {one.name for one in find_events(planted())}
    assert {"contact onset", "dwell start", "slip onset", "reversal"} <= names


def test_labels_of_other_tables_make_events_too():
    """A change of an unknown label inside trajectories is said with its values."""
    world = planted()
    gear = np.where(np.tile(np.arange(15), 40) > 7, "high", "low")
    other = type(world)(world.values, world.components, world.groups, {}, {"gear": gear})
    assert [one.name for one in find_events(other)] == ["gear turns from low to high"]


@pytest.mark.parametrize(
    ("plant", "event", "component"), [(decay_in_dwell, "dwell start", "fz"), (drop_at_slip, "slip onset", "fx")]
)
def test_what_an_event_brings_is_found_at_it(plant, event, component):
    """The most certain cluster lies after the right event, in the right component."""
    world = planted(1, 60, plant=plant, own=False)
    found = event_locked(world, find_events(world), draws=499)
    best = min(found, key=lambda one: (one.p, -abs(one.clusters[0].mass) if one.clusters else 0.0))
    assert best.event == event
    assert best.p <= 0.01
    assert best.clusters[0].component == component
    assert best.clusters[0].start in (0, 1)
    assert component in best.words


@pytest.mark.parametrize(
    ("plant", "event", "component"), [(decay_in_dwell, "dwell start", "fz"), (drop_at_slip, "slip onset", "fx")]
)
def test_events_compete_for_what_a_calibration_has_left(plant, event, component):
    """The event at which a drift began is told in nine of ten worlds, with E, mu and each trajectory's offset free."""
    hits = 0
    for seed in range(10):
        world = planted(seed, 60, plant=plant)
        first = event_effects(project(world), find_events(world), seed, 299)[0]
        hits += (first.event, first.component, first.p <= 0.05) == (event, component, True)
    assert hits >= 9


@pytest.mark.slow
def test_departure_false_alarms(nulls):
    """False alarms stay at 5 % over all events, components and shapes."""
    smallest = [
        event_effects(projection, find_events(world), seed, 199)[0].p
        for seed, (world, projection) in enumerate(nulls[:100])
    ]
    assert is_level(rate_of(smallest))


def test_what_goes_with_the_slide_shows_though_trajectories_slide_to_all_sides():
    """A shear that is too small from the start of the slide on shows along each trajectory's way, in no component."""
    rng = np.random.default_rng(3)
    angle = np.repeat(rng.uniform(0, 2 * np.pi, 40), 15)
    way = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(600)])

    def plant(world):
        return 1.5 * way * (world.labels["phase"] == "shear")[:, None]

    world = planted(4, plant=plant, heavy=False)
    told = dataclasses.replace(world, ways={"shear along the slide": way})
    without, with_ways = (event_effects(project(one), find_events(one), 4, 299) for one in (world, told))
    assert without[0].p > 0.01
    first = with_ways[0]
    assert (first.component, first.event) == ("shear along the slide", "shear start")
    assert first.p <= 0.01


@pytest.mark.slow
def test_event_locked_false_alarms(nulls):
    """False alarms stay at 5 % over all events and components."""
    smallest = [
        min(one.p for one in event_locked(world.with_values(projection.left), find_events(world), seed=seed, draws=199))
        for seed, (world, projection) in enumerate(nulls)
    ]
    assert is_level(rate_of(smallest))


def test_event_means_are_those_of_a_loop():
    """Means over trajectories, the mean before the event taken off, as written out."""
    world = planted(2, 12)
    events = next(one for one in find_events(world) if one.name == "dwell start")
    found = event_locked(world, [events], 2, 2, draws=19)[0]
    expected = []
    for row in events.rows:
        window = world.values[row - 2 : row + 2]
        expected.append(window - window[:2].mean(axis=0))
    np.testing.assert_allclose(found.mean, np.mean(expected, axis=0), atol=1e-12)
    np.testing.assert_allclose(found.deviation, np.std(expected, axis=0, ddof=1) / np.sqrt(12), atol=1e-9)


def test_a_step_between_trajectories_is_found_where_it_is():
    """E that is 30 % lower from trajectory 30 on gives one step, there, with its size."""

    def plant(world):
        return -world.slopes[:, :, 0] * (0.3 * MODULUS * (world.trajectory >= 30))[:, None]

    steps = change_points(project(planted(2, 60, plant=plant)))
    assert [step.parameter for step in steps] == ["E"]
    assert abs(steps[0].after - 30) <= 3
    assert abs(steps[0].change.value / MODULUS + 0.3) < 0.1
    assert "falls" in steps[0].words


def test_a_stretch_that_differs_has_two_ends():
    """A bump, which a single step would miss."""

    def plant(world):
        inside = (world.trajectory >= 20) & (world.trajectory < 35)
        return world.slopes[:, :, 0] * (0.5 * MODULUS * inside)[:, None]

    steps = change_points(project(planted(3, 60, plant=plant)))
    assert sorted(round(step.after / 5) for step in steps) == [4, 7]


def test_a_step_at_a_change_of_label_says_so():
    """The indenter that was changed there is named."""
    world = planted(2, 60)
    indenter = np.where(world.trajectory >= 30, "cone", "ball")
    moved = type(world)(
        world.values - world.slopes[:, :, 0] * (400.0 * (world.trajectory >= 30))[:, None],
        world.components, world.groups, world.covariates, {"indenter": indenter}, world.parameters, world.slopes,
    )  # fmt: skip
    step = change_points(project(moved))[0]
    if step.after == 30:
        assert "indenter ball to cone changes" in step.words
    assert abs(step.after - 30) <= 2


@pytest.mark.slow
def test_step_false_alarms(nulls):
    """False alarms stay at 5 % over all parameters."""
    found = [change_points(projection, seed=seed, draws=199) for seed, (_, projection) in enumerate(nulls)]
    assert is_level(np.mean([bool(steps) for steps in found]))


def test_series_are_least_squares_of_each_trajectory():
    """What a trajectory alone says of E, its own offset marginalised, equals a fit written out."""
    world = planted(4, 10)
    projection = project(world)
    series = series_of(projection, "index")[0]
    rows = world.trajectory == series.trajectories[0]
    own = world.slopes[rows][:, :, 2].ravel() * 0.04
    weight = np.linalg.inv(np.eye(len(own)) + np.outer(own, own))
    slope = world.slopes[rows][:, :, 0].ravel()
    expected = slope @ weight @ projection.left[rows].ravel() / (slope @ weight @ slope)
    np.testing.assert_allclose(series.values[0], expected, rtol=1e-8)


def test_a_soft_corner_shows_on_the_map():
    """E 40 % lower about x = 4, y = -5 mm: the summit lies there, the map goes down there."""

    def plant(world):
        x, y = world.covariates["x"].values, world.covariates["y"].values
        near = np.exp(-0.5 * ((x - 4) ** 2 + (y + 5) ** 2) / 2.5**2)
        return -world.slopes[:, :, 0] * (0.4 * MODULUS * near)[:, None]

    first = region_maps(project(planted(5, 120, plant=plant)), draws=499)[0]
    assert (first.parameter, first.p <= 0.05) == ("E", True)
    row, column = np.unravel_index(np.abs(first.statistic).argmax(), first.statistic.shape)
    assert np.hypot(first.x[column] - 4, first.y[row] + 5) < 4
    assert first.departure[row, column] < 0
    assert np.abs(first.statistic).max() > first.band


@pytest.mark.slow
def test_map_false_alarms(nulls):
    """False alarms stay at 5 % over all parameters and places."""
    smallest = [
        min(one.p for one in region_maps(projection, seed=seed, draws=199))
        for seed, (_, projection) in enumerate(nulls)
    ]
    assert is_level(rate_of(smallest))


def test_no_map_of_a_line():
    """Touches along one line of the gel span no plane."""
    world = planted(0)
    flat = {**world.covariates, "y": type(world.covariates["y"])(np.zeros(len(world.values)), "mm")}
    line = type(world)(world.values, world.components, world.groups, flat, {}, world.parameters, world.slopes)
    assert region_maps(project(line)) == ()


def test_a_leaf_is_found_and_confirmed():
    """A shear force is off where the press is deep and fast; half of the data find it, the other half agree."""

    def plant(world):
        where = (world.covariates["depth"].values > 0.5) & (world.covariates["speed"].values > 1.0)
        values = np.zeros_like(world.values)
        values[:, 0] = 2.5 * where
        return values

    first = honest_tree(project(planted(6, 80, plant=plant)), draws=499)[0]
    assert first.p <= 0.01
    assert first.component == "fx"
    assert "speed above" in first.conditions
    assert first.effect > 1


@pytest.mark.slow
def test_tree_false_alarms(nulls):
    """5 % over all leaves and components."""
    found = [honest_tree(projection, seed, draws=199) for seed, (_, projection) in enumerate(nulls)]
    assert is_level(rate_of([min([leaf.p for leaf in leaves], default=1.0) for leaves in found]))


def test_the_excess_is_found_in_its_corner():
    """Excess in fx and fy during slip only: said so, with nearly all of it."""

    def plant(world):
        values = np.zeros_like(world.values)
        values[:, :2] = 3.0 * (world.labels["contact"] == "slip")[:, None]
        return values

    shares = energy_shares(project(planted(7, 60, plant=plant, random_effects=False, heavy=False)))
    assert shares.sharpest is not None
    assert {"component", "contact"} <= set(shares.sharpest.factors)
    assert shares.sharpest.words.startswith("fx, fy, contact slip")
    assert shares.sharpest.share > 0.85
    assert shares.sharpest.interval[0] < shares.sharpest.share < shares.sharpest.interval[1]


def test_shares_of_a_factor_add_up():
    """Levels of one factor share the whole excess."""
    shares = energy_shares(project(planted(8, plant=drop_at_slip)))
    for factor in ("phase", "depth", "indenter"):
        parts = [cell for cell in shares.cells if cell.factors == (factor,)]
        assert np.isclose(sum(cell.share for cell in parts), 1.0)
        assert np.isclose(sum(cell.of_values for cell in parts), 1.0)


def test_no_excess_no_shares():
    """A residual smaller than the noise has nothing to share out."""
    shares = energy_shares(project(planted(9, random_effects=False).with_values(np.zeros((600, 3)))))
    assert (shares.cells, shares.sharpest) == ((), None)
    assert "no larger than the noise" in shares.words


def test_structure_in_free_air_is_said_first():
    """A zero of fy that drifts with the clock is found without contact; a stiffer gel is not."""

    def drift(world):
        values = np.zeros_like(world.values)
        values[:, 1] = 0.05 * world.covariates["minutes"].values
        return values

    found = free_air(planted(1, 60, frames=30, plant=drift), draws=499)
    assert found.p <= 0.01
    assert {one.parameter for one in found.drifts if one.p <= 0.05} == {"zero of fy"}
    assert "before anything touches" in found.words
    stiffer = planted(1, 60, frames=30, plant=modulus_over("depth", 0.5, 0.2, 1.0))
    assert free_air(stiffer, draws=499).p > 0.05


@pytest.mark.slow
def test_free_air_false_alarms(nulls):
    """False alarms stay at 5 %."""
    assert is_level(rate_of([free_air(world, seed, draws=199).p for seed, (world, _) in enumerate(nulls[:100])]))


def test_no_free_air_is_said():
    """Nothing is tested if no frame is in free air, and the words say what follows from that."""
    world = planted()
    bare = type(world)(world.values, world.components, world.groups)
    found = free_air(bare)
    assert (found.p, found.is_tested) == (1.0, False)
    assert "cannot be told" in found.words


def test_a_common_offset_is_a_calibration():
    """E off by 60 kPa everywhere: found, with its size, and no drift of E is needed."""
    world = planted(3, plant=lambda world: world.slopes[:, :, 0] * 60.0)
    first = offsets(world, draws=499)[0]
    assert (first.parameter, first.p <= 0.01) == ("E", True)
    assert abs(first.change.value - 60) < first.change.half_width * 1.5


@pytest.mark.slow
def test_offset_false_alarms(nulls):
    """False alarms stay at 5 % over all parameters."""
    smallest = [offsets(world, seed, draws=199)[0].p for seed, (world, _) in enumerate(nulls)]
    assert is_level(rate_of(smallest))


def test_an_even_residual_sits_nowhere():
    """Noise without a known size: the sharpest corner is no more than chance, and no sentence says where it sits."""
    shares = energy_shares(project(planted(10, 40, random_effects=False, heavy=False)), noise=0.0)
    assert shares.sharpest is not None
    assert not shares.is_uneven
    assert shares.words.startswith("No part of the data surely holds more")
