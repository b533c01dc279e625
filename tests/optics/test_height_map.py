"""Height maps: closed forms, frames, views, and what is refused."""

import numpy as np
import pytest
from known_surfaces import cap, flat_surface, pressed, view

from tactiledata.errors import UsageError
from tactiledata.optics.height_map import Indentation, contact_mask, height_map, rasterise, slopes
from tactiledata.optics.surface import GelSurface
from tactiledata.optics.view import View
from tactiledata.sensors.digit import DIGIT
from tactiledata.store.read.meshes import PadArrays


@pytest.mark.parametrize("skew", [0.0, 1.5e-4])
def test_a_plane_is_drawn_exactly(skew):
    """A tilted plane is linear in x and y, so that triangles of any shape draw it without error."""
    surface = flat_surface(skew=skew)
    drawn = height_map(surface, pressed(surface, lambda x, y: 0.02 * x - 0.03 * y + 1e-4), view())
    x, y = np.moveaxis(view().points(), -1, 0)
    np.testing.assert_allclose(drawn, -(0.02 * x - 0.03 * y + 1e-4), atol=1e-9)


def test_slopes_of_a_plane():
    """Central differences of a plane are its slopes, the border included."""
    surface, seen = flat_surface(), view()
    drawn = Indentation(surface, seen).of(pressed(surface, lambda x, y: 0.02 * x - 0.03 * y))
    np.testing.assert_allclose(slopes(drawn, seen)[..., 0], 0.02, rtol=1e-3)
    np.testing.assert_allclose(slopes(drawn, seen)[..., 1], -0.03, rtol=1e-3)


def test_a_ball_becomes_a_cap_of_second_order():
    """The error of a cap inside its rim falls fourfold with halved triangles, to 2 um at 0.25 mm."""
    errors = []
    for columns in (38, 75):
        surface = flat_surface(columns, int(columns * 1.36))
        drawn = Indentation(surface, view()).of(pressed(surface, cap(4e-3, 6e-4)))
        x, y = np.moveaxis(view().points(), -1, 0)
        inside = np.hypot(x, y) < 1.6e-3
        errors.append(np.abs(drawn - cap(4e-3, 6e-4)(x, y))[inside].max())
    assert errors[1] < 2e-6 * 4
    assert 3.0 < errors[0] / errors[1] < 5.5


def test_moving_mesh_and_view_together_changes_nothing():
    """Height maps depend on where the gel is relative to the camera only."""
    surface, seen = flat_surface(skew=1e-4), view()
    moved = pressed(surface, cap(4e-3, 6e-4, (1e-3, -2e-3)))
    by = np.array([3e-4, -7e-4])
    shifted = GelSurface(surface.places + np.append(by, 0.0), surface.triangles)
    matrix = np.eye(3)
    matrix[:2, 2] = by
    elsewhere = View(seen.shape, matrix @ seen.gel_from_pixel)
    np.testing.assert_allclose(height_map(shifted, moved, elsewhere), height_map(surface, moved, seen), atol=1e-9)


def test_the_mirrored_view_is_the_mirror_image():
    """Seen from behind and from outside, columns run in opposite ways, rows alike."""
    surface = flat_surface()
    moved = pressed(surface, cap(4e-3, 6e-4, (2e-3, 3e-3)))
    behind, outside = Indentation(surface, view()).of(moved), Indentation(surface, view(mirrored=False)).of(moved)
    np.testing.assert_allclose(behind, outside[:, ::-1], atol=1e-9)
    row, column = np.unravel_index(behind.argmax(), behind.shape)
    assert column > behind.shape[1] / 2
    assert row > behind.shape[0] / 2  # gel +x is on the right, +y below
    assert view().is_mirrored
    assert not view(mirrored=False).is_mirrored


def test_places_off_the_gel_have_no_height():
    """Places off the gel are NaN in the height map and 0 in the indentation."""
    surface = flat_surface(width=0.008)
    assert np.isnan(height_map(surface, np.zeros_like(surface.places), view())[:, 0]).all()
    deep = Indentation(surface, view()).of(pressed(surface, lambda x, y: np.full_like(x, 1e-4)))
    assert (deep[:, 0] == 0).all()
    assert deep[80, 60] == pytest.approx(1e-4)


def test_folds_show_what_the_camera_sees():
    """Of two sheets over one pixel the lower one counts, in whatever order they come."""
    corners = np.array([[0, 0], [9, 0], [0, 9], [0, 0], [9, 0], [0, 9]], float)
    heights = np.array([1.0, 1, 1, 2, 2, 2])
    for order in ([[0, 1, 2], [3, 4, 5]], [[3, 4, 5], [0, 1, 2]]):
        drawn = rasterise(corners, heights, np.array(order), (8, 8))
        assert np.nanmax(drawn) == np.nanmin(drawn) == 1.0


def test_every_pixel_of_a_patch_is_drawn_once_or_on_a_border():
    """No cracks: a sheet of crooked triangles leaves no hole inside its outline."""
    surface = flat_surface(skew=2e-4)
    assert np.isfinite(height_map(surface, np.zeros_like(surface.places), view())).all()
    flat = np.array([[0, 0], [4, 4], [8, 8]], float)  # a triangle without area covers nothing
    assert np.isnan(rasterise(flat, np.zeros(3), np.array([[0, 1, 2]]), (9, 9))).all()


def test_contact_masks():
    """The mask of a cap is its disc; nothing touched gives an empty mask; a bulge is no contact."""
    surface, seen = flat_surface(75, 103), view()
    drawn = Indentation(surface, seen).of(pressed(surface, cap(4e-3, 6e-4)))
    radius = np.sqrt(4e-3**2 - (4e-3 - 5.5e-4) ** 2)
    assert contact_mask(drawn).sum() * np.prod(seen.pitches) == pytest.approx(np.pi * radius**2, rel=0.03)
    assert not contact_mask(np.zeros((3, 4, 5))).any()
    assert not contact_mask(np.full((4, 5), -1e-3)).any()
    assert contact_mask(drawn, 5e-4).sum() < contact_mask(drawn).sum()


def test_views_of_other_sizes_see_the_same():
    """Half the pixels, the same corners of the picture; there and back is the same view."""
    whole = view((320, 240))
    half = whole.scaled((160, 120))
    np.testing.assert_allclose(half.gel_from_pixel, view((160, 120)).gel_from_pixel, atol=1e-12)
    np.testing.assert_allclose(half.scaled((320, 240)).gel_from_pixel, whole.gel_from_pixel, atol=1e-12)
    assert half.pitches == pytest.approx([2 * pitch for pitch in whole.pitches])


def test_pixels_and_points_are_inverse():
    """Pixels and points are inverse, also for a camera in perspective."""
    matrix = view().gel_from_pixel.copy()
    matrix[2, :2] = [1e-4, -2e-4]
    crooked = View((160, 120), matrix)
    pixels = np.random.default_rng(0).uniform(0, 120, (50, 2))
    np.testing.assert_allclose(crooked.pixels_at(crooked.points_at(pixels)), pixels, atol=1e-9)


def test_what_cannot_be_drawn_is_refused():
    """A mesh of another size, a frame without a mesh, a view off the gel and a sensor without a camera are refused."""
    surface = flat_surface()
    with pytest.raises(UsageError, match="another mesh"):
        height_map(surface, np.zeros((7, 3)), view())
    missing = np.full_like(surface.places, np.nan)
    with pytest.raises(UsageError, match="no mesh"):
        height_map(surface, missing, view())
    millimetres = View((160, 120), np.diag([1e3, 1e3, 1.0]) @ view().gel_from_pixel + [[0, 0, 1], [0, 0, 0], [0, 0, 0]])
    with pytest.raises(UsageError, match="metres"):
        Indentation(surface, millimetres)
    with pytest.raises(UsageError, match="invertible"):
        View((4, 4), np.zeros((3, 3)))


def test_the_surface_of_a_stored_pad():
    """Triangles are renumbered to the kept nodes; a mesh that keeps too few is refused."""
    vertices = np.random.default_rng(0).normal(0, 1e-3, (1, 9, 3))
    some = np.array([2, 5, 7, 8])
    empty = np.zeros(0, np.int64)
    pad = PadArrays(vertices, empty.reshape(0, 8), np.array([[5, 7, 8], [2, 5, 8]]), some, some, some, empty)
    surface = GelSurface.of_pad(pad)
    assert surface.triangles.tolist() == [[1, 2, 3], [0, 1, 3]]
    np.testing.assert_array_equal(surface.places, vertices[0, some])
    fewer = PadArrays(vertices, empty.reshape(0, 8), np.array([[5, 7, 8]]), some[:3], some, some, empty)
    with pytest.raises(UsageError, match="--keep"):
        GelSurface.of_pad(fewer)
    with pytest.raises(UsageError, match="pad 1"):
        GelSurface.of_pad(pad, 1)


def test_the_nominal_view_needs_a_camera():
    """A force sensor sees nothing."""
    from tactiledata.sensors.robotiq_ft300s import ROBOTIQ_FT300S

    assert View.nominal(DIGIT).shape == (320, 240)
    with pytest.raises(UsageError, match="no pictures"):
        View.nominal(ROBOTIQ_FT300S)
