"""Logs of the rig: whole, deterministic, the same in both forms, silent about the truth, with every variant."""

import filecmp
import json
from pathlib import Path

import cv2
import numpy as np
import pandas as pd
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from tactiledata.contract.description import LogDescription
from tactiledata.contract.schema import read_document
from tactiledata.errors import TactileDataError, UnknownName, UsageError
from tactiledata.rig.logs import ros2_messages
from tactiledata.rig.motion import ur5e
from tactiledata.rig.record import record
from tactiledata.rig.scenario.scenario import load_scenario
from tactiledata.transforms import pose_matrices

START = 1_700_000_000_000_000_000
PLAIN = {
    "format": "tactiledata-scenario/1",
    "seed": 5,
    "sensors": {"D1": {"background": "digit-bg-0"}, "D2": {"background": "digit-bg-3"}},
    "indenters": {"ball": {"shape": "sphere", "radius": 0.004}},
    "streams": {"joints": 50, "tcp": 50, "wrench": 50, "arm_wrench": 20},
    "images": {"free_air_frames": 1},
    "trajectories": [
        {
            "name": f"touch-{serial}",
            "sensor": serial,
            "indenter": "ball",
            "position": [0.001, -0.002],
            "steps": [{"press": {"depth": 0.0003, "settle": 0.05}}, {"shear": {"by": [0.0, 0.0002], "settle": 0.05}}],
        }
        for serial in ("D1", "D2")
    ],
}


def recorded(folder, form="mcap", **changes):
    return record(load_scenario({**PLAIN, **changes}), folder, form)


def messages(path):
    """(topic, log time, decoded message) in the order in which the file holds them."""
    with path.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()], validate_crcs=True)
        found = reader.iter_decoded_messages(log_time_order=False)
        return [(channel.topic, message.log_time, decoded) for _, channel, message, decoded in found]


def stamp_of(message):
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


def files_below(folder):
    return sorted(path.relative_to(folder) for path in folder.rglob("*") if path.is_file())


@pytest.mark.slow
@pytest.mark.parametrize("form", ["mcap", "folder"])
def test_the_same_scenario_gives_the_same_bytes(tmp_path, form):
    """Recorded twice, every file is equal, truth included; recording over it changes nothing."""
    first, second = tmp_path / "first", tmp_path / "second"
    for folder in (first, second, second):
        recorded(folder, form)
    assert files_below(first) == files_below(second)
    _, mismatch, errors = filecmp.cmpfiles(first, second, files_below(first), shallow=False)
    assert not mismatch
    assert not errors


def test_both_forms_hold_the_same_recording(tiny_mcaps, tiny_folders):
    """Streams, pictures, trajectories and description of the MCAP are those of the folder log."""
    found = messages(tiny_mcaps[0])
    folder = tiny_folders[0]
    wrench = pd.read_csv(folder / "wrench.csv")
    told = [message for topic, _, message in found if topic == ros2_messages.TOPICS["wrench"]]
    assert [stamp_of(message) for message in told] == wrench.t_ns.tolist()
    forces = [[message.wrench.force.x, message.wrench.torque.z] for message in told]
    np.testing.assert_array_equal(forces, wrench[["fx", "tz"]].to_numpy())
    pictures = [bytes(message.data) for topic, _, message in found if topic.endswith("image_raw/compressed")]
    assert pictures == [path.read_bytes() for path in sorted((folder / "frames").iterdir())]
    with tiny_mcaps[0].open("rb") as stream:
        (metadata,) = make_reader(stream).iter_metadata()
    document = json.loads(metadata.metadata["log"])
    rows = document.pop("trajectories")
    assert document == read_document(folder / "log.yaml")
    pd.testing.assert_frame_equal(
        pd.DataFrame(rows)[list(rows[0])], pd.read_csv(folder / "trajectories.csv")[list(rows[0])]
    )


def test_the_mcap_is_what_a_ros2_recorder_writes(tiny_mcaps):
    """It has the right profile, encodings, topics and frames, ordered log times after the stamps, and valid CRCs."""
    with tiny_mcaps[0].open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        summary = reader.get_summary()
        assert reader.get_header().profile == "ros2"
        assert [attachment.name for attachment in reader.iter_attachments()] == ["backgrounds/D20001.png"]
    assert {channel.message_encoding for channel in summary.channels.values()} == {"cdr"}
    assert {schema.encoding for schema in summary.schemas.values()} == {"ros2msg"}
    assert all(index.compression == "zstd" for index in summary.chunk_indexes)
    found = messages(tiny_mcaps[0])
    assert {topic for topic, _, _ in found} == {*ros2_messages.TOPICS.values(), "/digit/D20001/image_raw/compressed"}
    times = [log_ns for _, log_ns, _ in found]
    assert times == sorted(times)
    for name in ("wrench", "arm_wrench", "tcp"):
        frames = {message.header.frame_id for topic, _, message in found if topic == ros2_messages.TOPICS[name]}
        assert frames == {ros2_messages.FRAMES[name]}


def test_clocks_are_offset_as_the_scenario_says(tiny_folders):
    """Stamps are on the stream's own clock; only known offsets are told."""
    scenario = read_document(Path(__file__).parents[2] / "recipes/worlds/tiny.yaml")
    description = LogDescription.checked(read_document(tiny_folders[0] / "log.yaml"), "")
    truth = pd.read_parquet(tiny_folders[0].parent / "truth" / f"{tiny_folders[0].name}.parquet")
    for stream in ("wrench", "frames"):
        rows = truth[truth.stream == stream]
        assert set(rows.host_ns - rows.stamp_ns) == {scenario["clocks"][stream]["offset_ns"]}
    assert description.clock_offset("wrench") == scenario["clocks"]["wrench"]["offset_ns"]
    assert description.clock_offset("frames") == 0


def test_joints_and_tcp_tell_the_same_story(tiny_folders):
    """Forward kinematics of the joints gives the flange that carries the TCP."""
    tcp, joints = pd.read_csv(tiny_folders[0] / "tcp.csv"), pd.read_csv(tiny_folders[0] / "joints.csv")
    assert (tcp.t_ns == joints.t_ns).all()
    flange_from_tcp = load_scenario(PLAIN).robot.flange_from_tcp.matrix
    reached = ur5e.forward(joints.iloc[:, 1:].to_numpy()) @ flange_from_tcp
    told = pose_matrices(tcp.iloc[:, 1:].to_numpy())
    # the reported position carries its own noise of a micrometre
    np.testing.assert_allclose(reached, told, atol=1e-5)


def test_trajectories_begin_in_free_air(tiny_folders):
    """Contact begins half a second into a trajectory or later, and pictures show it only while there is force."""
    log = tiny_folders[0]
    truth = json.loads((log.parent / "truth" / f"{log.name}.json").read_text())
    for trajectory in truth["trajectories"].values():
        assert trajectory["onset_ns"] - trajectory["start_ns"] >= 5e8
        assert trajectory["release_ns"] < trajectory["end_ns"]
    frames = pd.read_csv(log / "frames.csv")
    contacts = pd.read_parquet(log.parent / "truth" / f"{log.name}.parquet").query("stream == 'frames'")
    background = cv2.imread(str(log / "backgrounds" / f"{log.name}.png")).astype(float)
    change = [
        np.abs(cv2.GaussianBlur(cv2.imread(str(log / name)) - background, (0, 0), 3)).max() for name in frames.file
    ]
    touching = contacts.fz.to_numpy() > 0.3
    assert np.min(np.array(change)[touching]) > 3 * np.max(np.array(change)[contacts.fz.to_numpy() == 0])


def test_nothing_in_the_log_tells_the_truth(tiny_folders, tiny_mcaps):
    """Neither the material nor a pose offset nor a time of contact stands in any log."""
    truth = json.loads((tiny_folders[0].parent / "truth" / "D20001.json").read_text())
    secrets = [
        str(truth["material"]["youngs_modulus"]),
        "onset",
        "friction",
    ]
    secrets += [repr(value) for row in truth["trajectories"].values() for value in row["offset"]]
    texts = [path.read_text() for path in tiny_folders[0].iterdir() if path.suffix in {".yaml", ".csv"}]
    with tiny_mcaps[0].open("rb") as stream:
        texts += [record.metadata["log"] for record in make_reader(stream).iter_metadata()]
    for text in texts:
        assert not [secret for secret in secrets if secret in text]


def test_a_log_is_whole_or_not_there(tmp_path, monkeypatch):
    """A fault in the middle of a log leaves the log of before, and no part file."""
    from tactiledata.rig.logs import write_mcap

    recorded(tmp_path)
    before = (tmp_path / "D1.mcap").read_bytes()
    monkeypatch.setattr(
        write_mcap, "_describe", lambda *_: (_ for _ in ()).throw(OSError(28, "No space left on device"))
    )
    with pytest.raises(TactileDataError, match="No space left") as caught:
        recorded(tmp_path, seed=6)
    assert caught.value.exit_code == 1
    assert (tmp_path / "D1.mcap").read_bytes() == before
    assert not list(tmp_path.glob(".*"))


def test_no_place_to_write_is_a_clear_error(tmp_path):
    """A file where the folder should be; a form that is none."""
    (tmp_path / "taken").write_text("")
    with pytest.raises(UsageError, match="cannot be written"):
        recorded(tmp_path / "taken")
    with pytest.raises(UnknownName, match="hdf5"):
        recorded(tmp_path / "out", "hdf5")


def test_progress_ends_at_the_number_of_trajectories(tmp_path):
    """Whoever watches sees it rise to the end."""
    seen = []
    record(load_scenario(PLAIN), tmp_path, "mcap", lambda done, total: seen.append((done, total)))
    assert seen[-1] == (2, 2)
    assert [done for done, _ in seen] == sorted(done for done, _ in seen)


@pytest.mark.slow
@pytest.mark.parametrize(("encoding", "said"), [("rgb8", "rgb8"), ("bgr8", "bgr8")])
def test_raw_images_say_what_they_are(tmp_path, encoding, said):
    """Raw pictures in either order of channels are the same picture."""
    (path, _) = recorded(tmp_path, images={"encoding": "raw", "channels": encoding})
    images = [message for topic, _, message in messages(path) if topic == "/digit/D1/image_raw"]
    assert images[0].encoding == said
    assert (images[0].height, images[0].width, images[0].step) == (320, 240, 720)
    pixels = np.frombuffer(images[0].data, np.uint8).reshape(320, 240, 3)
    rgb = pixels if encoding == "rgb8" else pixels[..., ::-1]
    # red stands on the left of this sensor
    assert rgb[160, :40, 0].mean() > rgb[160, :40, 2].mean() + 20


@pytest.mark.slow
def test_planted_faults_of_images(tmp_path):
    """Planted are mislabelled channels, a turned picture and lost pictures."""
    (path, _) = recorded(tmp_path / "a", images={"encoding": "raw", "mislabelled": True, "swapped_size": True})
    images = [message for topic, _, message in messages(path) if topic == "/digit/D1/image_raw"]
    assert (images[0].height, images[0].width, images[0].encoding) == (240, 320, "rgb8")
    (folder, _) = recorded(tmp_path / "b", "folder", imperfections={"dropped_frames": 0.5})
    frames = pd.read_csv(folder / "frames.csv", keep_default_na=False)
    lost = frames.file == ""
    assert 0 < lost.sum() < len(frames)
    assert len(list((folder / "frames").iterdir())) == (~lost).sum()


@pytest.mark.slow
def test_planted_faults_of_streams(tmp_path):
    """Planted are NaN in the wrench, messages out of order and repeated values."""
    faults = {"nan_wrench": 0.1, "out_of_order": 0.05}
    (folder, _) = recorded(tmp_path / "a", "folder", imperfections=faults)
    wrench = pd.read_csv(folder / "wrench.csv")
    assert 0.03 < wrench.fx.isna().mean() < 0.2
    assert (np.diff(wrench.t_ns) < 0).any()
    (path, _) = recorded(tmp_path / "b", imperfections=faults)
    assert (np.diff([log_ns for _, log_ns, _ in messages(path)]) < 0).any()
    (folder, _) = recorded(tmp_path / "c", "folder", streams={"wrench": 100, "wrench_effective": 62.5})
    repeated = (np.diff(pd.read_csv(folder / "wrench.csv")[["fx", "fy", "fz"]], axis=0) == 0).all(axis=1)
    assert repeated.mean() == pytest.approx(0.375, abs=0.02)


@pytest.mark.slow
def test_logs_that_say_little(tmp_path):
    """Unnamed trajectories; bare driver topics without description; a folder log cannot do without."""
    (folder, _) = recorded(tmp_path / "a", "folder", recordings={"name_trajectories": False})
    assert not (folder / "trajectories.csv").exists()
    assert pd.read_csv(folder / "frames.csv").trajectory.isna().all()
    (path, _) = recorded(tmp_path / "b", recordings={"describe": False, "crcs": False})
    with path.open("rb") as stream:
        reader = make_reader(stream)
        assert not list(reader.iter_metadata())
        assert not list(reader.iter_attachments())
        assert reader.get_summary().statistics.message_count > 100
    with pytest.raises(UsageError, match="needs its description"):
        recorded(tmp_path / "c", "folder", recordings={"describe": False})


@pytest.mark.slow
def test_two_sensors_in_one_log_and_a_video(tmp_path):
    """`group: all` puts both sensors into one log; a video runs on both cameras through the whole log."""
    images = {"capture": "video", "rate": 5}
    (path,) = recorded(tmp_path, recordings={"group": "all"}, images=images)
    counts = pd.Series([topic for topic, _, _ in messages(path) if topic.startswith("/digit")]).value_counts()
    assert set(counts.index) == {"/digit/D1/image_raw/compressed", "/digit/D2/image_raw/compressed"}
    assert counts.nunique() == 1


def test_a_mesh_travels_with_the_log(tmp_path):
    """An indenter given as a mesh lies inside the log, under the name that the description gives."""
    import trimesh

    trimesh.creation.icosphere(subdivisions=2, radius=0.004).apply_translation([0, 0, 0.004]).export(tmp_path / "p.stl")
    document = {**PLAIN, "indenters": {"ball": {"mesh": "p.stl", "unit": "m"}}, "images": {"free_air_frames": 0}}
    (folder, _) = record(load_scenario(document, tmp_path), tmp_path / "out", "folder")
    entry = read_document(folder / "log.yaml", "log")["indenters"]["ball"]
    assert (folder / entry["mesh"]).read_bytes() == (tmp_path / "p.stl").read_bytes()
