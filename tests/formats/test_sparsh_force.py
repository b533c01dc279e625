"""Sparsh forces: global indexes, forces paired inside each trajectory, JPEG bytes as they came."""

import os
import pickle
import tracemalloc
from itertools import pairwise

import numpy as np
import pytest
from generators import sparsh_force
from generators.collect import codes, read

from tactiledata.errors import BrokenLog, UnsafeContent
from tactiledata.formats.sparsh_force import SparshForceFormat

FORMAT = SparshForceFormat()


def first(folder, **settings):
    """The sphere's batch of a fake."""
    settings = {"probes": ("sphere",)} | settings
    return read(FORMAT, sparsh_force.write(folder, np.random.default_rng(9), **settings))[0]


def test_batches_images_and_forces(tmp_path):
    """A batch is a source with images of all files in order, forces where measured, NaN elsewhere, slip and contact."""
    root = sparsh_force.write(tmp_path, np.random.default_rng(9))
    taken = read(FORMAT, root)
    assert [recording.trajectories[0].indenter for recording, _ in taken] == ["flat", "sharp", "sphere"]
    recording, sink = taken[2]
    home = root / "sphere/batch_1"
    pictures = [
        item for number in range(2) for item in pickle.loads((home / f"dataset_digit_{number:02d}.pkl").read_bytes())
    ]
    labels = pickle.loads((home / "dataset_slip_forces.pkl").read_bytes())
    assert [image.payload for image in sink.images] == pictures
    assert [image.log_ns for image in sink.images] == [row * 10**9 // 30 for row in range(40)]
    force = np.full((40, 3), np.nan)
    for content in labels["trajectories"].values():
        force[content["indexes"]] = content["forces"]
    np.testing.assert_array_equal(recording.frame_values["force"].values, force)
    assert recording.frame_values["force"].units == ("N", "N", "N")
    assert recording.frame_values["in_contact"].values[:, 0].tolist() == labels["in_contact"].tolist()
    assert np.isfinite(recording.frame_values["slip"].values).sum() == 18
    assert [touch.name for touch in recording.trajectories] == ["trajectory_0", "trajectory_1"]
    for touch in recording.trajectories:
        rows = [row for row, image in enumerate(sink.images) if touch.start_ns <= image.log_ns < touch.end_ns]
        assert rows == labels["trajectories"][int(touch.name[-1])]["indexes"].tolist()
        assert touch.extra["coef_friction"] == 0.5
    assert codes(recording) == {"nominal-rate"}
    assert list(recording.references) == ["sparsh-digit"]


def test_longer_indexes_pair_inside_each_trajectory(tmp_path):
    """Where a trajectory lists more indexes than forces, each force stays with its own index, and it is said."""
    recording, _ = first(tmp_path, longer_indexes=True)
    fz = recording.frame_values["force"].values[:, 2]
    for start, stop in sparsh_force.spans(40):
        assert (-fz[start : stop - 2]).tolist() == list(range(stop - start - 2))
        assert np.isnan(fz[stop - 2 : stop]).all()
    assert "values-unpaired" in codes(recording)


def test_mismatches_are_said(tmp_path):
    """Wrong numbers of contact flags, indexes of no image and shared images are reported as damage."""
    for fault, code in (
        ({"flags": 41}, "count-mismatch"),
        ({"outside": True}, "index-outside"),
        ({"overlap": True}, "trajectory-overlap"),
    ):
        recording, sink = first(tmp_path / code, **fault)
        assert any(finding.code == code and finding.severity == "damage" for finding in recording.findings)
        assert len(sink.images) == 40
        edges = [(touch.start_ns, touch.end_ns) for touch in recording.trajectories]
        assert all(one[1] <= other[0] for one, other in pairwise(edges))


def test_a_batch_without_contacts_is_read(tmp_path):
    """A batch none of whose listed contacts has an image is read without trajectories, and findings say so."""
    root = sparsh_force.write(tmp_path, np.random.default_rng(9), probes=("sphere",))
    place = root / "sphere/batch_1/dataset_slip_forces.pkl"
    labels = pickle.loads(place.read_bytes())
    for content in labels["trajectories"].values():
        content["indexes"] = content["indexes"] + 1000
    place.write_bytes(pickle.dumps(labels))
    recording, sink = read(FORMAT, root)[0]
    assert recording.trajectories == ()
    assert len(sink.images) == 40
    assert {"index-outside", "trajectory-empty"} <= codes(recording)


def test_a_cut_file_does_not_shift_forces(tmp_path):
    """A cut file loses its later images as missing moments; every force stays with its image."""
    whole, sink_whole = first(tmp_path / "a")
    recording, sink = first(tmp_path / "b", cut=0)
    assert "pickle-truncated" in codes(recording)
    assert len(sink.images) == 40
    for row, image in enumerate(sink.images):
        assert image.payload in (b"", sink_whole.images[row].payload)
    assert sum(image.encoding == "missing" for image in sink.images) > 5
    np.testing.assert_array_equal(recording.frame_values["force"].values, whole.frame_values["force"].values)


def test_two_cut_files_are_a_broken_log(tmp_path):
    """Where two files are cut no index can be trusted."""
    root = sparsh_force.write(tmp_path, np.random.default_rng(9), probes=("sphere",))
    for path in (root / "sphere/batch_1").glob("dataset_digit_*.pkl"):
        path.write_bytes(path.read_bytes()[:9000])
    with pytest.raises(BrokenLog, match="cut"):
        read(FORMAT, root)


def test_lists_of_arrays_are_read_too(tmp_path):
    """Images pickled as arrays come as raw RGB, the same pixels."""
    _, sink = first(tmp_path, arrays=True)
    pictures = pickle.loads((tmp_path / "sphere/batch_1/dataset_digit_00.pkl").read_bytes())
    assert [image.encoding for image in sink.images] == ["raw"] * 40
    assert sink.images[3].payload == pictures[3].tobytes()


@pytest.mark.parametrize("name", ["dataset_digit_00.pkl", "dataset_slip_forces.pkl"])
def test_malicious_pickles_do_not_run(tmp_path, name):
    """Either file with an object that runs a command is refused; no mark appears."""
    mark = tmp_path / "mark"
    root = sparsh_force.write(tmp_path / "corpus", np.random.default_rng(9), probes=("sphere",))

    class Evil:
        def __reduce__(self):
            return (os.system, (f"touch {mark}",))

    (root / "sphere/batch_1" / name).write_bytes(pickle.dumps([b"x", Evil()]))
    with pytest.raises(UnsafeContent, match="system"):
        read(FORMAT, root)
    assert not mark.exists()


@pytest.mark.parametrize(
    "labels",
    [
        [],
        {"in_contact": [1]},
        {"trajectories": 3},
        {"trajectories": {0: {"forces": [[1, 2, 3]]}}},
        {"trajectories": {0: {"indexes": [0], "forces": [[1, 2]]}}},
        {"trajectories": {0: {"indexes": ["a"], "forces": [[1, 2, 3]]}}},
        {"trajectories": {0: {"indexes": [0], "forces": ["strong"]}}},
    ],
)
def test_other_labels_are_broken_logs(tmp_path, labels):
    """Labels of another shape are a clear error."""
    root = sparsh_force.write(tmp_path, np.random.default_rng(9), probes=("sphere",))
    (root / "sphere/batch_1/dataset_slip_forces.pkl").write_bytes(pickle.dumps(labels))
    with pytest.raises(BrokenLog):
        read(FORMAT, root)


def test_cut_labels_are_a_broken_log(tmp_path):
    """Labels that are cut are a clear error."""
    root = sparsh_force.write(tmp_path, np.random.default_rng(9), probes=("sphere",))
    path = root / "sphere/batch_1/dataset_slip_forces.pkl"
    path.write_bytes(path.read_bytes()[:-50])
    with pytest.raises(BrokenLog):
        read(FORMAT, root)


def test_memory_stays_flat(tmp_path):
    """Reading 40 MB of images takes little more memory than one of them."""
    root = sparsh_force.write(tmp_path, np.random.default_rng(9), probes=("sphere",), images=40)
    home = root / "sphere/batch_1"
    jpeg = pickle.loads((home / "dataset_digit_00.pkl").read_bytes())[0]
    large = [jpeg + bytes(2**20) for _ in range(40)]
    (home / "dataset_digit_00.pkl").write_bytes(pickle.dumps(large[:25]))
    (home / "dataset_digit_01.pkl").write_bytes(pickle.dumps(large[25:]))
    del large

    class Counted:
        images = 0

        def add(self, image):
            self.images += 1

    sink = Counted()
    source = FORMAT.sources(root)[0]
    tracemalloc.start()
    FORMAT.read(source, sink)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert sink.images == 40
    assert peak < 12 * 2**20
