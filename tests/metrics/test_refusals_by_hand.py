"""What metrics refuse, and numbers of theirs that are worked out by hand."""

import math

import numpy as np
import pytest

from tactiledata.errors import UsageError
from tactiledata.metrics import METRICS
from tactiledata.metrics.base import image_masks, images
from tactiledata.metrics.embedding import mmd
from tactiledata.metrics.gram_style import build_features


@pytest.mark.parametrize("dtype", [np.int8, bool, np.uint16, np.float32, np.float64])
def test_pictures_of_another_type_are_refused(dtype):
    """Only uint8 is taken, narrower and wider types alike are not."""
    with pytest.raises(UsageError, match="pictures"):
        images(np.zeros((2, 4, 4, 3), dtype), "predicted")


@pytest.mark.parametrize("shape", [(4, 4, 3), (2, 4, 4, 1), (2, 4, 4, 4), (2, 2, 4, 4, 3)])
def test_pictures_of_another_shape_are_refused(shape):
    """Only (n, H, W, 3) is taken."""
    with pytest.raises(UsageError, match="predicted of shape"):
        images(np.zeros(shape, np.uint8), "predicted")


def test_masks_are_boolean_and_of_the_pictures_size():
    """A mask of numbers, or of another size, is refused; none is none."""
    batch = np.zeros((2, 4, 5, 3), np.uint8)
    assert image_masks(None, batch) is None
    assert image_masks(np.ones((2, 4, 5), bool), batch).sum() == 40
    for wrong in (np.ones((2, 4, 5)), np.ones((2, 5, 4), bool), np.ones((1, 4, 5), bool)):
        with pytest.raises(UsageError):
            image_masks(wrong, batch)


def test_discrepancy_of_points_that_are_mostly_one():
    """With a median distance of 0, a point elsewhere is like no other: its kernel is 0, all others' is 1."""
    ours, theirs = np.zeros((5, 2)), np.zeros((5, 2))
    theirs[4] = [1.0, 0.0]
    # within ours 1; among theirs 12 of 20 pairs are alike; between them four of five
    np.testing.assert_allclose(mmd(ours, theirs), 1.0 - 2 * 0.8 + 12 / 20)


def test_discrepancy_of_four_points_by_hand():
    """Points at 0, 1 and 0, 3 on a line: the median distance is 1.5, the kernel exp(-d^2 / 4.5)."""
    kernel = {d: math.exp(-(d**2) / (2 * 1.5**2)) for d in (0, 1, 2, 3)}
    found = mmd(np.array([[0.0], [1.0]]), np.array([[0.0], [3.0]]))
    among = kernel[3]
    hand = [kernel[1] - (kernel[0] + kernel[3]) + among, kernel[1] - (kernel[1] + kernel[2]) + among]
    np.testing.assert_allclose(found, hand)


@pytest.mark.parametrize("narrower", [1, 8])
def test_layers_of_the_network_are_those_of_vgg_19(narrower):
    """The network has 2, 2, 4, 4 and 4 convolutions and five poolings (Simonyan and Zisserman 2015, column E)."""
    import torch

    network = build_features(narrower)
    widths = [part.out_channels * narrower for part in network if isinstance(part, torch.nn.Conv2d)]
    assert widths == [64] * 2 + [128] * 2 + [256] * 4 + [512] * 8
    assert sum(isinstance(part, torch.nn.MaxPool2d) for part in network) == 5


def test_a_distance_is_best_at_zero_and_a_likeness_at_one():
    """The best value of every score is what identical things get: 0 for what is lower, not 0 for what is higher."""
    for name in METRICS:
        for score in METRICS[name].scores.values():
            if score.better == "lower":
                assert score.best == 0.0, score.name
