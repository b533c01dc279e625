"""Scores of methods over whole parts of a split: a value for every frame, and intervals over trajectories."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from split_models.learning.contact_region import contact_region
from split_models.learning.data import TouchFrames
from split_models.methods.methods import ImageToMesh, MeshToImage, for_sensor
from tactiledata.errors import NotFinite
from tactiledata.metrics.base import Score
from tactiledata.metrics.bootstrap import bootstrap
from tactiledata.metrics.image_similarity import IMAGE_SIMILARITY
from tactiledata.metrics.mesh_distance import MESH_DISTANCE

Values = dict[str, NDArray[np.float64]]
CHUNK = 64
MASKED = "_contact"
"""Added to a score's name: inside the contact region only."""


def image_values(method: MeshToImage, frames: TouchFrames, scores: Sequence[str]) -> Values:
    """Scores (n,) of a method's pictures of all frames, of the full frame and, under ``<name>_contact``, inside the
    region in which the true picture shows the touch.
    """
    chosen = {name: IMAGE_SIMILARITY.scores[name] for name in scores}
    values = _empty(frames, [*chosen, *(f"{name}{MASKED}" for name in chosen)])
    for sensor, numbers in of_each_sensor(frames):
        background = frames.background(sensor)
        true = frames.pictures(numbers)
        found = for_sensor(method, sensor).predict(frames.displacements(numbers), background)
        region = contact_region(true, background)
        for name, score in chosen.items():
            values[name][numbers] = score(found, true)
            values[f"{name}{MASKED}"][numbers] = score(found, true, region)
    return values


def mesh_values(method: ImageToMesh, frames: TouchFrames, scores: Sequence[str]) -> Values:
    """Scores (n,), mm, of a method's meshes of all frames."""
    chosen = {name: MESH_DISTANCE.scores[name] for name in scores}
    values = _empty(frames, list(chosen))
    for sensor, numbers in of_each_sensor(frames):
        true = frames.displacements(numbers)
        found = for_sensor(method, sensor).predict(frames.pictures(numbers), frames.background(sensor))
        if not np.isfinite(found).all():
            raise NotFinite(f"the meshes of {method.name} for sensor {sensor} hold NaN", "numbers", "Train it again.")
        for name, score in chosen.items():
            values[name][numbers] = score(found, true)
    return values


def of_each_sensor(frames: TouchFrames) -> Iterator[tuple[str, NDArray[np.int64]]]:
    """Sensors with numbers of their frames, at most `CHUNK` together."""
    for sensor in frames.sensor_names:
        mine = np.flatnonzero(frames.sensors == sensor)
        for start in range(0, len(mine), CHUNK):
            yield sensor, mine[start : start + CHUNK]


def summarised(values: Values, trajectories: Any, rounds: int, known: Mapping[str, Score]) -> dict[str, Any]:
    """For each score its mean, the 95 % interval over trajectories, how many frames and trajectories, and its unit."""
    summary: dict[str, Any] = {}
    for name, one in values.items():
        score = known[name.removesuffix(MASKED)]
        judged = {"unit": score.unit, "better": score.better}
        if np.isnan(one).all():
            summary[name] = {"value": None, "low": None, "high": None, "frames": 0, "trajectories": 0, **judged}
            continue
        found = bootstrap(one, trajectories, rounds=rounds)
        summary[name] = {
            "value": _number(found.value),
            "low": _number(found.low),
            "high": _number(found.high),
            "frames": found.samples,
            "trajectories": found.trajectories,
            **judged,
        }
    return summary


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _empty(frames: TouchFrames, names: Sequence[str]) -> Values:
    return {name: np.full(len(frames), np.nan) for name in names}
