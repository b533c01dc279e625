"""Where networks run, and in which precision."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from dataclasses import dataclass

import torch
from torch import distributed

from tactiledata.errors import UnknownName, UsageError

DEVICES = ("cpu", "cuda")


def find_device(name: str) -> torch.device:
    """The device of this process: of several, that of its local rank.

    Raises
    ------
    UnknownName, UsageError
        Neither cpu nor cuda; cuda where there is none.
    """
    if name not in DEVICES:
        raise UnknownName("device", name, DEVICES)
    if name == "cpu":
        return torch.device("cpu")
    if not torch.cuda.is_available():
        build = "this build of PyTorch has no CUDA" if torch.version.cuda is None else "PyTorch sees no GPU"
        raise UsageError(
            f"--device cuda, and {build} (torch {torch.__version__})",
            "a GPU that PyTorch can use",
            "Say --device cpu, or install a CUDA build of PyTorch on a machine with a GPU.",
        )
    number = int(os.environ.get("LOCAL_RANK", "0"))
    if number >= torch.cuda.device_count():
        raise UsageError(
            f"process {number} on a machine with {torch.cuda.device_count()} GPUs",
            "a GPU for each process",
            "Start fewer with torchrun --nproc-per-node.",
        )
    return torch.device("cuda", number)


def uses_bfloat16(device: torch.device, convolves: bool) -> bool:
    """Whether learning in bfloat16 helps: on a GPU that knows it; on a CPU that multiplies in it, convolutions do.

    Parameters
    ----------
    device : torch.device
    convolves : bool
        Whether most of the work is convolutions of pictures.
    """
    if device.type == "cuda":
        return torch.cuda.is_bf16_supported()
    knows = torch.cpu.get_capabilities()
    return convolves and bool(knows.get("avx512_bf16") or knows.get("amx_bf16"))


@dataclass(frozen=True)
class Ranks:
    """Which of how many processes this is."""

    rank: int = 0
    world: int = 1

    @property
    def is_first(self) -> bool:
        """Whether it is the one that writes files and tells people."""
        return self.rank == 0

    def wait(self) -> None:
        """Go on when all have come here."""
        if self.world > 1:
            distributed.barrier()


@contextlib.contextmanager
def processes(device: torch.device) -> Iterator[Ranks]:
    """The processes that `torchrun` started together, or this one alone."""
    if int(os.environ.get("WORLD_SIZE", "1")) < 2:
        yield Ranks()
        return
    if distributed.is_initialized():
        yield Ranks(distributed.get_rank(), distributed.get_world_size())
        return
    if device.type == "cuda":
        torch.cuda.set_device(device)
    distributed.init_process_group("nccl" if device.type == "cuda" else "gloo")
    try:
        yield Ranks(distributed.get_rank(), distributed.get_world_size())
    finally:
        distributed.destroy_process_group()
