"""Metrics and their scores, each with its unit and best value, and the checks of the samples that they take."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from tactiledata.errors import UsageError

Values = NDArray[np.float64]
"""Values (n,) of a score for n samples."""
Subject = Literal["images", "changes", "meshes", "forces", "image sets", "latent sets"]
"""What a metric takes; see `Metric`."""


@dataclass(frozen=True)
class Score:
    """One number for each sample, with its unit and its best value.

    Parameters
    ----------
    name : str
        Name in tables and recipes.
    title : str
        Name for people, without the unit.
    unit : str
        Unit of the values; empty where they have none.
    better : "higher", "lower" or "nearest"
        Which values are better; nearest are those that lie close to the best one, on either side.
    best : float
        Value of a prediction that equals the truth.
    compute : callable
        ``compute(predicted, true, mask=None)`` gives (n,) values for n samples; a mask (n, H, W) bool restricts
        pictures to their contact. A sample with an empty mask is NaN. For two sets (``image sets``,
        ``latent sets``) there is a value for each member of the first set.
    """

    name: str
    title: str
    unit: str
    better: Literal["higher", "lower", "nearest"]
    best: float
    compute: Callable[..., Values]

    def __call__(self, predicted: Any, true: Any, mask: Any = None) -> Values:
        """Return the values (n,), float64, of n samples.

        Parameters
        ----------
        predicted, true : arrays
            Samples as the metric takes them, or two sets.
        mask : (n, H, W) bool, optional
            Restricts pictures to their contact.
        """
        return self.compute(predicted, true) if mask is None else self.compute(predicted, true, mask)


@dataclass(frozen=True)
class Metric:
    """A member of the family: scores of the same kind of sample.

    Parameters
    ----------
    name : str
        Name in the table.
    title : str
        Description in a few words.
    takes : str
        What the two batches are: ``images`` (n, H, W, 3) uint8, ``changes`` (n, H, W, 3) grey levels against a
        background, ``meshes`` (n, V, 3) m, ``forces`` (n, 3) N, or two sets of any sizes, ``image sets``
        (n, H, W, 3) uint8 and ``latent sets`` (n, d).
    scores : dict, name -> Score
        Scores by their names.
    """

    name: str
    title: str
    takes: Subject
    scores: Mapping[str, Score]


def metric(name: str, title: str, takes: Subject, scores: Sequence[Score]) -> Metric:
    """Return a metric that holds scores by their names.

    Parameters
    ----------
    name, title, takes : str
        As in `Metric`.
    scores : list of Score
        Scores, in the order in which tables show them.
    """
    return Metric(name, title, takes, {score.name: score for score in scores})


def images(values: Any, what: str) -> NDArray[np.uint8]:
    """Return a batch of pictures as an array, or refuse it; ``what`` names it in the message.

    Raises
    ------
    UsageError
        Values that are not (n, H, W, 3) uint8.
    """
    batch = np.asarray(values)
    if batch.ndim != 4 or batch.shape[3] != 3 or batch.dtype != np.uint8:
        raise UsageError(f"{what} of shape {batch.shape}, {batch.dtype}", "pictures (n, H, W, 3) uint8 RGB", "")
    return batch


def image_pairs(
    predicted: Any, true: Any, mask: Any
) -> tuple[NDArray[np.uint8], NDArray[np.uint8], NDArray[np.bool_] | None]:
    """Return two batches of pictures and their masks as arrays, or refuse them.

    Parameters
    ----------
    predicted, true : (n, H, W, 3) uint8
        Pictures, pair by pair.
    mask : (n, H, W) bool, optional
        Masks of the pairs; None stays None.

    Raises
    ------
    UsageError
        Shapes that differ, another type, or a mask of another shape.
    """
    ours, theirs = images(predicted, "predicted"), images(true, "true")
    if ours.shape != theirs.shape:
        raise UsageError(
            f"predicted pictures of shape {ours.shape} beside true ones of {theirs.shape}", "one shape for both", ""
        )
    return ours, theirs, image_masks(mask, ours)


def image_masks(mask: Any, pictures: NDArray[np.uint8]) -> NDArray[np.bool_] | None:
    """Return the masks (n, H, W) of pictures as an array, or refuse them; None stays None.

    Raises
    ------
    UsageError
        Masks that are not bool, or of another shape than the pictures.
    """
    if mask is None:
        return None
    inside = np.asarray(mask)
    if inside.shape != pictures.shape[:3] or inside.dtype != np.bool_:
        raise UsageError(f"a mask of shape {inside.shape}, {inside.dtype}", f"{pictures.shape[:3]} bool", "")
    return inside


def number_pairs(predicted: Any, true: Any, axes: tuple[str, ...]) -> tuple[Values, Values]:
    """Return two batches of vectors of one shape as float64 arrays, or refuse them.

    Parameters
    ----------
    predicted, true : (..., 3)
        Vectors, sample by sample.
    axes : tuple of str
        Names of the axes, as messages show them; the last one has three components.

    Raises
    ------
    UsageError
        Another number of axes, shapes that differ, or values that are not finite.
    """
    ours, theirs = np.asarray(predicted, np.float64), np.asarray(true, np.float64)
    if ours.shape != theirs.shape or ours.ndim != len(axes) or ours.shape[-1] != 3:
        raise UsageError(f"predicted {ours.shape} beside true {theirs.shape}", f"both ({', '.join(axes)})", "")
    for what, values in (("predicted", ours), ("true", theirs)):
        if not np.isfinite(values).all():
            row = int(np.nonzero(~np.isfinite(values.reshape(len(values), -1)).all(axis=1))[0][0])
            raise UsageError(f"{what} holds NaN or infinity, first in sample {row}", "finite numbers", "Leave it out.")
    return ours, theirs
