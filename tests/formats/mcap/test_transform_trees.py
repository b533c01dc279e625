"""Poses out of a tree of transforms: composed along fixed and moving edges, up and down, as matrices would."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from generators.collect import codes, read
from generators.mcap_files import KINDS, START, STEP, Tape, tree_message
from scipy.spatial.transform import Rotation

from tactiledata.formats.mcap.mcap import McapFormat
from tactiledata.formats.mcap.transform_tree import composed, inverted
from tactiledata.transforms import pose_matrices

FORMAT = McapFormat()


def poses(count, seed):
    rng = np.random.default_rng(seed)
    return np.concatenate([rng.normal(size=(count, 3)), Rotation.random(count, random_state=seed).as_quat()], axis=1)


def tcp_of(path, frame, child):
    mapping = {
        "format": "tactiledata-mapping/1",
        "signals": {"tcp": {"topic": "/tf", "frame": frame, "child_frame": child}},
    }
    [(recording, _)] = read(FORMAT, Path(path), mapping)
    return recording


def arm(path, count=5):
    """base_link -> base and wrist -> tool0 fixed, base_link -> elbow -> wrist moving; returns the edges as matrices."""
    edges = {name: poses(count, seed) for seed, name in enumerate(("base", "elbow", "wrist", "tool0"))}
    with Tape(path) as tape:
        fixed = [("base_link", "base", edges["base"][0]), ("wrist", "tool0", edges["tool0"][0])]
        tape.ros("/tf_static", START, tree_message(START, fixed), KINDS["tf"])
        for index in range(count):
            time = START + (index + 1) * STEP
            moving = [("base_link", "elbow", edges["elbow"][index]), ("elbow", "wrist", edges["wrist"][index])]
            tape.ros("/tf", time, tree_message(time, moving), KINDS["tf"])
            tape.ros("/tf", time, tree_message(time, [("world", "camera", edges["elbow"][0])]), KINDS["tf"])
    return {name: pose_matrices(rows) for name, rows in edges.items()}


def test_a_chain_is_composed(tmp_path):
    """The pose between a frame and one four edges away equals the product of matrices, one sample a message."""
    edges = arm(tmp_path / "run.mcap")
    recording = tcp_of(tmp_path / "run.mcap", "base", "tool0")
    tcp = recording.signals["tcp"]
    expected = np.linalg.inv(edges["base"][0]) @ edges["elbow"] @ edges["wrist"] @ edges["tool0"][0]
    np.testing.assert_allclose(pose_matrices(tcp.values), expected, atol=1e-12)
    np.testing.assert_array_equal(tcp.stamps.header, START + STEP * np.arange(1, 6))
    assert tcp.frame == "base"
    assert codes(recording) == set()


def test_a_chain_reads_both_ways(tmp_path):
    """The pose of the base in the tool is the inverse of that of the tool in the base."""
    arm(tmp_path / "run.mcap")
    there = tcp_of(tmp_path / "run.mcap", "base", "tool0").signals["tcp"].values
    back = tcp_of(tmp_path / "run.mcap", "tool0", "base").signals["tcp"].values
    np.testing.assert_allclose(pose_matrices(there) @ pose_matrices(back), np.tile(np.eye(4), (5, 1, 1)), atol=1e-12)


def test_an_edge_is_read_as_it_was_written(tmp_path):
    """Where one transform joins the two frames, its numbers come back to the bit."""
    rows = poses(4, 7)
    with Tape(tmp_path / "run.mcap") as tape:
        for index, row in enumerate(rows):
            tape.ros("/tf", START + index, tree_message(START, [("base", "tool0", row)]), KINDS["tf"])
    np.testing.assert_array_equal(tcp_of(tmp_path / "run.mcap", "/base", "tool0").signals["tcp"].values, rows)


def test_frames_that_are_not_joined_are_said(tmp_path):
    """No pose is made up between two trees, and the frames that there are are listed."""
    arm(tmp_path / "run.mcap")
    mapping = {
        "format": "tactiledata-mapping/1",
        "signals": {
            "tcp": {"topic": "/tf", "frame": "base", "child_frame": "camera"},
            "elbow": {"topic": "/tf", "fields": ["transforms[0].transform.translation.x"], "units": ["m"]},
        },
    }
    [(recording, _)] = read(FORMAT, tmp_path / "run.mcap", mapping)
    assert "tcp" not in recording.signals
    [finding] = [finding for finding in recording.findings if finding.code == "frames-not-joined"]
    assert "base_link -> base" in finding.message
    assert "world -> camera" in finding.message


def test_a_ring_of_frames_ends(tmp_path):
    """Frames that are each other's parents join nothing and do not hang."""
    entries = [("a", "b", poses(1, 0)[0]), ("b", "a", poses(1, 1)[0]), ("base", "tool0", poses(1, 2)[0])]
    with Tape(tmp_path / "run.mcap") as tape:
        tape.ros("/tf", START, tree_message(START, entries), KINDS["tf"])
    assert len(tcp_of(tmp_path / "run.mcap", "base", "tool0").signals["tcp"].values) == 1
    [source] = FORMAT.sources(tmp_path / "run.mcap")
    assert FORMAT.inspect(source).suggested_mapping["signals"]["tcp"]["child_frame"] == "tool0"


def test_inspect_drafts_a_pose_over_a_common_frame(tmp_path):
    """The draft joins base and tool0 although base hangs below base_link, and reads what the draft says."""
    arm(tmp_path / "run.mcap")
    [source] = FORMAT.sources(tmp_path / "run.mcap")
    drafted = FORMAT.inspect(source).suggested_mapping["signals"]["tcp"]
    assert drafted == {"topic": "/tf", "frame": "base", "child_frame": "tool0"}
    mapping = {"format": "tactiledata-mapping/1", "signals": {"tcp": drafted}}
    roles = {topic.name: topic.role for topic in FORMAT.inspect(source, mapping).topics}
    assert roles == {"/tf": "tcp", "/tf_static": "tcp (fixed transforms)"}


@pytest.mark.parametrize("seed", range(3))
def test_composition_is_that_of_matrices(seed):
    """`composed` and `inverted` are the product and the inverse of the matrices."""
    one, other = poses(2, seed)
    product = pose_matrices([one])[0] @ pose_matrices([other])[0]
    np.testing.assert_allclose(pose_matrices([composed(tuple(one), tuple(other))])[0], product, atol=1e-12)
    np.testing.assert_allclose(
        pose_matrices([inverted(tuple(one))])[0], np.linalg.inv(pose_matrices([one])[0]), atol=1e-12
    )
