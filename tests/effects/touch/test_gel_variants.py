"""Variants of the gel: where the surface stays and the base moves, and the other way round."""

import numpy as np
import pytest

from tactiledata.effects.touch.gel_variants import surface_height, variant_engine, warped
from tactiledata.effects.touch.response import GelVariant, SoftSpot
from tactiledata.gel.contact.history import GelTouch
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.gel.mesh.structured_pad import GridPlan, structured_pad
from tactiledata.indenters.sphere import Sphere
from tactiledata.sensors.digit import DIGIT

PAD = structured_pad("coarse", DIGIT.gel, GridPlan(7, 9, 0.8e-3, (2.4e-3, 2.4e-3), (0.0, 0.5, 0.8, 1.0)))


def forces(variant, places=((0.0, 0.0),), depth=0.4e-3):
    """Normal force, N, of a ball at each place on one gel."""
    touches = []
    for place in places:
        poses = np.eye(4)[None].copy()
        poses[0, :2, 3] = place
        poses[0, 2, 3] = surface_height(PAD, np.array([place]))[0] - depth
        touches.append(GelTouch(Sphere(radius=4e-3), poses))
    engine = variant_engine(PAD, 0.47, "linear", variant)
    histories = dict(engine.play(touches, GelMaterial(1.0, 0.47, 0.5)))
    return [histories[number].wrench[0, 2] for number in range(len(touches))]


def test_the_nominal_gel_is_the_pad_itself():
    assert warped(PAD, GelVariant()) is PAD
    assert surface_height(PAD, PAD.vertices[PAD.surface][:, :2]).max() == pytest.approx(0.0, abs=1e-9)


def test_a_thicker_pad_keeps_its_surface():
    thick = warped(PAD, GelVariant(thickness=1.2))
    assert np.abs(thick.vertices - PAD.vertices)[PAD.surface][:, :2].max() == 0
    up = surface_height(PAD, PAD.vertices[:, :2]) - PAD.vertices[:, 2] < 1e-9
    assert np.abs(thick.vertices - PAD.vertices)[up].max() < 1e-12
    assert thick.vertices[PAD.base, 2].max() == pytest.approx(PAD.vertices[PAD.base, 2].max() - 0.2 * PAD.thickness)


def test_a_dome_keeps_its_base_and_its_middle():
    dome = warped(PAD, GelVariant(dome=2000.0))
    assert np.array_equal(dome.vertices[PAD.base], PAD.vertices[PAD.base])
    assert surface_height(dome, np.zeros((1, 2)))[0] == pytest.approx(0.0, abs=2e-5)
    place = np.array([[3e-3, 4e-3]])
    fall = surface_height(PAD, place) - surface_height(dome, place)
    assert fall[0] == pytest.approx(PAD.thickness * 2000.0 * 25e-6, rel=0.1)


def test_each_variant_changes_the_force_its_own_way():
    on_spot, beside = (3e-3, 3e-3), (-4e-3, -5e-3)
    plain, plain_on_spot, plain_beside = forces(GelVariant(), ((0.0, 0.0), on_spot, beside))
    assert forces(GelVariant(thickness=1.2))[0] < 0.99 * plain
    assert forces(GelVariant(skin=0.3e-3))[0] > 1.01 * plain
    softer, same = forces(GelVariant(spots=(SoftSpot(3e-3, 3e-3, 2e-3, 0.4),)), (on_spot, beside))
    assert softer < 0.85 * plain_on_spot
    assert same == pytest.approx(plain_beside, rel=0.02)
