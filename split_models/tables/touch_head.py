"""A small network that reads a touch from a picture: place, depth and force; a check of what transferred pictures tell.

It stands for the networks that users train on tactile pictures. It is small, so that many of them can be trained on a
processor: one for each method of transfer.
"""

from __future__ import annotations

import cv2
import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from tactiledata.arrays import Array, PictureArray
from tactiledata.errors import UsageError

READINGS = {"x": "mm", "y": "mm", "depth": "mm", "fx": "N", "fy": "N", "fz": "N"}
"""What is read, with units: place and depth of the indenter's tip, and the contact force, in the gel frame."""
SIZE = (40, 30)
"""Rows and columns to which pictures are scaled by area."""
LEVELS = 40.0
"""Grey levels in one unit of the network's input."""
CHANNELS = (16, 32, 32)
"""Channels of the convolutions, each of which halves the picture."""
WIDTH = 64
"""Width of the hidden layer."""
DROPOUT = 0.2
"""Share of the features that are dropped while the network learns."""
EPOCHS, BATCH, RATE, DECAY = 50, 32, 2e-3, 1e-2
"""Epochs, pictures in a batch, largest learning rate, and decay of the weights."""


def small_pictures(pictures: PictureArray) -> NDArray[np.float32]:
    """Return pictures (n, 40, 30, 3), grey levels, of pictures (n, h, w, 3) of any size, scaled by area."""
    scaled = [cv2.resize(picture.astype(np.float32), SIZE[::-1], interpolation=cv2.INTER_AREA) for picture in pictures]
    return np.stack(scaled)


class TouchHead:
    """A trained network from small pictures to the values of `READINGS`.

    Parameters
    ----------
    network : nn.Module
        Gives standardised values of standardised pictures.
    mean, spread : (r,)
        Mean and spread of the values that it learned from.
    level : (40, 30, 3) grey levels
        Mean picture that it learned from.
    """

    def __init__(self, network: nn.Module, mean: Array, spread: Array, level: NDArray[np.float32]) -> None:
        self.network, self.mean, self.spread, self.level = network, mean, spread, level

    def read(self, pictures: NDArray[np.float32]) -> Array:
        """Return values (n, r) that the network reads from small pictures (n, 40, 30, 3)."""
        with torch.no_grad():
            values = self.network(_inputs(pictures, self.level)).numpy()
        return np.asarray(values * self.spread + self.mean, np.float64)


def learned_head(pictures: NDArray[np.float32], values: Array, seed: int = 0) -> TouchHead:
    """Return a network that has learned to read values from small pictures; the same seed gives the same network.

    Parameters
    ----------
    pictures : (n, 40, 30, 3) float32
        Pictures of `small_pictures`.
    values : (n, r)
        What they show.
    seed : int
        Seed of the weights and of the order of pictures.

    Raises
    ------
    UsageError
        There are fewer pictures than one batch, or not as many as values.
    """
    if len(pictures) < BATCH or len(pictures) != len(values):
        raise UsageError(
            f"{len(pictures)} pictures with {len(values)} rows of values to learn from",
            f"at least {BATCH} pictures with a row each",
            "Record more touches.",
        )
    mean, spread = values.mean(axis=0), np.maximum(values.std(axis=0), 1e-9)
    level = pictures.mean(axis=0)
    inputs, targets = _inputs(pictures, level), torch.from_numpy((values - mean) / spread).float()
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        network = _network(values.shape[1])
        optimiser = torch.optim.AdamW(network.parameters(), RATE, weight_decay=DECAY)
        steps = EPOCHS * -(-len(inputs) // BATCH)
        schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, RATE, total_steps=steps)
        for _ in range(EPOCHS):
            for rows in torch.randperm(len(inputs)).split(BATCH):
                optimiser.zero_grad()
                nn.functional.smooth_l1_loss(network(inputs[rows]), targets[rows]).backward()
                optimiser.step()
                schedule.step()
    return TouchHead(network.eval(), mean, spread, level)


def explained(predicted: Array, true: Array) -> float:
    """Return R² of predicted values (n,): 1 is perfect, 0 is no better than the mean, and less than 0 is worse."""
    around = np.square(true - true.mean()).sum()
    return float(1.0 - np.square(predicted - true).sum() / around) if around > 0 else float("nan")


def _network(outputs: int) -> nn.Module:
    """Three convolutions that halve the picture, and a hidden layer."""
    layers: list[nn.Module] = []
    inputs, (rows, columns) = 3, SIZE
    for number, channels in enumerate(CHANNELS):
        kernel = 3 if number else 5
        layers += [nn.Conv2d(inputs, channels, kernel, stride=2, padding=kernel // 2), nn.ReLU()]
        inputs, rows, columns = channels, -(-rows // 2), -(-columns // 2)
    flat = inputs * rows * columns
    layers += [nn.Flatten(), nn.Dropout(DROPOUT), nn.Linear(flat, WIDTH), nn.ReLU(), nn.Linear(WIDTH, outputs)]
    return nn.Sequential(*layers)


def _inputs(pictures: NDArray[np.float32], level: NDArray[np.float32]) -> Tensor:
    """Pictures (n, 40, 30, 3) less the mean picture, as a tensor (n, 3, 40, 30)."""
    scaled = np.moveaxis((pictures - level) / LEVELS, 3, 1)
    return torch.from_numpy(np.ascontiguousarray(scaled, dtype=np.float32))
