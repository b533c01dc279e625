"""A touch of a domed gel: against hand computations, between the two forms of contact, and against the gel engine."""

import json
from dataclasses import replace

import numpy as np
import pytest
from hidden_worlds import contact_of, stated, touch

from tactiledata.effects.touch.gel_variants import warped
from tactiledata.effects.touch.response import GelVariant
from tactiledata.rig.contact.gel_cap import Cap
from tactiledata.rig.motion.motion import gel_from_indenter_rotation

RADIUS = 0.08
DOME = stated("dome", curvature=1 / RADIUS)
PRESS = {"press": {"depth": 0.0007, "step": 0.0002, "settle": 0.05}}
OUTWARD = {"shear": {"by": [0.0010, 0.0], "step": 0.0002, "speed": 0.001, "settle": 0.1}}
MATERIAL = {"youngs_modulus": 0.9e6, "poisson_ratio": 0.475, "friction": 0.7}
LAYER = {"contact": "layer", "contact_pitch": 0.0006}
SCATTER = {"ball": 0.0, "punch": 0.06}
"""Share of its pull by which a slide that is shifted by 1e-8 m ends elsewhere: under an edge, tolerances of steps add
up, and so do the last bits of a processor."""
SLIPPERY = {"material": {**MATERIAL, "friction": 1e-6}}


PLAYED = {}
"""Wrenches that several tests ask for, by what was played."""


def last(hidden, phase, *played, **changes):
    """Wrench (6,) at the end of a phase, played once for all tests."""
    asked = json.dumps([hidden, phase, played, changes], sort_keys=True)
    if asked not in PLAYED:
        PLAYED[asked] = last_of(hidden, phase, *played, **changes)
    return PLAYED[asked]


def last_of(hidden, phase, position=(0.004, 0.0), indenter="ball", steps=(PRESS,), material=MATERIAL, **changes):
    trajectories = [touch("a", indenter, position, steps, force_limit=30.0)]
    _, phases, wrench, _, _ = contact_of(hidden, trajectories=trajectories, material=material, **changes)
    return wrench[np.flatnonzero(phases == phase)[-1]]


def test_a_cap_falls_as_its_slope_says():
    """A cap has the height of a sphere, its slope is the derivative of that height, and a flat cap does not fall."""
    cap, step = Cap(1 / RADIUS), 1e-6
    x, y = np.array([0.003, -0.005]), np.array([0.001, 0.004])
    np.testing.assert_allclose(cap.fall(x, y), RADIUS - np.sqrt(RADIUS**2 - x**2 - y**2), rtol=1e-12)
    for place in zip(x, y, strict=True):
        at = np.array(place)
        slope = [float(cap.fall(*(at + side)) - cap.fall(*(at - side))) / (2 * step) for side in step * np.eye(2)]
        np.testing.assert_allclose(cap.downhill(place), slope, rtol=1e-6)
        assert cap.fall_from(place, *place) == 0.0
    assert not Cap().fall(x, y).any()
    assert not Cap().downhill((0.003, 0.001)).any()


@pytest.mark.parametrize("form", [{}, pytest.param(LAYER, marks=pytest.mark.slow)], ids=["closed", "layer"])
def test_in_the_middle_a_ball_presses_like_a_smaller_one_on_a_flat_gel(form):
    """The force is that of 1 / R' = 1 / R + 1 / R_dome (Hertz), 3 % less than on a flat gel."""
    domed = last([DOME], "press", (0.0, 0.0), **form)
    smaller = {"ball": {"shape": "sphere", "radius": 1 / (1 / 0.004 + 1 / RADIUS)}}
    flat = last((), "press", (0.0, 0.0), indenters=smaller, **form)
    np.testing.assert_allclose(domed[2], flat[2], rtol=1e-2)
    plain = last((), "press", (0.0, 0.0), **form)
    assert domed[2] < 0.98 * plain[2]
    assert np.abs(domed[:2]).max() < 1e-2 * domed[2]


@pytest.mark.slow
@pytest.mark.parametrize("form", [{}, LAYER], ids=["closed", "layer"])
def test_without_friction_the_force_is_along_the_normal(form):
    """The force on the ball is on the line from the dome's centre to the ball's."""
    domed = last([DOME], "press", **form, **SLIPPERY)
    flat = last((), "press", **form, **SLIPPERY)
    slope = 0.004 / (RADIUS + 0.004 - 0.0007)
    assert (domed[0] - flat[0]) / domed[2] == pytest.approx(slope, rel=0.1)
    assert abs(domed[1]) < 1e-3 * domed[2]


@pytest.mark.parametrize("form", [{}, pytest.param(LAYER, marks=pytest.mark.slow)], ids=["closed", "layer"])
def test_on_the_other_side_it_is_the_mirror_image(form):
    """A touch on the other side of the dome has the mirrored wrench."""
    inward = {"shear": {**OUTWARD["shear"], "by": [-0.0010, 0.0]}}
    one = last([DOME], "shear", steps=(PRESS, OUTWARD), **form)
    other = last([DOME], "shear", (-0.004, 0.0), steps=(PRESS, inward), **form)
    mirrored = one * [-1, 1, 1, 1, -1, -1]
    np.testing.assert_allclose(other[:3], mirrored[:3], rtol=2e-2, atol=2e-2)
    np.testing.assert_allclose(other[3:], mirrored[3:], rtol=2e-2, atol=1e-4)


@pytest.mark.slow
def test_both_forms_of_contact_lose_as_much_on_the_way_out():
    """Sliding downhill, a ball leaves the gel: pull, force and torque fall alike, within a third."""
    lost = [
        last([DOME], "shear", steps=(PRESS, OUTWARD), **form) - last((), "shear", steps=(PRESS, OUTWARD), **form)
        for form in ({}, LAYER)
    ]
    assert lost[1][0] > 0.5
    assert lost[1][2] < -0.5
    np.testing.assert_allclose(lost[0][[0, 2, 4]], lost[1][[0, 2, 4]], rtol=0.33)


@pytest.mark.slow
def test_the_picture_shows_the_indenter_where_the_gel_is():
    """Within the contact, the surface that is seen lies where the ball is: its depth below the dome at rest."""
    trajectories = [touch("a", "ball", (0.004, 0.0), (PRESS,), force_limit=30.0)]
    _, phases, _, _, play = contact_of([DOME], trajectories=trajectories, material=MATERIAL, **LAYER)
    seconds = np.flatnonzero(phases == "press")[-1] / 500.0
    deepest = -float(play.contact.surface(seconds).min())
    fall = RADIUS - np.sqrt(RADIUS**2 - 0.004**2)
    assert deepest == pytest.approx(0.0007 - fall, abs=1.5e-5)


@pytest.mark.nightly
@pytest.mark.parametrize("indenter", ["ball", "punch"])
def test_it_changes_forces_as_a_domed_mesh_does(indenter):
    """The gel engine on a mesh of that shape: what the dome adds to pull, force and torque after a slide outward."""
    pytest.importorskip("numba")
    from tactiledata.gel.contact.history import GelTouch
    from tactiledata.gel.elasticity.material import GelMaterial
    from tactiledata.gel.engines.fem import FemEngine
    from tactiledata.gel.mesh.structured_pad import pad_mesh
    from tactiledata.rig.contact.contact import contact_times
    from tactiledata.sensors.digit import DIGIT

    press = {"press": {**PRESS["press"], "depth": 0.0005}}
    trajectories = [touch("a", indenter, (0.004, 0.0), (press, OUTWARD), force_limit=30.0)]
    (dome, flat) = (contact_of(one, trajectories=trajectories, material=MATERIAL, **LAYER) for one in ([DOME], ()))
    _, phases, _, _, play = flat
    at = np.flatnonzero(phases == "shear")[-1]
    change = dome[2][at] - flat[2][at]

    positions = play.path.at(contact_times(play.path))
    first = np.flatnonzero(positions[:, 2] > -1e-4)[0]
    rows = np.unique(np.linspace(first, at, 20).astype(int))
    poses = np.tile(np.eye(4), (len(rows), 1, 1))
    poses[:, :3, 3] = positions[rows] * [1, 1, -1]
    poses[:, :3, :3] = gel_from_indenter_rotation(play.touch)
    thickness = 0.0041
    mesh = pad_mesh("flat", replace(DIGIT.gel, thickness=thickness, edge_thickness=thickness))
    wrenches = []
    for dome_of in (1 / (2 * thickness * RADIUS), 0.0):
        engine = FemEngine(warped(mesh, GelVariant(dome=dome_of)), MATERIAL["poisson_ratio"], "finite-strain")
        body = play.contact.setup.indenter
        ((_, history),) = engine.play([GelTouch(body, poses)], GelMaterial(*MATERIAL.values()), "none")
        wrenches.append(history.wrench[-1])
    expected = wrenches[0] - wrenches[1]
    allowed = 0.15 * np.abs(expected)
    allowed[0] += SCATTER[indenter] * abs(flat[2][at][0])
    off = np.abs(change - expected)[[0, 2, 4]]
    assert (off <= allowed[[0, 2, 4]]).all(), f"{change[[0, 2, 4]]} for {expected[[0, 2, 4]]}"
