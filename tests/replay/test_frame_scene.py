"""The scene of a stored frame: the recording's own description, checked, and the command."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from tactiledata.cli.main import app
from tactiledata.errors import TactileDataError, UnknownName, UsageError
from tactiledata.gel.mesh.structured_pad import pad_mesh
from tactiledata.replay.frame_scene import frame_scene
from tactiledata.replay.plan import plan_replay
from tactiledata.store.read.reader import Store
from tactiledata.transforms import Transform


class Missing(Store):
    """A store in which some aligned values are missing, or moved."""

    gone = ()
    moved = 0.0

    def aligned(self, name, rows=None):
        values, gaps = super().aligned(name, rows)
        if name in self.gone:
            values = np.full_like(values, np.nan)
        if name == "tcp" and self.moved:
            values = values + self.moved * np.arange(len(values))[:, None] * np.eye(7)[0]
        return values, gaps


@pytest.fixture
def store(tiny_store):
    return Missing.open(tiny_store)


def test_scene_is_where_the_replay_presses(store):
    """MuJoCo's gel and indenter stand to each other as in the poses that the gel engine is given."""
    touch = plan_replay(store, pad_mesh).touches[0]
    found = frame_scene(store, touch.uid, 6).scene
    expected = touch.gel_touch(store, 0.0).poses[6]
    np.testing.assert_allclose(np.linalg.inv(found.pose("gel")) @ found.pose("indenter"), expected, atol=1e-6)


def test_joints_and_poses_agree(store):
    """The rig's joints and poses tell the same; a pose stream that drifts away from the joints does not."""
    found = frame_scene(store, "t00000", 3)
    assert found.agrees
    assert found.check.position_off < 1e-4
    store.moved = 1e-3
    assert not frame_scene(store, "t00000", 3).agrees


def test_pose_from_joints(store):
    """Without poses the sensor is where the arm's joints and the stated tool put it."""
    wanted = frame_scene(store, "t00000", 5)
    store.gone = ("tcp",)
    tool = Transform("flange", "tcp", wanted.check.flange_from_tcp)
    found = frame_scene(store, "t00000", 5, flange_from_tcp=tool)
    assert (wanted.pose_from, found.pose_from) == ("tcp", "joints")
    assert found.check is None
    np.testing.assert_allclose(found.scene.pose("gel"), wanted.scene.pose("gel"), atol=1e-4)
    store.gone = ("tcp", "joints")
    with pytest.raises(TactileDataError, match="neither pose nor joints"):
        frame_scene(store, "t00000", 5)


def test_without_joints_the_arm_is_left_out(store):
    """Poses alone place the sensor."""
    wanted = frame_scene(store, "t00000", 5).scene.pose("gel")
    store.gone = ("joints",)
    found = frame_scene(store, "t00000", 5).scene
    np.testing.assert_allclose(found.pose("gel"), wanted, atol=1e-6)
    assert 'name="q0"' not in found.mjcf


def test_wrong_names_are_told(store):
    """A trajectory or frame that does not exist."""
    with pytest.raises(UnknownName, match="t00000"):
        frame_scene(store, "t0000", 0)
    with pytest.raises(UsageError, match="0 to 18"):
        frame_scene(store, "t00000", 19)


def test_command(tiny_store, tmp_path):
    """`scene` writes MJCF, says where the indenter is, and refuses other kinds of files."""
    call = ["scene", str(tiny_store), "--trajectory", "t00000", "--frame", "8", "--json", "--out"]
    done = CliRunner().invoke(app, [*call, str(tmp_path / "deep" / "touch.xml")])
    assert done.exit_code == 0, done.output
    facts = json.loads(done.output)
    assert facts["distance_m"] < 0
    assert facts["joints_against_poses"]["agree"]
    assert (tmp_path / "deep" / "touch.xml").read_text().startswith("<mujoco")
    refused = CliRunner().invoke(app, [*call, str(tmp_path / "touch.gif")])
    assert isinstance(refused.exception, UsageError)
