"""What an audit says in words, near fingerprints by hand, and the fit of brightness among outliers."""

import numpy as np
import pyarrow as pa
import pytest
from split_cases import MemoryStore, many, trajectories

from tactiledata.contract.records import Finding
from tactiledata.splits import audit as module
from tactiledata.splits import copies
from tactiledata.splits.audit import AuditReport, _noise_by_sensor, _not_compared, _too_large, empty_parts
from tactiledata.splits.copies import Comparison, Portrait, brightness_fit, compare_images
from tactiledata.splits.fingerprints import CELLS, fingerprint, near_pairs, principal_axes
from tactiledata.splits.make import make_split
from tactiledata.splits.manifest import load_split

STALE = "out of date: the store holds other trajectories; run `tactiledata split` again"
NO_FRAME = "trajectories and no frame that the split takes"


def damage(code):
    return Finding(code, "damage", "words")


@pytest.mark.parametrize(
    ("findings", "verdict"),
    [
        ([], "no leak found"),
        ([damage("a")], "1 kind of leak"),
        ([damage("a"), damage("b"), Finding("c", "warning", "x")], "2 kinds of leak"),
        ([damage("split-out-of-date")], f"{STALE}; no leak found"),
        ([damage("split-out-of-date"), damage("a")], f"{STALE}; 1 kind of leak"),
        ([damage("a"), damage("split-changed")],
         "its files were changed or damaged, so that nothing can be said about leaks"),
        ([Finding("split-empty-part", "warning", "val has no trajectory: so")],
         "no leak found, but val has no trajectory"),
    ],
)  # fmt: skip
def test_the_verdict_in_words(findings, verdict):
    """Kinds of leaks are counted, staleness is said first, and what cannot be judged is not."""
    report = AuditReport("x", tuple(findings), {"frames": 7, "images": 2})
    assert report.lines()[0] == f"split 'x': {verdict} (7 frames, 2 images)"
    assert len(report.lines()) == 1 + len(findings)
    assert report.document()["leaks"] == sum(finding.severity == "damage" for finding in findings)
    assert AuditReport("x", (), {}).lines() == ["split 'x': no leak found (nothing could be checked)"]


@pytest.mark.parametrize(
    ("part", "owners", "words", "count"),
    [
        ([0, 1, 2, 3], [0, 1, 2, 3], None, 0),
        ([0, 0, 2, 3], [0, 1, 2, 3], "val has no trajectory", 1),
        ([0, 0, 0, 3], [0, 3], "val and test have no trajectory", 2),
        ([0, 1, 2, -1], [0, 1, 2, 3], "test_unseen has no trajectory", 1),
        ([0, 1, 2, 3], [0, 2, 3], f"val has {NO_FRAME}", 1),
        ([0, 1, 3, 3], [0, 2], f"test has no trajectory; val has {NO_FRAME}", 2),
        ([1, 1, 2, 3], [0, 0], f"train has no trajectory; test and test_unseen have {NO_FRAME}", 3),
    ],
)  # fmt: skip
def test_empty_parts_are_warned_of(tmp_path, part, owners, words, count):
    """Parts that were asked for and hold no trajectory, or no frame, are named; the warning counts them."""
    store = MemoryStore(tmp_path, trajectories(many(30)))
    make_split(store, hold_out={"sensor": ["A"]})
    found = empty_parts(load_split(store, "default"), np.array(part), np.array(owners))
    assert [finding.count for finding in found] == [count] * bool(count)
    if words:
        assert found[0].severity == "warning"
        assert found[0].message.startswith(f"{words}: nothing can be learned or tested there")


def test_parts_that_nobody_asked_for_may_be_empty(tmp_path):
    """Without held-out units and with a share of 0, test and test_unseen are not missed."""
    store = MemoryStore(tmp_path, trajectories(many(30)))
    make_split(store, hold_out="none", fractions=(0.5, 0.5, 0))
    assert empty_parts(load_split(store, "default"), np.array([0, 1]), np.array([0, 1])) == []


@pytest.mark.parametrize(("rows", "words"), [([7], "1 image is damaged and"), ([7, 3], "2 images are damaged and")])
def test_images_that_were_not_compared(rows, words):
    """One is, several are; the first frame and the command that marks them are named; none is no finding."""
    (found,) = _not_compared(rows, "damaged", "check --decode --repair")
    assert found.message.startswith(f"{words} not compared, first frame 7: `tactiledata check --decode --repair`")
    assert (found.severity, found.count) == ("warning", len(rows))
    assert _not_compared([], "damaged", "check --repair") == []


def test_sizes_beyond_the_limit_are_told_by_the_table():
    """4096 x 4096 pixels are decoded, one row more is not; rows are asked for by number."""

    class Sizes:
        def frames(self, columns):
            return pa.table(
                {"height": pa.array([9, 4096, 4097], pa.int16()), "width": pa.array([9, 4096, 4096], pa.int16())}
            )

    assert _too_large(Sizes(), np.array([2, 1, 0])).tolist() == [True, False, False]


def test_noise_is_from_sixteen_trajectories_spread_over_all(monkeypatch):
    """The first frame of each of 16 trajectories, from the first to the last; all where there are fewer."""
    asked = []

    class Pictures:
        def images(self, rows):
            return [np.full((2, 2, 3), rows[0], np.uint8)]

    def noted(pictures):
        asked.append([int(picture[0, 0, 0]) for picture in pictures])
        return float(len(asked))

    monkeypatch.setattr(module, "sensor_noise", noted)
    trajectory = np.repeat(np.arange(40), 2)
    sensor = np.where(trajectory < 31, 5, 8)
    found = _noise_by_sensor(Pictures(), np.arange(80), trajectory, sensor)
    assert asked == [list(range(0, 62, 4)), list(range(62, 80, 2))]
    assert found.tolist() == [1.0] * 62 + [2.0] * 18


@pytest.mark.parametrize(
    ("left", "expected", "ratio", "is_copy"),
    [(0.06, 0.01, 0.0, True), (0.065, 0.1, 0.65, True), (0.066, 0.1, 0.66, False), (2.0, 4.0, 0.5, True),
     (1.0, 0.0, 1e6, False)],
)  # fmt: skip
def test_a_copy_leaves_two_thirds_of_the_noise_at_most(left, expected, ratio, is_copy):
    """A copy leaves up to 0.65 of what a second recording leaves, or up to 0.06 grey levels."""
    found = Comparison(left, expected)
    assert (found.ratio, found.is_copy) == (pytest.approx(ratio), is_copy)


def test_pictures_of_other_content_are_not_compared_closely():
    """Beyond 4 grey levels and twice the noise nothing is tried: 20 levels of noise allow 44, 1 allows 6."""
    rng = np.random.default_rng(0)
    one = rng.integers(60, 190, (64, 64, 3)).astype(np.uint8)
    other = np.clip(one + 30 * np.sign(rng.normal(size=(64, 64, 1))), 0, 255).astype(np.uint8)
    assert compare_images(Portrait(one), Portrait(other), 1.0).left == np.inf
    assert compare_images(Portrait(one), Portrait(other), 20.0).left < 31


def test_outliers_have_no_say_in_the_brightness():
    """A tenth of the colours, changed by a contact, are left out of the second fit."""
    rng = np.random.default_rng(1)
    original = rng.uniform(30, 200, 1000).astype(np.float32)
    other = 1.05 * original + 4
    other[::10] -= 15
    assert brightness_fit(original, other) == pytest.approx((1.05, 4.0), abs=2e-3)


def blocks(levels):
    """A picture of 320 x 240 pixels from a level for each of 16 x 12 blocks."""
    grid = np.asarray(levels, np.uint8).reshape(16, 12)
    return np.repeat(np.repeat(grid, 20, 0), 20, 1)[..., None].repeat(3, 2)


def test_a_fingerprint_by_hand():
    """Half of the blocks at 90, half at 110: -1 and 1; of luma, so that blue counts for 0.114 of it."""
    levels = np.where(np.arange(192) % 2, 110, 90)
    found = fingerprint(blocks(levels))
    assert found.shape == (CELLS,) == (192,)
    np.testing.assert_allclose(found, np.where(np.arange(192) % 2, 1, -1), atol=1e-4)
    blue = np.zeros((320, 240, 3), np.uint8)
    blue[..., 2] = blocks(levels)[..., 2]
    np.testing.assert_allclose(fingerprint(blue), found, atol=1e-4)


@pytest.mark.parametrize(("contrast", "is_blank"), [(0, True), (1, True), (2, False), (3, False)])
def test_an_image_of_less_than_a_grey_level_is_blank(contrast, is_blank):
    """Levels 100 and 101 deviate by half a level, 100 and 102 by one."""
    found = fingerprint(blocks(100 + contrast * (np.arange(192) % 2)))
    assert np.isnan(found).all() == is_blank
    assert np.isfinite(found).all() != is_blank


def prints_at(*places):
    """Fingerprints that differ in one cell, by so many root-mean-squares."""
    found = np.zeros((len(places), CELLS), np.float32)
    found[:, 3] = np.array(places) * np.sqrt(CELLS)
    return found


def test_pairs_are_nearest_first_and_within_the_radius():
    """Of 0 in one part and 0.01, 0.03 and 0.05 in another, two pairs are within 0.04, the nearer first."""
    found = near_pairs(prints_at(0.0, 0.03, 0.05, 0.01), np.array([0, 1, 1, 1]))
    assert list(zip(found.first.tolist(), found.second.tolist(), strict=True)) == [(0, 3), (0, 1)]
    np.testing.assert_allclose(found.distance, [0.01, 0.03], rtol=1e-5)
    assert len(near_pairs(prints_at(0.0, 0.03, 0.05, 0.01), np.array([0, 1, 1, 1]), radius=0.06)) == 3


def test_the_four_nearest_of_each_image_are_looked_at():
    """One image beside seven in the other part: four pairs; the smaller part asks, whichever comes first."""
    places = prints_at(0.0, *(0.001 * k for k in range(1, 8)))
    for one, many_ in ((0, 1), (2, 0)):
        found = near_pairs(places, np.array([one] + [many_] * 7))
        assert sorted({*found.first.tolist(), *found.second.tolist()}) == [0, 1, 2, 3, 4]
        assert len(found) == 4


@pytest.mark.parametrize(
    ("places", "part"), [([], []), ([0.0], [0]), ([0.0, 0.0], [0, -1]), ([0.0, 0.0], [1, 1]), ([0.0, np.nan], [0, 1])]
)
def test_without_two_parts_there_is_no_pair(places, part):
    """No image, one image, none in a second part or a blank one gives empty arrays of one length."""
    found = near_pairs(prints_at(*places) if places else np.zeros((0, CELLS), np.float32), np.array(part, np.int64))
    assert [len(found), *map(len, (found.first, found.second, found.distance))] == [0, 0, 0, 0]


def test_principal_axes_keep_distances_of_few_directions():
    """Points that differ in 16 directions keep their distances in 16 axes; more directions only shrink them."""
    rng = np.random.default_rng(2)
    few = rng.normal(size=(60, 16)).astype(np.float32) @ np.linalg.qr(rng.normal(size=(CELLS, 16)))[0].T.astype(
        np.float32
    )
    flat = principal_axes(few + 7)
    assert flat.shape == (60, 16)
    np.testing.assert_allclose(np.linalg.norm(flat[3] - flat[9]), np.linalg.norm(few[3] - few[9]), rtol=1e-3)
    wide = rng.normal(size=(60, CELLS)).astype(np.float32)
    flat = principal_axes(wide)
    assert np.linalg.norm(flat[3] - flat[9]) < np.linalg.norm(wide[3] - wide[9])


def test_small_images_are_read_256_at_a_time(monkeypatch):
    """Of 300 small images 256 are asked for first, then 44; progress is told after each."""
    asked, told = [], []

    class Small:
        def frames(self, columns):
            return pa.table({side: pa.array([2] * 300, pa.int16()) for side in columns})

        def images(self, rows):
            asked.append(len(rows))
            return np.zeros((len(rows), 2, 2, 3), np.uint8)

    monkeypatch.setattr(module, "fingerprint", lambda image: np.ones(CELLS, np.float32))
    prints, unreadable = module._fingerprints(Small(), np.arange(300), lambda *given: told.append(given))
    assert (asked, told, unreadable) == ([256, 44], [(256, 300), (300, 300)], [])
    assert (prints == 1).all()


def test_smooth_colours_are_without_fine_grain():
    """A Gaussian blur of 3 pixels leaves 1 / (2 x 3 x sqrt(pi)) of the grain; every third pixel either way is taken."""
    grain = np.random.default_rng(3).normal(128, 20, (192, 144, 3))
    smooth = Portrait(np.rint(grain).clip(0, 255).astype(np.uint8)).smooth
    assert smooth.shape == (64 * 48 * 3,)
    assert smooth.std() == pytest.approx(20 / (6 * np.sqrt(np.pi)), rel=0.1)


def test_the_finest_fit_tries_nine_places_around_the_first(monkeypatch):
    """Gains 0.002 apart about the picture's mean, and offsets 0.2 grey levels apart; then half and a quarter of it."""
    tried = []

    def left(original, other, gain, offset, quality):
        tried.append((gain, offset, quality))
        return 5.0 * 0.8 ** (1 + (len(tried) - 1) // 9)

    monkeypatch.setattr(copies, "_left", left)
    picture = Portrait(np.full((64, 64, 3), 50, np.uint8))
    copies._finest(picture, picture, (5.0, 1.1, 3.0), 80)
    hand = [(1.1 + turn, 3.0 - 50 * turn + shift, 80) for turn in (-0.002, 0.0, 0.002) for shift in (-0.2, 0.0, 0.2)]
    np.testing.assert_allclose(tried[:9], hand, rtol=1e-9)
    assert len(tried) == 27
    for first, step in ((0, 0.002), (9, 0.001), (18, 0.0005)):
        gains, offsets, _ = np.array(tried[first : first + 9]).reshape(3, 3, 3).transpose(2, 0, 1)
        np.testing.assert_allclose(np.diff(gains, axis=0), step, rtol=1e-6)
        np.testing.assert_allclose(np.diff(offsets, axis=1), 100 * step, rtol=1e-6)
