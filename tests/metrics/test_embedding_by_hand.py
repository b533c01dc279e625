"""Measures of mixing on a few points of a line, and what t-SNE is asked for."""

import numpy as np
import pytest
import sklearn.manifold

from tactiledata.contract import extras
from tactiledata.errors import UsageError
from tactiledata.metrics.embedding import EMBEDDING, knn_mixing, mmd, silhouette, silhouettes, tsne


def line(*places):
    return np.array(places, float)[:, None]


def test_silhouettes_by_hand():
    """Own distance a, other's b: (b - a) over the larger; one that is alone has 0."""
    assert silhouettes(line(0, 1, 10), ["x", "x", "y"]) == pytest.approx([9 / 10, 8 / 9, 0])
    assert silhouettes(line(0, 4, 1), [0, 0, 1]) == pytest.approx([-3 / 4, -1 / 4, 0])


def test_a_silhouette_is_of_the_first_set():
    """0 and 1 against 10 and 12: 0 is 1 from its own and 11 from the others, 1 is 1 and 10 away."""
    assert silhouette(line(0, 1), line(10, 12)) == pytest.approx([10 / 11, 9 / 10])
    assert silhouette(line(10, 12, 14), line(0, 1)) == pytest.approx([6.5 / 9.5, 9.5 / 11.5, 10.5 / 13.5])


@pytest.mark.parametrize(
    ("count", "labels"),
    [(2, [0, 1]), (3, [0, 0, 0]), (3, [0, 1, 2]), (4, [0, 1, 0]), (4, [[0], [1], [0], [1]])],
)
def test_labels_that_part_nothing_are_refused(count, labels):
    """Two vectors, one label, a label for each vector, and other numbers of labels than vectors are refused."""
    with pytest.raises(UsageError, match=r"two labels or more|at least 3"):
        silhouettes(line(*range(count)), labels)


def test_mixing_counts_the_ten_nearest():
    """Ten of one set on a line far from twenty of the other: nine neighbours are own, the tenth is foreign."""
    ours, theirs = line(*range(10)), line(*range(1000, 1020))
    assert knn_mixing(ours, theirs) == pytest.approx([1 / 10 / (20 / 29)] * 10)
    assert knn_mixing(theirs, ours) == pytest.approx([0.0] * 20)


def test_mixing_of_few_vectors_takes_all_others():
    """Of two and two, the three others are two foreign and one own: as by chance."""
    assert knn_mixing(line(0, 5), line(1, 7)) == pytest.approx([1.0, 1.0])


def test_a_vector_is_no_neighbour_of_its_own():
    """Where equal vectors hide it, ten others are counted all the same: never more than all of them foreign."""
    ours, theirs = np.zeros((2, 3)), np.zeros((30, 3))
    share = knn_mixing(ours, theirs) * (30 / 31) * 10
    assert np.allclose(share, np.rint(share))
    assert (share <= 10 + 1e-9).all()
    assert (share >= 9 - 1e-9).all()


@pytest.mark.parametrize("scale", [1e-6, 1e-3, 1e3])
def test_discrepancy_and_mixing_do_not_depend_on_the_unit(scale):
    """The kernel is as wide as the points are apart: in other units all values stay."""
    rng = np.random.default_rng(0)
    ours, theirs = rng.normal(size=(9, 3)), rng.normal(size=(12, 3)) + 0.5
    for score in (mmd, knn_mixing, silhouette):
        np.testing.assert_allclose(score(scale * ours, scale * theirs), score(ours, theirs), rtol=1e-9)


@pytest.mark.parametrize(
    ("ours", "theirs", "words"),
    [
        (line(0), line(0, 1), r"the first set of shape \(1, 1\).*at least 2"),
        (line(0, 1), line(0), r"the second set of shape \(1, 1\).*at least 2"),
        (np.zeros(4), line(0, 1), r"the first set of shape \(4,\)"),
        (np.zeros((2, 2, 2)), line(0, 1), r"the first set of shape \(2, 2, 2\)"),
        (line(0, np.inf), line(0, 1), "finite"),
        (np.zeros((4, 2)), np.zeros((4, 3)), "vectors of 2 and of 3 components"),
        (np.zeros((4, 3)), np.zeros((4, 2)), "vectors of 3 and of 2 components"),
    ],
)
def test_sets_that_do_not_fit_are_refused(ours, theirs, words):
    """One vector, none in a table, infinite ones, and sets of another number of components are refused."""
    with pytest.raises(UsageError, match=words):
        mmd(ours, theirs)


class Asked:
    """A t-SNE that notes what it is asked for."""

    def __init__(self, **given):
        Asked.given = given

    def fit_transform(self, points):
        return points[:, :2] * 2.0


@pytest.mark.parametrize(
    ("count", "given", "perplexity", "seed"),
    [(200, {}, 30.0, 0), (31, {}, 10.0, 0), (5, {}, 4 / 3, 0), (92, {"perplexity": 7.0, "seed": 3}, 7.0, 3)],
)
def test_perplexity_is_at_most_a_third_of_the_others(count, given, perplexity, seed, monkeypatch):
    """30 unless asked otherwise, a third of the other vectors where they are few; from seed 0."""
    monkeypatch.setattr(sklearn.manifold, "TSNE", Asked)
    points = np.arange(3.0 * count).reshape(count, 3)
    places = tsne(points, **given)
    assert Asked.given["perplexity"] == pytest.approx(perplexity)
    assert (Asked.given["random_state"], places.dtype) == (seed, np.float32)
    np.testing.assert_array_equal(places, 2 * points[:, :2])
    with pytest.raises(UsageError, match="at least 5"):
        tsne(points[:4])


def test_without_scikit_learn_it_is_named(monkeypatch):
    """The error says what is missing and how it is installed."""
    monkeypatch.setattr(extras, "find_spec", lambda name: None)
    for ask in (lambda: tsne(np.zeros((9, 2))), lambda: silhouettes(line(0, 1, 2), [0, 0, 1])):
        with pytest.raises(UsageError, match=r"needs scikit-learn.*pip install"):
            ask()


def test_best_values():
    """Sets that are mixed have a silhouette and a discrepancy of 0 and a mixing of 1."""
    assert {name: score.best for name, score in EMBEDDING.scores.items()} == {
        "silhouette": 0.0, "knn_mixing": 1.0, "mmd": 0.0,
    }  # fmt: skip
