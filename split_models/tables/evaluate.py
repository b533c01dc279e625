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
"""Frames that a method gets together."""
MASKED = "_contact"
"""Suffix of a score that counts only the contact region."""


def image_values(method: MeshToImage, frames: TouchFrames, scores: Sequence[str]) -> Values:
    """Scores (n,) of a method's pictures of all frames, by name.

    Each score is of the full frame, and under ``<name>_contact`` of the region in which the true picture shows the
    touch.

    Parameters
    ----------
    method : MeshToImage
    frames : TouchFrames
    scores : sequence of str
        Names in `IMAGE_SIMILARITY`.
    """
    chosen = {name: IMAGE_SIMILARITY.scores[name] for name in scores}
    values = _empty(frames, [*chosen, *(f"{name}{MASKED}" for name in chosen)])
    for sensor, numbers in of_each_sensor(frames):
        background = frames.background(sensor)
        true = frames.pictures(numbers)
        predicted = for_sensor(method, sensor).predict(frames.displacements(numbers), background)
        region = contact_region(true, background)
        for name, score in chosen.items():
            values[name][numbers] = score(predicted, true)
            values[f"{name}{MASKED}"][numbers] = score(predicted, true, region)
    return values


def mesh_values(method: ImageToMesh, frames: TouchFrames, scores: Sequence[str]) -> Values:
    """Scores (n,), mm, of a method's meshes of all frames, by name.

    Parameters
    ----------
    method : ImageToMesh
    frames : TouchFrames
    scores : sequence of str
        Names in `MESH_DISTANCE`.

    Raises
    ------
    NotFinite
        The method's meshes hold NaN.
    """
    chosen = {name: MESH_DISTANCE.scores[name] for name in scores}
    values = _empty(frames, list(chosen))
    for sensor, numbers in of_each_sensor(frames):
        true = frames.displacements(numbers)
        predicted = for_sensor(method, sensor).predict(frames.pictures(numbers), frames.background(sensor))
        if not np.isfinite(predicted).all():
            raise NotFinite(f"the meshes of {method.name} for sensor {sensor} hold NaN", "numbers", "Train it again.")
        for name, score in chosen.items():
            values[name][numbers] = score(predicted, true)
    return values


def of_each_sensor(frames: TouchFrames) -> Iterator[tuple[str, NDArray[np.int64]]]:
    """Yield each sensor with numbers of its frames, at most `CHUNK` at a time."""
    for sensor in frames.sensor_names:
        mine = np.flatnonzero(frames.sensors == sensor)
        for start in range(0, len(mine), CHUNK):
            yield sensor, mine[start : start + CHUNK]


def summarised(values: Values, trajectories: Any, rounds: int, known: Mapping[str, Score]) -> dict[str, Any]:
    """Summary of each score: mean, 95 % interval over trajectories, numbers of frames and trajectories, and unit.

    Parameters
    ----------
    values : dict of (n,)
        Scores of frames by name; NaN is left out.
    trajectories : (n,) str
        Trajectory of each frame; the bootstrap draws whole trajectories.
    rounds : int
        Rounds of the bootstrap.
    known : dict of Score
        Unit and direction of each score by its name without `MASKED`.

    Returns
    -------
    dict
        A dict for each score, as ``schemas`` and pages use it; values are None where every frame is NaN.
    """
    summary: dict[str, Any] = {}
    for name, frame_values in values.items():
        score = known[name.removesuffix(MASKED)]
        facts = {"unit": score.unit, "better": score.better}
        if np.isnan(frame_values).all():
            summary[name] = {"value": None, "low": None, "high": None, "frames": 0, "trajectories": 0, **facts}
            continue
        interval = bootstrap(frame_values, trajectories, rounds=rounds)
        summary[name] = {
            "value": _number(interval.value),
            "low": _number(interval.low),
            "high": _number(interval.high),
            "frames": interval.samples,
            "trajectories": interval.trajectories,
            **facts,
        }
    return summary


def _number(value: float) -> float | None:
    """The value for JSON; None for NaN and infinity."""
    return float(value) if np.isfinite(value) else None


def _empty(frames: TouchFrames, names: Sequence[str]) -> Values:
    """NaN for every score of every frame."""
    return {name: np.full(len(frames), np.nan) for name in names}
