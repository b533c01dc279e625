"""Shadows fall away from the light, end where they must, and their strength is found again."""

import numpy as np
import pytest
from known_surfaces import cap, flat_surface, pressed, view

from tactiledata.optics.height_map import Indentation, slopes
from tactiledata.optics.shadows import SOFT_DEPTH, Shadows, cast_shadow, fit_shadows, light_azimuths
from tactiledata.optics.taxim import TaximTable, published_digit_table
from tactiledata.optics.view import View


def wall(height=5e-4, column=60):
    """A wall across all rows, and a view with 50 um pixels."""
    depth = np.zeros((40, 120), np.float32)
    depth[:, column : column + 6] = height
    return depth, View((40, 120), np.diag([5e-5, 5e-5, 1.0]))


@pytest.mark.parametrize("azimuth", [0.0, np.pi])
def test_a_wall_throws_a_shadow_of_its_height_over_the_tangent(azimuth):
    """A shadow of length height / tan(elevation) lies away from the light, and none towards it."""
    depth, seen = wall()
    elevation = np.arctan(0.5)
    shadow = cast_shadow(depth, seen, azimuth, elevation)[20]
    behind, before = (shadow[:60], shadow[66:]) if azimuth == 0 else (shadow[66:], shadow[:60])
    assert before.max() == 0
    length = (behind > 0.5).sum() * 5e-5
    assert length == pytest.approx((5e-4 - SOFT_DEPTH / 2) / 0.5, abs=2.6e-4)  # one place along the way


def test_flat_gel_has_no_shadow():
    """Nor has a slope that no light is steep enough to miss."""
    seen = view((80, 60))
    assert cast_shadow(np.zeros((80, 60)), seen, 1.0, 0.4).max() == 0
    ramp = np.linspace(0, 1e-3, 60)[None, :] * np.ones((80, 1))
    assert cast_shadow(ramp, seen, 0.0, 0.4).max() == 0


def test_planar_shadows_leave_the_contact_alone():
    """FOTS' shadows fall on the flat gel only."""
    surface = flat_surface()
    depth = Indentation(surface, view()).of(pressed(surface, cap(3e-3, 9e-4)))
    planar = cast_shadow(depth, view(), 0.0, 0.2, is_planar=True)
    assert planar[depth > SOFT_DEPTH].max() == 0
    assert planar.max() > 0.9


def test_lights_of_a_table():
    """The light of a channel stands opposite to the slope that it makes brightest."""
    table = np.zeros((32, 33, 3, 6))
    theta = (np.arange(33) + 0.5) / 32 * 2 * np.pi - np.pi
    for channel, azimuth in enumerate((0.3, -2.0, 2.9)):
        table[1:, :, channel, 5] = -np.cos(theta - azimuth)  # a slope that rises towards the light turns away from it
    assert light_azimuths(TaximTable(table, "planted")) == pytest.approx((0.3, -2.0, 2.9), abs=1e-3)


def test_a_planted_shadow_is_found():
    """Elevation and strengths from residuals that the shadow alone made; none where there was none."""
    surface, seen = flat_surface(), view()
    depths = [Indentation(surface, seen).of(pressed(surface, cap(3e-3, 9e-4, (x, x)))) for x in (-2e-3, 1e-3)]
    azimuths = light_azimuths(published_digit_table())
    truth = Shadows(azimuths, 0.25, (0.5, 0.1, 0.3))
    backgrounds = [np.full((*seen.shape, 3), level, np.float32) for level in (90, 140)]
    residuals = [-back * truth.darkening(depth, seen) for back, depth in zip(backgrounds, depths, strict=True)]
    found = fit_shadows(residuals, backgrounds, depths, seen, azimuths)
    assert found.elevation == 0.25
    assert found.strengths == pytest.approx(truth.strengths, abs=1e-4)
    noise = np.random.default_rng(0).normal(0, 1, (2, *seen.shape, 3))
    assert max(fit_shadows(noise, backgrounds, depths, seen, azimuths).strengths) < 0.01
    assert slopes(depths[0], seen).shape == (*seen.shape, 2)
