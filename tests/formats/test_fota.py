"""FoTa: shuffled frames come back into their sequences, tars are never unpacked, damage is said."""

import numpy as np
import pytest
from generators import fota
from generators.collect import codes, read

from tactiledata.errors import BrokenLog, UnsafeContent
from tactiledata.formats.fota import FotaFormat, sequence_of

FORMAT = FotaFormat()


def first(folder, **settings):
    """The only domain of a fake."""
    return read(FORMAT, fota.write(folder, np.random.default_rng(6), **settings))[0]


def test_frames_come_back_into_their_sequences(tmp_path):
    """Train and val give one trajectory a key prefix, with frames in natural order and the published part kept."""
    recording, sink = first(tmp_path, sequences=3, frames=12)
    assert [touch.name for touch in recording.trajectories] == ["0_2", "1_2", "2_2"]
    assert [image.name for image in sink.images] == [key for key, _, _ in fota.keys("yuan18", 3, 12)]
    assert [image.trajectory for image in sink.images] == [f"{row // 12}_2" for row in range(36)]
    part = recording.frame_values["published_part"].values[:, 0]
    assert (part == 0).sum() == 28
    assert (part == 1).sum() == 8
    assert {"published-split-leaks", "nominal-rate"} == codes(recording)
    for touch in recording.trajectories:
        inside = [image for image in sink.images if touch.start_ns <= image.log_ns < touch.end_ns]
        assert {image.trajectory for image in inside} == {touch.name}
        assert len(inside) == 12


@pytest.mark.parametrize(("domain", "count"), [("tvl", 3), ("calandra17", 6), ("objectfolder_real", 3), ("yuan18", 3)])
def test_sequences_of_the_known_domains(tmp_path, domain, count):
    """The prefix rule fits the keys that the corpus' scripts make; no sequence mixes two recordings."""
    recording, sink = first(tmp_path, domain=domain)
    assert len(recording.trajectories) == count
    truth = {key: sequence for key, sequence, _ in fota.keys(domain, 3, 8)}
    for touch in recording.trajectories:
        assert len({truth[image.name] for image in sink.images if image.trajectory == touch.name}) == 1


def test_prefix_rule():
    """Keys without a frame number stay whole; the TVL repack keeps only its part."""
    assert sequence_of("20220318_1234-0000000123", "touch_and_go") == "20220318_1234"
    assert sequence_of("seen_data5_rec_00001_frame0012", "visgel") == "seen_data5_rec_00001"
    assert sequence_of("ssvtp_image_12_tac", "tvl") == "ssvtp"
    assert sequence_of("17", "cnc") == "17"


def test_keys_that_tell_nothing_are_said(tmp_path):
    """Where every key is its own sequence the reader is warned."""
    recording, _ = first(tmp_path, domain="other", sequences=24, frames=1)
    assert "sequence-unclear" in codes(recording)


def test_poses_become_metres(tmp_path):
    """Millimetres become metres, other numbers stay, texts go with the trajectory."""
    recording, _ = first(tmp_path, pose=True)
    pose = recording.frame_values["pose"]
    np.testing.assert_allclose(pose.values[:8, 0], 1.5e-3 * np.arange(8), rtol=1e-12)
    np.testing.assert_allclose(pose.values[:, 1:], np.tile([2e-3, -3e-3, 0, 0, 0, 1], (24, 1)), rtol=1e-12)
    assert pose.units == ("m", "m", "m", "1", "1", "1", "1")
    assert recording.frame_values["label_fuzziness"].values[:, 0].tolist() == [0.0] * 8 + [1.0] * 8 + [2.0] * 8
    assert [touch.extra["label_obj_name"] for touch in recording.trajectories] == ["cloth 0", "cloth 1", "cloth 2"]


@pytest.mark.parametrize("name", ["../evil.jpg", "/etc/evil.jpg", "a/../../evil.jpg", "C:/evil.jpg", "..\\evil.jpg"])
def test_tar_slip_is_refused(tmp_path, name):
    """A member that leads out of the archive refuses the whole; nothing is written anywhere."""
    root = fota.write(tmp_path / "corpus", np.random.default_rng(6), escape=name)
    before = sorted(tmp_path.rglob("*"))
    with pytest.raises(UnsafeContent, match="evil"):
        read(FORMAT, root)
    assert sorted(tmp_path.rglob("*")) == before


def test_links_in_a_tar_are_left_out_and_said(tmp_path):
    """A link is no image and is reported as damage."""
    recording, sink = first(tmp_path, link=True)
    assert "tar-member-odd" in codes(recording)
    assert len(sink.images) == 24


@pytest.mark.parametrize("share", [0.1, 0.4, 0.7])
def test_cut_tars_give_what_is_whole(tmp_path, share):
    """A cut tar gives the samples before the cut byte by byte, and both the cut and the count are said."""
    whole = {image.name: image.payload for image in first(tmp_path / "a")[1].images}
    recording, sink = first(tmp_path / "b", cut=share)
    assert {"tar-truncated", "count-mismatch"} & codes(recording)
    assert 15 <= len([image for image in sink.images if image.payload]) < 24
    for image in sink.images:
        assert image.payload in (b"", whole[image.name])


def test_counts_are_checked(tmp_path):
    """count.txt that says more is damage, one that says less or nonsense is said, a right one is not."""
    more, _ = first(tmp_path / "a", count=20)
    less, _ = first(tmp_path / "b", count=3)
    odd, _ = first(tmp_path / "c", count="many")
    none, _ = first(tmp_path / "d", drop_count=True)
    right, _ = first(tmp_path / "e")
    said = [
        [(finding.code, finding.severity) for finding in recording.findings if finding.code.startswith("count-")]
        for recording in (more, less, odd)
    ]
    assert said == [[("count-mismatch", "damage")], [("count-exceeded", "warning")], [("count-mismatch", "damage")]]
    assert "count-missing" in codes(none)
    assert not {"count-mismatch", "count-exceeded", "count-missing"} & codes(right)


def test_lone_halves_are_said(tmp_path):
    """A JSON without image keeps its moment; an image without JSON is kept without labels."""
    recording, sink = first(tmp_path / "a", lone_json=True)
    assert "json-without-image" in codes(recording)
    assert [image.encoding for image in sink.images].count("missing") == 1
    recording, sink = first(tmp_path / "b", lone_image=True)
    assert "image-without-json" in codes(recording)
    assert len(sink.images) == 24


def test_broken_labels_are_said(tmp_path):
    """A JSON that does not parse costs its labels only."""
    recording, sink = first(tmp_path, broken_json=True)
    assert "label-broken" in codes(recording)
    assert all(image.payload for image in sink.images)
    assert np.isnan(recording.frame_values["label_fuzziness"].values).sum() == 1


def test_one_tar_and_one_part_can_be_named(tmp_path):
    """A single tar, and a single train folder, are sources too."""
    root = fota.write(tmp_path, np.random.default_rng(6))
    ((_, sink),) = read(FORMAT, root / "yuan18/train/data-000001.tar")
    assert len(sink.images) == 9
    ((recording, sink),) = read(FORMAT, root / "yuan18/train")
    assert len(sink.images) == 19
    assert recording.source.key == "train"


def test_tars_without_samples_are_broken_logs(tmp_path):
    """An empty file that is named like a tar of the corpus is a clear error."""
    home = tmp_path / "cnc" / "train"
    home.mkdir(parents=True)
    (home / "data-000000.tar").write_bytes(b"")
    with pytest.raises(BrokenLog, match="nothing to read"):
        read(FORMAT, tmp_path)


def test_inspection_opens_one_image_a_camera(tmp_path):
    """Inspecting counts all images and shows the first."""
    root = fota.write(tmp_path, np.random.default_rng(6))
    inspection = FORMAT.inspect(FORMAT.sources(root)[0])
    assert inspection.topics[0].messages == 24
    assert inspection.topics[0].example.startswith("jpeg 24 x 32")
    assert inspection.facts["trajectories"] == 3


def test_positions_without_a_turn_become_metres(tmp_path):
    """A domain whose poses are three numbers, as T3's loader reads them, has positions in metres and no pose."""
    recording, _ = first(tmp_path, pose="position")
    position = recording.frame_values["position"]
    wanted = np.column_stack([1.5e-3 * (np.arange(24) % 8), np.full(24, 2e-3), np.full(24, -3e-3)])
    np.testing.assert_allclose(position.values, wanted, rtol=1e-12)
    assert position.units == ("m", "m", "m")
    assert "pose" not in recording.frame_values
    assert not [name for name in recording.frame_values if name.endswith("_mm")]
