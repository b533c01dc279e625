"""Metrics: what a prediction is judged by; one file each, one line each."""

from __future__ import annotations

from tactiledata.registry import Registry

METRICS = Registry(
    "metric",
    {
        "image_similarity": "tactiledata.metrics.image_similarity:IMAGE_SIMILARITY",
        "mesh_distance": "tactiledata.metrics.mesh_distance:MESH_DISTANCE",
        "force_error": "tactiledata.metrics.force_error:FORCE_ERROR",
        "histogram": "tactiledata.metrics.histogram:HISTOGRAM",
        "gram_style": "tactiledata.metrics.gram_style:GRAM_STYLE",
        "embedding": "tactiledata.metrics.embedding:EMBEDDING",
    },
    group="tactiledata.metrics",
)
"""Metrics by name; each holds one or several scores."""
