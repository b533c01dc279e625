"""Files of weights with a record of what they were trained on; reading runs no code, and unfit weights are refused."""

from __future__ import annotations

import io
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import torch
from torch import Tensor

from split_models.networks.network import Network
from tactiledata import __version__
from tactiledata.contract.atomic import write_atomic
from tactiledata.contract.lfs_pointer import refuse_lfs_pointer
from tactiledata.contract.tensor_files import read_tensors
from tactiledata.errors import CheckpointError, MissingFile
from tactiledata.registry import Registry

FORMAT = "tactiledata-checkpoint/1"

KINDS = Registry(
    "kind of network",
    {
        "image_vae": "split_models.networks.image_vae:ImageVae",
        "mesh_vae": "split_models.networks.mesh_vae:MeshVae",
        "projection": "split_models.networks.projection:Projection",
        "force_head": "split_models.networks.force_head:ForceHead",
        "raw_forces": "split_models.networks.force_head:RawForces",
        "end_to_end": "split_models.networks.end_to_end:EndToEnd",
        "zhu": "split_models.methods.zhu:ZhuNetwork",
        "cycle_pair": "split_models.methods.cycle:CyclePair",
    },
    group="split_models.networks",
)
"""Classes of the networks that a checkpoint can hold, by their kind."""


@dataclass(frozen=True)
class TrainedOn:
    """Digests of what weights were trained on; all must agree to resume training or to use the weights on the data.

    Parameters
    ----------
    recipe : str
        Digest of everything in the recipe that shapes the weights.
    split : str
        Digest of the split's table.
    items : str
        Fingerprint of the training items.
    topology : str
        Digest of the mesh; empty where there is none.
    """

    recipe: str = ""
    split: str = ""
    items: str = ""
    topology: str = ""

    def differing(self, other: TrainedOn) -> list[str]:
        """Names of the digests that differ from those of another record."""
        return [name for name, value in vars(self).items() if value != getattr(other, name)]


@dataclass(frozen=True)
class Checkpoint:
    """The content of a file of weights.

    Parameters
    ----------
    kind : str
        The network's name in `KINDS`.
    settings : dict
        The network's arguments, as JSON values.
    stamps : TrainedOn
        Digests of what the weights were trained on.
    topology : str
        Digest of the mesh that the network is for; empty where it is for none.
    weights, extras : dict of Tensor
        Parameters and buffers (mean and spread of scaled values among them), and tensors that the class needs.
    progress : dict
        State of the training, as JSON values.
    optimiser : dict
        State of the optimiser; empty where training is over.
    """

    kind: str
    settings: Mapping[str, Any]
    stamps: TrainedOn
    topology: str
    weights: Mapping[str, Tensor]
    extras: Mapping[str, Tensor]
    progress: Mapping[str, Any] = field(default_factory=dict)
    optimiser: Mapping[str, Any] = field(default_factory=dict)

    @classmethod
    def of(cls, network: Network, stamps: TrainedOn, progress: Any = None, optimiser: Any = None) -> Checkpoint:
        """The checkpoint of a network in its present state.

        Parameters
        ----------
        network : Network
        stamps : TrainedOn
            Digests of what the weights were trained on.
        progress : dict, optional
            State of the training, as JSON values.
        optimiser : dict, optional
            State of the optimiser.
        """
        return cls(
            network.kind,
            network.settings,
            stamps,
            network.topology,
            network.state_dict(),
            network.extras(),
            progress or {},
            optimiser or {},
        )

    def network(self) -> Network:
        """The network with these weights, on the CPU, in evaluation mode.

        Raises
        ------
        CheckpointError
            The weights do not fit the settings, or are no finite numbers.
        """
        for name, weights in self.weights.items():
            if torch.is_tensor(weights) and not bool(torch.isfinite(weights).all()):
                raise CheckpointError(
                    f"weights {name} of the {self.kind} hold NaN or infinity",
                    "finite numbers",
                    "The file is damaged, or its training diverged. Fetch it again, or train it again.",
                )
        try:
            network: Network = KINDS[self.kind].rebuilt(self.settings, self.extras, self.topology)
            network.load_state_dict(dict(self.weights))
        except (RuntimeError, TypeError, KeyError, ValueError) as error:
            raise CheckpointError(
                f"the weights of a {self.kind} do not fit its settings: {str(error)[:300]}",
                "a checkpoint of this version",
                "Train it again.",
            ) from error
        return network.eval()


def save_checkpoint(path: Path, checkpoint: Checkpoint) -> None:
    """Write a checkpoint atomically: the file is complete or absent."""
    document = {
        "format": FORMAT,
        "version": __version__,
        "kind": checkpoint.kind,
        "settings": dict(checkpoint.settings),
        "stamps": vars(checkpoint.stamps),
        "topology": checkpoint.topology,
        "progress": dict(checkpoint.progress),
    }
    content = io.BytesIO()
    whole = {
        "document": json.dumps(document, sort_keys=True),
        "weights": dict(checkpoint.weights),
        "extras": dict(checkpoint.extras),
        "optimiser": dict(checkpoint.optimiser),
    }
    torch.save(whole, content)
    write_atomic(path, content.getvalue())


def load_checkpoint(path: Path) -> Checkpoint:
    """The checkpoint in a file, on the CPU; only tensors and plain values are read, and no code is run.

    Raises
    ------
    MissingFile
        The file does not exist, or is a folder.
    NotFetched
        The file is a Git LFS pointer.
    CheckpointError
        The file is no checkpoint of this format.
    """
    if path.is_dir():
        inside = sorted(str(file) for file in path.glob("*.pt"))
        remedy = (
            f"Name {' or '.join(inside)}." if inside else "Name the checkpoint, such as `best.pt` of a trained model."
        )
        raise MissingFile(f"{path} is a folder", "the file of a checkpoint", remedy)
    if not path.is_file():
        raise MissingFile(f"{path} does not exist", "a checkpoint", "Train first: `tactiledata train RECIPE`.")
    refuse_lfs_pointer(path)
    whole = read_tensors(path, "cannot be read as a checkpoint", CheckpointError)
    try:
        document = json.loads(whole["document"])
        parts = whole["weights"], whole["extras"], whole["optimiser"]
    except (LookupError, TypeError, ValueError, RecursionError) as error:
        raise CheckpointError(
            f"{path} cannot be read as a checkpoint: it lacks a part, or its document is no JSON",
            f"a file of format {FORMAT}",
            "It is of another program, or damaged. Remove it and train again.",
            path=str(path),
        ) from error
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        file_format = document.get("format") if isinstance(document, dict) else document
        raise CheckpointError(f"{path} has format {file_format!r}", FORMAT, "It is of another program or version.")
    weights, extras, optimiser = parts
    try:
        trained_on = TrainedOn(**document["stamps"])
        kind, settings, topology, progress = (document[key] for key in ("kind", "settings", "topology", "progress"))
    except (KeyError, TypeError) as error:
        raise CheckpointError(
            f"{path} cannot be read as a checkpoint: its document lacks {error}",
            "kind, settings, stamps, topology and progress",
            "It is of another version, or damaged. Remove it and train again.",
            path=str(path),
        ) from error
    return Checkpoint(kind, settings, trained_on, topology, weights, extras, progress, optimiser)


def require_stamps(stamps: TrainedOn, expected: TrainedOn, where: str) -> None:
    """Refuse weights that were trained on other data, or by another recipe, than the present ones.

    Parameters
    ----------
    stamps : TrainedOn
        Digests in the checkpoint.
    expected : TrainedOn
        Digests of the present recipe and data.
    where : str
        The checkpoint's place, for the message.

    Raises
    ------
    CheckpointError
        A digest differs; the message names which.
    """
    differing = stamps.differing(expected)
    if not differing:
        return
    words = {
        "recipe": "the recipe",
        "split": "the split (who is in which part)",
        "items": "the frames that it learns from",
        "topology": "the mesh topology",
    }
    listed = ", ".join(words[name] for name in differing)
    values = ", ".join(f"{name} {getattr(stamps, name)[:12] or 'none'}" for name in differing)
    expected_values = ", ".join(f"{name} {getattr(expected, name)[:12] or 'none'}" for name in differing)
    raise CheckpointError(
        f"{where} was made with another state of {listed} ({values})",
        expected_values,
        "Name another --out folder, or remove the file to train anew.",
        differing=differing,
    )


def require_topology(network: Network, topology: str, where: str) -> None:
    """Refuse a network for another mesh than the present one; a network for no mesh passes.

    Parameters
    ----------
    network : Network
    topology : str
        Digest of the present mesh.
    where : str
        The present mesh's source, for the message.

    Raises
    ------
    CheckpointError
        The network is for another mesh.
    """
    if network.topology and network.topology != topology:
        raise CheckpointError(
            f"the {network.kind} is for another mesh topology ({network.topology[:12]})",
            f"that of {where} ({topology[:12]})",
            "Name the mesh that it was trained on (`tactiledata info` lists meshes), or train on this one.",
        )
