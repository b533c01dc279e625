"""Engine mujoco-flex: what it gets right, by how much its forces are too high, and what it refuses."""

import importlib.util
import sys

import numpy as np
import pytest
from pressing import poses, pressed, slab

from tactiledata.errors import UsageError
from tactiledata.gel.contact.history import FrameStatus, GelTouch
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.gel.engines.fem import FemEngine
from tactiledata.gel.flex import engine as flex
from tactiledata.gel.make_engine import make_engine, mechanics_of
from tactiledata.gel.mesh.pad import PadMesh
from tactiledata.gel.mesh.structured_pad import GridPlan, structured_pad
from tactiledata.gel.mesh.tetrahedra import ten_node_cells
from tactiledata.indenters.cylinder_flat import CylinderFlat
from tactiledata.indenters.ring import Ring
from tactiledata.indenters.sphere import Sphere
from tactiledata.sensors.digit import DIGIT

pytestmark = pytest.mark.slow

if importlib.util.find_spec("mujoco") is None:
    pytest.skip("MuJoCo is not installed", allow_module_level=True)
NU = 0.46
DEPTHS = (0.2, 0.4, 0.6)
TILT = 0.05


@pytest.fixture(scope="module")
def engine():
    """676 vertices."""
    return flex.FlexEngine(slab(), NU)


@pytest.fixture(scope="module")
def history(engine):
    """Poses in the air, down in three frames, sideways in two, and in the air again."""
    down = [(0.3, 0.1, -depth) for depth in DEPTHS]
    path = poses((0.3, 0.1, 0.5), *down, (0.4, 0.1, -0.6), (0.5, 0.1, -0.6), (0.5, 0.1, 0.2))
    return pressed(engine, Sphere(4e-3), path, friction=0.3)


def test_frames_are_named_for_what_became_of_them(history):
    """Frames in the air are without contact, wrench and displacement, and frames between them are solved."""
    air, solved = FrameStatus.NO_CONTACT, FrameStatus.SOLVED
    assert history.status.tolist() == [air, *[solved] * 5, air]
    assert not history.wrench[[0, -1]].any()
    assert not history.displacement[[0, -1]].any()
    assert not history.pressed[[0, -1]].any()


def test_force_grows_with_depth_and_pushes_the_indenter_out(history):
    """The normal force rises with each deeper frame."""
    assert (np.diff(history.wrench[:4, 2]) > 0).all()


def test_nodes_bear_the_wrench(history, engine):
    """Forces on nodes are those on the indenter turned round; torques are theirs; what is touched moves down."""
    np.testing.assert_allclose(history.node_forces.sum(axis=1)[1:6], -history.wrench[1:6, :3], rtol=0.02, atol=2e-2)
    lever = history.wrench[1:4, 4] / history.wrench[1:4, 2]
    np.testing.assert_allclose(lever, -0.3e-3, atol=0.15e-3)
    deepest = history.displacement[3].min(axis=0)[2]
    assert deepest == pytest.approx(-0.6e-3, abs=0.1e-3)
    assert not history.displacement[:, engine.mesh.base].any()


def test_shear_drags_and_friction_bounds_it(history):
    """Moved along +x, the indenter is held back along -x, by no more than mu times the normal force."""
    pulled = history.wrench[[3, 4, 5], 0]
    assert pulled[2] < pulled[1] < pulled[0]
    tangential = np.linalg.norm(history.wrench[1:6, :2], axis=1)
    assert (tangential <= 1.02 * 0.3 * history.wrench[1:6, 2]).all()


def test_forces_are_in_proportion_to_youngs_modulus(engine):
    """With a Young's modulus four times as large, wrenches are four times as large and displacements the same."""
    path = poses((0, 0, -0.2))
    soft, hard = (pressed(engine, Sphere(4e-3), path, modulus=modulus) for modulus in (0.5e6, 2e6))
    np.testing.assert_allclose(hard.wrench, 4 * soft.wrench, rtol=1e-9, atol=1e-12)
    np.testing.assert_array_equal(hard.displacement, soft.displacement)


def test_forces_are_too_high_by_a_known_factor(history, engine):
    """Against ``fem`` on the same vertices: four-node tetrahedra lock. A coarse pad shows it most, at little depth."""
    fem = pressed(FemEngine(engine.mesh, NU), Sphere(4e-3), poses(*[(0.3, 0.1, -depth) for depth in DEPTHS]), 0.3)
    ratio = history.wrench[1:4, 2] / fem.wrench[:, 2]
    assert (ratio > 1.2).all()
    assert (ratio < 2.2).all()


@pytest.mark.nightly
def test_forces_on_a_finer_pad():
    """On 2,100 vertices of the DIGIT's dome forces are lower, and still half too high at little depth."""
    pad = structured_pad("finer", DIGIT.gel, GridPlan(10, 12, 0.6e-3, (3.6e-3, 4.8e-3), (0.0, 0.42, 0.75, 1.0)))
    path = poses((0.13, 0.07, -0.2), (0.13, 0.07, -0.5))
    found, expected = (
        pressed(make_engine(pad, NU, name), Sphere(4e-3), path, 0.6) for name in ("mujoco-flex", "finite-strain")
    )
    assert not found.status.any()
    ratio = found.wrench[:, 2] / expected.wrench[:, 2]
    assert (ratio > 1.1).all()
    assert (ratio < 1.7).all()


def test_a_flat_punch_and_a_tilt(engine):
    """Convex solids are pressed as meshes; a tilted one is turned back."""
    tilted = poses((0, 0, -0.2))
    tilted[0, :3, :3] = [[np.cos(TILT), 0, np.sin(TILT)], [0, 1, 0], [-np.sin(TILT), 0, np.cos(TILT)]]
    history = pressed(engine, CylinderFlat(radius=2e-3), tilted, friction=0.3)
    assert history.status[0] == FrameStatus.SOLVED
    # turned about +y, the side at +x is the deeper one; the force there turns about -y
    assert history.wrench[0, 4] < -0.2e-3 * history.wrench[0, 2]


def test_frames_that_cannot_be_played_say_why(engine, tmp_path, monkeypatch):
    """A missing pose, too deep, no rest within the budget; and nothing is written where the user works."""
    monkeypatch.chdir(tmp_path)
    path = poses((0, 0, 0), (0, 0, -3), (0, 0, -0.2))
    path[0] = np.nan
    monkeypatch.setattr(flex, "BUDGET", flex.WINDOW - 1)
    history = pressed(engine, Sphere(4e-3), path, keep="none")
    assert history.status.tolist() == [FrameStatus.POSE_MISSING, FrameStatus.TOO_DEEP, FrameStatus.NOT_CONVERGED]
    assert np.isnan(history.wrench).all()
    assert history.displacement.shape == (3, 0, 3)
    assert not list(tmp_path.iterdir())


def test_what_it_cannot_play_is_refused(engine):
    """An indenter that is not convex, another Poisson's ratio and a mesh of tetrahedra are refused."""
    touches = [GelTouch(indenter, poses((0, 0, -0.2))) for indenter in (Sphere(), Ring())]
    with pytest.raises(UsageError, match="'ring' is not convex"):
        next(engine.play(touches, GelMaterial(1e6, NU, 0.5)))
    with pytest.raises(UsageError, match=r"Poisson's ratio 0\.48"):
        next(engine.play([GelTouch(Sphere(), poses((0, 0, 0)))], GelMaterial(1e6, 0.48, 0.5)))
    points = np.vstack([np.zeros(3), np.eye(3)])
    vertices, cells, faces = ten_node_cells(points, np.array([[0, 1, 2, 3]]), np.array([[1, 2, 3]]))
    with pytest.raises(UsageError, match="tetrahedron10"):
        flex.FlexEngine(PadMesh("mine", "tetrahedron10", vertices, cells, np.array([0]), faces), NU)


def test_engines_by_name():
    """The names of engines and fidelities give engines, and unknown or contradictory ones are refused."""
    assert mechanics_of("fem", "linear") == "linear"
    assert mechanics_of("mujoco-flex", "finite-strain") == "mujoco-flex"
    assert make_engine(slab(), NU, "mujoco-flex").fidelity == "mujoco-flex"
    for names, words in (
        (("isaac", "linear"), "fem or mujoco-flex"),
        (("fem", "fine"), "finite-strain or linear"),
        (("mujoco-flex", "linear"), "linear preview"),
    ):
        with pytest.raises(UsageError, match=words):
            mechanics_of(*names)


def test_without_mujoco_it_says_so(monkeypatch):
    """Without MuJoCo the engine names the extra that installs it."""
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(UsageError, match=r"(?s)not installed.*tactiledata\[sim\]"):
        flex.FlexEngine(slab(), NU)
