"""What holds for every touch, whatever the mesh: balance, friction's cone, symmetry, scale, repeatability."""

import numpy as np
import pytest
from pressing import poses, pressed, slab
from scipy.spatial.transform import Rotation

from tactiledata.errors import UsageError
from tactiledata.gel.contact.history import FrameStatus, GelTouch
from tactiledata.gel.elasticity.compliance import FactorisedPad
from tactiledata.gel.elasticity.internal_forces import ElasticPad, internal_forces
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.gel.engines.fem import FemEngine
from tactiledata.gel.mesh.cells import cell_quadrature
from tactiledata.gel.mesh.structured_pad import pad_mesh
from tactiledata.gel.mesh.surface import contact_surface
from tactiledata.indenters.cylinder_flat import CylinderFlat
from tactiledata.indenters.sphere import Sphere
from tactiledata.sensors.digit import DIGIT

NU = 0.47
BALL = Sphere(4e-3)
SHEARED = poses((0, 0, 1), (0, 0, -0.3), (0, 0, -0.6), (0.2, 0, -0.6), (0.4, 0.1, -0.6), (0.1, 0, -0.6), (0, 0, 1))


@pytest.fixture(scope="module", params=["linear", "finite-strain"])
def engine(request):
    return FemEngine(slab(), NU, request.param)


def test_base_bears_what_the_surface_is_pressed_with():
    """Force and moment of the base's reaction balance any load to 1e-8, and patches pass on all of their force."""
    mesh = slab()
    surface, pad = contact_surface(mesh), FactorisedPad(mesh, cell_quadrature(mesh), NU)
    np.testing.assert_allclose(surface.averaging.sum(axis=1), 1.0, rtol=1e-12)
    loads = np.zeros((1, len(mesh.vertices), 3))
    loads[0, surface.nodes] = np.random.default_rng(5).normal(size=(len(surface.nodes), 3))
    moved = pad.solve(loads)[0]
    reaction = (pad.stiffness @ moved.ravel()).reshape(-1, 3)[mesh.base]
    whole = np.abs(loads).sum()
    assert np.abs(reaction.sum(axis=0) + loads[0].sum(axis=0)).max() < 1e-8 * whole
    moments = np.cross(mesh.vertices[mesh.base], reaction).sum(axis=0) + np.cross(mesh.vertices, loads[0]).sum(axis=0)
    assert np.abs(moments).max() < 1e-8 * whole * mesh.thickness


@pytest.mark.slow
def test_wrench_is_what_the_nodes_feel(engine):
    """The wrench is the sum of the nodes' forces, turned round; its torque that of their displaced places."""
    history = pressed(engine, BALL, SHEARED, 0.6)
    touching = history.status == FrameStatus.SOLVED
    assert touching.sum() == 5
    np.testing.assert_allclose(-history.node_forces.sum(axis=1)[touching], history.wrench[touching, :3], atol=1e-5)
    places = engine.mesh.vertices[engine.mesh.surface] + history.displacement[:, engine.mesh.surface]
    torques = -np.cross(places, history.node_forces).sum(axis=1)
    largest = np.abs(history.wrench[touching, 2]).max()
    assert np.abs(torques - history.wrench[:, 3:])[touching].max() < 2e-4 * largest * 1e-2


@pytest.mark.slow
def test_finite_strain_is_in_equilibrium_where_nothing_pushes():
    """With a tight tolerance, forces inside vanish and the base bears the wrench at the deformed places."""
    engine = FemEngine(slab(), NU, "finite-strain", tolerance=1e-9)
    history = pressed(engine, BALL, SHEARED[:5], 0.3)
    mesh, modulus = engine.mesh, 1e6
    assert history.residual.max() < 1e-4
    moved = history.displacement[-1].astype(float)
    forces = modulus * internal_forces(ElasticPad.of(mesh, cell_quadrature(mesh)), moved[None], NU)[0]
    largest = history.wrench[-1, 2]
    inner = np.setdiff1d(np.arange(len(mesh.vertices)), np.concatenate([mesh.base, mesh.surface]))
    assert np.abs(forces[inner]).max() < 1e-4 * largest
    base = forces[mesh.base]
    np.testing.assert_allclose(base.sum(axis=0), history.wrench[-1, :3], atol=1e-4 * largest)
    torque = np.cross((mesh.vertices + moved)[mesh.base], base).sum(axis=0)
    np.testing.assert_allclose(torque, history.wrench[-1, 3:], atol=1e-4 * largest * mesh.thickness)


def test_friction_cone(engine):
    """Under a flat punch that shears and turns no node is pulled, nor sheared by more than mu times its pressure."""
    friction = 0.4
    at = poses((0, 0, 0.5), (0, 0, -0.2), (0.3, 0, -0.2), (0.6, 0.2, -0.2), (0.2, 0.2, -0.1), (0.2, 0.2, -0.1))
    at[5, :3, :3] = Rotation.from_rotvec([0, 0, 0.3]).as_matrix()
    history = pressed(engine, CylinderFlat(radius=3e-3), at, friction)
    forces = history.node_forces[1:].astype(float)
    pressure, shear = -forces[..., 2], np.linalg.norm(forces[..., :2], axis=-1)
    slack = 1e-5 * pressure.max()
    assert pressure.min() >= -slack
    assert (shear <= friction * pressure + slack).all()
    # it slips, so that the law is put to the test
    slipping = np.linalg.norm(history.wrench[3, :2]) / history.wrench[3, 2]
    assert slipping == pytest.approx(friction, rel=0.02)
    assert abs(history.wrench[5, 5]) > 1e-4


def test_pressed_patches_do_not_overlap(engine):
    """Where the ball presses the mean gap is nothing; it is never negative by more than a thousandth of the depth."""
    history = pressed(engine, BALL, poses((0, 0, -0.3), (0, 0, -0.6)))
    assert np.abs(history.wrench[:, :2]).max() < 2e-5 * history.wrench[1, 2]
    assert history.gaps.min() > -6e-7


def test_symmetry(engine):
    """A mirrored touch gives the mirrored answer."""
    at = poses((0.3, 0.7, 0.5), (0.3, 0.7, -0.5), (0.6, 0.9, -0.5))
    mirrored = at.copy()
    mirrored[:, 0, 3] *= -1
    one, other = (pressed(engine, BALL, path, 0.5) for path in (at, mirrored))
    flip = np.array([-1, 1, 1, 1, -1, -1])
    scale = np.array([1, 1, 1, 4e-3, 4e-3, 4e-3]) * one.wrench[2, 2]
    assert np.abs(one.wrench - flip * other.wrench)[1:].max(axis=0) == pytest.approx(0, abs=2e-3 * scale.max())
    points = engine.mesh.vertices
    order = np.lexsort(np.round(points * [-1e7, 1e7, 1e7]).T)
    same = np.lexsort(np.round(points * 1e7).T)
    difference = one.displacement[2, same] - other.displacement[2, order] * flip[:3]
    assert np.abs(difference).max() < 2e-3 * np.abs(one.displacement[2]).max()


@pytest.mark.slow
def test_youngs_modulus_scales_out(engine):
    """Twice the modulus gives bit for bit the same shapes, and twice the force."""
    soft, stiff = (pressed(engine, BALL, SHEARED, 0.6, modulus) for modulus in (0.5e6, 1.0e6))
    np.testing.assert_array_equal(soft.displacement, stiff.displacement)
    np.testing.assert_array_equal(2 * soft.wrench, stiff.wrench)


@pytest.mark.slow
def test_again_is_the_same(engine):
    """The same touch twice is the same bit for bit."""
    one, other = (pressed(engine, BALL, SHEARED, 0.6) for _ in range(2))
    for name in ("wrench", "displacement", "node_forces", "gaps", "status", "residual"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


@pytest.mark.slow
def test_company_changes_nothing(engine):
    """Trajectories in lockstep end as they do alone."""
    material = GelMaterial(1e6, NU, 0.5)
    touches = [GelTouch(BALL, SHEARED[: 3 + number] + _moved(1e-4 * number)) for number in range(4)]
    alone, together = (dict(engine.play(touches, material, width=width)) for width in (1, 3))
    assert sorted(together) == list(range(4))
    for number, history in alone.items():
        np.testing.assert_array_equal(history.status, together[number].status)
        np.testing.assert_allclose(history.wrench, together[number].wrench, rtol=1e-6, atol=1e-9)


def _moved(way):
    offset = np.zeros((4, 4))
    offset[1, 3] = way
    return offset


@pytest.mark.slow
def test_without_friction_the_path_is_forgotten(engine):
    """Without friction only the pose counts; with friction the way back is another and the loop costs work."""
    there = [(x, 0, -0.6) for x in (0, 0.1, 0.2, 0.3, 0.4)]
    loop = poses((0, 0, -0.3), *there, *there[-2::-1], *there[1:])
    smooth, rough = (pressed(engine, BALL, loop, friction) for friction in (0.0, 0.4))
    scale = smooth.wrench[1, 2]
    np.testing.assert_allclose(smooth.wrench[1:6, :3], smooth.wrench[9:, :3], atol=5e-3 * scale)
    assert np.abs(rough.wrench[2:5, 0] - rough.wrench[8:5:-1, 0]).min() > 0.05 * scale
    # what the hand does on the indenter is against the gel's force on it
    ways = np.diff(loop[5:, 0, 3])
    work = -(0.5 * (rough.wrench[5:-1, 0] + rough.wrench[6:, 0]) * ways).sum()
    assert work > 1e-2 * scale * np.abs(ways).sum()


def test_sticking_is_elastic():
    """Where nothing can slip, shear forth and back leaves no force behind."""
    engine = FemEngine(slab(), NU, "linear")
    at = poses((0, 0, -0.2), (0, 0, -0.5), (0.02, 0, -0.5), (0.04, 0, -0.5), (0.02, 0, -0.5), (0, 0, -0.5))
    history = pressed(engine, BALL, at, 50.0)
    shear = history.wrench[:, 0]
    assert shear[3] < -0.02 * history.wrench[1, 2]
    assert abs(shear[5] - shear[1]) < 0.01 * abs(shear[3])
    assert shear[4] == pytest.approx(shear[2], rel=0.01)


def test_every_frame_has_a_reason(engine):
    """What cannot be solved is named, frame by frame, and the rest goes on."""
    at = poses((0, 0, 1), (0, 0, -0.4), (0, 0, -3), (0, 0, -0.4), (0, 0, -0.4), (18, 0, -3), (0, 0, -0.5), (0, 0, 1))
    at[3, 0, 3] = np.nan
    history = pressed(engine, BALL, at, 0.5)
    assert [FrameStatus(status).name for status in history.status] == [
        "NO_CONTACT",
        "SOLVED",
        "TOO_DEEP",
        "POSE_MISSING",
        "SOLVED",
        "BESIDE_THE_PAD",
        "SOLVED",
        "NO_CONTACT",
    ]
    assert np.isnan(history.wrench[[2, 3, 5]]).all()
    assert np.isnan(history.displacement[[2, 3, 5]]).all()
    np.testing.assert_array_equal(history.displacement[[0, 7]], 0)
    assert history.wrench[4, 2] == pytest.approx(history.wrench[1, 2], rel=1e-3)
    assert all(FrameStatus(status).reason for status in history.status)


def test_the_first_frame_may_touch(engine):
    """A recording that sets in during the touch, by however little, is solved from its first frame on."""
    for depth in (0.12, 0.3):
        at = poses((0, 0, -depth))
        begun, approached = (pressed(engine, BALL, path) for path in (at, np.concatenate([poses((0, 0, 1)), at])))
        assert begun.status[0] == FrameStatus.SOLVED
        assert begun.wrench[0, 2] == pytest.approx(approached.wrench[1, 2], rel=5e-3)


def test_a_jump_is_followed_in_parts(engine):
    """From free air straight to 0.8 mm gives the force that small steps give, without friction."""
    jumped = pressed(engine, BALL, poses((0, 0, 5), (0, 0, -0.8)))
    walked = pressed(engine, BALL, poses((0, 0, 5), *[(0, 0, -0.1 * step) for step in range(1, 9)]))
    assert jumped.wrench[-1, 2] == pytest.approx(walked.wrench[-1, 2], rel=5e-3)


@pytest.mark.slow
def test_nearly_incompressible_and_deep():
    """At nu = 0.495 a ball is followed to 0.9 mm on the sensor's own pad, and the force rises ever faster."""
    engine = FemEngine(pad_mesh("digit", DIGIT.gel), 0.495)
    history = pressed(engine, BALL, poses((0, 0, 1), *[(0, 0, -0.1 * step) for step in range(1, 10)]), 0.6, keep="none")
    assert (history.status[1:] == FrameStatus.SOLVED).all()
    assert np.diff(history.wrench[1:, 2], 2).min() > 0


def test_wrong_calls_are_told():
    """A fidelity or a material that the engine does not have."""
    with pytest.raises(UsageError, match="fidelity 'exact'"):
        FemEngine(slab(), NU, "exact")
    with pytest.raises(UsageError, match="poisson_ratio"):
        GelMaterial(1e6, 0.5, 0.3)
    engine = FemEngine(slab(), NU, "linear")
    with pytest.raises(UsageError, match=r"Make an engine"):
        next(engine.play([], GelMaterial(1e6, 0.45, 0.3)))
