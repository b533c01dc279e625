"""The option ``--device``, which all commands that run networks share."""

from __future__ import annotations

import typer

DEVICE = typer.Option("cpu", "--device", help="cpu or cuda: where networks run.")


def require_device(device: str) -> None:
    """Refuse a device that does not exist, before any work is done; PyTorch is imported only for another than the CPU.

    Raises
    ------
    UnknownName
        The name is neither cpu nor cuda.
    UsageError
        PyTorch has no GPU.
    """
    if device == "cpu":
        return
    from split_models.learning.device import find_device

    find_device(device)
