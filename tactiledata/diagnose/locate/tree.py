"""An honest regression tree of the residual: grown on one half of the trajectories, tested on the other half.

The data that choose the leaves must not measure them (Athey and Imbens 2016).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array
from tactiledata.contract.extras import need_packages
from tactiledata.diagnose.locate.base import Locator, LocatorInput
from tactiledata.diagnose.residuals.projection import ProjectedResiduals
from tactiledata.diagnose.residuals.residuals import Residuals
from tactiledata.diagnose.residuals.scores import Contributions
from tactiledata.diagnose.residuals.sign_flips import DRAWS, family_wise, signs
from tactiledata.diagnose.residuals.wording import p_words, quantity, with_interval

DEPTH = 3
"""Most conditions that lead to a leaf."""
SMALLEST = 0.05
"""Least share of the first half's frames in a leaf."""
FEWEST_IN_HALF = 8
"""Fewest units of exchange in each half."""
MOST_LABEL_LEVELS = 12
"""Most levels of a label that become features; further ones, in alphabetical order, are ignored."""


@dataclass(frozen=True)
class Leaf:
    """The mean residual of one component in one leaf of the tree, measured on the second half.

    Parameters
    ----------
    conditions : str
        Conditions that lead to the leaf, in words.
    component : str
        Name of the component.
    effect, half_width : float
        Mean residual in the second half and half width of its interval (two standard errors), in the unit
        that `Residuals.scale` names.
    p : float
        Family-wise p-value over all leaves and components.
    words : str
        The leaf as a clause.
    """

    conditions: str
    component: str
    effect: float
    half_width: float
    p: float
    words: str


def honest_tree(projection: ProjectedResiduals, seed: int = 0, draws: int = DRAWS) -> tuple[Leaf, ...]:
    """Return all testable leaves and components with their mean residual, the most certain first.

    With fewer than 16 units of exchange, or without covariates, there are none.

    Parameters
    ----------
    projection : ProjectedResiduals
        Residuals after the refit.
    seed : int
        Random seed of the halves, of the tree and of the sign flips.
    draws : int
        Number of sign flips.

    Raises
    ------
    TactileDataError
        scikit-learn is not installed.
    """
    residuals = projection.residuals
    units = residuals.unit_count
    names = list(residuals.covariates)
    if units < 2 * FEWEST_IN_HALF or not names:
        return ()
    need_packages("a diagnosis", "sklearn")
    from sklearn.tree import DecisionTreeRegressor

    # grow the tree on a random half of the units
    rng = np.random.default_rng(seed)
    is_first = np.zeros(units, dtype=bool)
    is_first[rng.permutation(units)[: units // 2]] = True
    in_first = is_first[residuals.unit_of_trajectory][residuals.trajectory]
    features = np.column_stack([residuals.covariates[name].values for name in names])
    labelled, label_features = _labels(residuals)
    features = np.column_stack([features, label_features])
    tree = DecisionTreeRegressor(
        max_depth=DEPTH, min_samples_leaf=max(1, int(SMALLEST * in_first.sum())), random_state=seed
    )
    tree.fit(features[in_first], projection.score[in_first])
    # node 0 is a leaf only where the tree has no condition
    leaf = tree.apply(features)
    leaf_nodes = [node for node in np.unique(leaf) if node != 0]
    if not leaf_nodes:
        return ()
    # test the mean residual of each leaf and component on the other half
    columns = [(node, k) for node in leaf_nodes for k in range(len(residuals.components))]
    in_leaf = (leaf[:, None] == np.array(leaf_nodes)) & ~in_first[:, None]
    sums = residuals.by_unit(np.einsum("nl,nk->nlk", in_leaf.astype(float), projection.score))
    sums = sums.reshape(units, -1)[~is_first]
    counts = np.repeat(residuals.by_unit(in_leaf.astype(float))[~is_first], len(residuals.components), axis=1)
    scores = Contributions(sums, counts)
    is_testable = scores.is_testable
    p_values = family_wise(np.abs(scores.statistic), np.abs(scores.flipped(signs(len(sums), draws, seed))))
    paths = _paths(tree.tree_, [*names, *labelled], residuals)
    leaves = [
        _leaf(
            paths[node],
            residuals.components[k],
            residuals.scale,
            sums[:, place],
            counts[:, place],
            float(p_values[place]),
        )
        for place, (node, k) in enumerate(columns)
        if is_testable[place]
    ]
    return tuple(sorted(leaves, key=lambda finding: (finding.p, -abs(finding.effect))))


def _leaf(conditions: str, component: str, scale: str, sums: Array, counts: Array, p: float) -> Leaf:
    """Return one leaf and component, with the mean residual and its interval.

    Parameters
    ----------
    conditions, component : str
        Conditions of the leaf in words, and name of the component.
    scale : str
        What the residual is a multiple of, in words.
    sums, counts : (u,)
        Sum of the residual and number of frames in the leaf, for each unit of the second half.
    p : float
        Family-wise p-value.
    """
    effect = float(sums.sum() / counts.sum())
    misfit = sums - effect * counts
    half_width = 2.0 * float(np.sqrt((misfit**2).sum()) / counts.sum())
    size = with_interval(effect, half_width, scale)
    return Leaf(conditions, component, effect, half_width, p, f"where {conditions}: {component} {size} ({p_words(p)})")


def _labels(residuals: Residuals) -> tuple[list[tuple[str, str]], Array]:
    """Return names (label, level) and indicator features (n, f) of the labels' levels."""
    listed, columns = [], [np.zeros((len(residuals.values), 0))]
    for label, texts in residuals.labels.items():
        for level in np.unique(texts)[:MOST_LABEL_LEVELS]:
            listed.append((label, str(level)))
            columns.append((texts == level).astype(np.float64)[:, None])
    return listed, np.concatenate(columns, axis=1)


def _paths(tree: object, features: list[str | tuple[str, str]], residuals: Residuals) -> dict[int, str]:
    """Return conditions that lead to each leaf node, in words; of two on the same side of a covariate the narrower one.

    Parameters
    ----------
    tree : sklearn.tree.Tree
        The fitted tree.
    features : list of str or (label, level)
        Name of each feature.
    residuals : Residuals
        Units of the covariates.
    """
    left, right = tree.children_left, tree.children_right  # type: ignore[attr-defined]
    paths: dict[int, str] = {}
    open_nodes: list[tuple[int, dict[tuple[object, str], str]]] = [(0, {})]
    while open_nodes:
        node, path = open_nodes.pop()
        if left[node] < 0:
            paths[node] = " and ".join(path.values()) or "everywhere"
            continue
        feature = features[tree.feature[node]]  # type: ignore[attr-defined]
        threshold = float(tree.threshold[node])  # type: ignore[attr-defined]
        for child, side in ((left[node], "below"), (right[node], "above")):
            if isinstance(feature, tuple):
                condition = f"{feature[0]} is {'not ' if side == 'below' else ''}{feature[1]}"
            else:
                condition = f"{feature} {side} {quantity(threshold, residuals.covariates[feature].unit)}"
            open_nodes.append((int(child), {**path, (feature, side): condition}))
    return paths


def _find(given: LocatorInput) -> tuple[Leaf, ...] | None:
    """Return the leaves of a tree over all covariates and labels; ``None`` where no tree can be grown."""
    return honest_tree(given.projection, given.seed + 6, given.draws) or None


LOCATOR = Locator("the tree", _find, lambda leaf: {"component": leaf.component})
