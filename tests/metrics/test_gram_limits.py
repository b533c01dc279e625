"""Which pictures the style distances take, how many at a time, and which network they use."""

import hashlib

import numpy as np
import pytest

from tactiledata.errors import SchemaError, UsageError
from tactiledata.metrics import gram_style as module
from tactiledata.metrics.gram_style import GRAM_STYLE, _mean_grams, gram_style, gram_style_random, style_distances

torch = pytest.importorskip("torch")

WHITE, BLACK = 255, 0
FIRST, LAST = -0.197572, 0.039544
"""The first weight of the random network's first and of its last convolution."""


def flat(value, height=32, width=32, count=1):
    return np.full((count, height, width, 3), value, np.uint8)


def halves():
    """White on the left, black on the right."""
    picture = flat(WHITE)
    picture[:, :, 16:] = BLACK
    return picture


def left(count=1):
    mask = np.zeros((count, 32, 32), bool)
    mask[:, :, :16] = True
    return mask


@pytest.fixture(scope="module")
def one_by_one():
    """A network whose convolutions double each place by itself; white gives the same values as any white picture."""
    network = module.build_features(narrower=8)
    for part in network:
        if isinstance(part, torch.nn.Conv2d):
            part.weight.zero_()
            part.bias.zero_()
            part.weight[range(3), range(3), 1, 1] = 2.0
    return network


@pytest.fixture
def runs(monkeypatch):
    """Sizes of the runs that go through the network, which gives one channel of ones."""
    seen = []

    def grams(network, pictures, weights):
        seen.append(tuple(pictures.shape[:3]))
        return [[np.ones((len(pictures), 1, 1))] for _ in weights]

    monkeypatch.setattr(module, "_layer_grams", grams)
    return seen


def test_a_mask_leaves_out_what_it_does_not_cover(one_by_one):
    """White under the mask is white, black under it has no texture, and without a mask both count by their area."""
    whole, over_white, over_black = (
        _mean_grams(one_by_one, halves(), [mask])[0][0] for mask in (None, left(), ~left())
    )
    white = _mean_grams(one_by_one, flat(WHITE), [None])[0][0]
    # sums in single precision, whose order depends on the processor: 1e-5 apart on one of them
    np.testing.assert_allclose(over_white, white, rtol=1e-4)
    np.testing.assert_allclose(whole, white / 2, rtol=1e-4)
    assert not over_black.any()


def test_the_mean_is_over_pictures_with_a_mask_by_each_mask(one_by_one):
    """Nine white pictures and three black ones, more than go through at once, by two sets of masks."""
    others = np.concatenate([flat(WHITE, count=9), flat(BLACK, count=3)])
    some = np.ones((12, 32, 32), bool)
    some[:6] = False
    white = _mean_grams(one_by_one, flat(WHITE), [None])[0]
    whole, half = _mean_grams(one_by_one, others, [None, some])
    for layer, of_all, of_some in zip(white, whole, half, strict=True):
        np.testing.assert_allclose(of_all, 9 / 12 * layer, rtol=1e-5)
        np.testing.assert_allclose(of_some, 3 / 6 * layer, rtol=1e-5)
    with pytest.raises(UsageError, match="no picture of the other set"):
        _mean_grams(one_by_one, others, [None, np.zeros_like(some)])


@pytest.mark.parametrize(
    ("count", "height", "width", "shapes"),
    [
        (20, 32, 40, [(8, 32, 40), (8, 32, 40), (4, 32, 40)]),
        (5, 1024, 1024, [(4, 1024, 1024), (1, 1024, 1024)]),
        (5, 512, 2048, [(4, 512, 2048), (1, 512, 2048)]),
        (2, 1024, 4096, [(1, 1024, 4096), (1, 1024, 4096)]),
    ],
)
def test_eight_pictures_or_four_million_pixels_at_once(count, height, width, shapes, runs):
    """Both limits hold, for pictures that are wide or high too."""
    batch = np.broadcast_to(flat(WHITE, height, width), (count, height, width, 3))
    _mean_grams(None, batch, [None])
    assert runs == shapes


def test_a_picture_of_more_than_four_million_pixels_is_refused(runs):
    """2^22 pixels go through alone; with one row more the size, the limit and the memory are said."""
    _mean_grams(None, np.broadcast_to(flat(WHITE, 2048, 2048), (1, 2048, 2048, 3)), [None])
    with pytest.raises(UsageError, match=r"others of 2049 x 2048; expected at most 4194304 pixels.*the network 3 GB"):
        _mean_grams(None, np.broadcast_to(flat(WHITE, 1, 1), (1, 2049, 2048, 3)), [None])


@pytest.mark.parametrize(("height", "width"), [(31, 40), (40, 31)])
def test_both_sides_need_32_pixels(height, width, runs):
    """31 are refused in words, either way; 32 x 32 are taken."""
    with pytest.raises(UsageError, match=f"others of {height} x {width}; expected at least 32 px a side"):
        _mean_grams(None, flat(WHITE, height, width, 3), [None])
    _mean_grams(None, flat(WHITE, 32, 32), [None])
    assert runs == [(1, 32, 32)]


def test_no_pictures_have_no_distances():
    """Distances of no pictures are an empty array."""
    assert gram_style_random(flat(WHITE, count=0), flat(WHITE)).shape == (0,)


def test_layers_are_compared_behind_the_first_relu_of_each_width():
    """Gatys et al. 2016: conv1_1 to conv5_1, each behind its ReLU, where no value is negative."""
    network = list(module.build_features(8))
    assert all(isinstance(network[number], torch.nn.ReLU) for number in module.STYLE_LAYERS)
    assert [network[number - 1].out_channels for number in module.STYLE_LAYERS] == [8, 16, 32, 64, 64]


def test_the_random_network_is_always_the_same():
    """Golden values of its first and last convolution: with others, no two versions could be compared.

    Generator: ``random_features`` as it was when scores of it were first written down.
    """
    convolutions = [part for part in module.random_features() if isinstance(part, torch.nn.Conv2d)]
    assert [part.out_channels for part in convolutions[::4]] == [8, 32, 64, 64]
    assert all(not part.bias.any() for part in convolutions)
    # ReLU halves the variance: 2 over the inputs of a place, 9 x 64
    assert convolutions[-1].weight.std() == pytest.approx(np.sqrt(2 / (9 * 64)), rel=0.02)
    assert convolutions[0].weight[0, 0, 0, 0].item() == pytest.approx(FIRST, abs=1e-6)
    assert convolutions[-1].weight[0, 0, 0, 0].item() == pytest.approx(LAST, abs=1e-6)


def test_each_score_has_its_network_and_its_masks(monkeypatch, tmp_path, one_by_one):
    """The official score asks for the file that it is given, the other never does; each pair of masks has its value."""
    asked = []
    monkeypatch.setattr(module, "find_weights", lambda path: asked.append(path) or tmp_path)
    monkeypatch.setattr(module, "vgg19_features", lambda path: one_by_one)
    expected = module._distances(one_by_one, halves(), flat(WHITE), [(None, None), (left(), None)])
    (whole,) = gram_style(halves(), flat(WHITE), weights=tmp_path / "mine")
    (masked,) = gram_style(halves(), flat(WHITE), left(), weights=tmp_path / "mine")
    assert (whole, masked) == pytest.approx((expected[0][0], expected[1][0]))
    assert whole > 1.0
    assert masked < 1e-6 * whole
    assert gram_style(flat(WHITE), halves(), others_mask=left()) == pytest.approx(0.0, abs=1e-6 * whole)
    assert asked == [tmp_path / "mine", tmp_path / "mine", None]
    style_distances("gram_style_random", halves(), flat(WHITE), [(None, None)])
    assert len(asked) == 3
    assert [score.best for score in GRAM_STYLE.scores.values()] == [0.0, 0.0]


def test_a_file_of_the_official_name_must_have_its_digest(monkeypatch, tmp_path):
    """The digits of the name begin the SHA-256: where they do the content is read, where they do not it is refused."""
    content = b"no weights"
    digest = hashlib.sha256(content).hexdigest()
    for begin, words in ((digest[:8], "holds no weights of VGG-19"), ("00000000", f"has SHA-256 {digest[:8]}…")):
        monkeypatch.setattr(module, "WEIGHTS", f"vgg19-{begin}.pth")
        path = tmp_path / f"vgg19-{begin}.pth"
        path.write_bytes(content)
        with pytest.raises(SchemaError, match=words):
            module.vgg19_features(path)


@pytest.mark.parametrize("name", ["other.pth", "zzz.pth", "vgg19-dcbb9e9e.pth"])
def test_only_a_file_of_the_published_name_must_have_the_published_digest(name, tmp_path, monkeypatch):
    """A file of another name is read by what it holds; one of torchvision's name with other bytes is refused."""
    monkeypatch.setattr(module, "build_features", lambda: torch.nn.Sequential(torch.nn.Linear(1, 1)))
    module.vgg19_features.cache_clear()
    held = {"features.0.weight": torch.full((1, 1), 7.0), "features.0.bias": torch.zeros(1)}
    torch.save(held, tmp_path / name)
    torch.save(held, tmp_path / module.WEIGHTS)
    assert module.vgg19_features(tmp_path / name)[0].weight.item() == 7.0
    with pytest.raises(SchemaError, match="as it was published"):
        module.vgg19_features(tmp_path / module.WEIGHTS)
