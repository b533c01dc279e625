"""Models in a folder, named by what shaped them: each is trained once, by whoever asks first."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import torch

from split_models.learning.checkpoint import TrainedOn, load_checkpoint, require_stamps, require_topology
from split_models.learning.device import Ranks
from split_models.learning.items import Items
from split_models.learning.objectives import Objective
from split_models.learning.train import BEST, LAST, train
from split_models.learning.train_options import TrainOptions
from split_models.networks.latent_normal import drawn_alike
from split_models.networks.network import Network
from tactiledata.contract.progress import Progress
from tactiledata.contract.provenance import digest_of
from tactiledata.errors import UsageError

Build = Callable[[], tuple[Objective, Items, Items]]
"""What gives a network to train, its items and those to validate on."""


class KeptModels:
    """Networks from memory, from disk, or trained.

    Parameters
    ----------
    folder : Path
    device : torch.device
    ranks : Ranks
    tell : callable
        Called with epochs done, epochs in all, and words.
    may_train : bool
        Without, a model that is not trained yet is an error.

    Attributes
    ----------
    keys : dict
        What shaped each network that was asked for, as a digest.
    folders : dict
        Where it lies.
    """

    def __init__(self, folder: Path, device: torch.device, ranks: Ranks, tell: Progress, may_train: bool) -> None:
        self.folder, self.device, self.ranks, self.tell, self.may_train = folder, device, ranks, tell, may_train
        self.keys: dict[str, str] = {}
        self.folders: dict[str, str] = {}
        self._networks: dict[str, Network] = {}

    def trained(
        self, name: str, described: Mapping[str, Any], stamps: TrainedOn, options: TrainOptions, build: Build
    ) -> Network:
        """The network of a name.

        Parameters
        ----------
        name : str
        described : dict
            Everything that shapes its weights beside the options, JSON values.
        stamps : TrainedOn
            Of its data; ``recipe`` is filled in.
        options : TrainOptions
        build : callable
            Called only where there is something to train.

        Raises
        ------
        UsageError
            It is not trained yet, and may not be.
        CheckpointError
            What lies there was learned from other data.
        """
        if name in self._networks:
            return self._networks[name]
        # how often it is saved changes no weight
        key = digest_of({**described, "options": vars(replace(options, save_seconds=0.0))})
        folder = self.folder / f"{name}-{key[:12]}"
        stamps = replace(stamps, recipe=key)
        network = self._ready(folder, stamps) or self._train(name, folder, stamps, options, build)
        if stamps.topology:
            require_topology(network, stamps.topology, "the store")
        self.keys[name], self.folders[name], self._networks[name] = key, str(folder), network
        return network

    def _ready(self, folder: Path, stamps: TrainedOn) -> Network | None:
        if not (folder / LAST).exists():
            return None
        kept = load_checkpoint(folder / LAST)
        require_stamps(kept.stamps, stamps, str(folder / LAST))
        return load_checkpoint(folder / BEST).network().to(self.device) if kept.progress["is_over"] else None

    def _train(self, name: str, folder: Path, stamps: TrainedOn, options: TrainOptions, build: Build) -> Network:
        if not self.may_train:
            raise UsageError(
                f"the model {name} is not trained yet ({folder})",
                "all models of the recipe",
                "Run `tactiledata train` with the same recipe, scale and --out first.",
            )
        with drawn_alike(options.seed):
            objective, items, validation = build()

        def told(done: int, total: int, what: str = "") -> None:
            self.tell(done, total, f"{name}: {what}")

        return train(objective, items, validation, options, folder, stamps, self.device, self.ranks, told).network
