"""Datasets whose pictures are decoded smaller: as frames, as tensors, as backgrounds, and normalised at that size."""

import loader_stores as made
import numpy as np
import pytest

from tactiledata.errors import UsageError
from tactiledata.loaders.numpy import TactileArrays
from tactiledata.loaders.picture_arrays import channels_first
from tactiledata.store.read.scaled_pictures import average_into

SIZE = (8, 5)


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A store of PNG files with a split."""
    folder = tmp_path_factory.mktemp("smaller") / "ds.zarr"
    made.split_store(folder)
    return folder


def test_all_pictures_have_the_size(place):
    """Frames, trajectories and backgrounds are the means over areas of the pictures as stored."""
    streams = ("digit", "background")
    plain = TactileArrays(place, "default/train", streams, image_dtype="uint8")
    smaller = TactileArrays(place, "default/train", streams, image_dtype="uint8", image_size=SIZE)
    expected = np.zeros((*SIZE, 3), np.uint8)
    for item, whole in zip(smaller.items([0, 3]), plain.items([0, 3]), strict=True):
        for name in streams:
            average_into(whole[name], expected)
            np.testing.assert_array_equal(item[name], expected)
    touches = TactileArrays(place, "default/train", streams, unit="trajectory", image_size=SIZE, missing="keep")
    assert touches[0]["digit"].shape[1:] == (*SIZE, 3)
    assert touches[0]["background"].shape == (*SIZE, 3)
    assert smaller.fingerprint == plain.fingerprint  # the same items


def test_tensors_have_the_size_and_scale(place):
    """Channels first; normalised at that size, for means over areas spread less."""
    pytest.importorskip("torch")
    from tactiledata.loaders.torch import TactileDataset, collate

    spread = {}
    for size in (None, SIZE):
        train = TactileDataset(place, "default/train", ["digit"], normalise=["digit"], image_size=size)
        pictures = collate(train.__getitems__(range(len(train))))["digit"]
        assert pictures.shape[1:] == (3, *(size or (made.HEIGHT, made.WIDTH)))
        assert abs(float(pictures.mean())) < 1e-3
        assert abs(float(pictures.std()) - 1) < 1e-2
        spread[size] = train.normalisers["digit"].std[0]
    assert spread[SIZE] < 0.7 * spread[None]


def test_sizes_without_pictures_or_beyond_them_are_refused(place):
    """Pictures are not enlarged, and numbers have no size."""
    with pytest.raises(UsageError, match="at most the 16 x 12"):
        TactileArrays(place, "default/train", ["digit"], image_size=(17, 12))
    with pytest.raises(UsageError, match="at most the 16 x 12"):
        TactileArrays(place, "default/train", ["background"], image_size=(16, 13))
    with pytest.raises(UsageError, match="without pictures"):
        TactileArrays(place, "default/train", ["wrench"], image_size=(8, 8))


@pytest.mark.parametrize("shape", [(1, 1), (16, 12), (5, 7)])
@pytest.mark.parametrize("threads", [1, 3])
def test_parted_colours_are_a_transposition(shape, threads):
    """Bytes are moved and floats are the bytes over 255 to the bit, for one picture and for several."""
    levels = np.random.default_rng(0).integers(0, 256, (9, *shape, 3)).astype(np.uint8)
    expected = np.ascontiguousarray(levels.transpose(0, 3, 1, 2))
    for dtype, scaled in ((np.uint8, expected), (np.float32, expected.astype(np.float32) / np.float32(255))):
        several, alone = np.zeros_like(expected, dtype), np.zeros_like(expected[0], dtype)
        channels_first(levels, several, threads)
        channels_first(levels[4], alone, threads)
        np.testing.assert_array_equal(several, scaled)
        np.testing.assert_array_equal(alone, scaled[4])
