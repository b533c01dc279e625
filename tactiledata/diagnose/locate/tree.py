"""A tree of conditions, grown on half of the trajectories and believed only as far as the other half agrees.

Athey and Imbens (2016): what chooses the leaves must not measure them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.residuals.learners import need_learning_library
from tactiledata.diagnose.residuals.projection import ProjectedResiduals
from tactiledata.diagnose.residuals.residuals import Residuals
from tactiledata.diagnose.residuals.scores import Contributions
from tactiledata.diagnose.residuals.sign_flips import DRAWS, family_wise, signs
from tactiledata.diagnose.residuals.wording import p_words, quantity, with_interval

DEPTH = 3
SMALLEST = 0.05
"""Share of the frames that a leaf must hold."""
FEWEST_IN_HALF = 8


@dataclass(frozen=True)
class Leaf:
    """A leaf that the second half confirms.

    Parameters
    ----------
    conditions : str
    component : str
    effect, half_width : float
        Mean residual in the second half, times the noise, with its 95 % interval.
    p : float
        For all leaves and components together.
    words : str
    """

    conditions: str
    component: str
    effect: float
    half_width: float
    p: float
    words: str


def honest_tree(projection: ProjectedResiduals, seed: int = 0, draws: int = DRAWS) -> tuple[Leaf, ...]:
    """Leaves whose mean residual is not 0, the most certain first; none with fewer than 16 units of exchange."""
    residuals = projection.residuals
    units = residuals.unit_count
    names = list(residuals.covariates)
    if units < 2 * FEWEST_IN_HALF or not names:
        return ()
    need_learning_library()
    from sklearn.tree import DecisionTreeRegressor

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
    leaf = tree.apply(features)
    kept = [node for node in np.unique(leaf) if node != 0]
    if not kept:
        return ()
    columns = [(node, k) for node in kept for k in range(len(residuals.components))]
    in_leaf = (leaf[:, None] == np.array(kept)) & ~in_first[:, None]
    sums = residuals.by_unit(np.einsum("nl,nk->nlk", in_leaf.astype(float), projection.score))
    sums = sums.reshape(units, -1)[~is_first]
    counts = np.repeat(residuals.by_unit(in_leaf.astype(float))[~is_first], len(residuals.components), axis=1)
    found = Contributions(sums, counts)
    enough = found.is_testable
    p_values = family_wise(np.abs(found.statistic), np.abs(found.flipped(signs(len(sums), draws, seed))))
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
        if enough[place]
    ]
    return tuple(sorted(leaves, key=lambda one: (one.p, -abs(one.effect))))


def _leaf(conditions: str, component: str, scale: str, sums: Array, counts: Array, p: float) -> Leaf:
    effect = float(sums.sum() / counts.sum())
    misfit = sums - effect * counts
    half_width = 2.0 * float(np.sqrt((misfit**2).sum()) / counts.sum())
    said = with_interval(effect, half_width, scale)
    return Leaf(conditions, component, effect, half_width, p, f"where {conditions}: {component} {said} ({p_words(p)})")


def _labels(residuals: Residuals) -> tuple[list[tuple[str, str]], Array]:
    """Levels of the labels as features of 0 and 1."""
    listed, columns = [], [np.zeros((len(residuals.values), 0))]
    for label, texts in residuals.labels.items():
        for level in np.unique(texts)[:12]:
            listed.append((label, str(level)))
            columns.append((texts == level).astype(np.float64)[:, None])
    return listed, np.concatenate(columns, axis=1)


def _paths(tree: object, features: list[str | tuple[str, str]], residuals: Residuals) -> dict[int, str]:
    """The conditions that lead to each leaf, in words; of two on one covariate the narrower."""
    left, right = tree.children_left, tree.children_right  # type: ignore[attr-defined]
    paths: dict[int, str] = {}
    open_nodes: list[tuple[int, dict[tuple[object, str], str]]] = [(0, {})]
    while open_nodes:
        node, path = open_nodes.pop()
        if left[node] < 0:
            paths[node] = " and ".join(path.values()) or "everywhere"
            continue
        feature = features[tree.feature[node]]  # type: ignore[attr-defined]
        at = float(tree.threshold[node])  # type: ignore[attr-defined]
        for child, side in ((left[node], "below"), (right[node], "above")):
            if isinstance(feature, tuple):
                said = f"{feature[0]} is {'not ' if side == 'below' else ''}{feature[1]}"
            else:
                said = f"{feature} {side} {quantity(at, residuals.covariates[feature].unit)}"
            open_nodes.append((int(child), {**path, (feature, side): said}))
    return paths
