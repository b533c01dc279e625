"""What holds for every importer of a public corpus: nobody claims another's folder, bad input is a clear error."""

import contextlib
import os
import pathlib
import pickle

import h5py
import numpy as np
import pytest
from generators import across_hdf5, fota, objectfolder_real, sparsh_force, tvl, ycb_slide
from generators.collect import Collected, read

from tactiledata.contract.schema import check_document
from tactiledata.errors import MissingFile, TactileDataError, UsageError
from tactiledata.formats import FORMATS
from tactiledata.formats.reading.corpus import Timeline, nominal_ns, seconds_to_ns, stream_name

GENERATORS = {
    "ycb_slide": ycb_slide,
    "tvl": tvl,
    "fota": fota,
    "objectfolder_real": objectfolder_real,
    "sparsh_force": sparsh_force,
    "across_hdf5": across_hdf5,
}


@pytest.fixture(scope="module")
def fakes(tmp_path_factory):
    """One small fake of each corpus, by format."""
    rng = np.random.default_rng(12)
    return {name: module.write(tmp_path_factory.mktemp(name) / name, rng) for name, module in GENERATORS.items()}


@pytest.mark.parametrize("name", GENERATORS)
def test_everyone_knows_its_own_only(fakes, name):
    """A format claims its own corpus and no other."""
    claimed = {other for other, root in fakes.items() if FORMATS[name]().sniff(root)}
    assert claimed == {name}


@pytest.mark.parametrize("name", GENERATORS)
def test_recordings_keep_the_contract(fakes, name):
    """Sources are unique, files exist below their path, intervals do not overlap, values fit the images."""
    form = FORMATS[name]()
    taken = read(form, fakes[name])
    keys = [recording.source.key for recording, _ in taken]
    assert len(set(keys)) == len(keys)
    for recording, sink in taken:
        source = recording.source
        assert source.format == name
        assert source.files
        assert all(os.path.isfile(path) and path.startswith(source.path) for path in source.files)  # noqa: PTH113
        check_document(dict(recording.description.document), "log", source.key)
        edges = sorted((touch.start_ns, touch.end_ns) for touch in recording.trajectories)
        assert all(start < end for start, end in edges)
        assert all(one[1] <= other[0] for one, other in zip(edges, edges[1:], strict=False))  # noqa: RUF007
        names = {touch.name for touch in recording.trajectories}
        assert len(names) == len(recording.trajectories)
        intervals = {touch.name: (touch.start_ns, touch.end_ns) for touch in recording.trajectories}
        for image in sink.images:
            if image.trajectory:
                start, end = intervals[image.trajectory]
                assert start <= image.log_ns < end
        serials = {(image.sensor, image.camera) for image in sink.images}
        assert len({serial for serial, _ in serials}) == len(serials)  # two cameras are never one sensor
        assert {serial for serial, _ in serials} <= set(recording.description.sensors)
        times = [image.log_ns for image in sink.images]
        assert times == sorted(times)
        for values in recording.frame_values.values():
            assert values.values.shape == (len(sink.images), len(values.columns))
            assert len(values.units) == len(values.columns)
        for signal in recording.signals.values():
            assert (np.diff(signal.stamps.log) >= 0).all()
        assert all(finding.message and finding.code.replace("-", "").isalnum() for finding in recording.findings)


@pytest.mark.parametrize("name", GENERATORS)
def test_reading_twice_gives_the_same(fakes, name):
    """Reading twice gives the same, as nothing depends on the moment of reading."""
    form = FORMATS[name]()
    source = form.sources(fakes[name])[0]
    one, other = Collected(), Collected()
    first, second = form.read(source, one), form.read(source, other)
    assert one.images == other.images
    assert first.findings == second.findings
    assert first.trajectories == second.trajectories


@pytest.mark.parametrize("name", GENERATORS)
def test_inspection_agrees_with_reading(fakes, name):
    """`inspect` counts what `read` hands over, without a mapping to suggest."""
    form = FORMATS[name]()
    source = form.sources(fakes[name])[0]
    sink = Collected()
    recording = form.read(source, sink)
    inspection = form.inspect(source)
    counted = {topic.name: topic.messages for topic in inspection.topics if topic.kind == "images"}
    assert counted == {camera: len(sink.of(camera)) for camera in {image.camera for image in sink.images}}
    assert inspection.facts["trajectories"] == len(recording.trajectories)
    assert set(recording.signals) <= {topic.name for topic in inspection.topics}
    assert inspection.suggested_mapping is None


@pytest.mark.parametrize("name", GENERATORS)
def test_what_is_not_there_or_another_s_is_an_error_of_use(fakes, name, tmp_path):
    """A missing path, an empty folder and a stray file are told apart from recordings."""
    form = FORMATS[name]()
    with pytest.raises(MissingFile):
        form.sources(tmp_path / "nowhere")
    (tmp_path / "notes.txt").write_text("nothing")
    for path in (tmp_path, tmp_path / "notes.txt"):
        assert not form.sniff(path)
        with pytest.raises(UsageError):
            form.sources(path)


@pytest.mark.parametrize("name", GENERATORS)
def test_a_mapping_can_add_a_description(fakes, name):
    """What the corpus does not say of itself can be said in a mapping."""
    form = FORMATS[name]()
    source = form.sources(fakes[name])[0]
    mapping = {"format": "tactiledata-mapping/1", "description": {"title": "mine", "robot": {"model": "ur5e"}}}
    recording = form.read(source, Collected(), mapping)
    assert recording.description.document["title"] == "mine"
    assert recording.description.robot["model"] == "ur5e"


@pytest.mark.parametrize("name", GENERATORS)
def test_damaged_bytes_never_end_in_a_traceback(fakes, name, tmp_path):
    """Files cut or flipped at random places give a recording or an error of ours, never another exception."""
    rng = np.random.default_rng(3)
    module, form = GENERATORS[name], FORMATS[name]()
    root = module.write(tmp_path / name, rng)
    source = form.sources(root)[0]
    for _ in range(12):
        path = source.files[int(rng.integers(min(len(source.files), 6)))]
        with open(path, "rb") as stream:  # noqa: PTH123
            whole = stream.read()
        broken = bytearray(whole)
        if rng.random() < 0.5:
            broken = broken[: int(rng.integers(len(broken)))]
        else:
            for place in rng.integers(len(broken), size=4):
                broken[place] ^= int(rng.integers(1, 256))
        with open(path, "wb") as stream:  # noqa: PTH123
            stream.write(broken)
        with contextlib.suppress(TactileDataError):
            form.read(source, Collected())
        with open(path, "wb") as stream:  # noqa: PTH123
            stream.write(whole)


def test_clocks():
    """Seconds become whole nanoseconds; what is no time continues; nominal frames do not drift; pauses part touches."""
    times, is_good = seconds_to_ns([0.0, 0.1, float("nan"), 59.999999, float("inf")])
    assert times.tolist() == [0, 100_000_000, 133_333_333, 59_999_999_000, 60_033_332_333]
    assert is_good.tolist() == [True, True, False, True, False]
    assert nominal_ns(30 * 3600) == 3600 * 10**9
    timeline = Timeline()
    assert timeline.begin() == 0
    timeline.at(2)
    first = timeline.interval()
    assert timeline.begin() >= first[1] + 10**9


def test_stream_names_are_safe():
    """Names that a corpus uses become names that the store takes."""
    assert [stream_name(text) for text in ("../../x", "Ünder Score", "1st", "", "a" * 100)] == [
        "x",
        "nder_score",
        "v_1st",
        "v",
        "a" * 60,
    ]


def test_hdf5_and_pickle_of_others_are_not_claimed(tmp_path):
    """Any HDF5 file and any pickle are not of these corpora."""
    with h5py.File(tmp_path / "other.hdf5", "w") as file:
        file["data"] = np.zeros(3)
    (tmp_path / "other.pkl").write_bytes(pickle.dumps([1, 2]))
    for name in GENERATORS:
        form = FORMATS[name]()
        assert not any(form.sniff(path) for path in (tmp_path, *tmp_path.iterdir()))


@pytest.mark.parametrize(("name", "files", "count"), [
    ("objectfolder_real", "tactile_data/*/0/gelsight/1?.png", 4), ("fota", "train/*.tar", 3),
    ("sparsh_force", "*digit_01.pkl", 1),
])  # fmt: skip
@pytest.mark.parametrize("target", ["nowhere", "a file elsewhere"])
def test_files_that_are_links_are_said(tmp_path, name, files, count, target):
    """A copy whose content was not fetched holds links in the place of files: they are counted and named.

    Where nothing but order tells the times of images, those after a missing one move up.
    """
    root = GENERATORS[name].write(tmp_path / name, np.random.default_rng(12))
    form = FORMATS[name]()
    source = form.sources(root)[0]
    assert not [one for one in read(form, root)[0][0].findings if one.code == "link-left"]
    places = sorted(pathlib.Path(source.path).glob(files))
    for number, path in enumerate(places):
        elsewhere = tmp_path / f"{number}{path.suffix}"
        path.rename(elsewhere if target == "a file elsewhere" else tmp_path / f"gone-{number}{path.suffix}")
        path.symlink_to(elsewhere)
    assert len(places) == count
    [finding] = [one for one in read(form, root)[0][0].findings if one.code == "link-left"]
    assert (finding.severity, finding.count) == ("warning", count)
    assert places[0].name in finding.message
    assert "link-left" in {one.code for one in form.inspect(form.sources(root)[0]).findings}
