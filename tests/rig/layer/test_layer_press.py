"""Laws of the rig's contact solver, and its forces against closed forms and an axisymmetric reference."""

import numpy as np
import pytest
from axisymmetric_layer import AxisymmetricLayer, graded
from scipy.spatial.transform import Rotation

from tactiledata.indenters import make_indenter
from tactiledata.rig.contact.closed_form import sphere_force
from tactiledata.rig.layer.friction import FrictionState
from tactiledata.rig.layer.gap import TouchPoints, gaps, gaps_and_normals
from tactiledata.rig.layer.grid import Column, LayerGrid
from tactiledata.rig.layer.kernel import LayerKernel
from tactiledata.rig.layer.press import solve_press
from tactiledata.rig.layer.solver import SPRINGS, Layer, lame_constants
from tactiledata.rig.layer.touch import Surface
from tactiledata.rig.scenario.scenario import Material

THICKNESS = 4e-3
GEL = Material(0.9e6, 0.48, 0.8)
SLIPPERY = Material(0.9e6, 0.48, 0.0)
COARSE = LayerGrid(5e-4, (36, 36))


def body(shape, **sizes):
    return make_indenter({"shape": shape, **sizes}, None, "test")


BALL = body("sphere", radius=0.004)


def poses_at(positions, tilt=(0.0, 0.0, 0.0)):
    """Poses (n, 4, 4) with the tip at x, y and depth (n, 3)."""
    poses = np.tile(np.eye(4), (len(positions), 1, 1))
    poses[:, :3, :3] = Rotation.from_rotvec(tilt).as_matrix()
    poses[:, :3, 3] = np.asarray(positions) * [1, 1, -1]
    return poses


def down_to(depth, count):
    return np.column_stack([np.zeros((count, 2)), depth * np.arange(1, count + 1) / count])


def linear_contact(indenter, depth, thickness, grid, material):
    """Normal force, N, of one frictionless linear press."""
    shear, lame = lame_constants(material)
    points = TouchPoints.of(grid)
    pose = poses_at([[0.0, 0.0, depth]])[0]
    near = np.flatnonzero(gaps(indenter, pose, points.places) < depth)
    kernel = LayerKernel(grid, Column.of(thickness, grid.pitch), shear, lame)
    surface = Surface(points.chosen(near), kernel.displace_surface, grid.shape)
    gel_stiffness = material.youngs_modulus / (1 - material.poisson_ratio**2) / grid.pitch
    zero, fresh = np.zeros((len(near), 3)), np.ones(len(near), bool)
    friction_state = FrictionState(SPRINGS * gel_stiffness, gel_stiffness, 0.0, zero, points.places[near], fresh)
    values, force, flat = zero, np.zeros((3, *grid.shape)), np.zeros((3, *grid.shape))
    for _ in range(8):
        found = surface.settle(flat, values, force, friction_state, lambda at: gaps_and_normals(indenter, pose, at))
        values, force = found.tractions, found.force
    return -force[2].sum()


@pytest.mark.parametrize(
    ("thickness", "radius", "depth", "pitch", "count", "within"),
    [
        (4e-3, 4e-3, 1.5e-4, 2.5e-4, 90, 0.03),
        pytest.param(16e-3, 4e-3, 1e-4, 1e-4, 270, 0.02, marks=pytest.mark.slow),
    ],
    ids=["layer", "nearly a half-space"],
)
def test_a_ball_obeys_hertz_and_dimitriadis(thickness, radius, depth, pitch, count, within):
    """A linear, frictionless press obeys Hertz's law, corrected for the thickness (by 4 % on the thick layer)."""
    force = linear_contact(body("sphere", radius=radius), depth, thickness, LayerGrid(pitch, (count, count)), GEL)
    assert force == pytest.approx(sphere_force(np.array([depth]), radius, thickness, GEL)[0], rel=within)


@pytest.fixture(scope="module")
def sheared():
    """A layer, and its states while a ball is pressed to 0.5 mm, sheared by 0.3 mm and brought back."""
    layer = Layer(COARSE, THICKNESS, Material(0.9e6, 0.48, 0.3), tolerance=5e-4)
    there = np.column_stack([np.arange(1, 4) * 1e-4, np.zeros(3), np.full(3, 5e-4)])
    poses = poses_at(np.concatenate([down_to(5e-4, 5), there, there[-2::-1], [[0.0, 0.0, 5e-4]]]))
    states = [layer.at_rest(BALL, poses[0])]
    for pose in poses:
        states.append(layer.step(BALL, states[-1], pose))
    return layer, poses, states[1:]


@pytest.mark.slow
def test_a_symmetric_press_pulls_nowhere(sheared):
    """A press head-on has no sideways force and no torque."""
    wrench = sheared[2][4].wrench
    assert np.abs(wrench[:2]).max() < 2e-3 * wrench[2]
    assert np.abs(wrench[3:]).max() < 2e-6 * wrench[2]


@pytest.mark.slow
def test_the_layer_is_in_balance(sheared):
    """Inside nothing is left over, and what the base holds is what the indenter gives."""
    layer, _, states = sheared
    for state in (states[4], states[7]):
        forces = layer._strain.forces(state.u)
        size = np.linalg.norm(state.wrench[:3])
        np.testing.assert_allclose(-forces.sum(axis=(1, 2, 3)), state.wrench[:3], atol=5e-3 * size)
        assert np.abs(forces[:, :-1].sum(axis=(2, 3))).max() < 3e-2 * size


def test_nothing_pulls_and_friction_stays_in_its_cone(sheared):
    """At every point of every state there is pressure, and no more friction than 0.3 of it."""
    _, poses, states = sheared
    for pose, state in zip(poses, states, strict=True):
        on = state.traction.any(axis=1)
        _, normal = gaps_and_normals(BALL, pose, state.points[on])
        pressure = np.einsum("ij,ij->i", state.traction[on], normal)
        friction = np.linalg.norm(state.traction[on] - pressure[:, None] * normal, axis=1)
        largest = pressure.max()
        assert pressure.min() > -0.02 * largest
        assert (friction <= 0.3 * pressure + 0.02 * largest).all()
        assert np.linalg.norm(state.wrench[:2]) < 0.3 * state.wrench[2] * 1.3


def test_nothing_is_pierced(sheared):
    """No touch point lies deeper in the body than 8 um of 500."""
    assert min(state.gap.min() for state in sheared[2]) > -8e-6


def test_friction_remembers_its_path(sheared):
    """There and back: the pull is against the motion, a loop is left, and it takes work."""
    pull = np.array([state.wrench[0] for state in sheared[2][4:]])
    assert (np.diff(pull[:4]) < 0).all()
    assert pull[-1] > 0.1 * np.abs(pull).max()
    work = -np.sum((pull[1:] + pull[:-1]) / 2 * np.array([1, 1, 1, -1, -1, -1]) * 1e-4)
    assert work > 0


def test_without_friction_nothing_pulls():
    """A frictionless ball moved sideways feels its own slope only."""
    path = np.concatenate([down_to(3e-4, 3), [[1e-4, 0.0, 3e-4], [2e-4, 0.0, 3e-4]]])
    press = solve_press(BALL, poses_at(path), THICKNESS, SLIPPERY, COARSE)
    assert np.abs(press.wrench[:, 0]).max() < 5e-3 * press.wrench[-1, 2]


@pytest.mark.slow
def test_partial_slip_is_mindlins():
    """A ball on a thick linear layer pulls mu N (1 - (1 - u / u*)^(3/2)) with u* = 3 mu N (2 - nu) / (16 G a)."""
    material = Material(0.9e6, 0.48, 0.3)
    thickness, depth = 12e-3, 2e-4
    shear, _ = lame_constants(material)
    layer = Layer(LayerGrid(2e-4, (90, 90)), thickness, material, is_linear=True, tolerance=5e-4)
    poses = poses_at([[0.0, 0.0, depth]])
    state = layer.step(BALL, layer.at_rest(BALL, poses[0]), poses[0])
    normal = state.wrench[2]
    radius = np.sqrt(0.004 * depth)
    full = 3 * 0.3 * normal * (2 - 0.48) / (16 * shear * radius)
    for share in np.arange(1, 13) / 16:
        state = layer.step(BALL, state, poses_at([[share * full, 0.0, depth]])[0])
        if share in (0.25, 0.5, 0.75):
            expected = 0.3 * normal * (1 - (1 - share) ** 1.5)
            assert -state.wrench[0] == pytest.approx(expected, rel=0.05)


@pytest.mark.slow
def test_full_slip_pulls_with_the_coefficient_of_friction():
    """Far enough sideways everything slides, and the pull is mu times the load."""
    material = Material(0.9e6, 0.48, 0.2)
    path = np.concatenate([down_to(2e-4, 2), [[step * 1e-4, 0.0, 2e-4] for step in range(1, 4)]])
    press = solve_press(BALL, poses_at(path), THICKNESS, material, COARSE)
    assert press.slipping[-1]
    assert -press.wrench[-1, 0] == pytest.approx(0.2 * press.wrench[-1, 2], rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize(("shift", "steps"), [(1e-9, 5), (1e-9, 12), (-3e-9, 12)])
def test_a_slide_under_an_edge_amplifies_nothing(shift, steps):
    """A tilted punch is dragged by 0.5 or 1.2 mm, and once more from nanometres beside: forces agree within 1 %."""
    drag = np.column_stack([np.arange(1, steps + 1) * 1e-4, np.zeros(steps), np.full(steps, 4e-4)])
    path, tilt = np.concatenate([down_to(4e-4, 4), drag]), (0.03, -0.02, 0.1)
    once, again = (
        solve_press(body("cylinder_flat"), poses_at(at, tilt), THICKNESS, GEL, COARSE).wrench[:, :3]
        for at in (path, path + np.array([shift, 0.0, 0.0]))
    )
    assert np.abs(again - once).max() < 0.01 * np.abs(once).max()


def reference_punch(material, depths, cells, is_linear=False, is_stuck=True):
    """Forces, N, of a flat punch of 3 mm by the axisymmetric reference."""
    heights = np.append(0.0, np.cumsum(1.2 ** np.arange(cells // 2 + 1)))
    lines = THICKNESS * (1 - heights[::-1] / heights[-1])
    layer = AxisymmetricLayer(THICKNESS, *lame_constants(material), graded(3e-3, cells, 18e-3, 8), lines, is_linear)
    under = layer.top[layer.places[layer.top, 0] <= 3e-3 + 1e-9]
    return layer.press(under, -np.asarray(depths)[:, None] * np.ones(len(under)), is_stuck)


@pytest.mark.parametrize("is_linear", [pytest.param(True, marks=pytest.mark.slow), False])
def test_a_punch_agrees_with_the_axisymmetric_reference(is_linear):
    """A stuck punch of 3 mm at 0.3 mm is within 3 % of Newton's solution on another mesh, linear and not."""
    depths = np.arange(1, 4) * 1e-4
    expected = reference_punch(GEL, depths, 16, is_linear)
    stuck = Material(GEL.youngs_modulus, GEL.poisson_ratio, 5.0)
    press = solve_press(body("cylinder_flat"), poses_at(down_to(3e-4, 3)), THICKNESS, stuck, COARSE, is_linear)
    np.testing.assert_allclose(press.wrench[:, 2], expected, rtol=0.03)
    assert press.settled.all()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("poisson_ratio", "within"), [(0.48, 0.02), pytest.param(0.495, 0.03, marks=pytest.mark.nightly)]
)
def test_a_fine_punch_agrees_with_a_fine_reference(poisson_ratio, within):
    """The forces at 0.5 mm agree when the grids are refined on both sides."""
    stuck = Material(0.9e6, poisson_ratio, 5.0)
    depths = np.arange(1, 11) * 5e-5
    expected = reference_punch(stuck, depths, 24)[-1]
    grid = LayerGrid(3.2e-4, (64, 64))
    press = solve_press(body("cylinder_flat"), poses_at(down_to(5e-4, 5)), THICKNESS, stuck, grid, tolerance=5e-4)
    assert press.wrench[-1, 2] == pytest.approx(expected, rel=within)


@pytest.mark.slow
def test_large_strain_stiffens_the_layer():
    """A stuck ball at 0.8 mm has 4.09 N by an axisymmetric solution at large strain, and 3.91 N by a linear one."""
    stuck = Material(0.9e6, 0.48, 10.0)
    path = poses_at(down_to(8e-4, 8))
    forces = [solve_press(BALL, path, THICKNESS, stuck, COARSE, linear).wrench[-1, 2] for linear in (False, True)]
    np.testing.assert_allclose(forces, [4.092, 3.908], rtol=0.02)


@pytest.mark.slow
def test_grids_agree():
    """A tilted box: half the pitch changes the force by less than 4 %, and torque follows."""
    path = poses_at(down_to(2e-4, 2), tilt=(0.03, 0.0, 0.4))
    wrenches = [
        solve_press(body("box"), path, THICKNESS, GEL, LayerGrid(pitch, (count, count))).wrench[-1]
        for pitch, count in ((5e-4, 40), (2.5e-4, 80))
    ]
    assert wrenches[0][2] == pytest.approx(wrenches[1][2], rel=0.04)
    assert wrenches[0][3] == pytest.approx(wrenches[1][3], rel=0.06)


def test_moving_everything_moves_the_answer():
    """A press by whole cells beside the middle is the same press, with its lever."""
    shift = np.array([4, -2, 0]) * COARSE.pitch
    here, there = (
        solve_press(BALL, poses_at(down_to(2e-4, 2) + move), THICKNESS, GEL, COARSE) for move in (np.zeros(3), shift)
    )
    np.testing.assert_allclose(there.wrench[:, :3], here.wrench[:, :3], atol=1e-3)
    lever = np.cross(shift, here.wrench[-1, :3])
    np.testing.assert_allclose(there.wrench[-1, 3:] - here.wrench[-1, 3:], lever, atol=5e-6)


@pytest.mark.slow
@pytest.mark.parametrize(
    "shape", ["torus", "cone", "pyramid", "edge", "cylinder_side", "ring", "hexagon", "dots", "dome"]
)
def test_every_solid_presses_and_lets_go(shape):
    """Tilted, 0.3 mm in and out again: force rises, falls and ends at nothing, the surface flat."""
    solid = body(shape)
    low = (np.asarray(solid.mesh().vertices) @ poses_at([[0, 0, 0]], (0.05, -0.03, 0.2))[0, 2, :3]).min()
    depths = np.array([2e-4, 3e-4, 1e-4, -1e-4]) + low
    press = solve_press(
        solid, poses_at(np.column_stack([np.zeros((4, 2)), depths]), (0.05, -0.03, 0.2)), THICKNESS, GEL, COARSE
    )
    assert 0 < press.wrench[0, 2] < press.wrench[1, 2]
    assert not press.wrench[-1].any()
    assert not press.surface[-1].any()
    assert press.settled.all()
