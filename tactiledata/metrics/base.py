"""What a metric is: a few scores, each with its unit, its best value, and a value for every sample."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from tactiledata.errors import UsageError

Values = NDArray[np.float64]
Subject = Literal["images", "meshes", "forces", "image sets", "latent sets"]


@dataclass(frozen=True)
class Score:
    """One number by which a sample is judged.

    Parameters
    ----------
    name : str
        As in tables and recipes.
    title : str
        For people, without the unit.
    unit : str
        Empty where it has none.
    better : "higher" or "lower"
    best : float
        Of a prediction that equals the truth.
    compute : callable
        ``compute(predicted, true, mask=None)`` gives (n,) values for n samples; a mask (n, H, W) bool restricts
        pictures to their contact. Where the mask of a sample is empty there is nothing to judge: NaN. Of two sets
        (``image sets``, ``latent sets``), a value for each member of the first set.
    """

    name: str
    title: str
    unit: str
    better: Literal["higher", "lower"]
    best: float
    compute: Callable[..., Values]

    def __call__(self, predicted: Any, true: Any, mask: Any = None) -> Values:
        """Values (n,), float64."""
        return self.compute(predicted, true) if mask is None else self.compute(predicted, true, mask)


@dataclass(frozen=True)
class Metric:
    """A member of the family: scores that look at the same kind of sample.

    ``takes`` says what the two batches are: ``images`` (n, H, W, 3) uint8, ``meshes`` (n, V, 3) m, ``forces`` (n, 3) N,
    or two sets of any sizes, ``image sets`` and ``latent sets`` (n, d).
    """

    name: str
    title: str
    takes: Subject
    scores: Mapping[str, Score]


def metric(name: str, title: str, takes: Subject, scores: Sequence[Score]) -> Metric:
    """A metric of these scores, by their names."""
    return Metric(name, title, takes, {score.name: score for score in scores})


def images(values: Any, what: str) -> NDArray[np.uint8]:
    """A batch of pictures, checked.

    Raises
    ------
    UsageError
        Not (n, H, W, 3) uint8.
    """
    batch = np.asarray(values)
    if batch.ndim != 4 or batch.shape[3] != 3 or batch.dtype != np.uint8:
        raise UsageError(f"{what} of shape {batch.shape}, {batch.dtype}", "pictures (n, H, W, 3) uint8 RGB", "")
    return batch


def image_pairs(
    predicted: Any, true: Any, mask: Any
) -> tuple[NDArray[np.uint8], NDArray[np.uint8], NDArray[np.bool_] | None]:
    """Two batches of pictures of one shape, and their masks.

    Raises
    ------
    UsageError
        Shapes that differ, another type, a mask that does not go with the pictures.
    """
    ours, theirs = images(predicted, "predicted"), images(true, "true")
    if ours.shape != theirs.shape:
        raise UsageError(
            f"predicted pictures of shape {ours.shape} beside true ones of {theirs.shape}", "one shape for both", ""
        )
    return ours, theirs, image_masks(mask, ours)


def image_masks(mask: Any, pictures: NDArray[np.uint8]) -> NDArray[np.bool_] | None:
    """The masks of pictures, checked; None stays None.

    Raises
    ------
    UsageError
        Not bool, or of another shape.
    """
    if mask is None:
        return None
    inside = np.asarray(mask)
    if inside.shape != pictures.shape[:3] or inside.dtype != np.bool_:
        raise UsageError(f"a mask of shape {inside.shape}, {inside.dtype}", f"{pictures.shape[:3]} bool", "")
    return inside


def number_pairs(predicted: Any, true: Any, axes: tuple[str, ...]) -> tuple[Values, Values]:
    """Two batches of numbers of one shape, whose last axis has three components.

    Raises
    ------
    UsageError
        Other shapes, or values that are not finite.
    """
    ours, theirs = np.asarray(predicted, np.float64), np.asarray(true, np.float64)
    if ours.shape != theirs.shape or ours.ndim != len(axes) or ours.shape[-1] != 3:
        raise UsageError(f"predicted {ours.shape} beside true {theirs.shape}", f"both ({', '.join(axes)})", "")
    for what, values in (("predicted", ours), ("true", theirs)):
        if not np.isfinite(values).all():
            row = int(np.nonzero(~np.isfinite(values.reshape(len(values), -1)).all(axis=1))[0][0])
            raise UsageError(f"{what} holds NaN or infinity, first in sample {row}", "finite numbers", "Leave it out.")
    return ours, theirs
