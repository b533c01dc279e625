"""Measures of how well two sets of latent vectors mix: silhouette, neighbours, maximum mean discrepancy; t-SNE."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactiledata.contract.extras import need_packages
from tactiledata.errors import UsageError
from tactiledata.metrics.base import Score, Values, metric

NEIGHBOURS = 10
"""Nearest vectors of each vector among which `knn_mixing` counts."""
PERPLEXITY = 30.0
"""Perplexity of t-SNE: about the number of neighbours that each vector keeps."""


def tsne(vectors: Any, perplexity: float = PERPLEXITY, seed: int = 0) -> NDArray[np.float32]:
    """Places (n, 2) of vectors on a plane, by scikit-learn's t-SNE, started from the principal components.

    The places are for pictures; distances between them have no meaning.

    Parameters
    ----------
    vectors : (n, d)
        Latent vectors, at least five.
    perplexity : float
        About the number of neighbours that each vector keeps; lowered to a third of the vectors where they are few.
    seed : int
        Seed of the random numbers.

    Raises
    ------
    UsageError
        Fewer than five vectors, NaN, or scikit-learn is not installed.
    """
    points = _vectors(vectors, "vectors", least=5)
    need_packages("an embedding", "sklearn")
    from sklearn.manifold import TSNE

    fitted = TSNE(perplexity=min(perplexity, (len(points) - 1) / 3), init="pca", random_state=seed)
    places: NDArray[np.float32] = fitted.fit_transform(points).astype(np.float32)
    return places


def silhouettes(vectors: Any, labels: Any) -> Values:
    """Silhouettes (n,) of vectors (n, d) by their labels (n,): 1 far from other labels, 0 mixed, -1 among others.

    Raises
    ------
    UsageError
        Fewer than two labels, as many labels as vectors, NaN, or scikit-learn is not installed.
    """
    points, names = _vectors(vectors, "vectors", least=3), np.asarray(labels)
    count = len(np.unique(names))
    if names.shape != (len(points),) or not 2 <= count < len(points):
        raise UsageError(f"{len(points)} vectors with {count} labels", "two labels or more, some vectors of each", "")
    need_packages("an embedding", "sklearn")
    from sklearn.metrics import silhouette_samples

    return np.asarray(silhouette_samples(points, names), np.float64)


def silhouette(ours: Any, theirs: Any) -> Values:
    """Silhouettes (n,) of the first set (n, d) against the second (m, d): 0 is mixed, 1 apart."""
    first, second = _two_sets(ours, theirs)
    labels = np.repeat([0, 1], [len(first), len(second)])
    return silhouettes(np.concatenate([first, second]), labels)[: len(first)]


def knn_mixing(ours: Any, theirs: Any) -> Values:
    """Share (n,) of vectors of the second set among the ten nearest, over that by chance: 1 is mixed, 0 apart."""
    from scipy.spatial import cKDTree

    first, second = _two_sets(ours, theirs)
    whole = np.concatenate([first, second])
    count = min(NEIGHBOURS, len(whole) - 1)
    _, nearest = cKDTree(whole).query(first, k=count + 1)
    # the vector itself is among them; where equal vectors hide it, the last one stands for it
    is_self = nearest == np.arange(len(first))[:, None]
    is_self[~is_self.any(axis=1), -1] = True
    is_foreign = (nearest >= len(first)) & ~is_self
    by_chance = len(second) / (len(whole) - 1)
    return is_foreign.sum(axis=1) / count / by_chance


def mmd(ours: Any, theirs: Any) -> Values:
    """Parts (n,) of the squared maximum mean discrepancy; their mean is its unbiased estimate, 0 for one distribution.

    The kernel is a Gaussian, as wide as the median distance between all vectors.
    """
    from scipy.spatial.distance import cdist

    first, second = _two_sets(ours, theirs)
    whole = np.concatenate([first, second])
    distance = cdist(whole, whole)
    width = np.median(distance[np.triu_indices(len(whole), 1)])
    kernel = np.exp(-0.5 * np.square(distance / max(float(width), 1e-12)))
    n, m = len(first), len(second)
    within = (kernel[:n, :n].sum(axis=1) - 1) / (n - 1)
    among = (kernel[n:, n:].sum() - m) / (m * (m - 1))
    return within - 2 * kernel[:n, n:].mean(axis=1) + among


def _two_sets(ours: Any, theirs: Any) -> tuple[Values, Values]:
    """Return two sets of vectors of one length as arrays, or refuse them."""
    first, second = _vectors(ours, "the first set", least=2), _vectors(theirs, "the second set", least=2)
    if first.shape[1] != second.shape[1]:
        raise UsageError(f"vectors of {first.shape[1]} and of {second.shape[1]} components", "one latent space", "")
    return first, second


def _vectors(values: Any, what: str, least: int) -> Values:
    """Return vectors (n, d) as float64, or refuse fewer than ``least``, or some that are not finite."""
    points = np.asarray(values, np.float64)
    if points.ndim != 2 or len(points) < least or not np.isfinite(points).all():
        raise UsageError(f"{what} of shape {points.shape}", f"at least {least} finite vectors (n, d)", "")
    return points


EMBEDDING = metric(
    "embedding",
    "how well two sets of latent vectors mix",
    "latent sets",
    [
        Score("silhouette", "silhouette", "", "lower", 0.0, silhouette),
        Score("knn_mixing", "kNN mixing", "", "higher", 1.0, knn_mixing),
        Score("mmd", "MMD²", "", "lower", 0.0, mmd),
    ],
)
