"""Metrics: how far is a prediction from the truth, or one set of pictures from another?

A metric is one file and one line in the table below. Read in this order:

- ``base``: what a metric is, its scores with unit and best value, and the checks of what it takes.
- ``image_similarity``, ``mesh_distance``, ``force_error``: pairs of a prediction and the truth.
- ``kept_touch``: pairs of what a touch changes, before and after a transfer.
- ``histogram``, ``gram_style``, ``embedding``: two sets without pairs.
- ``bootstrap``: intervals of scores, over trajectories.

A metric takes arrays and gives a value for every sample; it knows nothing of stores, splits or models.
"""

from __future__ import annotations

from tactiledata.registry import Registry

METRICS = Registry(
    "metric",
    {
        "image_similarity": "tactiledata.metrics.image_similarity:IMAGE_SIMILARITY",
        "kept_touch": "tactiledata.metrics.kept_touch:KEPT_TOUCH",
        "mesh_distance": "tactiledata.metrics.mesh_distance:MESH_DISTANCE",
        "force_error": "tactiledata.metrics.force_error:FORCE_ERROR",
        "histogram": "tactiledata.metrics.histogram:HISTOGRAM",
        "gram_style": "tactiledata.metrics.gram_style:GRAM_STYLE",
        "embedding": "tactiledata.metrics.embedding:EMBEDDING",
    },
    group="tactiledata.metrics",
)
"""Metrics by name; each has one or several scores."""
