"""How well two sets of latent vectors mix: silhouette, share of foreign neighbours, maximum mean discrepancy; t-SNE."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactiledata.errors import UsageError
from tactiledata.metrics.base import Score, Values, metric

NEIGHBOURS = 10
PERPLEXITY = 30.0


def tsne(vectors: Any, perplexity: float = PERPLEXITY, seed: int = 0) -> NDArray[np.float32]:
    """Places (n, 2) of vectors (n, d) on a plane, by scikit-learn's t-SNE, started from the main directions.

    A picture for people; distances in it are none. For fewer vectors the perplexity is lowered to a third of them.

    Raises
    ------
    UsageError
        Fewer than five vectors, NaN, or scikit-learn is not installed.
    """
    points = _vectors(vectors, "vectors", least=5)
    _need_learning_library()
    from sklearn.manifold import TSNE

    fitted = TSNE(perplexity=min(perplexity, (len(points) - 1) / 3), init="pca", random_state=seed)
    places: NDArray[np.float32] = fitted.fit_transform(points).astype(np.float32)
    return places


def silhouettes(vectors: Any, labels: Any) -> Values:
    """Silhouettes (n,) of vectors (n, d) by their labels: 1 far from all others, 0 mixed, -1 among others.

    Raises
    ------
    UsageError
        Fewer than two labels, NaN, or scikit-learn is not installed.
    """
    points, names = _vectors(vectors, "vectors", least=3), np.asarray(labels)
    count = len(np.unique(names))
    if names.shape != (len(points),) or not 2 <= count < len(points):
        raise UsageError(f"{len(points)} vectors with {count} labels", "two labels or more, some vectors of each", "")
    _need_learning_library()
    from sklearn.metrics import silhouette_samples

    return np.asarray(silhouette_samples(points, names), np.float64)


def silhouette(ours: Any, theirs: Any) -> Values:
    """Silhouettes (n,) of the first set against the second; 0 is mixed, 1 apart."""
    one, other = _two_sets(ours, theirs)
    labels = np.repeat([0, 1], [len(one), len(other)])
    return silhouettes(np.concatenate([one, other]), labels)[: len(one)]


def knn_mixing(ours: Any, theirs: Any) -> Values:
    """Share (n,) of foreign vectors among each one's ten nearest, over what chance gives: 1 is mixed, 0 apart."""
    from scipy.spatial import cKDTree

    one, other = _two_sets(ours, theirs)
    whole = np.concatenate([one, other])
    count = min(NEIGHBOURS, len(whole) - 1)
    _, nearest = cKDTree(whole).query(one, k=count + 1)
    # its own place is among them; where there are doubles of it, any one of them may stand for it
    is_self = nearest == np.arange(len(one))[:, None]
    is_self[~is_self.any(axis=1), -1] = True
    is_foreign = (nearest >= len(one)) & ~is_self
    by_chance = len(other) / (len(whole) - 1)
    return is_foreign.sum(axis=1) / count / by_chance


def mmd(ours: Any, theirs: Any) -> Values:
    """Parts (n,) of the squared maximum mean discrepancy: their mean is its unbiased estimate, 0 for one distribution.

    Gaussian kernel as wide as the median distance between all vectors.
    """
    from scipy.spatial.distance import cdist

    one, other = _two_sets(ours, theirs)
    whole = np.concatenate([one, other])
    distance = cdist(whole, whole)
    width = np.median(distance[np.triu_indices(len(whole), 1)])
    kernel = np.exp(-0.5 * np.square(distance / max(float(width), 1e-12)))
    n, m = len(one), len(other)
    within = (kernel[:n, :n].sum(axis=1) - 1) / (n - 1)
    among = (kernel[n:, n:].sum() - m) / (m * (m - 1))
    return within - 2 * kernel[:n, n:].mean(axis=1) + among


def _two_sets(ours: Any, theirs: Any) -> tuple[Values, Values]:
    one, other = _vectors(ours, "the first set", least=2), _vectors(theirs, "the second set", least=2)
    if one.shape[1] != other.shape[1]:
        raise UsageError(f"vectors of {one.shape[1]} and of {other.shape[1]} components", "one latent space", "")
    return one, other


def _vectors(values: Any, what: str, least: int) -> Values:
    points = np.asarray(values, np.float64)
    if points.ndim != 2 or len(points) < least or not np.isfinite(points).all():
        raise UsageError(f"{what} of shape {points.shape}", f"at least {least} finite vectors (n, d)", "")
    return points


def _need_learning_library() -> None:
    from importlib.util import find_spec

    if find_spec("sklearn") is None:
        raise UsageError(
            "t-SNE and silhouettes need scikit-learn, which is not installed",
            "",
            "pip install -c constraints.txt -e '.[models]'",
        )


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
