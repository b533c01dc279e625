"""Checks that stop a training at the first NaN or infinity, and name where it occurred."""

from __future__ import annotations

import math
from collections.abc import Mapping

from torch import Tensor

from split_models.learning.items import Batch, Items
from tactiledata.errors import NotFinite


def require_finite_batch(batch: Batch, numbers: list[int], items: Items) -> None:
    """Refuse a batch with NaN or infinity.

    Parameters
    ----------
    batch : dict of Tensor
        Values (n, ...) by name.
    numbers : list of int
        Numbers of the n items.
    items : Items
        Source of the batch, which names an item's frame.

    Raises
    ------
    NotFinite
        A value is NaN or infinite; the message names the first frame.
    """
    for name, values in batch.items():
        if not values.is_floating_point():
            continue
        bad = ~values.flatten(1).isfinite().all(dim=1)
        if bad.any():
            places = [numbers[place] for place in bad.nonzero().flatten().tolist()]
            raise NotFinite(
                f"NaN or infinity in {name!r} of {items.where(places[0])}"
                + (f" and {len(places) - 1} more of its batch" if places[1:] else ""),
                "numbers",
                "`tactiledata check` looks for damage; leave such frames out.",
                items=places,
            )


def require_finite_losses(
    losses: Mapping[str, Tensor], network: str, epoch: int, items: Items, numbers: list[int], learning_rate: float
) -> None:
    """Refuse a loss that is NaN or infinite.

    Parameters
    ----------
    losses : dict of Tensor
        Scalars by name.
    network : str
        The network's kind, for the message.
    epoch : int
        The present epoch, for the message.
    items : Items
        Source of the batch, which names an item's frame.
    numbers : list of int
        Numbers of the batch's items.
    learning_rate : float
        The learning rate, for the message.

    Raises
    ------
    NotFinite
        A loss is NaN or infinite; the message names the epoch and the batch.
    """
    for name, value in losses.items():
        if not bool(value.isfinite()):
            raise NotFinite(
                f"the {name} of the {network} became {value.item()} in epoch {epoch}, at "
                f"{items.where(numbers[0])} and the rest of its batch",
                "a number",
                f"Lower the learning rate ({learning_rate:g}); the checkpoint before is whole.",
                epoch=epoch,
            )


def require_finite_validation(checked: Mapping[str, float], network: str, epoch: int) -> None:
    """Refuse a validation loss that is NaN or infinite.

    Parameters
    ----------
    checked : dict of float
        Validation losses by name; ``loss`` is looked at.
    network : str
        The network's kind, for the message.
    epoch : int
        The present epoch, for the message.

    Raises
    ------
    NotFinite
        The validation loss is NaN or infinite; the message names the epoch.
    """
    if not math.isfinite(checked["loss"]):
        raise NotFinite(
            f"the validation loss of the {network} is {checked['loss']} after epoch {epoch}",
            "a number",
            "`tactiledata check` looks for damage; else lower the learning rate.",
            epoch=epoch,
        )
