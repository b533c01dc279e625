"""Worlds that are played by the layer solver: steps, force limit, pictures, the same bytes from any worker."""

import filecmp
import json
from functools import partial

import numpy as np
import pandas as pd
import pytest

from tactiledata.indenters import make_indenter
from tactiledata.rig.contact.by_layer import STEP, STEP_OUT, solver_steps, touch_layer
from tactiledata.rig.contact.contact import TouchSetup
from tactiledata.rig.contact.footprint import GelGrid, make_footprint
from tactiledata.rig.layer.grid import LayerGrid
from tactiledata.rig.layer.solver import Layer
from tactiledata.rig.motion import motion
from tactiledata.rig.motion.touch import Step, TouchPlan
from tactiledata.rig.record import record
from tactiledata.rig.scenario.scenario import Gel, Material, load_scenario

GEL = Gel((0.0124, 0.0124), 0.0041)
PRESS = Step("press", depth=4e-4, settle=0.05)
OFFSET = np.array([1e-5, -2e-5, 2.5e-5])
WORLD = {
    "format": "tactiledata-scenario/1",
    "seed": 5,
    "contact": "layer",
    "contact_pitch": 0.001,
    "sensors": {"D1": {"background": "digit-bg-0"}, "D2": {"background": "digit-bg-3"}},
    "indenters": {"ball": {"shape": "sphere", "radius": 0.004}},
    "streams": {"joints": 50, "tcp": 50, "wrench": 50, "arm_wrench": 20},
    "trajectories": [
        {"name": f"touch-{serial}", "sensor": serial, "indenter": "ball", "steps": [{"press": {"depth": 0.0003}}]}
        for serial in ("D1", "D2")
    ],
}


@pytest.fixture(scope="module")
def layer():
    return Layer(LayerGrid.of(GEL.outline, 5e-4), GEL.thickness, Material())


def setup_of(*steps, shape="sphere", force_limit=13.0, tilt=(0.0, 0.0)):
    touch = TouchPlan("t", "s", "i", steps, tilt=tilt, force_limit=force_limit)
    sizes = {"radius": 0.004} if shape == "sphere" else {}
    indenter = make_indenter({"shape": shape, **sizes}, None, "test")
    rotation = motion.gel_from_indenter_rotation(touch)
    footprint = make_footprint(indenter, rotation, touch.position, GelGrid.of(GEL))
    plan = partial(motion.plan, touch)
    return TouchSetup(touch, indenter, rotation, footprint, OFFSET, GEL.thickness, Material(), plan)


def test_steps_of_the_solver_are_small_and_hit_the_corners():
    """No step in the gel is longer than allowed; ends of moves, first and last touch are among them."""
    path = setup_of(PRESS, Step("shear", by=(2.5e-4, 0.0))).plan(lambda _: 1.0)
    marks, positions = solver_steps(path, OFFSET)
    assert (np.diff(marks) > 0).all()
    np.testing.assert_allclose(np.diff(marks), np.linalg.norm(np.diff(positions, axis=0), axis=1))
    inside = (positions[1:, 2] > 1e-12) | (positions[:-1, 2] > 1e-12)
    assert np.diff(marks)[inside].max() <= STEP_OUT * 1.0001
    rising = inside & (np.diff(positions[:, 2]) >= 0)
    assert np.diff(marks)[rising].max() <= STEP * 1.0001
    assert np.count_nonzero(np.abs(positions[:, 2]) < 1e-12) == 2
    for corner in path.positions + OFFSET:
        assert np.linalg.norm(positions - corner, axis=1).min() < 1e-12


def test_force_begins_and_ends_with_contact(layer):
    """The force is zero in the air, rises through the press, is held and zero again, with the depth that was asked."""
    contact = touch_layer(setup_of(PRESS), layer)
    seconds = np.arange(len(contact.wrench)) / 500.0
    depth = contact.path.at(seconds)[:, 2] + OFFSET[2]
    force = contact.wrench[:, 2]
    assert not force[depth <= 0].any()
    assert (force[depth > 1e-5] > 0).all()
    assert depth[force.argmax()] == pytest.approx(4.25e-4, abs=1e-6)
    down = seconds <= seconds[depth.argmax()]
    assert (np.diff(force[down]) >= -1e-9).all()


@pytest.mark.slow
def test_a_press_stops_at_the_limit_of_force(layer):
    """A punch that may press with 3 N stops there, though 0.4 mm were asked for."""
    contact = touch_layer(setup_of(PRESS, shape="cylinder_flat", force_limit=3.0), layer)
    assert contact.wrench[:, 2].max() == pytest.approx(3.0, rel=0.02)
    assert contact.path.positions[:, 2].max() < 3e-4
    assert contact.unsettled == 0


def test_the_picture_shows_the_indenter_in_the_gel(layer):
    """Under the ball the surface is the ball's, to some micrometres; beside it the gel rises; in the air it is flat."""
    setup = setup_of(PRESS)
    contact = touch_layer(setup, layer)
    surface = contact.surface(float(contact.path.captures[-1]))
    grid = setup.footprint.grid
    x, y = np.meshgrid(grid.x - OFFSET[0], grid.y - OFFSET[1])
    near = np.hypot(x, y) < 6e-4
    np.testing.assert_allclose(surface[near], -4.25e-4 + (np.hypot(x, y)[near]) ** 2 / (2 * 0.004), atol=1e-5)
    ring = (np.hypot(x, y) > 4e-3) & grid.on_pad
    assert surface[ring].max() > 2e-6
    assert not contact.surface(0.1).any()


@pytest.mark.slow
def test_friction_drags_the_picture(layer):
    """After a shear along x the surface before the ball stands higher than behind it."""
    setup = setup_of(PRESS, Step("shear", by=(3e-4, 0.0), settle=0.05))
    contact = touch_layer(setup, layer)
    surface = contact.surface(float(contact.path.captures[-1]))
    grid = setup.footprint.grid
    row = np.abs(grid.y).argmin()
    before, behind = (surface[row, np.abs(grid.x - 3e-4 - side).argmin()] for side in (2.5e-3, -2.5e-3))
    assert before > behind + 5e-6


@pytest.mark.slow
def test_workers_do_not_change_what_is_recorded(tmp_path):
    """One process or two: equal files, truth included; and the truth says which contact it was."""
    scenario = load_scenario(WORLD)
    told = []
    record(scenario, tmp_path / "one", "folder")
    record(scenario, tmp_path / "two", "folder", lambda done, total: told.append((done, total)), workers=2)
    files = sorted(path.relative_to(tmp_path / "one") for path in (tmp_path / "one").rglob("*") if path.is_file())
    _, mismatch, errors = filecmp.cmpfiles(tmp_path / "one", tmp_path / "two", files, shallow=False)
    assert not mismatch
    assert not errors
    assert told[-1] == (2, 2)
    truth = json.loads((tmp_path / "one" / "truth" / "D1.json").read_text())
    assert truth["contact"] == {"form": "layer", "pitch": 0.001}
    contacts = pd.read_parquet(tmp_path / "one" / "truth" / "D1.parquet")
    assert contacts.fz.max() == pytest.approx(truth["trajectories"]["touch-D1"]["peak_force"], rel=0.02)
