"""The image beta-VAE: residual blocks between down-samplings, mirrored in the decoder; activations are tanh or SiLU."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal, Self

import torch
from torch import Tensor, nn

from split_models.networks.latent_normal import draw
from split_models.networks.learned_backgrounds import Learned, as_extras, of_extras
from split_models.networks.network import Network
from tactiledata.errors import UsageError

Activation = Literal["tanh", "silu"]
Upsampling = Literal["nearest", "sub_pixel"]
GROUP = 8
"""Channels that are normalised together."""
LAYOUT = torch.channels_last
"""Memory layout with the channels of a pixel side by side: a training step takes a quarter less time on a CPU."""


ACTIVATIONS: dict[Activation, type[nn.Module]] = {"tanh": nn.Tanh, "silu": nn.SiLU}
"""Layers by the name of an activation in a recipe."""


class ResidualBlock(nn.Module):
    """Two 3 x 3 convolutions added to the identity; the second starts at zero, so that a new block is the identity."""

    def __init__(self, channels: int, activation: Activation = "tanh") -> None:
        super().__init__()
        last = nn.Conv2d(channels, channels, 3, padding=1)
        nn.init.zeros_(last.weight)
        if last.bias is not None:
            nn.init.zeros_(last.bias)
        self.body = nn.Sequential(
            _normalised(channels),
            ACTIVATIONS[activation](),
            nn.Conv2d(channels, channels, 3, padding=1),
            ACTIVATIONS[activation](),
            last,
        )

    def forward(self, values: Tensor) -> Tensor:
        """Features (n, channels, h, w) of features of the same shape."""
        changed: Tensor = self.body(values)
        return values + changed


def _normalised(channels: int) -> nn.GroupNorm:
    """A group normalisation with `GROUP` channels in each group."""
    return nn.GroupNorm(max(1, channels // GROUP), channels)


def _stage(channels: int, blocks: int, activation: Activation) -> nn.Sequential:
    """Residual blocks of one width, in sequence."""
    return nn.Sequential(*(ResidualBlock(channels, activation) for _ in range(blocks)))


def _enlarge(inputs: int, outputs: int, factor: int, upsampling: Upsampling) -> nn.Sequential:
    """Layers that enlarge features ``factor`` times along both axes.

    ``nearest`` repeats pixels and convolves; the convolution then cannot distinguish the inner pixels of a block of 5 x
    5. ``sub_pixel`` gives each of the factor x factor new pixels weights of its own (Shi et al. 2016). These start
    equal, so that training does not begin with a checkerboard (Aitken et al. 2017).
    """
    if upsampling == "nearest":
        return nn.Sequential(nn.Upsample(scale_factor=factor, mode="nearest"), nn.Conv2d(inputs, outputs, 3, padding=1))
    mix = nn.Conv2d(inputs, outputs * factor**2, 3, padding=1, bias=False)
    with torch.no_grad():
        mix.weight.copy_(mix.weight[:: factor**2].repeat_interleave(factor**2, dim=0))
    return nn.Sequential(mix, nn.PixelShuffle(factor))


class ImageEncoder(nn.Module):
    """Convolutions from pictures (n, 3, h, w) in [-1, 1] to features (n, c, h / total, w / total)."""

    def __init__(
        self, blocks: Sequence[int], down: Sequence[int], channels: Sequence[int], activation: Activation = "tanh"
    ) -> None:
        super().__init__()
        self.stem = nn.Conv2d(3, channels[0], 3, padding=1)
        self.stages = nn.ModuleList(
            _stage(width, count, activation) for width, count in zip(channels, blocks, strict=True)
        )
        self.down = nn.ModuleList(
            nn.Conv2d(fine, coarse, factor + 1, stride=factor, padding=factor // 2)
            for fine, coarse, factor in zip(channels[:-1], channels[1:], down, strict=True)
        )
        self.last = nn.Tanh() if activation == "tanh" else _normalised(channels[-1])

    def forward(self, pictures: Tensor) -> Tensor:
        """Features (n, c, h / total, w / total) of pictures (n, 3, h, w) in [-1, 1]."""
        values = self.stages[0](self.stem(pictures.contiguous(memory_format=LAYOUT)))
        for reduce, stage in zip(self.down, list(self.stages)[1:], strict=True):
            values = stage(reduce(values))
        features: Tensor = self.last(values)
        return features


class ImageDecoder(nn.Module):
    """The mirror of `ImageEncoder`: convolutions from features to pictures (n, 3, h, w) in [-1, 1]."""

    def __init__(
        self,
        blocks: Sequence[int],
        down: Sequence[int],
        channels: Sequence[int],
        activation: Activation = "tanh",
        upsampling: Upsampling = "nearest",
    ) -> None:
        super().__init__()
        self.stages = nn.ModuleList(
            _stage(width, count, activation) for width, count in reversed(list(zip(channels, blocks, strict=True)))
        )
        pairs = list(zip(channels[:-1], channels[1:], down, strict=True))
        self.up = nn.ModuleList(_enlarge(coarse, fine, factor, upsampling) for fine, coarse, factor in reversed(pairs))
        self.last = ACTIVATIONS[activation]()
        self.head = nn.Conv2d(channels[0], 3, 3, padding=1)

    def forward(self, features: Tensor) -> Tensor:
        """Pictures (n, 3, h, w) in [-1, 1] of features (n, c, h / total, w / total)."""
        values = self.stages[0](features.contiguous(memory_format=LAYOUT))
        for enlarge, stage in zip(self.up, list(self.stages)[1:], strict=True):
            values = stage(enlarge(values))
        return torch.tanh(self.head(self.last(values)))


class ImageVae(Network):
    """A beta-VAE of pictures of one size.

    Parameters
    ----------
    size : (height, width) px
        Size of the pictures.
    blocks : (s,) int
        Number of residual blocks of each stage.
    down : (s - 1,) int
        Factors by which the picture shrinks between stages.
    channels : (s,) int
        Number of channels of each stage.
    latent : int
        Latent dimensions.
    activation : "tanh" or "silu"
        Activation between convolutions. With tanh the encoder's features are bounded, else they are normalised: without
        either the divergence of the first steps has no bound. Pictures are always bounded.
    upsampling : "nearest" or "sub_pixel"
        How the decoder enlarges features.

    Attributes
    ----------
    learned_from : tuple of (str, (40, 30, 3) uint8)
        Sensors that it was trained on, with their pictures without contact; empty where that is not known.

    Raises
    ------
    UsageError
        The size does not divide by the factors, or the lists do not fit each other.
    """

    kind = "image_vae"
    convolves = True

    def __init__(
        self,
        size: Sequence[int] = (320, 240),
        blocks: Sequence[int] = (3, 3, 5, 5, 3, 3),
        down: Sequence[int] = (2, 2, 2, 2, 5),
        channels: Sequence[int] = (16, 32, 64, 64, 128, 128),
        latent: int = 256,
        activation: Activation = "tanh",
        upsampling: Upsampling = "nearest",
    ) -> None:
        super().__init__()
        _check_sizes(size, blocks, down, channels)
        self.settings = {
            "size": list(size),
            "blocks": list(blocks),
            "down": list(down),
            "channels": list(channels),
            "latent": latent,
            "activation": activation,
            "upsampling": upsampling,
        }
        self.size = (int(size[0]), int(size[1]))
        total = _product(down)
        self.inner = (int(channels[-1]), self.size[0] // total, self.size[1] // total)
        self.encoder = ImageEncoder(blocks, down, channels, activation)
        self.decoder = ImageDecoder(blocks, down, channels, activation, upsampling)
        self.latent = latent
        self.learned_from: Learned = ()
        self.to_mean = nn.Linear(_product(self.inner), latent)
        self.to_log_variance = nn.Linear(_product(self.inner), latent)
        self.from_latent = nn.Linear(latent, _product(self.inner))
        self.to(memory_format=LAYOUT)  # type: ignore[call-overload]

    def extras(self) -> dict[str, Tensor]:
        """Pictures without contact of the sensors that it was trained on, by number and name."""
        return as_extras(self.learned_from)

    @classmethod
    def rebuilt(cls, settings: Mapping[str, Any], extras: Mapping[str, Tensor], topology: str) -> Self:
        """The network that a checkpoint describes, with initial weights.

        Parameters
        ----------
        settings : dict
            The arguments of the class.
        extras : dict of Tensor
            Pictures without contact of the sensors it was trained on.
        topology : str
            Not used: an image VAE is for no mesh.
        """
        vae = cls(**settings)
        vae.learned_from = of_extras(extras)
        return vae

    def features(self, pictures: Tensor) -> Tensor:
        """Encoder features (n, f) of pictures (n, 3, h, w) in [-1, 1]."""
        features: Tensor = self.encoder(pictures).flatten(1)
        return features

    def distribution(self, pictures: Tensor) -> tuple[Tensor, Tensor]:
        """Mean and log variance (n, latent) of pictures (n, 3, h, w) in [-1, 1]."""
        features = self.features(pictures)
        return self.to_mean(features), self.to_log_variance(features)

    def decode(self, latent: Tensor) -> Tensor:
        """Pictures (n, 3, h, w) in [-1, 1] of latent vectors (n, latent)."""
        pictures: Tensor = self.decoder(self.from_latent(latent).unflatten(1, self.inner))
        return pictures

    def forward(self, pictures: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Reconstruction (n, 3, h, w), mean and log variance (n, latent); training decodes a sample of the vector."""
        mean, log_variance = self.distribution(pictures)
        return self.decode(draw(mean, log_variance) if self.training else mean), mean, log_variance


def as_input(pictures: Tensor) -> Tensor:
    """Pictures (n, 3, h, w) in [-1, 1], float32, from pictures (n, h, w, 3), uint8."""
    return pictures.permute(0, 3, 1, 2).float().div(127.5).sub(1.0)


def as_pictures(output: Tensor) -> Tensor:
    """Pictures (n, h, w, 3), uint8, from pictures (n, 3, h, w) in [-1, 1]; values are rounded and clipped."""
    return output.float().add(1.0).mul(127.5).round().clamp(0, 255).to(torch.uint8).permute(0, 2, 3, 1)


def _product(numbers: Sequence[int]) -> int:
    """Product of integers; 1 where there are none."""
    total = 1
    for number in numbers:
        total *= int(number)
    return total


def _check_sizes(size: Sequence[int], blocks: Sequence[int], down: Sequence[int], channels: Sequence[int]) -> None:
    """Refuse lists of unequal length, and a picture size that the down-sampling factors do not divide."""
    if not len(blocks) == len(channels) == len(down) + 1:
        raise UsageError(
            f"{len(blocks)} stages of blocks, {len(channels)} widths and {len(down)} factors",
            "a width for every stage, and a factor between each two stages",
            "Correct image_vae in the recipe.",
        )
    total = _product(down)
    if any(int(side) % total for side in size):
        raise UsageError(
            f"pictures of {size[0]} x {size[1]} px do not divide by {total} ({' x '.join(map(str, down))})",
            "a size that every factor divides",
            "Correct `size` or `down` of image_vae in the recipe.",
        )
