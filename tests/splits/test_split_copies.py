"""Copies of one image are told from second pictures of one touch, by what is left when compression is accounted for."""

import numpy as np
import pytest
from split_cases import MemoryStore, background, frames, jpeg, levels, many, replaced, touch, trajectories

from tactiledata.errors import StoreError
from tactiledata.splits.audit import audit
from tactiledata.splits.copies import Portrait, compare_images, noise_between, sensor_noise
from tactiledata.splits.fingerprints import CELLS, RADIUS, fingerprint, near_pairs
from tactiledata.splits.make import make_split
from tactiledata.splits.manifest import frame_rows, load_split

SEED = 1
COPIES = {
    "same": lambda picture: picture,
    "q95": lambda picture: jpeg(picture, 95),
    "q85": lambda picture: jpeg(picture, 85),
    "q75": lambda picture: jpeg(picture, 75),
    "brighter, lossless": lambda picture: levels(picture * 1.04 + 3.0),
    "darker, q90": lambda picture: jpeg(levels(picture * 0.96 - 2.0), 90),
    "brighter, q80": lambda picture: jpeg(levels(picture + 5.0), 80),
}


def is_copy(one, other, noise):
    return compare_images(Portrait(one), Portrait(other), noise).is_copy


def distance(one, other):
    return float(np.sqrt(np.mean((fingerprint(one) - fingerprint(other)) ** 2)))


@pytest.mark.parametrize("kind", COPIES)
@pytest.mark.parametrize("stored", [0, 95])
def test_copies_are_found(kind, stored):
    """A copy of a lossless or JPEG picture, compressed again or a little brighter, is near and is a copy."""
    rng = np.random.default_rng(1)
    base = background(rng)
    pictures = [touch(base, (70 + 40 * k, 120), rng) for k in range(5)]
    pictures = [jpeg(picture, stored) for picture in pictures] if stored else pictures
    original, noise = pictures[2], sensor_noise(pictures)
    copy = COPIES[kind](original)
    assert distance(original, copy) < RADIUS
    assert is_copy(original, copy, noise)
    assert is_copy(copy, original, noise)


@pytest.mark.parametrize("stored", [0, 75, 85, 95])
@pytest.mark.parametrize("noise", [0.7, 1.0, 2.0])
def test_the_same_touch_again_is_no_copy(stored, noise):
    """Negative control: the very same pose, with other noise, is near and yet no copy, at any compression."""
    rng = np.random.default_rng(2)
    base = background(rng)
    places = ((150, 120), (90, 100), (200, 140), (150, 120))
    pictures = [touch(base, place, rng, noise=noise) for place in places]
    pictures = [jpeg(picture, stored) for picture in pictures] if stored else pictures
    assert distance(pictures[0], pictures[3]) < RADIUS
    assert not is_copy(pictures[0], pictures[3], sensor_noise(pictures))


@pytest.mark.parametrize("noise", [0.7, 1.0, 2.0])
def test_noise_is_recovered_beside_a_fixed_pattern(noise):
    """The noise of a sensor is found within 20 %, though its picture is full of specks."""
    rng = np.random.default_rng(6)
    base = background(rng)
    pictures = [touch(base, (70 + 30 * k, 120), rng, noise=noise) for k in range(6)]
    assert sensor_noise(pictures) == pytest.approx(noise, rel=0.2)
    assert sensor_noise(pictures[:1]) == 0.0
    assert noise_between(pictures[0], pictures[1][1:]) == 0.0


def test_pictures_of_other_sizes_are_no_copies():
    """Sizes that differ are not compared."""
    assert not is_copy(np.zeros((4, 4, 3), np.uint8), np.zeros((8, 4, 3), np.uint8), 1.0)


@pytest.mark.parametrize("quality", [55, 70, 75, 88, 95])
def test_the_quality_is_recovered_from_pixels(quality):
    """An image tells at which quality it was compressed last; a lossless one says 0."""
    rng = np.random.default_rng(3)
    picture = touch(background(rng), (100, 90), rng)
    assert Portrait(jpeg(picture, quality)).quality == quality
    assert Portrait(picture).quality == 0


def test_near_pairs_agree_with_their_slow_twin():
    """Among few points, the tree finds the pairs that comparing all finds."""
    rng = np.random.default_rng(4)
    prints = rng.normal(0, 1, (60, CELLS)).astype(np.float32)
    prints[40:50] = prints[:10] + rng.normal(0, 0.01, (10, CELLS))
    prints[55] = np.nan
    part = np.arange(60) // 20
    part[7] = -1
    slow = {
        (i, j)
        for i in range(60)
        for j in range(i + 1, 60)
        if part[i] != part[j]
        and min(part[i], part[j]) >= 0
        and np.sqrt(np.mean((prints[i] - prints[j]) ** 2)) <= RADIUS
    }
    pairs = near_pairs(prints, part)
    assert {tuple(sorted(pair)) for pair in zip(pairs.first.tolist(), pairs.second.tolist(), strict=True)} == slow
    assert len(slow) == 9
    assert len(near_pairs(prints[:1], part[:1])) == 0


@pytest.mark.parametrize("shape", [(40, 32, 3), (400, 100, 3), (400, 300, 3)])
def test_a_portrait_does_not_keep_its_image(shape):
    """What is kept of an image for comparing is a copy of its middle, so that the image's memory is freed."""
    image = np.zeros(shape, np.uint8)
    assert not np.shares_memory(Portrait(image).middle, image)


@pytest.mark.slow
def test_an_audit_holds_few_pixels(rig, monkeypatch):
    """Pictures are asked for in runs within the limit of pixels, then one at a time; the verdict is the same."""
    asked = []
    images = rig.images
    monkeypatch.setattr(rig, "images", lambda rows: asked.append(len(rows)) or images(rows))
    monkeypatch.setattr("tactiledata.contract.image_batches.image_batches.__defaults__", (3 * 320 * 240,))
    assert audit(rig).findings == ()
    assert max(asked) == 3
    assert sum(asked[:7]) == 20


@pytest.fixture(scope="module")
def repeats():
    """Ten times the same two touches by one sensor, each with its own noise: a rig that repeats itself."""
    rng = np.random.default_rng(5)
    base = background(rng)
    return [jpeg(touch(base, (90 + 60 * k, 120), rng), 95) for _ in range(10) for k in range(2)]


@pytest.fixture
def rig(tmp_path, repeats):
    table = trajectories(many(10, "A", ("ball",)))
    store = MemoryStore(tmp_path, table, frames(table, 2), list(repeats))
    make_split(store, hold_out="none", fractions=(0.6, 0.2, 0.2), seed=SEED)
    return store


def both_sides(store):
    split = load_split(store, "default")
    return [int(frame_rows(store, split, part)[0]) for part in ("train", "test")]


@pytest.mark.slow
def test_a_rig_that_repeats_itself_passes(rig):
    """Negative control: twenty look-alikes across parts are looked at and none is called a copy."""
    seen = []
    report = audit(rig, progress=lambda done, total: seen.append((done, total)))
    assert report.checked["near pairs"] > 20
    assert report.findings == ()
    assert seen == [(20, 20)]


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["q75", "darker, q90"])
def test_a_planted_copy_is_found_among_repeats(rig, kind):
    """One train picture copied into test, compressed again or made darker, is found, and it alone."""
    train, test = both_sides(rig)
    rig.pictures[test] = COPIES[kind](rig.pictures[train])
    (found,) = audit(rig).leaks
    assert found.code == "near-duplicate-image"
    assert found.count == 1
    for row, part in ((train, "train"), (test, "test")):
        trajectory = rig.table.slice(rig.frame_table["trajectory"][row].as_py(), 1).to_pylist()[0]
        name = f"log{trajectory['source']}/{trajectory['trajectory']}"
        assert f"frame {row} of {name} ({part})" in found.message


@pytest.mark.slow
def test_images_of_the_same_bytes_are_one_kind_of_leak(rig):
    """They are told as identical, and not as compressed or brightened copies too."""
    train, test = both_sides(rig)
    rig.pictures[test] = rig.pictures[train]
    crc, length = (rig.frame_table[name].to_numpy().copy() for name in ("crc32c", "length"))
    crc[test], length[test] = crc[train], length[train] = 7, 1000
    rig.frame_table = replaced(rig.frame_table, crc32c=crc, length=length)
    assert [found.code for found in audit(rig).leaks] == ["identical-image"]


@pytest.mark.slow
def test_what_cannot_be_judged_is_said(rig):
    """Blank and unreadable pictures are named, and do not end the audit."""
    train, test = both_sides(rig)
    rig.pictures[train] = np.full((320, 240, 3), 7, np.uint8)
    images = rig.images

    def refuse(rows):
        if test in np.asarray(rows):
            raise StoreError("does not decode")
        return images(rows)

    rig.images = refuse
    findings = {finding.code: finding for finding in audit(rig).findings}
    assert {code: finding.count for code, finding in findings.items()} == {"blank-image": 1, "images-not-compared": 1}
    # an image that does not decode may fit its checksum: only decoding finds it
    assert "check --decode --repair" in findings["images-not-compared"].message


def test_more_look_alikes_than_are_compared_is_said(rig, monkeypatch):
    """A limit on pairs is never silent."""
    monkeypatch.setattr("tactiledata.splits.audit.MAX_PAIRS", 2)
    report = audit(rig)
    assert [finding.code for finding in report.findings] == ["near-pairs-not-compared"]
    compared = int(report.findings[0].message.split()[0])
    assert report.findings[0].count == compared - 2
    assert report.leaks == ()
