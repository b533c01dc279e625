"""The device that networks run on, their precision, and the processes that share a training."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from dataclasses import dataclass

import torch
from torch import distributed

from tactiledata.errors import UnknownName, UsageError

DEVICES = ("cpu", "cuda")
"""Values of the option ``--device``."""


def find_device(name: str) -> torch.device:
    """The device of this process; with several processes, the GPU of its local rank.

    Raises
    ------
    UnknownName
        The name is neither cpu nor cuda.
    UsageError
        PyTorch has no GPU, or fewer GPUs than there are processes.
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
    """Whether training in bfloat16 is faster: on a GPU that supports it, and for convolutions on a CPU that does.

    Parameters
    ----------
    device : torch.device
    convolves : bool
        Whether most of the work is convolutions of pictures.
    """
    if device.type == "cuda":
        return torch.cuda.is_bf16_supported()
    capabilities = torch.cpu.get_capabilities()
    return convolves and bool(capabilities.get("avx512_bf16") or capabilities.get("amx_bf16"))


@dataclass(frozen=True)
class Ranks:
    """Number of this process among the processes that train together.

    Parameters
    ----------
    rank : int
        Number of this process, from 0.
    world : int
        Number of processes.
    """

    rank: int = 0
    world: int = 1

    @property
    def is_first(self) -> bool:
        """Whether this process is the one that writes files and reports progress."""
        return self.rank == 0

    def wait(self) -> None:
        """Wait until all processes have called this method."""
        if self.world > 1:
            distributed.barrier()


@contextlib.contextmanager
def processes(device: torch.device) -> Iterator[Ranks]:
    """Number of this process among those that `torchrun` started together; one process without it."""
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
