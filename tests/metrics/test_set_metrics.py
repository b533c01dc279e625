"""Metrics of two sets: alike sets score best, moved ones worse, masks restrict, and networks are never mixed."""

import hashlib

import numpy as np
import pytest

from tactiledata.errors import MissingFile, SchemaError, UsageError
from tactiledata.metrics.embedding import knn_mixing, mmd, silhouette, silhouettes, tsne
from tactiledata.metrics.histogram import histogram_correlation, histogram_intersection, histograms

RNG = np.random.default_rng


def pictures(count=6, level=100, spread=20, seed=0, size=40):
    return np.clip(RNG(seed).normal(level, spread, (count, size, size, 3)), 0, 255).astype(np.uint8)


def test_histograms_of_a_flat_picture():
    """All weight in one bin; two flat pictures of other levels do not overlap at all."""
    one, other = np.full((1, 9, 9, 3), 12, np.uint8), np.full((1, 9, 9, 3), 200, np.uint8)
    assert histograms(one)[0, 0, 1] == 1
    assert histogram_intersection(one, one)[0] == histogram_correlation(one, one)[0] == pytest.approx(1)
    assert histogram_intersection(one, other)[0] == 0
    assert histogram_correlation(one, other)[0] < 0


def test_histograms_forget_where_pixels_are():
    """Shuffled pixels change nothing; another brightness does, ever more."""
    batch = pictures()
    shuffled = RNG(1).permutation(batch.reshape(6, -1, 3), axis=1).reshape(batch.shape)
    for score in (histogram_intersection, histogram_correlation):
        np.testing.assert_allclose(score(shuffled, batch), score(batch, batch))
        values = [score(pictures(level=100 + shift, seed=2), batch).mean() for shift in (0, 15, 40)]
        assert values[0] > values[1] > values[2]


def test_intersection_and_correlation_are_two_measures():
    """On one pair of sets they differ: which is which must be said."""
    one, other = pictures(level=110, spread=10), pictures(spread=30, seed=3)
    assert abs(histogram_intersection(one, other).mean() - histogram_correlation(one, other).mean()) > 0.05


def test_masks_of_histograms():
    """Outside the mask nothing counts; an empty mask has no value; an empty other set is refused."""
    batch, mask = pictures(), np.zeros((6, 40, 40), bool)
    mask[:4, 5:20, 5:20] = True
    other = batch.copy()
    other[:, 30:] = 0
    found = histogram_intersection(other, batch, mask, mask)
    np.testing.assert_array_equal(found, histogram_intersection(batch, batch, mask, mask))
    assert np.isnan(found[4:]).all()
    with pytest.raises(UsageError, match="mask"):
        histogram_intersection(batch, batch, None, np.zeros_like(mask))


def clouds(shift, count=150, dimensions=5, seed=0):
    rng = RNG(seed)
    return rng.normal(0, 1, (count, dimensions)), rng.normal(0, 1, (count, dimensions)) + shift


def test_mixed_clouds_and_clouds_apart():
    """One distribution has silhouette and MMD about 0 and mixing about 1; farther apart, each is worse."""
    near, half, far = ({s: s(*clouds(shift)).mean() for s in (silhouette, knn_mixing, mmd)} for shift in (0, 1, 6))
    assert abs(near[silhouette]) < 0.02
    assert near[knn_mixing] == pytest.approx(1, abs=0.08)
    assert abs(near[mmd]) < 0.01
    assert near[silhouette] < half[silhouette] < far[silhouette]
    assert near[knn_mixing] > half[knn_mixing] > far[knn_mixing] == 0
    assert near[mmd] < half[mmd] < far[mmd]


def test_the_parts_of_mmd_average_to_its_estimate():
    """The parts average to the double sum, written out."""
    one, other = clouds(0.7, 20)
    whole = np.concatenate([one, other])
    distance = np.linalg.norm(whole[:, None] - whole[None], axis=2)
    kernel = np.exp(-0.5 * (distance / np.median(distance[np.triu_indices(40, 1)])) ** 2)
    xx, yy, xy = kernel[:20, :20], kernel[20:, 20:], kernel[:20, 20:]
    expected = (xx.sum() - 20) / 380 + (yy.sum() - 20) / 380 - 2 * xy.mean()
    assert mmd(one, other).mean() == pytest.approx(expected)


def test_mixing_of_unequal_sets_is_measured_against_chance():
    """Ten times as many vectors of one set still give 1 for both."""
    rng = RNG(4)
    few, many = rng.normal(0, 1, (60, 4)), rng.normal(0, 1, (600, 4))
    assert knn_mixing(few, many).mean() == pytest.approx(1, abs=0.1)
    assert knn_mixing(many, few).mean() == pytest.approx(1, abs=0.15)


def test_doubles_are_neighbours():
    """Two copies of one cloud: each vector's copy is a foreign neighbour, and nothing breaks."""
    one, _ = clouds(0, 40)
    assert (knn_mixing(one, one.copy()) > 0).all()


def test_tsne_keeps_clusters_together():
    """Two far clouds stay two; the same seed gives the same places."""
    one, other = clouds(30, 25)
    places = tsne(np.concatenate([one, other]), perplexity=10)
    assert places.shape == (50, 2)
    assert silhouettes(places, np.repeat([0, 1], 25)).mean() > 0.5
    np.testing.assert_array_equal(places, tsne(np.concatenate([one, other]), perplexity=10))


def test_sets_that_do_not_go_together_are_refused():
    """Other dimensions, NaN, one label, pictures that are floats."""
    one, other = clouds(0, 20)
    with pytest.raises(UsageError, match="latent space"):
        mmd(one, other[:, :3])
    with pytest.raises(UsageError, match="finite"):
        knn_mixing(np.full((5, 2), np.nan), np.zeros((5, 2)))
    with pytest.raises(UsageError, match="labels"):
        silhouettes(one, np.zeros(20))
    with pytest.raises(UsageError, match="uint8"):
        histograms(np.zeros((2, 9, 9, 3)))


class TestGramStyle:
    """Needs PyTorch."""

    @pytest.fixture(autouse=True)
    def style(self):
        pytest.importorskip("torch")
        import tactiledata.metrics.gram_style as module

        return module

    def textures(self, period, count=3, seed=0):
        """Stripes of a period, at random phases."""
        phase = RNG(seed).uniform(0, 2 * np.pi, count)
        x = np.arange(48)
        wave = 128 + 90 * np.sin(2 * np.pi * x / period + phase[:, None])
        return np.repeat(np.repeat(wave[:, None, :, None], 48, 1), 3, 3).astype(np.uint8)

    def test_style_is_texture_not_place(self, style):
        """Stripes of one period at other phases are nearer than stripes of another period."""
        same = style.gram_style_random(self.textures(6, seed=1), self.textures(6))
        other = style.gram_style_random(self.textures(14, seed=1), self.textures(6))
        assert same.max() < 0.3 * other.min()
        alone = self.textures(6, count=1)
        assert style.gram_style_random(alone, alone) == pytest.approx(0, abs=1e-9)

    def test_masks(self, style):
        """What is far outside the mask does not count; an empty mask has no value."""
        batch = self.textures(6)
        mask = np.zeros((3, 48, 48), bool)
        mask[:2] = True
        found = style.gram_style_random(batch, batch, mask)
        assert np.isnan(found[2])
        np.testing.assert_allclose(found[:2], style.gram_style_random(batch, batch)[:2], rtol=1e-4)

    def test_without_weights_vgg_is_refused_and_the_other_is_named(self, style, monkeypatch, tmp_path):
        """Never silently: the VGG score fails and proposes the other, which has another name."""
        import torch

        monkeypatch.setattr(torch.hub, "get_dir", lambda: str(tmp_path))
        batch = self.textures(6)
        with pytest.raises(UsageError, match="gram_style_random"):
            style.gram_style(batch, batch)
        assert style.style_score() == "gram_style_random"
        assert set(style.GRAM_STYLE.scores) == {"gram_style", "gram_style_random"}
        assert "random" in style.GRAM_STYLE.scores["gram_style_random"].title

    @pytest.mark.slow
    def test_official_names_of_the_weights(self, style, tmp_path):
        """A file with torchvision's keys is taken; one that only bears the name, or is no such file, is refused."""
        import torch

        network = style.build_features()
        kept = {f"features.{name}": value for name, value in network.state_dict().items()}
        assert {"features.0.weight", "features.34.bias", "features.28.weight"} <= set(kept)
        assert kept["features.28.weight"].shape == (512, 512, 3, 3)
        torch.save({**kept, "classifier.6.bias": torch.zeros(1000)}, tmp_path / "mine.pth")
        loaded = style.vgg19_features(tmp_path / "mine.pth")
        torch.testing.assert_close(loaded.state_dict(), network.state_dict())
        assert style.style_score(tmp_path / "mine.pth") == "gram_style"
        (tmp_path / style.WEIGHTS).write_bytes(b"not they")
        assert not hashlib.sha256(b"not they").hexdigest().startswith("dcbb9e9d")
        with pytest.raises(SchemaError, match="SHA-256"):
            style.vgg19_features(tmp_path / style.WEIGHTS)
        (tmp_path / "other.pth").write_bytes(b"no archive")
        with pytest.raises(SchemaError, match="no weights"):
            style.vgg19_features(tmp_path / "other.pth")
        with pytest.raises(MissingFile):
            style.find_weights(tmp_path / "none.pth")

    def test_small_pictures_are_refused(self, style):
        """Five poolings need 32 pixels."""
        with pytest.raises(UsageError, match="32"):
            style.gram_style_random(pictures(2, size=20), pictures(2, size=20))
