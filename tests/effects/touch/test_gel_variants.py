"""Variants of the gel: where the surface stays and the base moves, and the other way round."""

import dataclasses

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tactiledata.effects.touch.gel_variants import _cell_factors, contact_height, surface_height, variant_engine, warped
from tactiledata.effects.touch.response import GelVariant, SoftSpot
from tactiledata.gel.contact.history import GelTouch
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.gel.mesh.structured_pad import GridPlan, structured_pad
from tactiledata.indenters.cylinder_flat import CylinderFlat
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
    """The nominal variant is the very same mesh, with its surface at height 0."""
    assert warped(PAD, GelVariant()) is PAD
    assert surface_height(PAD, PAD.vertices[PAD.surface][:, :2]).max() == pytest.approx(0.0, abs=1e-9)


def test_a_turned_punch_touches_with_its_rim_before_its_tip():
    """A ball meets the surface with its tip; a flat punch of 4 mm radius turned by 0.1 rad does 4 mm x 0.1 earlier."""
    places = np.array([[0.0, 0.0], [3e-3, -5e-3]])
    poses = np.tile(np.eye(4), (2, 1, 1))
    poses[:, :3, :3] = Rotation.from_euler("y", 0.1).as_matrix()
    poses[:, :2, 3] = places
    poses[:, 2, 3] = 7.0  # the height of the pose plays no part
    surface = surface_height(PAD, places)
    assert abs(surface[1] - surface[0]) > 1e-4
    ball, punch = (contact_height(PAD, solid, poses) for solid in (Sphere(radius=4e-3), CylinderFlat(radius=4e-3)))
    assert ball == pytest.approx(surface, abs=5e-5)
    assert punch == pytest.approx(surface + 4e-4, abs=5e-5)


def test_a_thicker_pad_keeps_its_surface():
    """A pad that is 20 % thicker keeps its outer surface, and its base lies lower by 20 %."""
    thick = warped(PAD, GelVariant(thickness=1.2))
    assert np.abs(thick.vertices - PAD.vertices)[PAD.surface][:, :2].max() == 0
    up = surface_height(PAD, PAD.vertices[:, :2]) - PAD.vertices[:, 2] < 1e-9
    assert np.abs(thick.vertices - PAD.vertices)[up].max() < 1e-12
    assert thick.vertices[PAD.base, 2].max() == pytest.approx(PAD.vertices[PAD.base, 2].max() - 0.2 * PAD.thickness)


def test_a_dome_keeps_its_base_and_its_middle():
    """A domed pad keeps its base and the height of its middle, and falls with the square of the distance."""
    dome = warped(PAD, GelVariant(dome=2000.0))
    assert np.array_equal(dome.vertices[PAD.base], PAD.vertices[PAD.base])
    assert surface_height(dome, np.zeros((1, 2)))[0] == pytest.approx(0.0, abs=2e-5)
    place = np.array([[3e-3, 4e-3]])
    fall = surface_height(PAD, place) - surface_height(dome, place)
    assert fall[0] == pytest.approx(PAD.thickness * 2000.0 * 25e-6, rel=0.1)


@pytest.mark.slow
def test_each_variant_changes_the_force_its_own_way():
    """A thicker pad is softer, a skin stiffer, and a soft spot softer above the spot only."""
    on_spot, beside = (3e-3, 3e-3), (-4e-3, -5e-3)
    plain, plain_on_spot, plain_beside = forces(GelVariant(), ((0.0, 0.0), on_spot, beside))
    assert forces(GelVariant(thickness=1.2))[0] < 0.99 * plain
    assert forces(GelVariant(skin=0.3e-3))[0] > 1.01 * plain
    softer, same = forces(GelVariant(spots=(SoftSpot(3e-3, 3e-3, 2e-3, 0.4),)), (on_spot, beside))
    assert softer < 0.85 * plain_on_spot
    assert same == pytest.approx(plain_beside, rel=0.02)


def cells():
    """The middle of each cell, its height, and whether it has a face on the outer surface."""
    corners = PAD.vertices[PAD.cells]
    top = np.isclose(surface_height(PAD, PAD.vertices[:, :2]), PAD.vertices[:, 2], atol=1e-9)
    return corners.mean(axis=1), np.ptp(corners[:, :, 2], axis=1), top[PAD.cells].sum(axis=1) == 4


def test_a_skin_stiffens_the_uppermost_cells_by_its_thickness_over_theirs():
    """The factor is 1 + skin / height on cells under the surface, away from rounded sides, and 1 below."""
    middles, heights, is_upper = cells()
    inner = (np.abs(middles[:, 0]) < 6e-3) & (np.abs(middles[:, 1]) < 6e-3)
    found = _cell_factors(PAD, GelVariant(skin=2e-4))
    assert (inner & is_upper).sum() > 50
    np.testing.assert_allclose(found[inner & is_upper], 1 + 2e-4 / heights[inner & is_upper])
    assert (found[inner & ~is_upper] == 1.0).all()


def test_spots_multiply_the_modulus_through_the_whole_thickness():
    """Each spot gives the factor 1 - loss exp(-r^2 / (2 radius^2)) at any depth; without skin and spots it is 1."""
    middles, _, _ = cells()
    spots = (SoftSpot(1e-3, -2e-3, 1.5e-3, 0.4), SoftSpot(-3e-3, 0.0, 3e-3, 0.2))
    wanted = np.ones(len(middles))
    for spot in spots:
        away = np.hypot(middles[:, 0] - spot.x, middles[:, 1] - spot.y)
        wanted *= 1 - spot.loss * np.exp(-0.5 * (away / spot.radius) ** 2)
    np.testing.assert_allclose(_cell_factors(PAD, GelVariant(spots=spots)), wanted)
    assert _cell_factors(PAD, GelVariant(thickness=1.2, dome=1e3, c20=0.1)) is None


def test_between_its_nodes_the_surface_is_a_plane_and_outside_the_nearest_node():
    """The surface has the nodes' own height at the nodes, and far beyond the pad that of the surface, not a hole."""
    nodes = PAD.vertices[np.unique(PAD.faces)]
    inner = nodes[(np.abs(nodes[:, 0]) < 5e-3) & (np.abs(nodes[:, 1]) < 5e-3)]
    np.testing.assert_allclose(surface_height(PAD, inner[:, :2]), inner[:, 2], atol=1e-12)
    far = surface_height(PAD, np.array([[1.0, 0.0], [0.0, -1.0]]))
    assert np.isfinite(far).all()
    assert all(np.isclose(nodes[:, 2], height).any() for height in far)


def test_a_warped_pad_moves_all_its_nodes_in_proportion():
    """Half-way up, a pad 1.2 times as thick with a dome of 2000 1/m^2 moves by half of what base and surface move."""
    both = warped(PAD, GelVariant(thickness=1.2, dome=2000.0))
    x, y, z = PAD.vertices.T
    bottom = PAD.vertices[PAD.base, 2].max()
    share = (z - bottom) / (surface_height(PAD, PAD.vertices[:, :2]) - bottom)
    lowered = share * PAD.thickness * 2000.0 * (x**2 + y**2) + (1 - share) * 0.2 * PAD.thickness
    np.testing.assert_allclose(PAD.vertices[:, 2] - both.vertices[:, 2], lowered, atol=1e-12)
    np.testing.assert_array_equal(both.vertices[:, :2], PAD.vertices[:, :2])
    assert both.name != PAD.name


@pytest.mark.parametrize("is_reversed", [False, True])
def test_of_nodes_above_one_another_the_uppermost_is_the_surface(is_reversed):
    """A face that hangs below the surface, as on upright sides, hides nothing, in whatever order nodes are numbered."""
    under = PAD.base[np.hypot(*PAD.vertices[PAD.base, :2].T) < 5e-3][:4]
    walled = dataclasses.replace(PAD, faces=np.vstack([PAD.faces, under]))
    if is_reversed:
        last = len(PAD.vertices) - 1
        walled = dataclasses.replace(walled, vertices=PAD.vertices[::-1], faces=last - walled.faces)
    places = PAD.vertices[under, :2]
    np.testing.assert_allclose(surface_height(walled, places), surface_height(PAD, places), atol=1e-12)
