"""What a network learns from, batch by batch: pictures, meshes, latent vectors, each with what they are to become."""

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
    """Things with numbers from 0, read in batches."""

    @property
    def fingerprint(self) -> str:
        """The same for the same items."""

    def __len__(self) -> int: ...

    def batch(self, numbers: Sequence[int]) -> Batch:
        """Tensors with an item along their first axis."""

    def where(self, number: int) -> str:
        """In words, where an item comes from."""


class PictureItems:
    """Pictures of several sets of frames, and backgrounds of sensors among them.

    A batch has ``image`` (n, h, w, 3), uint8, and ``sensor`` (n,), int64: the place of each picture's sensor in
    ``sensor_names``, -1 for pictures of other sensors and of other sets than the first.

    Parameters
    ----------
    sets : TouchFrames, the first of them the one whose sensors' backgrounds are taken
    background_copies : int
        How often each sensor's picture without contact is among the items.
    sensor_names : sequence of str, optional
        Those that are told apart; those of the first set unless stated.
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
        """The same for the same pictures."""
        return digest_of([[frames.fingerprint for frames in self.sets], self._names])

    def __len__(self) -> int:
        return int(self._ends[-1]) + len(self._names)

    def batch(self, numbers: Sequence[int]) -> Batch:
        """``image`` and ``sensor``."""
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
        """Store and frame."""
        which = int(np.searchsorted(self._ends, number, side="right"))
        if which == len(self.sets):
            return f"the background of {self._names[number - int(self._ends[-1])]}"
        inside = number - (int(self._ends[which - 1]) if which else 0)
        return frame_of(self.sets[which], inside)


class FrameItems:
    """Of frames ``mesh`` (n, v, 3), m, ``image`` (n, h, w, 3) and ``force`` (n, 3), N, as far as they are asked for."""

    def __init__(self, frames: TouchFrames, what: Sequence[str]) -> None:
        self.frames, self.what = frames, tuple(what)

    @property
    def fingerprint(self) -> str:
        """The same for the same frames."""
        return digest_of([self.frames.fingerprint, list(self.what)])

    def __len__(self) -> int:
        return len(self.frames)

    def batch(self, numbers: Sequence[int]) -> Batch:
        """What was asked for."""
        read = {"mesh": self.frames.displacements, "image": self.frames.pictures, "force": self.frames.forces}
        return {name: torch.from_numpy(read[name](numbers)) for name in self.what}

    def where(self, number: int) -> str:
        """Store and frame."""
        return frame_of(self.frames, number)


class TensorItems:
    """Tensors that are in memory, all of one length: latent vectors and what they are to become.

    Parameters
    ----------
    tensors : dict
    fingerprint : str
        Names them.
    frames : TouchFrames, optional
        Whose frames they go with.
    """

    def __init__(self, tensors: Mapping[str, Tensor], fingerprint: str, frames: TouchFrames | None = None) -> None:
        self.tensors, self._fingerprint, self._frames = dict(tensors), fingerprint, frames

    @property
    def fingerprint(self) -> str:
        """As it was given."""
        return self._fingerprint

    def __len__(self) -> int:
        return len(next(iter(self.tensors.values())))

    def batch(self, numbers: Sequence[int]) -> Batch:
        """All of them."""
        places = torch.as_tensor(numbers)
        return {name: values[places] for name, values in self.tensors.items()}

    def where(self, number: int) -> str:
        """Store and frame, or the number."""
        return f"item {number}" if self._frames is None else frame_of(self._frames, number)


def frame_of(frames: TouchFrames, number: int) -> str:
    """In words, which frame of which store it is."""
    place = f"frame {int(frames.rows[number])} (trajectory {frames.trajectories[number]})"
    return f"{place} of {frames.arrays.location}"
