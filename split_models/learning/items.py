"""Training items, read in batches: pictures, meshes or latent vectors, each with the values to be predicted from it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import chain
from typing import Protocol

import numpy as np
import torch
from torch import Tensor

from split_models.learning.data import TouchFrames
from tactiledata.contract.provenance import digest_of

Batch = dict[str, Tensor]


class Items(Protocol):
    """Training items with numbers from 0, which are read in batches."""

    @property
    def fingerprint(self) -> str:
        """Digest of the items; equal for equal items."""

    def __len__(self) -> int: ...

    def batch(self, numbers: Sequence[int]) -> Batch:
        """Tensors by name, each with one item along its first axis."""

    def where(self, number: int) -> str:
        """Source of an item in words, for messages."""


class PictureItems:
    """Pictures of several sets of frames, and backgrounds of sensors among them.

    A batch has ``image`` (n, h, w, 3), uint8, and ``sensor`` (n,), int64: the place of each picture's sensor in
    ``sensor_names``. Pictures of other sensors, and of all sets but the first, have -1.

    Parameters
    ----------
    sets : sequence of TouchFrames
        Sets of frames; backgrounds are those of the first set's sensors.
    background_copies : int
        How often each sensor's picture without contact is among the items.
    sensor_names : sequence of str, optional
        Sensors that ``sensor`` numbers; those of the first set unless given.
    """

    def __init__(
        self, sets: Sequence[TouchFrames], background_copies: int = 0, sensor_names: Sequence[str] | None = None
    ) -> None:
        self.sets = list(sets)
        self._ends = np.cumsum([len(frames) for frames in self.sets])
        places = {name: place for place, name in enumerate(sensor_names or self.sets[0].sensor_names)}
        names = self.sets[0].sensor_names if background_copies else []
        self._names = [name for name in names for _ in range(background_copies)]
        self._backgrounds = {name: self.sets[0].background(name) for name in names}
        of_frames = [
            [places.get(sensor, -1) if number == 0 else -1 for sensor in frames.sensors]
            for number, frames in enumerate(self.sets)
        ]
        of_backgrounds = [places.get(name, -1) for name in self._names]
        self._sensors = torch.tensor([*chain.from_iterable(of_frames), *of_backgrounds])

    @property
    def fingerprint(self) -> str:
        """Digest of the sets of frames and of the backgrounds among them."""
        return digest_of([[frames.fingerprint for frames in self.sets], self._names])

    def __len__(self) -> int:
        return int(self._ends[-1]) + len(self._names)

    def batch(self, numbers: Sequence[int]) -> Batch:
        """``image`` (n, h, w, 3) and ``sensor`` (n,) of items by their number."""
        places = np.asarray(numbers, np.int64)
        which = np.searchsorted(self._ends, places, side="right")
        parts, order = [], []
        for number in np.unique(which):
            mine = np.flatnonzero(which == number)
            inside = places[mine] - (self._ends[number - 1] if number else 0)
            if number < len(self.sets):
                parts.append(self.sets[number].pictures(inside))
            else:
                parts.append(np.stack([self._backgrounds[self._names[place]] for place in inside]))
            order.append(mine)
        pictures = np.concatenate(parts)[np.argsort(np.concatenate(order))]
        return {"image": torch.from_numpy(pictures), "sensor": self._sensors[torch.from_numpy(places)]}

    def where(self, number: int) -> str:
        """Store and frame of an item, or the sensor of a background."""
        which = int(np.searchsorted(self._ends, number, side="right"))
        if which == len(self.sets):
            return f"the background of {self._names[number - int(self._ends[-1])]}"
        inside = number - (int(self._ends[which - 1]) if which else 0)
        return frame_of(self.sets[which], inside)


class FrameItems:
    """Meshes, pictures and forces of frames, as far as they are requested.

    A batch may have ``mesh`` (n, v, 3), m, ``image`` (n, h, w, 3), uint8, and ``force`` (n, 3), N.

    Parameters
    ----------
    frames : TouchFrames
    what : sequence of str
        Which of the three a batch has.
    """

    def __init__(self, frames: TouchFrames, what: Sequence[str]) -> None:
        self.frames, self.what = frames, tuple(what)

    @property
    def fingerprint(self) -> str:
        """Digest of the frames and of which values are read."""
        return digest_of([self.frames.fingerprint, list(self.what)])

    def __len__(self) -> int:
        return len(self.frames)

    def batch(self, numbers: Sequence[int]) -> Batch:
        """The requested values of items by their number."""
        read = {"mesh": self.frames.displacements, "image": self.frames.pictures, "force": self.frames.forces}
        return {name: torch.from_numpy(read[name](numbers)) for name in self.what}

    def where(self, number: int) -> str:
        """Store and frame of an item."""
        return frame_of(self.frames, number)


class TensorItems:
    """Tensors in memory, all of one length, such as latent vectors and the values to be predicted from them.

    Parameters
    ----------
    tensors : dict of Tensor
        Values by name, (n, ...) each.
    fingerprint : str
        Digest that stands for them.
    frames : TouchFrames, optional
        Frames that the items are of, for messages.
    """

    def __init__(self, tensors: Mapping[str, Tensor], fingerprint: str, frames: TouchFrames | None = None) -> None:
        self.tensors, self._fingerprint, self._frames = dict(tensors), fingerprint, frames

    @property
    def fingerprint(self) -> str:
        """The digest that the items were made with."""
        return self._fingerprint

    def __len__(self) -> int:
        return len(next(iter(self.tensors.values())))

    def batch(self, numbers: Sequence[int]) -> Batch:
        """All tensors at items by their number."""
        places = torch.as_tensor(numbers)
        return {name: values[places] for name, values in self.tensors.items()}

    def where(self, number: int) -> str:
        """Store and frame of an item, or its number where no frames are known."""
        return f"item {number}" if self._frames is None else frame_of(self._frames, number)


def frame_of(frames: TouchFrames, number: int) -> str:
    """Row, trajectory and store of a frame in words, for messages."""
    place = f"frame {int(frames.rows[number])} (trajectory {frames.trajectories[number]})"
    return f"{place} of {frames.arrays.location}"
