"""Real recordings by others go in, or come back with a clear reason; what is wrong with them is found."""

import contextlib
from pathlib import Path

import numpy as np
import pytest

from tactiledata.errors import TactileDataError
from tactiledata.formats import FORMATS
from tactiledata.ingest.pipeline import ingest
from tactiledata.ingest.sources.discover import find_sources
from tactiledata.ingest.trajectories.assemble import IngestOptions
from tactiledata.store.check.check import check
from tactiledata.store.read.reader import Store

DATA = Path(__file__).resolve().parents[1] / "data"
BAGS = sorted((DATA / "mcap").rglob("*.mcap"))
NUMBERS = {  # what each file's own summary counts
    "cdr_test_0.mcap": 7,
    "only_services.mcap": 12,
    "talker.mcap": 20,
    "test_bag_for_seek_0.mcap": 5,
    "wrong_rmw_test_0.mcap": 7,
    "custom-camera-model.mcap": 30,
    "example.mcap": 111,
    "example_logs.mcap": 1111,
}


def inspected(path):
    sources, _ = find_sources([path])
    return [FORMATS[source.format]().inspect(source) for source in sources]


@pytest.mark.parametrize("name", NUMBERS)
def test_every_bag_gives_its_messages_or_a_reason(name):
    """Each real MCAP is counted to the last message; a topic that cannot be decoded says why, any other shows one."""
    path = next(bag for bag in BAGS if bag.name == name)
    looked = inspected(path)[0]
    assert sum(topic.messages for topic in looked.topics) == NUMBERS[name]
    for topic in looked.topics:
        assert topic.example or topic.note or not topic.messages, topic


def test_a_bag_in_several_files_is_one_recording():
    """The five files of the split bag are one source, with all 6,074 messages."""
    looked = inspected(DATA / "mcap" / "ros2" / "wbag")
    assert len(looked) == 1
    assert sum(topic.messages for topic in looked[0].topics) == 6074


@pytest.mark.parametrize("name", [name for name in NUMBERS if name != "custom-camera-model.mcap"])
def test_bags_without_touch_are_refused_with_their_topics(name, tmp_path):
    """A bag that holds nothing tactile is not taken in silence: the report names its topics and the mapping."""
    path = next(bag for bag in BAGS if bag.name == name)
    report = ingest([path], tmp_path / "ds.zarr")
    assert report.fell_short
    assert report.sources[0].state == "failed"
    assert len(report.sources[0].error) > 60


def test_numbers_of_any_topic_go_in_by_mapping(tmp_path):
    """The mouse of Foxglove's example becomes a signal, by a mapping of four lines."""
    path = next(bag for bag in BAGS if bag.name == "example.mcap")
    fields = {topic.name: topic.example for topic in inspected(path)[0].topics}
    assert "clientX" in fields["mouse"]
    mapping = {
        "format": "tactiledata-mapping/1",
        "signals": {"mouse": {"topic": "mouse", "fields": ["clientX", "clientY"], "units": ["px", "px"]}},
    }
    report = ingest([path], tmp_path / "ds.zarr", IngestOptions(mapping=mapping))
    assert report.sources[0].state == "added"
    signal = Store.open(tmp_path / "ds.zarr").signal("mouse")
    assert (signal.n_rows, signal.columns, signal.units) == (111, ("clientX", "clientY"), ("px", "px"))
    assert np.isfinite(signal.values(0, 111)).all()


def test_foxglove_images_keep_their_bytes(tmp_path):
    """JSON-encoded CompressedImage messages become frames whose payload decodes and fits its checksum."""
    path = next(bag for bag in BAGS if bag.name == "custom-camera-model.mcap")
    report = ingest([path], tmp_path / "ds.zarr")
    assert report.sources[0].state == "added", report.sources[0].error
    store = Store.open(tmp_path / "ds.zarr")
    assert store.n_frames == 10
    assert store.images([0])[0].ndim == 3
    assert check(store, decode=True) == []


def test_the_gelsight_presses_and_their_impossible_radii(tmp_path):
    """All 49 presses are in, pixel for pixel; 48 of their radii exceed the ball, and a finding counts them."""
    pack = DATA / "gelsight_r15" / "dataPack.npz"
    report = ingest([pack], tmp_path / "ds.zarr")
    assert report.sources[0].frames == 49
    store = Store.open(tmp_path / "ds.zarr")
    finding = next(one for one in report.sources[0].findings if one.code == "impossible-contact-radius")
    assert finding.count == 48
    with np.load(pack) as content:
        original, background = content["imgs"], content["f0"]
    stored = np.stack(store.images(list(range(49))))
    names = store.trajectories(["trajectory"])["trajectory"].to_pylist()
    assert len(names) == 49
    distances = np.abs(stored[:, None, ::16, ::16].astype(int) - original[None, :, ::16, ::16, ::-1]).sum((2, 3, 4))
    assert sorted(distances.argmin(axis=1).tolist()) == list(range(49))
    assert (distances.min(axis=1) == 0).all()
    reference = next(iter(store.references().values()))
    assert (reference.image == background[..., ::-1]).all()
    assert check(store) == []


def test_the_real_digit_contacts(tmp_path):
    """Two real DIGIT pictures are in a store byte for byte; the mask beside them is named, not taken for a picture."""
    folder = DATA / "digit_contact"
    report = ingest([folder], tmp_path / "ds.zarr")
    assert report.sources[0].frames == 2
    store = Store.open(tmp_path / "ds.zarr")
    wanted = {(folder / name).read_bytes() for name in ("digit_raw.png", "limitation_raw_digit.png")}
    assert set(store.encoded([0, 1])) == wanted
    assert "mask" in " ".join(finding.message for finding in report.sources[0].findings)


@pytest.mark.slow
def test_all_real_data_in_one_store(tmp_path):
    """All real data in one call: what can be read is in, every other recording is named with its reason."""
    report = ingest([DATA], tmp_path / "ds.zarr")
    states = {source.key: source.state for source in report.sources}
    assert sum(state == "added" for state in states.values()) >= 3
    assert all(source.error for source in report.sources if source.state == "failed")
    assert Store.open(tmp_path / "ds.zarr").n_frames == 49 + 2 + 10
    for bag in BAGS:
        if bag.parent.name != "wbag":
            assert any(bag.name in key for key in states), bag.name


def test_errors_of_real_files_are_ours():
    """No real file ends in an error of another kind."""
    for path in BAGS:
        with contextlib.suppress(TactileDataError):
            inspected(path)
