"""The engine against published solutions of contact."""

import numpy as np
import pytest
from pressing import block, forces_at, poses, pressed, slab

from tactiledata.gel.engines.fem import FemEngine
from tactiledata.indenters.sphere import Sphere

NU = 0.495
RADIUS, DEPTH = 10e-3, 1e-4
CONTACT = np.sqrt(RADIUS * DEPTH)  # m, Hertz's radius of contact


def hertz(radius, depth, poisson_ratio):
    """Force over Young's modulus of a rigid ball on a half-space."""
    return 4 / 3 / (1 - poisson_ratio**2) * np.sqrt(radius) * depth**1.5


def dimitriadis(radius, depth, thickness, poisson_ratio):
    """Hertz's force times the correction for a bonded layer (Dimitriadis et al., Biophys. J. 82, 2002, eq. 12)."""
    alpha = -(1.2876 - 1.4678 * poisson_ratio + 1.3442 * poisson_ratio**2) / (1 - poisson_ratio)
    beta = (0.6387 - 1.0277 * poisson_ratio + 1.5164 * poisson_ratio**2) / (1 - poisson_ratio)
    chi = np.sqrt(radius * depth) / thickness
    return hertz(radius, depth, poisson_ratio) * (
        1
        - 2 * alpha / np.pi * chi
        + 4 * alpha**2 / np.pi**2 * chi**2
        - 8 / np.pi**3 * (alpha**3 + 4 * np.pi**2 / 15 * beta) * chi**3
        + 16 * alpha / np.pi**4 * (alpha**3 + 3 * np.pi**2 / 5 * beta) * chi**4
    )


@pytest.fixture(scope="module")
def thick():
    """A block 60 radii of contact wide and 30 thick, seven nodes to a radius of contact."""
    depths = 30e-3 * np.concatenate([[0], np.geomspace(0.128 / 30, 1, 12)])
    levels = 1 - depths[::-1] / 30e-3
    return FemEngine(block(30e-3, 30e-3, 15, 0.16e-3, 1.12e-3, levels, 1.3e-3), NU, "linear")


@pytest.mark.nightly
def test_hertz(thick):
    """A ball on a thick block has Hertz's force within 2 %, with the block's own thickness allowed for (4 %)."""
    history = pressed(thick, Sphere(RADIUS), poses((0, 0, -0.06), (0, 0, -0.1)))
    expected = [1e6 * dimitriadis(RADIUS, depth, 30e-3, NU) for depth in (6e-5, 1e-4)]
    assert expected[1] < 1.045e6 * hertz(RADIUS, 1e-4, NU)
    np.testing.assert_allclose(history.wrench[:, 2], expected, rtol=0.02)


@pytest.mark.nightly
def test_hertz_pressure(thick):
    """Its pressure is Hertz's half ellipsoid: nothing beyond the contact, the right force within parts of it."""
    history = pressed(thick, Sphere(RADIUS), poses((0, 0, -0.1)))
    away = np.linalg.norm(thick.mesh.vertices[thick.mesh.surface, :2], axis=1)
    force = -history.node_forces[0, :, 2].astype(float)
    assert force[away > CONTACT + 0.2e-3].sum() == 0
    for share in (0.4, 0.6, 0.8):
        # a node stands for half a spacing around it
        within = force[away <= share * CONTACT].sum() / force.sum()
        inner, outer = (1 - (1 - min(1, max(0, share + edge)) ** 2) ** 1.5 for edge in (-0.09, 0.09))
        assert inner < within < outer


@pytest.mark.nightly
def test_partial_slip(thick):
    """A ball that is pressed and shifted has Cattaneo's and Mindlin's force within 5 % of the sliding force."""
    friction, shifts = 0.5, np.linspace(0, 6e-5, 13)
    at = poses((0, 0, -0.05), (0, 0, -0.1), *[(1e3 * shift, 0, -0.1) for shift in shifts])
    wrench = pressed(thick, Sphere(RADIUS), at, friction).wrench[2:]
    slides = friction * wrench[0, 2]
    shear_modulus = 1e6 / (2 * (1 + NU))
    # K. L. Johnson, Contact Mechanics, eq. 7.42, one of the bodies rigid
    share = 1 - shifts * 16 * CONTACT * shear_modulus / (3 * slides * (2 - NU))
    expected = 1 - np.clip(share, 0, 1) ** 1.5
    np.testing.assert_allclose(-wrench[:, 0] / slides, expected, atol=0.05)
    # most of the way it is neither stuck nor sliding
    stuck = shifts * 8 * CONTACT * shear_modulus / ((2 - NU) * slides)
    assert np.abs(expected - stuck).max() > 0.15
    assert expected.max() < 0.95


@pytest.mark.slow
@pytest.mark.parametrize(("radius", "depth"), [(4e-3, 1e-4), (4e-3, 2e-4), (8e-3, 2e-4)])
def test_finite_thickness(radius, depth):
    """A ball on a bonded layer of 4 mm has Dimitriadis' force within 3 % (up to 1.5 times that of Hertz)."""
    mesh = slab(0.24e-3, 12, 1.44e-3, (0, 0.3, 0.52, 0.68, 0.8, 0.88, 0.94, 1), 1.7e-3)
    force = forces_at(mesh, 0.49, "linear", Sphere(radius), [depth])[0]
    assert force == pytest.approx(1e6 * dimitriadis(radius, depth, 4e-3, 0.49), rel=0.03)
