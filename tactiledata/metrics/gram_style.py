"""Similarity of the texture of two sets of pictures: distance of Gram matrices of VGG-19's features.

Source: Gatys et al. 2016, equations 3 to 5: five layers, equal weights. The official weights are torchvision's file.
Without it a network of random weights gives a score of another name, whose numbers cannot be compared with VGG's.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tactiledata.contract.image_batches import image_batches
from tactiledata.contract.lfs_pointer import refuse_lfs_pointer
from tactiledata.contract.tensor_files import read_tensors
from tactiledata.errors import MissingFile, SchemaError, UsageError
from tactiledata.metrics.base import Score, Values, image_masks, images, metric

if TYPE_CHECKING:
    from torch import Tensor, nn

WIDTHS = (64, 64, 0, 128, 128, 0, 256, 256, 256, 256, 0, 512, 512, 512, 512, 0, 512, 512, 512, 512, 0)
"""Output channels of VGG-19's convolutions, each followed by ReLU; 0 stands for maxima of 2 x 2."""
STYLE_LAYERS = (1, 6, 11, 20, 29)
"""Numbers of the layers that are compared: ReLU after conv1_1, conv2_1, conv3_1, conv4_1 and conv5_1."""
WEIGHTS = "vgg19-dcbb9e9d.pth"
"""Name of the file of weights, as torchvision publishes it; the digits are the beginning of its SHA-256."""
MEAN, SPREAD = (0.485, 0.456, 0.406), (0.229, 0.224, 0.225)
"""Mean and standard deviation of the channels of ImageNet, on which the weights were trained."""
NARROWER = 8
"""Factor by which the random network has fewer channels, so that it is fast."""
CHUNK = 8
"""Largest number of pictures that go through the network together."""
MOST_PIXELS = 2**22
"""Largest number of pixels of a picture, and of those that go through the network together: its first layers take some
0.8 kB a pixel."""


def build_features(narrower: int = 1) -> nn.Sequential:
    """Return the convolutional part of VGG-19, with all widths divided; parameters are named as in torchvision."""
    from torch import nn

    parts: list[nn.Module] = []
    inputs = 3
    for width in WIDTHS:
        if width == 0:
            parts.append(nn.MaxPool2d(2))
            continue
        outputs = width // narrower
        parts += [nn.Conv2d(inputs, outputs, 3, padding=1), nn.ReLU()]
        inputs = outputs
    return nn.Sequential(*parts).eval().requires_grad_(False)


def find_weights(path: Path | None = None) -> Path | None:
    """Return the file of official weights: the given one, else that in PyTorch's cache, else None.

    Raises
    ------
    MissingFile
        The given file does not exist.
    """
    import torch

    if path is not None:
        if not path.is_file():
            raise MissingFile(f"no weights at {path}", f"torchvision's {WEIGHTS}", "", path=str(path))
        return path
    cached = Path(torch.hub.get_dir()) / "checkpoints" / WEIGHTS
    return cached if cached.is_file() else None


@cache
def vgg19_features(path: Path) -> nn.Sequential:
    """Return VGG-19 with the official weights in a file.

    Raises
    ------
    SchemaError
        A file that does not hold these weights.
    """
    refuse_lfs_pointer(path)
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    if path.name == WEIGHTS and not digest.startswith(path.stem.rpartition("-")[2]):
        raise SchemaError(f"{path} has SHA-256 {digest[:8]}…", f"{WEIGHTS} as it was published", "Fetch it again.")
    network = build_features()
    kept = read_tensors(path, "holds no weights of VGG-19", SchemaError)
    try:
        own = {name.removeprefix("features."): kept[name] for name in kept if name.startswith("features.")}
        network.load_state_dict(own)
    except (AttributeError, LookupError, RuntimeError, TypeError) as error:
        raise SchemaError(
            f"{path} holds no weights of VGG-19: its names or shapes are others",
            "a state dict with features.0.weight, …",
            f"Fetch {WEIGHTS} as torchvision publishes it.",
        ) from error
    return network


@cache
def random_features() -> nn.Sequential:
    """Return a network shaped as VGG-19 with an eighth of its channels and random weights, always the same."""
    import torch

    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(19)
        network = build_features(NARROWER)
        for part in network:
            if isinstance(part, torch.nn.Conv2d):
                torch.nn.init.kaiming_normal_(part.weight, nonlinearity="relu")
                part.bias = torch.nn.Parameter(torch.zeros(part.out_channels), requires_grad=False)
    return network


def gram_style(
    pictures: Any,
    others: Any,
    mask: Any = None,
    others_mask: Any = None,
    weights: Path | None = None,
    device: str = "cpu",
) -> Values:
    """Style distance (n,) of each picture to the mean Gram matrices of another set, by VGG-19; 0 is alike.

    Parameters
    ----------
    pictures, others : (n, H, W, 3), (m, H, W, 3), uint8 RGB
        Pictures to score, and those of the other set; at least 32 x 32.
    mask, others_mask : (n, H, W), (m, H, W), bool, optional
        Restrict the Gram matrices to the pixels of the masks; a picture with an empty mask is NaN.
    weights : Path, optional
        torchvision's ``vgg19-dcbb9e9d.pth``; that in PyTorch's cache unless stated.
    device : str
        PyTorch's name of the device that the network runs on.

    Raises
    ------
    UsageError
        No weights, or pictures that are too small or too large.
    """
    return style_distances("gram_style", pictures, others, [(mask, others_mask)], weights, device)[0]


def gram_style_random(
    pictures: Any, others: Any, mask: Any = None, others_mask: Any = None, device: str = "cpu"
) -> Values:
    """Style distance (n,) by the features of a random network; its values cannot be compared with ``gram_style``.

    Parameters
    ----------
    pictures, others, mask, others_mask, device
        As in `gram_style`.
    """
    return style_distances("gram_style_random", pictures, others, [(mask, others_mask)], device=device)[0]


def style_distances(
    name: str,
    pictures: Any,
    others: Any,
    masks: Sequence[tuple[Any, Any]],
    weights: Path | None = None,
    device: str = "cpu",
) -> list[Values]:
    """Style distances (n,) for each of several pairs of masks, by one pass through the network.

    Parameters
    ----------
    name : "gram_style" or "gram_style_random"
        The score, and with it the network.
    pictures, others : (n, H, W, 3), (m, H, W, 3), uint8 RGB
        Pictures to score, and those of the other set.
    masks : sequence of (mask, others_mask)
        Masks as in `gram_style`; None for the full frame.
    weights : Path, optional
        Official weights of VGG-19; those in PyTorch's cache unless stated.
    device : str
        PyTorch's name of the device that the network runs on.

    Returns
    -------
    list of (n,)
        Distances for each pair of masks.
    """
    if name == "gram_style_random":
        return _distances(random_features().to(device), pictures, others, masks)
    path = find_weights(weights)
    if path is None:
        raise UsageError(
            "the official weights of VGG-19 are not there",
            f"{WEIGHTS} in PyTorch's cache, or a path to it",
            "Take `gram_style_random` instead: another measure under another name.",
        )
    return _distances(vgg19_features(path).to(device), pictures, others, masks)


def style_score(weights: Path | None = None) -> str:
    """Return the style score that can be computed: ``gram_style`` with official weights, else ``gram_style_random``.

    The two must not be mixed in a table: choose once for a table.
    """
    return "gram_style" if find_weights(weights) is not None else "gram_style_random"


def _distances(network: nn.Sequential, pictures: Any, others: Any, masks: Sequence[tuple[Any, Any]]) -> list[Values]:
    """Style distances (n,) by a network, for each pair of masks."""
    means = _mean_grams(network, others, [theirs for _, theirs in masks])
    distances = [[np.zeros(0)] for _ in masks]
    for by_mask in _grams(network, pictures, [ours for ours, _ in masks], "pictures"):
        for grams, mean, kept in zip(by_mask, means, distances, strict=True):
            # equation 4; the Gram matrices are over the number of places already: 1 / (4 N²) of the sum of squares
            parts = [
                np.square(ours - theirs).sum(axis=(1, 2)) / (4 * theirs.shape[0] ** 2) / len(STYLE_LAYERS)
                for ours, theirs in zip(grams, mean, strict=True)
            ]
            kept.append(np.sum(parts, axis=0))
    return [np.concatenate(kept) for kept in distances]


def _mean_grams(network: nn.Sequential, others: Any, masks: Sequence[Any]) -> list[list[Values]]:
    """Mean Gram matrix (c, c) of each style layer, over the pictures whose masks are not empty, for each mask."""
    sums: list[list[Values]] = []
    counts = np.zeros(len(masks))
    for by_mask in _grams(network, others, masks, "others"):
        # a picture with an empty mask is NaN, and does not count
        is_there = [~np.isnan(grams[0][:, 0, 0]) for grams in by_mask]
        more = [[gram[there].sum(axis=0) for gram in grams] for grams, there in zip(by_mask, is_there, strict=True)]
        sums = [[o + s for o, s in zip(*two, strict=True)] for two in zip(sums, more, strict=True)] if sums else more
        counts += [there.sum() for there in is_there]
    if not len(sums) or not counts.all():
        raise UsageError("no picture of the other set has a pixel in its mask", "at least one", "")
    return [[layer / count for layer in layers] for layers, count in zip(sums, counts, strict=True)]


def _grams(network: nn.Sequential, pictures: Any, masks: Sequence[Any], what: str) -> Iterator[list[list[Values]]]:
    """Gram matrices (k, c, c) of each style layer, over the number of places, for each mask; NaN where it is empty.

    They come for a few pictures at a time, as the matrices of one picture take 5 MB.
    """
    import torch

    batch = images(pictures, what)
    if min(batch.shape[1:3]) < 32:
        raise UsageError(f"{what} of {batch.shape[1]} x {batch.shape[2]}", "at least 32 px a side", "")
    # pictures that the network, and the memory, can take
    pixels = np.full(len(batch), batch.shape[1] * batch.shape[2])
    if len(batch) and pixels[0] > MOST_PIXELS:
        raise UsageError(
            f"{what} of {batch.shape[1]} x {batch.shape[2]}",
            f"at most {MOST_PIXELS} pixels for a style distance: so many take the network {MOST_PIXELS * 8e-7:.0f} GB",
            "Scale the pictures down, or ask for another score.",
        )
    # without a mask, every pixel counts
    whole = np.ones(batch.shape[:3], bool)
    inside = [whole if (checked := image_masks(mask, batch)) is None else checked for mask in masks]
    for rows in (slice(*run) for run in image_batches(pixels, CHUNK, MOST_PIXELS)):
        with torch.no_grad():
            weights = [torch.from_numpy(mask[rows]) for mask in inside]
            yield _layer_grams(network, torch.from_numpy(np.array(batch[rows])), weights)


def _layer_grams(network: nn.Sequential, pictures: Tensor, weights: Sequence[Tensor]) -> list[list[Values]]:
    """Gram matrices (k, c, c) of each style layer of pictures (k, H, W, 3), for each weight (k, H, W) of the pixels."""
    import torch

    device = next(network.parameters()).device
    # colours as the weights were trained on
    values = pictures.to(device).permute(0, 3, 1, 2).float() / 255
    mean, spread = (torch.tensor(channels, device=device).view(3, 1, 1) for channels in (MEAN, SPREAD))
    values = (values - mean) / spread
    grams: list[list[Values]] = [[] for _ in weights]
    for number, part in enumerate(list(network)[: max(STYLE_LAYERS) + 1]):
        values = part(values)
        if number in STYLE_LAYERS:
            flat = values.flatten(2)
            for kept, weight in zip(grams, weights, strict=True):
                # the share of each place of the layer that the mask covers
                share = torch.nn.functional.adaptive_avg_pool2d(weight[:, None].to(device).float(), values.shape[2:])
                places = share.sum(dim=(2, 3))[..., None]
                gram = (flat * share.flatten(2)) @ flat.transpose(1, 2) / places
                kept.append(gram.double().cpu().numpy())
    return grams


GRAM_STYLE = metric(
    "gram_style",
    "how alike the texture of each picture and of another set is",
    "image sets",
    [
        Score("gram_style", "style distance (VGG-19)", "", "lower", 0.0, gram_style),
        Score("gram_style_random", "style distance (random features)", "", "lower", 0.0, gram_style_random),
    ],
)
