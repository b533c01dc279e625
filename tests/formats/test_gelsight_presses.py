"""Calibration packs: the real 49 presses, their impossible radii, and archives that mean harm."""

from __future__ import annotations

import io
import pickle
import zipfile
from pathlib import Path

import numpy as np
import pytest
from generators.collect import codes, read
from generators.gelsight_presses import arrays, write

from tactiledata.errors import BrokenLog, UnsafeContent
from tactiledata.formats.gelsight_presses import GelsightPressesFormat
from tactiledata.formats.reading import npz_members
from tactiledata.formats.reading.contact_radius import CODE, radius_findings

PACK = Path(__file__).resolve().parents[1] / "data" / "gelsight_r15"
FORMAT = GelsightPressesFormat()


def read_one(path, mapping=None):
    [(recording, sink)] = read(FORMAT, path, mapping)
    return recording, sink.images


def radius_finding(recording):
    return [finding for finding in recording.findings if finding.code == CODE]


def test_real_presses_go_in_as_rgb():
    """All 49 presses and the background come as RGB, one trajectory each, with their annotations."""
    recording, images = read_one(PACK)
    published = np.load(PACK / "dataPack.npz")
    assert len(images) == len(recording.trajectories) == 49
    [sensor] = recording.description.sensors
    np.testing.assert_array_equal(recording.references[sensor], published["f0"][..., ::-1])
    for index, image in enumerate(images):
        pixels = np.frombuffer(image.payload, np.uint8).reshape(120, 160, 3)
        np.testing.assert_array_equal(pixels, published["imgs"][index][..., ::-1])
        assert (image.encoding, image.trajectory, image.sensor) == ("raw", f"press-frame_{index + 1}", sensor)
    touch = recording.frame_values["touch"]
    np.testing.assert_array_equal(touch.values[:, :2], published["touch_center"])
    np.testing.assert_array_equal(touch.values[:, 2], published["touch_radius"])
    np.testing.assert_allclose(touch.values[:, 3], published["touch_radius"] * 0.1245e-3)
    first = recording.trajectories[0]
    assert (first.indenter, first.extra["touch_radius_px"], first.extra["touch_radius_mm"]) == ("ball", 17.0, 2.1165)
    assert recording.description.indenters["ball"] == {"shape": "sphere", "radius": 0.002}
    assert recording.description.document["licence"] == "CC BY 4.0"


def test_real_annotation_is_where_the_picture_changes():
    """The annotated centre (column, row) lies where the press changes the picture: the axes are not swapped."""
    recording, images = read_one(PACK)
    [background] = recording.references.values()
    far, far_swapped = [], []
    for image, (column, row, *_) in zip(images, recording.frame_values["touch"].values, strict=True):
        pixels = np.frombuffer(image.payload, np.uint8).reshape(background.shape)
        change = np.abs(pixels.astype(float) - background).sum(axis=2)
        rows, columns = np.nonzero(change > np.quantile(change, 0.98))
        far.append(np.hypot(np.median(rows) - row, np.median(columns) - column))
        far_swapped.append(np.hypot(np.median(rows) - column, np.median(columns) - row))
    assert np.median(far) < 12
    assert np.median(far_swapped) > 2 * np.median(far)


def test_impossible_radii_of_the_real_pack_are_reported():
    """48 of the 49 annotated radii exceed the ball's own 16.06 px, 47 are exactly 17: counted, not typed."""
    [finding] = radius_finding(read_one(PACK)[0])
    assert (finding.severity, finding.count) == ("warning", 48)
    for words in ("48 of 49", "16.06 px", "47 of them are exactly 17"):
        assert words in finding.message


def test_possible_radii_are_not_reported(tmp_path):
    """Negative control: radii up to the ball's own, and the real pack pressed with a ball of 2.5 mm, say nothing."""
    write(tmp_path / "pack.npz")
    assert codes(read_one(tmp_path / "pack.npz")[0]) == {"no-clock"}
    larger = {"description": {"indenters": {"ball": {"radius": 0.0025}}}}
    assert radius_finding(read_one(PACK, larger)[0]) == []


def test_radius_check_follows_its_inputs():
    """The limit is the radius over the pitch; the count and the commonest value come from what is given."""
    assert radius_findings([10, 20], 0.002, 0.0001, "radii") == []
    assert radius_findings([], 0.002, 0.0001, "radii") == []
    [finding] = radius_findings([10, 20.01, 30, 30, 31], 0.002, 0.0001, "radii")
    assert finding.count == 4
    assert "20.00 px (2 mm at 0.1 mm/px)" in finding.message
    assert "2 of them are exactly 30" in finding.message
    [single] = radius_findings([25], 0.002, 0.0001, "radii")
    assert "exactly" not in single.message
    rng = np.random.default_rng(0)
    for _ in range(50):
        radii, radius, pitch = rng.uniform(0, 30, 20), rng.uniform(1e-3, 4e-3), rng.uniform(5e-5, 3e-4)
        expected = int((radii * pitch > radius).sum())
        assert sum(finding.count for finding in radius_findings(radii, radius, pitch, "radii")) == expected


def test_sensor_is_known_by_its_background(tmp_path):
    """Packs with one background are one sensor, with another are another; a mapping names it."""
    write(tmp_path / "a.npz")
    write(tmp_path / "b.npz", **{key: value for key, value in arrays(3).items() if key != "f0"})
    write(tmp_path / "c.npz", f0=arrays(seed=1)["f0"])
    sensors = [recording.references.keys() for recording, _ in read(FORMAT, tmp_path)]
    assert sensors[0] == sensors[1] != sensors[2]
    mapping = {"images": {"gelsight": {"topic": "a.npz", "sensor": "R15-7"}}}
    recording, images = read_one(tmp_path / "a.npz", mapping)
    assert set(recording.references) == {images[0].sensor} == {"R15-7"}


def test_other_picture_size_has_no_length(tmp_path):
    """Where the length of a pixel is not known nothing is said in millimetres, and that is said."""
    write(tmp_path / "pack.npz", **arrays(shape=(80, 100)))
    recording, _ = read_one(tmp_path / "pack.npz")
    assert codes(recording) == {"no-clock", "scale-unknown"}
    assert recording.trajectories[0].extra["touch_radius_mm"] is None
    assert np.isnan(recording.frame_values["touch"].values[:, 3]).all()


SURVIVABLE = {
    "fewer-radii": ({"touch_radius": np.array([7, 8])}, "annotation-count", "damage"),
    "more-centres": ({"touch_center": np.full((9, 2), 50.0)}, "annotation-count", "damage"),
    "nan-radius": ({"touch_radius": np.array([7, 8, 9, np.nan, 8])}, "annotation-missing", "warning"),
    "text-radii": ({"touch_radius": np.array(["7"] * 5)}, "annotation-unreadable", "damage"),
    "odd-centres": ({"touch_center": np.arange(9.0)}, "annotation-unreadable", "damage"),
    "centre-outside": ({"touch_center": np.full((5, 2), 130.0)}, "touch-outside-picture", "warning"),
    "negative-radius": ({"touch_radius": np.array([7, 8, 9, -1, 8])}, CODE, "warning"),
    "other-size": ({"img_size": np.array([160, 120, 3])}, "size-misstated", "warning"),
    "unknown-member": ({"secret": np.zeros(3)}, "members-ignored", "info"),
}


@pytest.mark.parametrize("fault", SURVIVABLE)
def test_survivable_fault_is_named_and_all_presses_are_read(tmp_path, fault):
    """Annotations that do not fit are named; the pictures are read."""
    changed, code, severity = SURVIVABLE[fault]
    write(tmp_path / "pack.npz", **changed)
    recording, images = read_one(tmp_path / "pack.npz")
    assert [finding.severity for finding in recording.findings if finding.code == code] == [severity]
    assert len(images) == 5


def test_names_are_made_unique_or_counted(tmp_path):
    """Presses of one name are told apart; without names they are counted."""
    write(tmp_path / "pack.npz", names=np.array(["a.jpg", "a.jpg", "ü" * 300, "", "../x.jpg"]))
    recording, _ = read_one(tmp_path / "pack.npz")
    names = [touch.name for touch in recording.trajectories]
    assert names[:2] == ["press-a~0", "press-a~1"]
    assert names[3:] == ["press-3", "press-x"]
    write(tmp_path / "pack.npz", without=["names", "img_size"])
    recording, _ = read_one(tmp_path / "pack.npz")
    assert [touch.name for touch in recording.trajectories] == [f"press-{index}" for index in range(5)]


def with_member(path, name, content):
    with zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(name, content)


def npy(value, **options):
    stream = io.BytesIO()
    np.save(stream, value, **options)
    return stream.getvalue()


class Harm:
    def __reduce__(self):
        return (pytest.fail, ("a pickle was run",))


def header_of(shape):
    stream = io.BytesIO()
    np.lib.format.write_array_header_1_0(stream, {"descr": "|u1", "fortran_order": False, "shape": shape})
    return stream.getvalue()


def replaced(name, content):
    """A pack in which one member is these bytes."""

    def plant(path):
        write(path, without=[name])
        with_member(path, f"{name}.npy", content)

    return plant


def cut(path):
    write(path)
    path.write_bytes(path.read_bytes()[:-200])


def flipped(path):
    write(path)
    content = bytearray(path.read_bytes())
    content[20_000] ^= 0x55
    path.write_bytes(bytes(content))


def slip(name):
    def plant(path):
        write(path)
        with_member(path, name, b"x")

    return plant


def twice(path):
    write(path)
    with pytest.warns(UserWarning, match="Duplicate name"):
        with_member(path, "f0.npy", npy(np.zeros(3)))


def harmful(path):
    write(path, without=["names"])
    objects = np.array([Harm()], dtype=object)
    content = npy(np.array([None], dtype=object), allow_pickle=True)
    with_member(path, "names.npy", content[:128] + pickle.dumps(objects))


HOSTILE = {
    "cut": (cut, BrokenLog, "cannot be unpacked"),
    "flipped": (flipped, BrokenLog, "CRC"),
    "twice": (twice, BrokenLog, "twice"),
    "pickle": (harmful, UnsafeContent, "pickled objects"),
    "slip-up": (slip("../../evil.npy"), UnsafeContent, "leads out"),
    "slip-absolute": (slip("/etc/evil.npy"), UnsafeContent, "leads out"),
    "slip-windows": (slip("..\\evil.npy"), UnsafeContent, "leads out"),
    "shape-lies": (replaced("imgs", header_of((10**12, 120, 160, 3))), BrokenLog, "no NumPy array"),
    "shape-negative": (replaced("imgs", header_of((-1, 120, 160, 3))), BrokenLog, "no NumPy array"),
    "not-npy": (replaced("imgs", b"hello"), BrokenLog, "no NumPy array"),
    "header-is-code": (replaced("imgs", b"\x93NUMPY\x01\x00\x20\x00__import__('os').getcwd()\n"),
                       BrokenLog, "no NumPy array"),
    "float-pictures": (lambda p: write(p, imgs=np.zeros((5, 120, 160, 3))), BrokenLog, "imgs float64"),
    "no-pictures": (lambda p: write(p, imgs=np.zeros((0, 120, 160, 3), np.uint8)), BrokenLog, "n > 0"),
    "other-background": (lambda p: write(p, f0=np.zeros((8, 8, 3), np.uint8)), BrokenLog, "expected f0 uint8"),
}  # fmt: skip


@pytest.mark.parametrize("fault", HOSTILE)
def test_bad_archive_is_refused_with_a_reason(tmp_path, fault):
    """Damaged and hostile archives are refused by an error of ours, and nothing in them is run or unpacked."""
    plant, kind, words = HOSTILE[fault]
    path = tmp_path / "pack.npz"
    plant(path)
    source = FORMAT.make_source(path, path, [path])
    with pytest.raises(kind, match=words):
        FORMAT.read(source, None)
    assert [child.name for child in tmp_path.iterdir()] == ["pack.npz"]


def test_bomb_is_refused_before_unpacking(tmp_path, monkeypatch):
    """An archive that unpacks to more than pictures need is refused by its stated sizes."""
    write(tmp_path / "pack.npz")
    monkeypatch.setattr(npz_members, "MAX_BYTES", 100_000)
    with pytest.raises(UnsafeContent, match="unpacks from"):
        read_one(tmp_path / "pack.npz")


def test_sniff_wants_the_arrays_of_a_pack(tmp_path):
    """Other archives, other files and folders of other recordings are left alone; a folder of packs is claimed."""
    np.savez(tmp_path / "other.npz", f0=np.zeros(3))
    (tmp_path / "broken.npz").write_bytes(b"PK\x03\x04")
    (tmp_path / "text.npz").write_text("hello")
    for path in (tmp_path, *tmp_path.iterdir(), PACK / "LICENSE", PACK.parent):
        assert not FORMAT.sniff(path), path
    write(tmp_path / "pack.npz")
    assert FORMAT.sniff(tmp_path)
    assert FORMAT.sniff(tmp_path / "pack.npz")
    assert [Path(source.path).name for source in FORMAT.sources(tmp_path)] == ["pack.npz"]
    (tmp_path / "run.mcap").write_bytes(b"")
    assert not FORMAT.sniff(tmp_path)
