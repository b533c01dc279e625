"""A small training that a test can kill: run as a program it trains in a folder and prints its curve."""

import json
import sys
import time
from pathlib import Path

import torch

from split_models.learning.checkpoint import TrainedOn
from split_models.learning.device import processes
from split_models.learning.items import TensorItems
from split_models.learning.objectives import Regression
from split_models.learning.train import train
from split_models.learning.train_options import TrainOptions
from split_models.networks.projection import Projection

STAMPS = TrainedOn(recipe="r", split="s", items="i")


class SlowItems(TensorItems):
    """Items that take a moment to read, so that a kill comes in the midst of an epoch."""

    pause = 0.0

    def batch(self, numbers):
        time.sleep(self.pause)
        return super().batch(numbers)


def items(count=48, seed=0, pause=0.0):
    generator = torch.Generator().manual_seed(seed)
    given = torch.randn(count, 6, generator=generator)
    found = SlowItems({"given": given, "target": given[:, :3] * 2 + given[:, 3:].square()}, f"{count}-{seed}")
    found.pause = pause
    return found


def objective(dropout=(0.2,), seed=0):
    with torch.random.fork_rng():
        torch.manual_seed(seed)
        return Regression(Projection(6, 3, (16, 16, 3), dropout), "given", "target")


def learn(
    folder, epochs=4, pause=0.0, save_seconds=1e9, dropout=(0.2,), tell=None, schedule="decay", accumulate=1, **changes
):
    options = TrainOptions(
        epochs, batch_size=8, learning_rate=0.01, schedule=schedule, decay=0.99, save_seconds=save_seconds,
        accumulate=accumulate,
    )  # fmt: skip
    arguments = {"stamps": STAMPS, "items": items(pause=pause), "objective": objective(dropout), **changes}
    device = torch.device("cpu")
    with processes(device) as ranks:
        return train(
            arguments["objective"], arguments["items"], items(16, 1), options, Path(folder), arguments["stamps"],
            device, ranks, tell,
        )  # fmt: skip


if __name__ == "__main__":
    torch.set_num_threads(1)
    folder, pause, dropout = sys.argv[1], float(sys.argv[2]), float(sys.argv[3])
    trained = learn(folder, pause=pause, save_seconds=0.0, dropout=(dropout,))
    sys.stdout.write(json.dumps([row["train_loss"] for row in trained.rows]) + "\n")
