"""NaN and infinity in training, named before hours are spent on them."""

from __future__ import annotations

import math
from collections.abc import Mapping

from torch import Tensor

from split_models.learning.items import Batch, Items
from tactiledata.errors import NotFinite


def require_finite_batch(batch: Batch, numbers: list[int], items: Items) -> None:
    """Refuse a batch with numbers that are none.

    Raises
    ------
    NotFinite
        The message names frames.
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
    """Refuse a loss that is no number.

    Raises
    ------
    NotFinite
        The message names the epoch and the batch.
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
    """Refuse a validation loss that is no number.

    Raises
    ------
    NotFinite
        The message names the epoch.
    """
    if not math.isfinite(checked["loss"]):
        raise NotFinite(
            f"the validation loss of the {network} is {checked['loss']} after epoch {epoch}",
            "a number",
            "`tactiledata check` looks for damage; else lower the learning rate.",
            epoch=epoch,
        )
