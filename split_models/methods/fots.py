"""FOTS as a baseline: a small network from normal and position to the change of colour, and planar shadows.

Source: Zhao et al., FOTS, 2024: the optical response is learned by a multilayer perceptron from normals, and shadows
are those that the indented shape casts on the plane of the gel.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import partial
from itertools import pairwise

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from split_models.methods.optical_method import OpticalMethod, calibrated
from tactiledata.errors import UsageError
from tactiledata.optics.registration import Touch
from tactiledata.optics.surface import GelSurface
from tactiledata.optics.taxim import TaximTable, place_terms, published_digit_table
from tactiledata.optics.taxim_calibration import CalibrationPress
from tactiledata.optics.view import View
from tactiledata.sensors.base import Sensor
from tactiledata.sensors.digit import DIGIT

HIDDEN = (32, 32)
"""Widths of the network's hidden layers."""
PIXELS = 200_000
"""Largest number of pixels, drawn at random from all presses, that the network is trained on."""
STEPS, BATCH, RATE = 600, 1024, 2e-2
"""Training steps, pixels in each, and the largest learning rate."""
LEVELS = 100.0
"""Grey levels in one unit of the network's output."""
FLAT = 0.01
"""Slope below which the gel counts as flat; there the background is not changed."""


class ColourNetwork(nn.Module):
    """Change of colour (n, 3), grey levels, from normals (n, 3) and positions (n, 2) in [-1, 1]; 0 for flat gel."""

    def __init__(self, hidden: Sequence[int] = HIDDEN) -> None:
        super().__init__()
        widths = [5, *hidden]
        parts: list[nn.Module] = []
        for inputs, outputs in pairwise(widths):
            parts += [nn.Linear(inputs, outputs), nn.Tanh()]
        self.layers = nn.Sequential(*parts, nn.Linear(widths[-1], 3))

    def forward(self, normals: Tensor, places: Tensor) -> Tensor:
        """Change of colour (n, 3), grey levels, relative to flat gel at the same positions."""
        flat = torch.zeros_like(normals)
        flat[:, 2] = 1.0
        changed: Tensor = self.layers(torch.cat([normals, places], 1)) - self.layers(torch.cat([flat, places], 1))
        return LEVELS * changed


def normals_of(slope: NDArray[np.float32]) -> NDArray[np.float32]:
    """Unit normals (..., 3) towards the camera of a surface with slopes (..., 2), which rises towards the camera."""
    normals = np.concatenate([-slope, np.ones_like(slope[..., :1])], axis=-1)
    return normals / np.linalg.norm(normals, axis=-1, keepdims=True)


def learned_colours(presses: Iterable[CalibrationPress], seed: int = 0) -> ColourNetwork:
    """A network trained on pixels of known slopes.

    Raises
    ------
    UsageError
        No pixel has a slope above `FLAT`.
    """
    rng = np.random.default_rng(seed)
    given, changes = [], []
    for press in presses:
        used = press.is_known & (np.hypot(press.slopes[..., 0], press.slopes[..., 1]) > FLAT)
        places = place_terms(press.change.shape[:2])[..., 3:5]
        given.append(np.concatenate([normals_of(press.slopes[used]), places[used]], axis=1))
        changes.append(press.change[used])
    if not sum(map(len, given)):
        raise UsageError("no pixel with a slope to learn from", "touches that show a contact", "")
    inputs, targets = np.concatenate(given), np.concatenate(changes)
    chosen = rng.permutation(len(inputs))[:PIXELS]
    return _trained(torch.from_numpy(inputs[chosen]).float(), torch.from_numpy(targets[chosen]).float(), seed)


def _trained(inputs: Tensor, targets: Tensor, seed: int) -> ColourNetwork:
    """A network trained on normals and positions (n, 5) with their changes of colour (n, 3), grey levels."""
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        network = ColourNetwork()
        optimizer = torch.optim.Adam(network.parameters(), RATE)
        schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, RATE, total_steps=STEPS)
        for _ in range(STEPS):
            rows = torch.randint(len(inputs), (BATCH,))
            change = network(inputs[rows, :3], inputs[rows, 3:])
            loss = nn.functional.mse_loss(change / LEVELS, targets[rows] / LEVELS)
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
            schedule.step()
    return network.eval()


def presses_of_table(table: TaximTable, seed: int = 0, count: int = 8) -> list[CalibrationPress]:
    """Presses with random slopes, up to 60 degrees in every direction, and the colours that a Taxim table gives them.

    Parameters
    ----------
    table : TaximTable
    seed : int
        Seed of the slopes.
    count : int
        Number of presses, of 160 x 120 px each.
    """
    rng = np.random.default_rng(seed)
    presses = []
    for _ in range(count):
        angle, direction = rng.uniform(0.0, np.pi / 3, (160, 120)), rng.uniform(-np.pi, np.pi, (160, 120))
        slope = np.tan(angle)[..., None] * np.stack([np.cos(direction), np.sin(direction)], axis=-1)
        slope = slope.astype(np.float32)
        presses.append(CalibrationPress(table.change(slope), slope, np.ones(slope.shape[:2], bool)))
    return presses


def fots_published(surface: GelSurface, sensor: Sensor = DIGIT, seed: int = 0) -> OpticalMethod:
    """FOTS without calibration on the unit: it takes the unit's background and the nominal camera.

    FOTS' own calibration files were not available. The network is trained on the published DIGIT table of Taxim
    instead, which describes the same response for another DIGIT.

    Parameters
    ----------
    surface : GelSurface
        Surface of the mesh that displacements belong to.
    sensor : Sensor
        Sensor with the nominal camera.
    seed : int
        Seed of the training.
    """
    network = learned_colours(presses_of_table(published_digit_table(), seed), seed)
    return OpticalMethod("fots_published", surface, View.nominal(sensor), partial(change_by, network))


def fots_calibrated(surface: GelSurface, view: View, touches: Sequence[Touch], seed: int = 0) -> OpticalMethod:
    """FOTS with a network and planar shadows fitted to touches of the unit, seen through its registered camera.

    Parameters
    ----------
    surface : GelSurface
        Surface of the mesh that displacements belong to.
    view : View
        The unit's registered camera.
    touches : sequence of Touch
        Touches of the unit with their meshes.
    seed : int
        Seed of the training.

    Raises
    ------
    UsageError
        There is no touch, or none that shows a contact.
    """
    return calibrated(
        "fots_calibrated",
        surface,
        view,
        touches,
        lambda presses: partial(change_by, learned_colours(presses, seed)),
        is_planar=True,
    )


def change_by(network: ColourNetwork, slope: NDArray[np.float32]) -> NDArray[np.float32]:
    """Change of colour (rows, columns, 3), grey levels, for slopes (rows, columns, 2); 0 where the gel is flat."""
    change = np.zeros((*slope.shape[:2], 3), np.float32)
    steep = np.hypot(slope[..., 0], slope[..., 1]) > FLAT
    if steep.any():
        places = place_terms(slope.shape[:2])[..., 3:5][steep]
        with torch.no_grad():
            predicted = network(torch.from_numpy(normals_of(slope[steep])), torch.from_numpy(places))
        change[steep] = predicted.numpy()
    return change
