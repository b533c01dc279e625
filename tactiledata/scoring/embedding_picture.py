"""t-SNE of the latent vectors of sensors' touches, drawn: a picture for people, whose distances mean nothing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tactiledata.errors import UsageError
from tactiledata.metrics.embedding import tsne
from tactiledata.scoring.sensor_pairs import Encode, load_touches
from tactiledata.scoring.sensor_sets import SensorSet
from tactiledata.store.read.reader import Store


def embed_sets(
    store: Store, sets: Sequence[SensorSet], encode: Encode, seed: int = 0
) -> dict[str, dict[str, NDArray[np.float32]]]:
    """Return places (n, 2) of the touches of each set on a plane, by kind of vector and set.

    Sets with such vectors share one plane.

    Pictures of one set are in memory at once.
    """
    return embed_vectors({one.name: load_touches(store, one, encode).vectors for one in sets}, seed)


def embed_vectors(
    vectors: Mapping[str, Mapping[str, NDArray[np.floating]]], seed: int = 0
) -> dict[str, dict[str, NDArray[np.float32]]]:
    """Return places (n, 2) on a plane of vectors (n, d) that are given by set and by kind."""
    kinds = list(dict.fromkeys(kind for found in vectors.values() for kind in found))
    drawn = {}
    for kind in kinds:
        those = {name: found[kind] for name, found in vectors.items() if kind in found}
        places = tsne(np.concatenate(list(those.values())), seed=seed)
        stops = np.cumsum([len(one) for one in those.values()])[:-1]
        drawn[kind] = dict(zip(those, np.split(places, stops), strict=True))
    return drawn


def draw_embedding(
    drawn: Mapping[str, Mapping[str, NDArray[np.float32]]],
    path: Path,
    kinds: Mapping[str, str] | None = None,
    heading: str = "",
) -> Path:
    """A PNG with a panel for each kind of vector, a colour for each set.

    Parameters
    ----------
    drawn : dict, kind of vector -> set -> (n, 2)
    path : Path
    kinds : dict, set -> str, optional
        What the pictures of a set are, for the legend.
    heading : str
        Above all panels: what kind of recordings the sets are of; empty for none.

    Raises
    ------
    UsageError
        matplotlib is not installed.
    """
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    except ImportError as error:
        raise UsageError(
            "t-SNE is drawn by matplotlib, which is not installed", "", "pip install -c constraints.txt -e '.[report]'"
        ) from error
    figure = Figure(figsize=(5.2 * len(drawn), 5.6), layout="constrained")
    FigureCanvasAgg(figure)
    for axes, (kind, sets) in zip(np.atleast_1d(figure.subplots(1, len(drawn))), drawn.items(), strict=True):
        for name, places in sets.items():
            axes.scatter(places[:, 0], places[:, 1], s=9, alpha=0.7, label=f"{name} ({kinds[name]})" if kinds else name)
        axes.set(title=f"t-SNE of {kind}", xticks=[], yticks=[])
        axes.legend(fontsize="small", loc="upper center", bbox_to_anchor=(0.5, -0.01))
    if heading:
        figure.suptitle(heading, fontsize=10)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110)
    return path
