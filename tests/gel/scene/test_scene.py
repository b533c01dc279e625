"""The scene: kinematics, frames held against each other, distances, pictures."""

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from tactiledata.errors import TactileDataError, UsageError
from tactiledata.gel.scene.arm import base_from_flange, fit_tool
from tactiledata.gel.scene.mujoco_package import load_mujoco
from tactiledata.gel.scene.scene import GelScene, SceneParts
from tactiledata.indenters.sphere import Sphere
from tactiledata.rig.motion import ur5e
from tactiledata.transforms import Transform

JOINTS = np.random.default_rng(7).uniform(-2.5, 2.5, (20, 6))
TOOL = Transform.from_parts("flange", "tcp", [0.01, -0.02, 0.15], [0.1, 0.2, 0.3, 0.9]).matrix
GEL = Transform.from_parts("tcp", "gel", [0.002, 0.001, 0.01], [0.0, 0.0, 0.38, 0.92]).matrix
PAD = trimesh.creation.box([0.018, 0.025, 0.004]).apply_translation([0, 0, -0.002])


def parts(height, joints=JOINTS[0], tilt=0.0):
    """A ball of 4 mm whose tip is at a height over the gel's middle, its axis against the gel's."""
    base_from_tcp = base_from_flange(joints)[0] @ TOOL
    gel_from_indenter = np.eye(4)
    gel_from_indenter[:3, :3] = Rotation.from_euler("x", tilt).as_matrix()
    gel_from_indenter[:3, 3] = (0.001, -0.002, height)
    place = base_from_tcp @ GEL @ gel_from_indenter
    return SceneParts(base_from_tcp, GEL, PAD, Sphere(4e-3).mesh(), place, joints, TOOL)


def test_flange_is_where_the_closed_form_says():
    """Forward kinematics agree with the rig's, written apart, and with MuJoCo's placing of the bodies."""
    np.testing.assert_allclose(base_from_flange(JOINTS), ur5e.forward(JOINTS), atol=1e-12)
    for joints in JOINTS[:4]:
        scene = GelScene(parts(0.0, joints))
        np.testing.assert_allclose(scene.pose("tcp"), scene.parts.base_from_tcp, atol=1e-7)
        np.testing.assert_allclose(scene.pose("gel"), scene.parts.base_from_tcp @ GEL, atol=1e-7)
        np.testing.assert_allclose(scene.pose("indenter"), scene.parts.base_from_indenter, atol=1e-7)


@pytest.mark.parametrize("height", [2e-3, 1e-4, -5e-4])
def test_distance_of_a_ball(height):
    """Over a flat pad the distance of a ball is its tip's height, negative where it overlaps, and lies on both."""
    found, ends = GelScene(parts(height)).distance()
    assert found == pytest.approx(height, abs=2e-6)
    assert np.linalg.norm(ends[1] - ends[0]) == pytest.approx(abs(height), abs=2e-6)


def test_a_tool_is_found_and_a_wrong_frame_shows():
    """Joints and poses give the planted tool; poses in another base, or of another moment, leave too much."""
    poses = base_from_flange(JOINTS) @ TOOL
    joints = JOINTS.copy()
    joints[3] = np.nan
    check = fit_tool(joints, poses)
    np.testing.assert_allclose(check.flange_from_tcp, TOOL, atol=1e-9)
    assert check.samples == 19
    assert check.position_off < 1e-9
    assert check.rotation_off < 1e-6
    # ROS' base_link is the controller's base, turned half round
    half_round = np.diag([-1.0, -1.0, 1.0, 1.0])
    assert fit_tool(JOINTS, half_round @ poses).position_off > 0.1
    assert fit_tool(JOINTS, np.roll(poses, 1, axis=0)).position_off > 0.1
    assert fit_tool(np.full((4, 6), np.nan), poses[:4]) is None


def test_scene_without_an_arm():
    """Where joints are unknown the sensor floats where its pose says."""
    with_arm = parts(1e-3)
    alone = SceneParts(with_arm.base_from_tcp, GEL, with_arm.gel, with_arm.indenter, with_arm.base_from_indenter)
    scene = GelScene(alone)
    np.testing.assert_allclose(scene.pose("gel"), with_arm.base_from_tcp @ GEL, atol=1e-7)
    assert "q0" not in scene.mjcf
    assert "q5" in GelScene(with_arm).mjcf
    with pytest.raises(UsageError, match="flange_from_tcp"):
        GelScene(
            SceneParts(alone.base_from_tcp, GEL, alone.gel, alone.indenter, alone.base_from_indenter, JOINTS[0])
        ).pose("gel")


def test_exported_scene_is_whole(tmp_path):
    """The MJCF needs no other file: read back elsewhere, it holds the arm's joints and all geometry."""
    mujoco = load_mujoco("the test")

    (tmp_path / "scene.xml").write_text(GelScene(parts(1e-3)).mjcf)
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "scene.xml"))
    assert model.njnt == 6
    assert model.mesh("indenter").vertnum[0] == len(Sphere(4e-3).mesh().vertices)


@pytest.mark.slow
def test_picture_shows_gel_and_indenter():
    """The near view holds the colours of both; a scene whose indenter is far away lacks one."""
    try:
        near = GelScene(parts(1e-3)).picture()
    except TactileDataError as error:
        pytest.skip(f"no OpenGL: {error}")
    far = GelScene(parts(0.4)).picture()
    assert near.shape == (720, 1920, 3)

    def bluish(picture):
        red, _, blue = picture[:, 960:].astype(int).transpose(2, 0, 1)
        return int((blue > red + 60).sum())

    assert bluish(near) > 2000
    assert bluish(far) < 100
