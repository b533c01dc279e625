"""Gram matrices of VGG-19's shape with weights that let every number be worked out by hand."""

import numpy as np
import pytest

from tactiledata.errors import UsageError
from tactiledata.metrics.gram_style import _distances, _layer_grams, build_features, gram_style_random

torch = pytest.importorskip("torch")

WHITE = np.array([(1 - 0.485) / 0.229, (1 - 0.456) / 0.224, (1 - 0.406) / 0.225])
"""White after the norm of ImageNet."""


def doubling():
    """The network, an eighth as wide, in which each convolution doubles its first three channels."""
    network = build_features(narrower=8)
    for part in network:
        if isinstance(part, torch.nn.Conv2d):
            part.weight.zero_()
            part.bias.zero_()
            for channel in range(3):
                part.weight[channel, channel, 1, 1] = 2.0
    return network


def test_gram_matrices_by_hand():
    """Half white, half black: the mean of products of channels, doubled by 1, 3, 5, 9 and 13 convolutions."""
    picture = np.zeros((1, 32, 32, 3), np.uint8)
    picture[:, :, 16:] = 255
    whole = torch.ones(1, 32, 32, dtype=torch.bool)
    (grams,) = _layer_grams(doubling(), torch.from_numpy(picture), [whole])
    assert [gram.shape[1] for gram in grams] == [8, 16, 32, 64, 64]
    for gram, convolutions in zip(grams, (1, 3, 5, 9, 13), strict=True):
        # black is below 0 after the norm: the first ReLU leaves nothing of it
        assert gram[0, :3, :3] == pytest.approx(4.0**convolutions * np.outer(WHITE, WHITE) / 2, rel=1e-5)
        assert not gram[0, 3:].any()


def test_style_distance_by_hand():
    """White and black differ by a fifth of each layer's sum of squares over four times the channels' square."""
    white, black = np.full((1, 32, 32, 3), 255, np.uint8), np.zeros((1, 32, 32, 3), np.uint8)
    squares = np.square(np.outer(WHITE, WHITE)).sum()
    layers = zip((1, 3, 5, 9, 13), (8, 16, 32, 64, 64), strict=True)
    expected = sum(16.0**n * squares / (4 * channels**2) / 5 for n, channels in layers)
    (found,) = _distances(doubling(), white, black, [(None, None)])
    assert found == pytest.approx([expected], rel=1e-5)


def test_few_pixels_at_once_change_nothing(monkeypatch):
    """However few pictures go through the network together, distances stay; one that is too large is refused."""
    rng = np.random.default_rng(3)
    ours, theirs = (rng.integers(0, 256, (n, 40, 48, 3)).astype(np.uint8) for n in (5, 3))
    whole = gram_style_random(ours, theirs)
    monkeypatch.setattr("tactiledata.metrics.gram_style.MOST_PIXELS", 2 * 40 * 48)
    np.testing.assert_allclose(gram_style_random(ours, theirs), whole, rtol=1e-5)
    # read-only pictures, as one that is laid beside many, are taken
    np.testing.assert_allclose(gram_style_random(np.broadcast_to(ours[0], (3, 40, 48, 3)), theirs), whole[0], rtol=1e-5)
    monkeypatch.setattr("tactiledata.metrics.gram_style.MOST_PIXELS", 40 * 48 - 1)
    with pytest.raises(UsageError, match=r"pictures of 40 x 48|others of 40 x 48"):
        gram_style_random(ours, theirs)
