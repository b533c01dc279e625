"""MCAP files of an export hold every sample of the store, for our own reader and for others."""

import json
from pathlib import Path

import numpy as np
import pytest
import yaml
from exported import export
from loader_stores import write_loader_store
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from owner_loaders import snippet_of
from random_signals import renamed_store

from tactiledata.errors import StoreError
from tactiledata.export.message_types import number_type
from tactiledata.export.recorded_streams import RecordedStamps, RecordedStreams
from tactiledata.export.recording_log import LoggedStream, write_log
from tactiledata.ingest.pipeline import ingest
from tactiledata.ingest.trajectories.assemble import IngestOptions
from tactiledata.store.read.reader import Store

STAMPS = ("log_ns", "publish_ns", "header_ns")


def same_signals(ours, back, names):
    """The signals of two stores are equal: times, stamps, values, columns and frames."""
    for name in names:
        first, second = ours.signal(name), back.signal(name)
        assert first.n_rows == second.n_rows, name
        assert (first.columns, first.units, first.frame) == (second.columns, second.units, second.frame)
        everything = (0, first.n_rows)
        assert np.array_equal(first.t_ns(*everything), second.t_ns(*everything)), name
        assert np.array_equal(first.values(*everything), second.values(*everything), equal_nan=True), name


@pytest.fixture(scope="module", params=["mcap", "folder"])
def world(request, tmp_path_factory):
    """A store of the tiny world, from MCAP files or from folder logs, its export, and the store made of that."""
    place = tmp_path_factory.mktemp(request.param)
    ingest(request.getfixturevalue(f"tiny_{request.param}s"), place / "ds.zarr")
    store = Store.open(place / "ds.zarr")
    out, document = export(store, "mcap", place / "out")
    report = ingest([out], place / "back.zarr")
    assert {source.status for source in report.sources} <= {"ok"}
    return store, out, document, Store.open(place / "back.zarr")


@pytest.mark.slow
def test_our_reader_gets_the_same_store_back(world):
    """Signals, aligned values, contact forces, frames, their bytes, trajectories and descriptions are equal."""
    store, _, _, back = world
    assert back.signal_names == store.signal_names
    same_signals(store, back, store.signal_names)
    for name in store.aligned_names:
        assert np.array_equal(store.aligned(name)[0], back.aligned(name)[0], equal_nan=True), name
    assert back.encoded(range(back.n_frames)) == store.encoded(range(store.n_frames))
    columns = ["t_ns", "camera", "sensor", "encoding", "trajectory", "contact_force", "flags"]
    assert back.frames(columns).to_pylist() == store.frames(columns).to_pylist()
    names = ["trajectory", "sensor", "indenter", "start_ns", "end_ns", "peak_force", "segmented", "extra"]
    assert back.trajectories(names).to_pylist() == store.trajectories(names).to_pylist()
    for sensor, reference in store.references().items():
        assert np.array_equal(reference.image, back.reference(sensor).image)
    for ours, theirs in zip(store.sources().to_pylist(), back.sources().to_pylist(), strict=True):
        stated, again = json.loads(ours["description"]), json.loads(theirs["description"])
        assert {name: again[name] for name in stated} == stated


@pytest.mark.slow
def test_stamps_of_an_mcap_recording_stay(tiny_mcaps, tmp_path):
    """All three stamps of every image and sample are those of the recording."""
    ingest(tiny_mcaps, tmp_path / "ds.zarr")
    store = Store.open(tmp_path / "ds.zarr")
    out, _ = export(store, "mcap", tmp_path / "out")
    ingest([out], tmp_path / "back.zarr")
    back = Store.open(tmp_path / "back.zarr")
    assert back.frames(list(STAMPS)).to_pylist() == store.frames(list(STAMPS)).to_pylist()
    for name in store.signal_names:
        for kind in ("log", "publish", "header"):
            rows = (0, store.signal(name).n_rows)
            assert np.array_equal(store.signal(name).stamps(kind, *rows), back.signal(name).stamps(kind, *rows))


@pytest.mark.slow
def test_other_readers_find_well_known_types(world):
    """The `mcap` package and its ROS 2 decoder find types that Foxglove shows, and the values of the store."""
    store, out, document, _ = world
    with (out / "D20001.mcap").open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        summary = reader.get_summary()
        types = {channel.topic: summary.schemas[channel.schema_id].name for channel in summary.channels.values()}
        messages = list(reader.iter_decoded_messages())
        records = {record.name: record.metadata for record in reader.iter_metadata()}
    assert types["/digit/image_raw/compressed"] == "sensor_msgs/msg/CompressedImage"
    assert types["/robotiq_force_torque_sensor_broadcaster/wrench"] == "geometry_msgs/msg/WrenchStamped"
    assert types["/tcp_pose_broadcaster/pose"] == "geometry_msgs/msg/PoseStamped"
    assert types["/joint_states"] == "sensor_msgs/msg/JointState"
    assert document["streams"]["contact_wrench"]["kept_as"] == "/tactiledata/contact_wrench"
    times = [message.log_time for _, _, message, _ in messages]
    assert times == sorted(times)
    own = json.loads(records["tactiledata.export"]["export"])
    assert own["recorded"] == "simulated"
    assert {touch["uid"] for touch in own["trajectories"]} <= {*store.trajectories(["uid"])["uid"].to_pylist()}
    wrench = [m for _, channel, _, m in messages if channel.topic == "/tactiledata/contact_wrench"]
    assert wrench[0].header.frame_id == "gel"
    start, stop = json.loads(store.sources(["contents"])["contents"][0].as_py())["signals"]["contact_wrench"]["rows"]
    assert [m.wrench.force.z for m in wrench] == store.signal("contact_wrench").values(start, stop)[:, 2].tolist()
    pictures = [bytes(m.data) for _, channel, _, m in messages if channel.topic == "/digit/image_raw/compressed"]
    assert pictures == store.encoded(range(len(pictures)))


@pytest.mark.slow
def test_the_page_shows_lines_that_run(world, monkeypatch, capsys):
    """The lines under Loading list topics with their numbers of messages."""
    _, out, _, _ = world
    monkeypatch.chdir(out)
    exec(snippet_of(out), {})
    assert "/joint_states" in capsys.readouterr().out


@pytest.mark.slow
@pytest.mark.parametrize("encoding", ["png", "raw"])
def test_signals_of_any_name_come_back_by_the_mapping(encoding, tmp_path):
    """Cameras without a tactile name and signals of any name are read back by the mapping beside the files."""
    store = renamed_store(tmp_path / "ds.zarr", encoding)
    out, document = export(store, "mcap", tmp_path / "out")
    assert "--mapping mapping.yaml" in " ".join(document["remarks"])
    mapping = yaml.safe_load((out / "mapping.yaml").read_text())
    ingest([out], tmp_path / "back.zarr", IngestOptions(mapping=mapping))
    back = Store.open(tmp_path / "back.zarr")
    assert set(store.cameras) == set(back.cameras) == {"left_pad", "right_pad"}
    same_signals(store, back, ["temperature"])
    with (out / "run.mcap").open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        read = [m.t0 for _, _, _, m in reader.iter_decoded_messages(topics=["/tactiledata/temperature"])]
    assert read == store.signal("temperature").values(0, len(read))[:, 0].tolist()
    assert back.encoded(range(back.n_frames)) == store.encoded(range(store.n_frames))
    assert back.frames(["encoding"]).to_pylist() == store.frames(["encoding"]).to_pylist()


def test_captured_moments_without_an_image_are_counted(tmp_path):
    """They have no message; broken images do, as they came, and the document counts the former."""
    store = write_loader_store(tmp_path / "ds.zarr", n_sources=1, damaged=(3, 10))
    out, document = export(store, "mcap", tmp_path / "out")
    assert document["left_out"] == {"no image recorded": 1}
    with (out / "run0.mcap").open("rb") as stream:
        summary = make_reader(stream).get_summary()
    counts = summary.statistics.channel_message_counts
    by_topic = {channel.topic: counts[number] for number, channel in summary.channels.items()}
    assert by_topic["/digit/image_raw/compressed"] == store.n_frames - 1


def test_times_that_no_mcap_holds_are_refused(tmp_path):
    """A clock before 1970 or after 2038 is an error that names topic and times."""
    for times in ([-5, 3], [0, 2**31 * 10**9]):
        stamps = RecordedStamps(*[np.array(times)] * 3)
        stream = LoggedStream(number_type("wrench", tuple("abcdef")), stamps, lambda: iter(()))
        with (tmp_path / "x.mcap").open("wb") as file, pytest.raises(StoreError, match="1970 to 2038"):
            write_log(file, [stream], {}, {}, "a recording")


def test_recordings_of_one_name_get_two(tmp_path):
    """Two recordings with the same key are two files."""
    store = write_loader_store(tmp_path / "ds.zarr", n_sources=3)
    recorded = RecordedStreams(store)
    recorded.__dict__["sources"] = [{**source, "key": "day/run.mcap"} for source in recorded.sources]
    names = recorded.file_names
    assert len(set(names)) == 3
    assert all(Path(name).name == name and name.startswith("day%2Frun-") for name in names)


def test_descriptions_that_no_log_may_hold(tmp_path):
    """What a transfer notes goes into the record of the export; a recording without a known sensor says that it did."""
    store = write_loader_store(tmp_path / "ds.zarr", n_sources=2)
    recorded = RecordedStreams(store)
    touch = {"trajectory": "t1", "start_ns": 6000, "end_ns": 12000, "sensor": "D7"}
    gone = {"trajectory": "gone", "start_ns": 90000, "end_ns": 91000}
    stated = {"sensors": {"D1": {"model": "digit"}}, "trajectories": [touch, gone], "transfer": {"to": "ycb-sensorA"}}
    recorded.__dict__["sources"] = [
        {**recorded.sources[0], "description": json.dumps(stated)},
        {**recorded.sources[1], "description": json.dumps({"sensors": {"D2": {"model": 7}}})},
    ]
    log, others = recorded.description(0)
    assert log["sensors"] == {"D1": {"model": "digit", "background": "backgrounds/D1.png"}}
    assert [touch["trajectory"] for touch in log["trajectories"]] == ["gone", "t0", "t1", "t2"]
    assert log["trajectories"][2]["sensor"] == "D1"
    assert others == {"transfer": {"to": "ycb-sensorA"}}
    log, others = recorded.description(1)
    assert log == {}
    assert others["sensors"]["D2"]["model"] == 7
