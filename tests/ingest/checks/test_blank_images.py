"""Images of one colour among good ones are found, marked and left out; dark pictures of gels are not."""

import cv2
import numpy as np
import pyarrow as pa
import pytest

from tactiledata.contract.description import LogDescription
from tactiledata.contract.records import Image, Recording, Signal, Source, Stamps, Trajectory
from tactiledata.contract.take import FrameFlag, findings_of
from tactiledata.ingest.checks.blank_images import blank_images
from tactiledata.ingest.pipeline import _checked_take, ingest
from tactiledata.ingest.trajectories.assemble import IngestOptions
from tactiledata.loaders.numpy import TactileArrays
from tactiledata.sensors.backgrounds import bundled_backgrounds, load_background
from tactiledata.sensors.image_checks import is_one_colour
from tactiledata.store.read.reader import Store
from tactiledata.units import SIGNAL_COLUMNS
from tests.ingest.checks.test_spooled import spooled

MS = 1_000_000
SAME = {"xyz": [0.0, 0.0, 0.0], "xyzw": [0.0, 0.0, 0.0, 1.0]}
GEL = load_background("digit-bg-0")[::4, ::4]


def recorded(folder, pictures, suffix):
    """A store of a folder of pictures (H, W, 3) RGB."""
    run = folder / "run"
    run.mkdir()
    for number, picture in enumerate(pictures):
        cv2.imwrite(str(run / f"{number:02d}{suffix}"), picture[..., ::-1])
    ingest([run], folder / "ds.zarr")
    return Store.open(folder / "ds.zarr")


def gel(number, gain=1.0):
    noise = np.random.default_rng(number).normal(0, 1.5, GEL.shape)
    return np.clip(gain * GEL + noise, 0, 255).astype(np.uint8)


def flat(level, noise=0.0):
    made = level + np.random.default_rng(9).normal(0, noise, GEL.shape)
    return np.clip(np.rint(made), 0, 255).astype(np.uint8)


@pytest.mark.parametrize("suffix", [".png", ".jpg"])
@pytest.mark.parametrize("blank", [flat(0), flat(255), flat(0, 0.8), flat(np.array([90, 20, 140]))])
@pytest.mark.parametrize("places", [(7,), (0,), (19,), (3, 4, 11)])
def test_an_image_of_one_colour_is_marked(tmp_path, suffix, blank, places):
    """Black, white, noisy black or one hue, at any place: named, flagged, and not among what is learned from."""
    pictures = [blank if number in places else gel(number) for number in range(20)]
    store = recorded(tmp_path, pictures, suffix)
    flags = store.frames(["flags"])["flags"].to_numpy()
    assert np.flatnonzero(flags & FrameFlag.BLANK).tolist() == list(places)
    (said,) = [one for one in findings_of(store.findings()) if one.code == "image-blank"]
    assert (said.severity, said.count) == ("warning", len(places))
    assert f"of 20 of camera 'tactile', of one colour throughout: number {places[0]}" in said.message
    arrays = TactileArrays(tmp_path / "ds.zarr", "all", ("tactile",), allow_leaks=True)
    assert len(arrays) == 20 - len(places)
    assert arrays.report.left_out == {"an image of one colour": len(places)}


def test_a_camera_that_is_dark_from_some_moment_on_is_seen(tmp_path):
    """Most images black: all of them are marked, although the usual size of a file is theirs."""
    store = recorded(tmp_path, [gel(number) if number < 5 else flat(0, 1.0) for number in range(20)], ".png")
    flags = store.frames(["flags"])["flags"].to_numpy()
    assert np.flatnonzero(flags & FrameFlag.BLANK).tolist() == list(range(5, 20))


@pytest.mark.parametrize("gain", [0.25, 1.0])
def test_pictures_of_a_gel_are_not_blank(tmp_path, gain):
    """Negative control: gels, in poor light too, and one image that is smaller because it is smooth."""
    pictures = [gel(number, gain) for number in range(20)]
    pictures[6] = cv2.GaussianBlur(pictures[6], (0, 0), 3.0)
    store = recorded(tmp_path, pictures, ".png")
    assert not (store.frames(["flags"])["flags"].to_numpy() & FrameFlag.BLANK).any()


def test_every_bundled_gel_has_more_than_one_colour():
    """The limit is far from pictures of gels: none of the 18 is of one colour at a third of its brightness."""
    assert not any(is_one_colour((load_background(name) // 3).astype(np.uint8)) for name in bundled_backgrounds())
    assert is_one_colour(flat(40, 2.5))
    assert not is_one_colour(flat(40, 3.5))


class Files:
    """Images that are only the sizes of their files, and the rows that are looked at; those in ``blank`` are black."""

    def __init__(self, length, camera="a", encoding="png", blank=(), unreadable=()):
        count = len(length)
        named = {"camera": camera, "encoding": encoding}
        texts = {
            name: pa.array([text] * count if isinstance(text, str) else list(text)) for name, text in named.items()
        }
        self.columns = pa.table({**texts, "length": pa.array(length, pa.int64())})
        self.blank, self.unreadable, self.seen = set(blank), set(unreadable), []

    def decode(self, rows):
        (row,) = rows.tolist()
        self.seen.append(row)
        return [None if row in self.unreadable else flat(0) if row in self.blank else GEL]


def looked_at(length, **options):
    """Rows that are looked at, in order; each only once."""
    files = Files(length, **options)
    blank_images(files)
    assert len(set(files.seen)) == len(files.seen)
    return sorted(files.seen)


def marked(length, **options):
    rows, findings = blank_images(Files(length, **options))
    return rows.tolist(), [one.message.partition(" in the order")[0] for one in findings]


def test_only_small_files_and_three_others_are_looked_at():
    """Up to 0.8 of the median, and the first, the middle and the last, whatever their size."""
    assert looked_at([100] * 9) == [0, 4, 8]
    assert looked_at([100] * 8) == [0, 4, 7]
    assert looked_at([100, 80, 81, 100, 100, 100, 79, 100, 900]) == [0, 1, 4, 6, 8]
    assert looked_at([7]) == [0]


def test_beside_a_blank_probe_twice_its_size_is_looked_at():
    """The largest blank one of the three counts; one that cannot be read is not blank."""
    sizes = [60, 120, 121, 300, 300, 300, 300, 300, 50]
    assert looked_at([130, 260, 261, 300, 300, 300, 300, 300, 290], blank=[0], unreadable=[8]) == [0, 1, 4, 8]
    assert looked_at([130, 260, 261, 300, 300, 300, 300, 300, 50], blank=[0, 8]) == [0, 1, 4, 8]
    assert looked_at([50, 260, 261, 300, 300, 300, 300, 300, 130], blank=[0, 8]) == [0, 1, 4, 8]
    assert marked(sizes, unreadable=range(9)) == ([], [])


def test_each_camera_and_each_kind_of_file_is_judged_beside_its_own():
    """Cameras in the order of their names, and numbers among those of the camera that are not missing."""
    sizes = [1000, 1000, 0, 10, 1000, 500, 20, 20, 20, 20]
    kinds = ["png", "png", "missing", "png", "png", "png", "jpeg", "jpeg", "jpeg", "jpeg"]
    cameras = ["b", "b", "b", "b", "b", "a", "b", "b", "b", "a"]
    assert looked_at(sizes, encoding=kinds, camera=cameras) == [0, 3, 4, 5, 6, 7, 8, 9]
    rows, said = marked(sizes, encoding=kinds, camera=cameras, blank=[3, 7, 9])
    assert rows == [3, 7, 9]
    assert said == [
        "1 image of 2 of camera 'a', of one colour throughout: number 1",
        "2 images of 7 of camera 'b', of one colour throughout: number 2, 5",
    ]
    assert marked([10] * 4, camera=["a", "a", "b", "b"], blank=[3])[0] == [3]


def test_three_images_of_one_colour_are_named():
    """A fourth is a sign."""
    assert marked([10] * 5, blank=[0, 1, 2])[1] == [
        "3 images of 5 of camera 'a', of one colour throughout: number 0, 1, 2"
    ]
    (said,) = marked([10] * 5, blank=[1, 2, 3, 4])[1]
    assert said == "4 images of 5 of camera 'a', of one colour throughout: number 1, 2, 3 …"


def test_the_limit_of_one_colour_is_three_grey_levels():
    """A channel of half 0 and half 6 has a deviation of 3: more than one colour; the others do not make up for it."""
    picture = np.zeros((4, 4, 3), np.uint8)
    picture[:2, :, 1] = 6
    assert not is_one_colour(picture)
    picture[:2, :, 1] = 5
    assert is_one_colour(picture)


def test_an_image_of_one_colour_is_no_picture_without_contact(tmp_path):
    """Of four frames in free air one is black: the mean is that of the three gels, and none of two gels and it."""
    for count, origin in ((4, "mean of 3 frames below 0.2 N"), (3, None)):
        pictures = [GEL, flat(0), GEL + 2, GEL + 4][:count]
        images = spooled(tmp_path / str(count), [
            Image("digit", picture.tobytes(), "raw", *picture.shape[:2], log_ns=number * MS, sensor="D1")
            for number, picture in enumerate(pictures)
        ])  # fmt: skip
        times = MS * np.arange(100)
        signals = {"wrench": Signal("wrench", Stamps(times), np.zeros((100, 6)), SIGNAL_COLUMNS["wrench"])}
        document = {"sensors": {"D1": {"model": "digit"}}, "robot": {"tcp_from_gel": SAME, "tcp_from_ft": SAME}}
        touches = (Trajectory("t", 0, 100 * MS, "D1"),)
        recording = Recording(Source("p", "k", "folder", ()), LogDescription(document), signals, touches)
        take = _checked_take(recording, images, "ab" * 32, IngestOptions())
        assert take.frames["flags"].to_pylist() == [0, FrameFlag.BLANK, 0, 0][:count]
        if origin is None:
            assert "D1" not in take.references
        else:
            assert take.references["D1"].origin == origin
            np.testing.assert_array_equal(take.references["D1"].image, GEL + 2)
