"""Networks in a folder, named by what shaped them; each is trained once, when it is first needed."""

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
"""A function that gives an objective, the items to train on and the items to validate on."""


class KeptModels:
    """Networks from memory, from disk, or trained.

    Parameters
    ----------
    folder : Path
        Folder with one folder for each network.
    device : torch.device
    ranks : Ranks
        Number of this process among those that train together.
    tell : callable
        Called with epochs done, epochs in all, and the network's name and losses in words.
    may_train : bool
        Whether a network that is not trained yet is trained; else it is an error.

    Attributes
    ----------
    keys : dict
        Digest of what shaped each network that was requested, by name.
    folders : dict
        Folder of each of these networks.
    """

    def __init__(self, folder: Path, device: torch.device, ranks: Ranks, tell: Progress, may_train: bool) -> None:
        self.folder, self.device, self.ranks, self.tell, self.may_train = folder, device, ranks, tell, may_train
        self.keys: dict[str, str] = {}
        self.folders: dict[str, str] = {}
        self._networks: dict[str, Network] = {}

    def trained(
        self, name: str, described: Mapping[str, Any], stamps: TrainedOn, options: TrainOptions, build: Build
    ) -> Network:
        """The trained network of a name.

        Parameters
        ----------
        name : str
            Name of the network in this recipe; with the digest it names the folder.
        described : dict
            Everything that shapes its weights beside the options, as JSON values.
        stamps : TrainedOn
            Digests of its data; ``recipe`` is filled in.
        options : TrainOptions
        build : callable
            Gives objective and items; called only where there is something to train.

        Raises
        ------
        UsageError
            The network is not trained yet, and may not be trained.
        CheckpointError
            The folder's weights were trained on other data.
        """
        if name in self._networks:
            return self._networks[name]
        # the interval between checkpoints does not influence the weights, so it is not part of the key
        key = digest_of({**described, "options": options.shaping})
        folder = self.folder / f"{name}-{key[:12]}"
        stamps = replace(stamps, recipe=key)
        network = self._ready(folder, stamps) or self._train(name, folder, stamps, options, build)
        if stamps.topology:
            require_topology(network, stamps.topology, "the store")
        self.keys[name], self.folders[name], self._networks[name] = key, str(folder), network
        return network

    def _ready(self, folder: Path, stamps: TrainedOn) -> Network | None:
        """The network in a folder, or None where its training is not complete."""
        if not (folder / LAST).exists():
            return None
        kept = load_checkpoint(folder / LAST)
        require_stamps(kept.stamps, stamps, str(folder / LAST))
        return load_checkpoint(folder / BEST).network().to(self.device) if kept.progress["is_over"] else None

    def _train(self, name: str, folder: Path, stamps: TrainedOn, options: TrainOptions, build: Build) -> Network:
        """The network after training, which reports progress under its name."""
        if not self.may_train:
            raise UsageError(
                f"the model {name} is not trained yet ({folder})",
                "all models of the recipe",
                "Run `tactiledata train` with the same recipe, scale and --out first.",
            )
        with drawn_alike(options.seed):
            objective, items, validation = build()

        def report_epoch(done: int, total: int, what: str = "") -> None:
            self.tell(done, total, f"{name}: {what}")

        return train(
            objective, items, validation, options, folder, stamps, self.device, ranks=self.ranks, tell=report_epoch
        ).network
