"""Laws of the layer's insides: the linear layer's inverse, and large strain against closed forms."""

import numpy as np
import pytest

from tactiledata.rig.layer.grid import Column, LayerGrid, gauss_lobatto
from tactiledata.rig.layer.kernel import LayerKernel
from tactiledata.rig.layer.strain import LayerStrain

PITCH, THICKNESS, SHEAR, LAME = 5e-4, 4e-3, 3.0e5, 7.0e6
GRID = LayerGrid(PITCH, (12, 10))
COLUMN = Column.of(THICKNESS, PITCH)
HEIGHTS = THICKNESS * np.append(COLUMN.share[1:5], COLUMN.share[6:])


def material(grid=GRID, is_linear=False):
    return LayerStrain(grid, COLUMN, SHEAR, LAME, is_linear)


def random_field(scale, seed=0):
    return scale * np.random.default_rng(seed).standard_normal((3, 8, *GRID.shape))


def test_quadrature_and_derivative_are_exact_for_polynomials():
    """Five points integrate degree 7 and differentiate degree 4 without error."""
    points, weights, derivative = gauss_lobatto(4)
    assert weights @ points**7 == pytest.approx(1 / 8, rel=1e-12)
    np.testing.assert_allclose(derivative @ points**4, 4 * points**3, atol=1e-12)


def test_the_kernel_undoes_the_linear_layer():
    """Forces of any displacement, given to the kernel, give the displacement back."""
    kernel = LayerKernel(GRID, COLUMN, SHEAR, LAME)
    u = random_field(1e-6)
    np.testing.assert_allclose(kernel.displace(material(is_linear=True).forces(u)), u, atol=1e-14)


def test_the_surface_kernel_is_the_kernel_at_the_surface():
    """Loads on the surface move it alike by both."""
    kernel = LayerKernel(GRID, COLUMN, SHEAR, LAME)
    load = random_field(1e-3)
    load[:, :-1] = 0.0
    np.testing.assert_allclose(kernel.displace_surface(load[:, -1]), kernel.displace(load)[:, -1], atol=1e-15)


def test_small_strain_is_linear():
    """At strains of 1e-6 the large-strain forces are those of the linear layer, to second order."""
    u = random_field(1e-10)
    linear = material(is_linear=True).forces(u)
    np.testing.assert_allclose(material().forces(u), linear, atol=1e-5 * np.abs(linear).max())


@pytest.mark.parametrize("stretch", [0.6, 0.8, 1.2])
def test_uniform_compression_is_the_oedometers_closed_form(stretch):
    """Every column shorter by one factor: the pressure is mu (s - 1/s) + lambda ln s / s, all inside balanced."""
    u = np.zeros((3, 8, *GRID.shape))
    u[2] = (stretch - 1) * HEIGHTS[:, None, None]
    forces = material().forces(u)
    stress = SHEAR * (stretch - 1 / stretch) + LAME * np.log(stretch) / stretch
    np.testing.assert_allclose(forces[2, -1], stress * PITCH**2, rtol=1e-10)
    assert np.abs(forces[:2]).max() < 1e-12
    assert np.abs(forces[2, :-1]).max() < 1e-9 * np.abs(forces[2, -1]).max()


@pytest.mark.parametrize("slope", [0.1, 1.0])
def test_simple_shear_needs_shear_stress_only(slope):
    """Simple shear keeps the volume: stress mu times slope along x, none upwards, at any slope."""
    u = np.zeros((3, 8, *GRID.shape))
    u[0] = slope * HEIGHTS[:, None, None]
    forces = material().forces(u)
    np.testing.assert_allclose(forces[0, -1], SHEAR * slope * PITCH**2, rtol=1e-10)
    assert np.abs(forces[2]).max() < 1e-9 * np.abs(forces[0, -1]).max()


def test_forces_come_from_an_energy():
    """The stiffness at a strained state is symmetric: what u does along v, v does along u."""
    strained, first, second = random_field(2e-5), random_field(1e-9, 1), random_field(1e-9, 2)
    layer = material()
    one = np.sum(second * (layer.forces(strained + first) - layer.forces(strained - first)))
    other = np.sum(first * (layer.forces(strained + second) - layer.forces(strained - second)))
    assert one == pytest.approx(other, rel=1e-5)


def test_a_pad_has_free_sides():
    """Outside the pad there is no gel: forces vanish there, and the cells' shares add up to the pad's area."""
    grid = LayerGrid.of((0.0043, 0.0031), PITCH)
    assert grid.filling.sum() * PITCH**2 == pytest.approx(0.0043 * 0.0031, rel=1e-12)
    u = np.zeros((3, 8, *grid.shape))
    u[2] = -0.1 * HEIGHTS[:, None, None]
    forces = material(grid).forces(u)
    outside = (np.abs(grid.x) > 0.0043 / 2 + PITCH)[None, :] | (np.abs(grid.y) > 0.0031 / 2 + PITCH)[:, None]
    assert outside.any()
    assert not forces[:, :, outside].any()
