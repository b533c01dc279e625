"""Transfer as augmentation: the same by seed whatever the batch, never onto a style that is tested on."""

import loaders.loader_stores as made
import pytest
import torch
from touch_world import UNSEEN

from split_models.transfer.pixels import PIXEL_TRANSFERS
from split_models.transfer.style_augmentation import OWN, StyleAugmentation
from tactiledata.errors import StoreError, UnknownName, UsageError
from tactiledata.loaders.torch import TactileDataset, collate
from tactiledata.store.change.keep_sensors import remove_picture

TARGETS = ["digit-bg-7", "D20002"]


@pytest.fixture(scope="module")
def dataset(touch_store):
    return TactileDataset(touch_store, "default/train", ["digit"], image_dtype="uint8")


def batch_of(dataset, numbers):
    return collate(dataset.__getitems__(numbers))


def test_a_frame_is_moved_alike_in_any_batch(dataset):
    """A frame's style follows from seed, epoch and frame alone, in any batch; another epoch or seed draws anew."""
    augment = StyleAugmentation(dataset, TARGETS, seed=3)
    one, other = augment(batch_of(dataset, range(12)), 2), augment(batch_of(dataset, [7, 3]), 2)
    assert torch.equal(other["digit"][0], one["digit"][7])
    assert other["style"] == [one["style"][7], one["style"][3]]
    assert set(one["style"]) == {OWN, *TARGETS}
    assert augment(batch_of(dataset, range(12)), 3)["style"] != one["style"]
    assert StyleAugmentation(dataset, TARGETS, seed=4)(batch_of(dataset, range(12)), 2)["style"] != one["style"]


def test_pictures_are_what_the_method_makes(dataset, touch_store):
    """Each moved picture is the transfer of its own, those not drawn and the batch that was given stay bit for bit."""
    method = PIXEL_TRANSFERS["background_swap"]
    batch = batch_of(dataset, range(10))
    before = batch["digit"].clone()
    moved = StyleAugmentation(dataset, TARGETS, method)(batch)
    assert torch.equal(batch["digit"], before)
    store = dataset.arrays.store
    from tactiledata.store.read.targets import find_target

    for row, style in enumerate(moved["style"]):
        picture = before[row].movedim(0, -1).numpy()
        if style != OWN:
            target = find_target(style, store).background
            picture = method.transfer(picture[None], store.reference(batch["sensor"][row]).image, target)[0]
        assert torch.equal(moved["digit"][row].movedim(0, -1), torch.from_numpy(picture))


def test_floats_stay_floats(touch_store, dataset):
    """Pictures in [0, 1] come out in [0, 1], the same to half a grey level; a share of 0 changes nothing."""
    floats = TactileDataset(touch_store, "default/train", ["digit"])
    one = StyleAugmentation(floats, TARGETS, share=1.0)(batch_of(floats, range(4)))["digit"]
    bytes_ = StyleAugmentation(dataset, TARGETS, share=1.0)(batch_of(dataset, range(4)))["digit"]
    assert torch.equal((one * 255).round().byte(), bytes_)
    still = batch_of(floats, range(4))
    assert torch.equal(StyleAugmentation(floats, TARGETS, share=0.0)(still)["digit"], still["digit"])


@pytest.mark.parametrize(
    ("targets", "says"),
    [
        ([UNSEEN], f"that of sensor {UNSEEN}, which is held out"),
        (["digit-bg-14"], f"that of sensor {UNSEEN}, which is held out"),
        ([], "0 targets"),
    ],
)
def test_what_is_tested_on_is_no_style(dataset, targets, says):
    """A tested sensor is no style, by its name, or by its picture under another name."""
    with pytest.raises(UsageError, match=says):
        StyleAugmentation(dataset, targets)


@pytest.mark.slow
def test_other_datasets_are_refused(touch_store, dataset, tmp_path):
    """Parts that are tested on, trajectories, no pictures, normalised ones; unknown targets; a wrong share."""
    for part, options, says in [
        ("default/test", {}, "augmentation of default/test"),
        ("default/train", {"unit": "trajectory"}, "trajectories"),
        ("default/train", {"streams": ["wrench"], "missing": "keep"}, "no pictures"),
        ("default/train", {"normalise": ["digit"]}, "normalised pictures"),
    ]:
        other = TactileDataset(touch_store, part, **{"streams": ["digit"], **options})
        with pytest.raises(UsageError, match=says):
            StyleAugmentation(other, TARGETS)
    with pytest.raises(UnknownName, match="digit-bg-7"):
        StyleAugmentation(dataset, ["digit-bg-77"])
    with pytest.raises(UsageError, match=r"share of 1\.5"):
        StyleAugmentation(dataset, TARGETS, share=1.5)
    made.split_store(tmp_path / "ds.zarr")
    small = TactileDataset(tmp_path / "ds.zarr", "default/train", ["digit"])
    with pytest.raises(UsageError, match=r"\(320, 240, 3\)"):
        StyleAugmentation(small, ["digit-bg-7"])
    remove_picture(tmp_path / "ds.zarr", "D1")
    with pytest.raises(StoreError, match="sensors add D1"):
        StyleAugmentation(TactileDataset(tmp_path / "ds.zarr", "default/train", ["digit"]), ["D2"])
