"""A picture of the latent vectors of the touches of sensors, by t-SNE; distances in it have no meaning."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tactiledata.contract.extras import missing_package
from tactiledata.metrics.embedding import tsne
from tactiledata.scoring.sensor_pairs import Encode, load_touches
from tactiledata.scoring.sensor_sets import SensorSet
from tactiledata.store.read.reader import Store


def embed_sets(
    store: Store, sets: Sequence[SensorSet], encode: Encode, seed: int = 0
) -> dict[str, dict[str, NDArray[np.float32]]]:
    """Return places (n, 2) of the touches of each set on a plane, by kind of vector and set.

    All sets that have vectors of a kind share one plane. The pictures of one set are in memory at a time.

    Parameters
    ----------
    store : Store
        The store of the sets.
    sets : list of SensorSet
        Sets of touches.
    encode : callable
        Gives latent vectors by kind; see `tactiledata.scoring.sensor_pairs.Encode`.
    seed : int
        Seed of t-SNE.
    """
    vectors = {sensor_set.name: load_touches(store, sensor_set, encode).vectors for sensor_set in sets}
    return embed_vectors(vectors, seed)


def embed_vectors(
    vectors: Mapping[str, Mapping[str, NDArray[np.floating]]], seed: int = 0
) -> dict[str, dict[str, NDArray[np.float32]]]:
    """Return places (n, 2) on a plane, by kind and set, of vectors (n, d) that are given by set and kind.

    ``seed`` is that of t-SNE.
    """
    kinds = list(dict.fromkeys(kind for by_kind in vectors.values() for kind in by_kind))
    drawn = {}
    for kind in kinds:
        by_set = {name: by_kind[kind] for name, by_kind in vectors.items() if kind in by_kind}
        places = tsne(np.concatenate(list(by_set.values())), seed=seed)
        stops = np.cumsum([len(points) for points in by_set.values()])[:-1]
        drawn[kind] = dict(zip(by_set, np.split(places, stops), strict=True))
    return drawn


def draw_embedding(
    drawn: Mapping[str, Mapping[str, NDArray[np.float32]]],
    path: Path,
    kinds: Mapping[str, str] | None = None,
    heading: str = "",
) -> Path:
    """Write a PNG with a panel for each kind of vector and a colour for each set; return its path.

    Parameters
    ----------
    drawn : dict, kind of vector -> set -> (n, 2)
        Places of the touches.
    path : Path
        File to write; its folder is made.
    kinds : dict, set -> str, optional
        What the pictures of each set are, for the legend.
    heading : str
        Text above all panels, such as what kind of recordings the sets are of; empty for none.

    Raises
    ------
    UsageError
        matplotlib is not installed.
    """
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    except ImportError as error:
        raise missing_package("matplotlib", "a picture of t-SNE") from error
    # a panel for each kind of vector, its legend below it
    figure = Figure(figsize=(5.2 * len(drawn), 5.6), layout="constrained")
    FigureCanvasAgg(figure)
    for axes, (kind, sets) in zip(np.atleast_1d(figure.subplots(1, len(drawn))), drawn.items(), strict=True):
        for position, (name, places) in enumerate(sets.items()):
            # of points in one place the larger lie below: a set that another covers is still seen
            size, label = 9 + 12 * (len(sets) - 1 - position), f"{name} ({kinds[name]})" if kinds else name
            axes.scatter(places[:, 0], places[:, 1], s=size, alpha=0.7, label=label, linewidths=0)
        axes.set(title=f"t-SNE of {kind}", xticks=[], yticks=[])
        axes.legend(fontsize="small", loc="upper center", bbox_to_anchor=(0.5, -0.01))
    if heading:
        figure.suptitle(heading, fontsize=10)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110, metadata={"Software": "tactiledata"})
    return path
