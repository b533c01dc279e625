"""YCB-Slide: both key variants, lost poses masked, jumps masked, contact poses as the corpus defines them."""

import os
import pickle
from pathlib import Path

import numpy as np
import pytest
from generators import ycb_slide
from generators.collect import codes, read
from scipy.spatial.transform import Rotation

from tactiledata.contract.simulated import recording_kind
from tactiledata.errors import BrokenLog, UnsafeContent, UsageError
from tactiledata.formats.reading.optitrack import contact_poses, find_jumps, nearest_rows
from tactiledata.formats.ycb_slide import BACKGROUNDS, YcbSlideFormat, background_of

FORMAT = YcbSlideFormat()


def first(folder, rng, mapping=None, **settings):
    """The first source of a fake with one object and one real run."""
    settings = {"objects": ("035_power_drill",), "runs": 1, "sim": False} | settings
    return read(FORMAT, ycb_slide.write(folder, rng, **settings), mapping)[0]


@pytest.fixture
def rng():
    return np.random.default_rng(5)


def test_layout_real_and_simulated(tmp_path, rng):
    """Each dataset_k and simulated run is one source and one trajectory, with its files and images byte by byte."""
    root = ycb_slide.write(tmp_path, rng)
    taken = read(FORMAT, root)
    assert [recording.source.key for recording, _ in taken][:3] == [
        "dataset/real/004_sugar_box/dataset_0",
        "dataset/real/004_sugar_box/dataset_1",
        "dataset/real/035_power_drill/dataset_0",
    ]
    assert len(taken) == 8
    for recording, sink in taken:
        assert len(recording.trajectories) == 1
        assert len(sink.of("digit")) == 12
        home = root.joinpath(*recording.source.key.split("/")[1:])
        for image in sink.of("digit"):
            assert image.payload == (home / image.name).read_bytes()
        kind = "simulated" if "/sim/" in recording.source.key else "real"
        assert recording_kind(recording.description.document) == kind
        assert all(path.startswith(recording.source.path) for path in recording.source.files)
        assert all(os.path.exists(path) for path in recording.source.files)  # noqa: PTH110
    assert FORMAT.inspect(taken[0][0].source).facts["sensors"] == ["ycb-slide-bg0", "ycb-slide-bg0-webcam"]


def test_seconds_become_exact_nanoseconds(tmp_path, rng):
    """Times are the corpus' seconds in whole nanoseconds, the same for image and pose."""
    recording, sink = first(tmp_path, rng)
    wanted = [round(0.0333 * row + 0.0001 * (row % 3), 6) for row in range(12)]
    assert [image.log_ns for image in sink.of("digit")] == [round(second * 1e9) for second in wanted]
    assert recording.signals["digit_pose"].stamps.log.tolist() == [image.log_ns for image in sink.of("digit")]
    assert {image.log_ns for image in sink.of("webcam")} == {image.log_ns for image in sink.of("digit")}


def test_old_keys_and_digit_only(tmp_path, rng):
    """Files with the keys frame, timestamp, image_path are read like those with the usual keys, without poses."""
    plain, sink_plain = first(tmp_path / "a", np.random.default_rng(1), variant="digit")
    old, sink_old = first(tmp_path / "b", np.random.default_rng(1), variant="old-keys")
    assert [(image.log_ns, image.payload) for image in sink_plain.of("digit")] == [
        (image.log_ns, image.payload) for image in sink_old.of("digit")
    ]
    for recording in (plain, old):
        assert not recording.signals
        assert "poses-missing" in codes(recording)


def test_sensor_is_the_background(tmp_path, rng):
    """The object tells the sensor's background; another object stands alone and is reported; a mapping wins."""
    assert first(tmp_path / "a", rng)[1].images[0].sensor == "ycb-slide-bg0"
    recording, sink = first(tmp_path / "b", rng, objects=("077_rubiks_cube",))
    assert sink.images[0].sensor == "ycb-slide-077_rubiks_cube"
    assert "sensor-unlisted" in codes(recording)
    mapping = {"format": "tactiledata-mapping/1", "images": {"digit": {"topic": "frames", "sensor": "D20542"}}}
    recording, sink = first(tmp_path / "c", rng, mapping)
    assert sink.images[0].sensor == recording.trajectories[0].sensor == "D20542"
    wanted = {"004_sugar_box": 0, "035_power_drill": 0, "005_tomato_soup_can": 1, "006_mustard_bottle": 2}
    wanted |= {"021_bleach_cleanser": 3, "025_mug": 4, "037_scissors": 5, "042_adjustable_wrench": 6}
    wanted |= {"048_hammer": 8, "055_baseball": 8}
    assert {name: background_of(name) for name in wanted} == wanted
    assert len(BACKGROUNDS) == 10


def test_contact_pose_is_recovered():
    """A DIGIT placed 22 mm behind a known contact gives that contact back, moved by the alignment's shift alone."""
    rng = np.random.default_rng(3)
    contact = ycb_slide.poses(rng, 5)
    thing = np.tile(ycb_slide.poses(rng, 1), (5, 1))
    turn_contact, turn_thing = Rotation.from_quat(contact[:, 3:]), Rotation.from_quat(thing[:, 3:])
    camera = contact[:, :3] + turn_contact.apply([0, 0, 0.022])
    digit = np.concatenate([thing[:, :3] + turn_thing.apply(camera), (turn_thing * turn_contact).as_quat()], axis=1)
    alignment = np.eye(4)
    alignment[:3, :3] = Rotation.from_euler("x", 30, degrees=True).as_matrix()
    alignment[:3, 3] = [0.001, 0.002, 0.003]
    poses, is_jump = contact_poses(digit, thing, alignment)
    np.testing.assert_allclose(poses[:, :3], contact[:, :3] + alignment[:3, 3], atol=1e-12)
    error = (Rotation.from_quat(poses[:, 3:]).inv() * turn_contact).magnitude()
    assert error.max() < 1e-9  # the alignment's rotation does not act
    assert not is_jump.any()


def test_jumps_are_masked_not_dropped(tmp_path, rng):
    """A planted jump masks its pose and the way back; images and rows all stay; a calm slide has none."""
    recording, sink = first(tmp_path / "a", rng, frames=40, jump=25)
    contact = recording.signals["contact_pose"].values
    assert np.flatnonzero(np.isnan(contact).any(axis=1)).tolist() == [25, 26]
    assert np.isfinite(recording.signals["digit_pose"].values).all()
    assert len(sink.of("digit")) == len(contact) == 40
    known = recording.frame_values["pose_known"].values[:, 0]
    is_digit = np.array([image.camera == "digit" for image in sink.images])
    assert np.flatnonzero(known[is_digit] == 0).tolist() == [25, 26]
    assert np.isnan(known[~is_digit]).all()
    assert "pose-jump" in codes(recording)
    calm, _ = first(tmp_path / "b", rng, frames=40)
    assert "pose-jump" not in codes(calm)
    assert np.isfinite(calm.signals["contact_pose"].values).all()


def test_jump_filter_agrees_with_its_loop():
    """The vectorised filter marks what a plain loop over the corpus' criterion marks."""
    rng = np.random.default_rng(11)
    path = np.cumsum(rng.standard_t(1.2, size=(300, 3)) * 1e-3, axis=0)
    steps, slow = [], []
    for row in range(len(path)):
        if row:
            steps.append(np.linalg.norm(path[row] - path[row - 1]))
        slow.append(row > 1 and steps[-1] > 10 * np.mean(steps))
    assert find_jumps(path).tolist() == slow
    assert any(slow)


def test_lost_poses_are_nan(tmp_path, rng):
    """Empty poses are NaN in place: no row moves, no image goes, and it is said."""
    recording, sink = first(tmp_path, rng, lost=(0, 7))
    for name in ("digit_pose", "contact_pose"):
        assert np.flatnonzero(np.isnan(recording.signals[name].values).any(axis=1)).tolist() == [0, 7]
    assert np.isfinite(recording.signals["object_pose"].values).all()
    assert len(sink.of("digit")) == 12
    assert {finding.count for finding in recording.findings if finding.code == "pose-lost"} == {2}


def test_poses_from_the_trackers_export(tmp_path, rng):
    """Without synced_data the nearest sample of the OptiTrack export is taken; its empty cells are NaN."""
    recording, _ = first(tmp_path, rng, variant="digit", optitrack=True, frames=20)
    assert "poses-from-optitrack" in codes(recording)
    times = recording.signals["digit_pose"].stamps.log / 1e9 + 1.0
    rows = np.round(times * 120).astype(int)
    lost = (rows >= 60) & (rows < 70)
    assert np.isnan(recording.signals["digit_pose"].values[lost]).all()
    assert np.isfinite(recording.signals["digit_pose"].values[~lost]).all()
    assert np.isfinite(recording.signals["object_pose"].values).all()


def test_nearest_row_agrees_with_a_search():
    """The nearest row is the one with the least distance."""
    rng = np.random.default_rng(2)
    times, wanted = np.sort(rng.uniform(0, 10, 50)), rng.uniform(-1, 11, 200)
    found = nearest_rows(times, wanted)
    distance = np.abs(times[None] - wanted[:, None])
    np.testing.assert_array_equal(distance[np.arange(200), found], distance.min(axis=1))


def test_unpadded_numbers_of_the_simulation(tmp_path, rng):
    """Simulated frames 0 … 11 come in the order of their numbers with their height maps, on a nominal clock."""
    root = ycb_slide.write(tmp_path, rng, objects=("025_mug",), runs=1)
    recording, sink = read(FORMAT, root / "sim")[0]
    assert [image.name for image in sink.of("digit")] == [f"tactile_images/{row}.jpg" for row in range(12)]
    assert [image.name for image in sink.of("gt_heightmap")] == [f"gt_heightmaps/{row}.jpg" for row in range(12)]
    assert [image.log_ns for image in sink.of("digit")] == [row * 10**9 // 30 for row in range(12)]
    assert {"nominal-rate", "heightmap-8bit"} <= codes(recording)
    assert set(recording.signals) == {"gel_pose", "camera_pose", "gel_pose_measured"}
    assert sink.images[0].sensor == "ycb-slide-sim"


def test_a_missing_image_keeps_its_moment(tmp_path, rng):
    """A frame that is not on disk is a missing image at its time, damage is reported, the others keep theirs."""
    recording, sink = first(tmp_path, rng, drop_frame=4)
    assert [image.encoding for image in sink.of("digit")].index("missing") == 4
    assert len(sink.of("digit")) == 12
    assert any(finding.code == "image-missing" and finding.severity == "damage" for finding in recording.findings)


def test_missing_folder_of_frames(tmp_path, rng):
    """Without frames/ every moment is missing, and said; the poses are still there."""
    recording, sink = first(tmp_path, rng, no_frames=True)
    assert {image.encoding for image in sink.of("digit")} == {"missing"}
    assert "contact_pose" in recording.signals


def test_an_image_without_time(tmp_path, rng):
    """An image that no list names is kept behind the others, and said."""
    recording, sink = first(tmp_path, rng, extra_frame=True)
    assert len(sink.of("digit")) == 13
    assert sink.of("digit")[-1].log_ns > sink.of("digit")[-2].log_ns
    assert {"image-without-time", "length-mismatch"} <= codes(recording)


def test_a_time_that_is_no_number(tmp_path, rng):
    """A NaN among the times is reported as damage and continues the clock."""
    recording, sink = first(tmp_path, rng, bad_time=3)
    assert "time-broken" in codes(recording)
    assert sink.of("digit")[3].log_ns == sink.of("digit")[2].log_ns + 33333333


def test_missing_alignment_is_said(tmp_path, rng):
    """Without alignment.npy contact poses are not aligned, and it is said."""
    assert "alignment-missing" in codes(first(tmp_path, rng, drop_alignment=True)[0])


def test_paths_out_of_the_folder_are_refused(tmp_path, rng):
    """A list of frames that points outside is refused."""
    with pytest.raises(UnsafeContent, match="passwd"):
        first(tmp_path, rng, escape=True)


@pytest.mark.parametrize("name", ["synced_data.npy", "digit_data.npy"])
def test_malicious_files_do_not_run(tmp_path, rng, name):
    """A dict file that would run a command is refused and leaves no mark."""
    mark = tmp_path / "mark"
    root = ycb_slide.write(tmp_path, rng, objects=("025_mug",), runs=1, sim=False, variant="digit")

    class Evil:
        def __reduce__(self):
            return (os.system, (f"touch {mark}",))

    np.save(root / "real/025_mug/dataset_0" / name, {"timestamps": Evil()}, allow_pickle=True)
    with pytest.raises(UnsafeContent, match="system"):
        read(FORMAT, root)
    assert not mark.exists()


@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 0.9])
def test_cut_files_are_broken_logs(tmp_path, rng, share):
    """A cut dict file is a clear error."""
    root = ycb_slide.write(tmp_path, rng, objects=("025_mug",), runs=1, sim=False)
    path = root / "real/025_mug/dataset_0/synced_data.npy"
    path.write_bytes(path.read_bytes()[: int(path.stat().st_size * share)])
    with pytest.raises(BrokenLog):
        read(FORMAT, root)


def test_other_content_is_a_broken_log(tmp_path, rng):
    """A file that holds something else says what, and what was expected."""
    root = ycb_slide.write(tmp_path, rng, objects=("025_mug",), runs=1)
    np.save(root / "real/025_mug/dataset_0/synced_data.npy", np.zeros(3))
    with pytest.raises(BrokenLog, match="pickled dict"):
        read(FORMAT, root / "real")
    (root / "sim/025_mug/00/tactile_data.pkl").write_bytes(pickle.dumps([1, 2]))
    with pytest.raises(BrokenLog, match="dict of poses"):
        read(FORMAT, root / "sim")


def test_other_folders_are_not_claimed(tmp_path):
    """An empty folder is not of this corpus, and naming it is an error of use."""
    assert not FORMAT.sniff(tmp_path)
    with pytest.raises(UsageError):
        FORMAT.sources(tmp_path)


@pytest.mark.parametrize("written_by", ["dill_0_3_4", "dill_0_4_1"])
def test_simulated_poses_as_the_corpus_writes_them(tmp_path, rng, written_by):
    """The authors' simulator writes with dill, which wraps arrays, and puts an object of omegaconf beside them."""
    root = ycb_slide.write(tmp_path, rng, objects=("025_mug",), runs=1, frames=2)
    home = root / "sim/025_mug/00/tactile_data.pkl"
    home.write_bytes((Path(__file__).parents[1] / f"data/ycb_slide/tactile_data_{written_by}.pkl").read_bytes())
    recording, _ = read(FORMAT, root / "sim")[0]
    drawn = np.random.default_rng(0)
    for name in ("gel_pose", "camera_pose", "gel_pose_measured"):
        wanted = np.column_stack([drawn.normal(size=(2, 3)) * 0.1, np.tile([0, 0, 0, 1.0], (2, 1))])
        np.testing.assert_array_equal(recording.signals[name].values, wanted)


def test_clocks_that_the_corpus_could_not_match(tmp_path, rng):
    """A run whose synced data are None has the images and times of digit_data.npy."""
    root = ycb_slide.write(tmp_path, rng, objects=("025_mug",), runs=1, sim=False)
    np.save(root / "real/025_mug/dataset_0/synced_data.npy", None, allow_pickle=True)
    recording, sink = read(FORMAT, root)[0]
    assert len(sink.of("digit")) == 12
    assert {image.encoding for image in sink.of("digit")} == {"jpeg"}
    assert not recording.signals
    assert any("not matched" in finding.message for finding in recording.findings)
