"""Residuals aligned at an event and averaged over trajectories: what the event alone brings.

A window reaches to the events before and after it; its mean before the event is taken off. Runs of neighbouring frames
whose mean stands out are clusters; the largest cluster is compared with the largest that arises when whole trajectories
change their sign (Maris and Oostenveld 2007), over all kinds of events and all components together.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import Array
from tactiledata.diagnose.locate.events import Events, stretch
from tactiledata.diagnose.residuals.residuals import Residuals
from tactiledata.diagnose.residuals.sign_flips import DRAWS, signs
from tactiledata.diagnose.residuals.wording import p_words, rounded

BEFORE, AFTER = 4, 8
"""Frames about the event."""
THRESHOLD = 2.0
"""Of the studentised mean, from which on a frame may belong to a cluster."""
CHUNK = 200


@dataclass(frozen=True)
class Cluster:
    """A run of frames that stands out.

    Parameters
    ----------
    component : str
    start, stop : int
        Frames after the event, ``stop`` not included.
    mass : float
        Sum of the studentised means.
    p : float
        For all events and components together.
    peak : float
        Largest mean in the run, times the noise.
    """

    component: str
    start: int
    stop: int
    mass: float
    p: float
    peak: float


@dataclass(frozen=True)
class EventLocked:
    """One kind of event.

    Parameters
    ----------
    event : str
    trajectories : int
    frames : (w,)
        Relative to the event.
    mean, deviation : (w, k)
        Over trajectories, and its standard error; NaN where too few have such a frame.
    clusters : the certain ones first
    words : str
    """

    event: str
    trajectories: int
    frames: NDArray[np.int64]
    mean: Array
    deviation: Array
    clusters: tuple[Cluster, ...]
    words: str

    @property
    def p(self) -> float:
        """Of the largest cluster."""
        return min([cluster.p for cluster in self.clusters], default=1.0)


def event_locked(
    residuals: Residuals,
    events: Sequence[Events],
    before: int = BEFORE,
    after: int = AFTER,
    seed: int = 0,
    draws: int = DRAWS,
) -> tuple[EventLocked, ...]:
    """Every kind of event, in the order given.

    Raises
    ------
    TactileDataError
        Too few units of exchange.
    """
    residuals.need_units("event-locked means")
    frames = np.arange(-before, after)
    windows = [_windows(residuals, one, frames) for one in events]
    thrown = signs(residuals.unit_count, draws, seed)
    largest = np.zeros(draws)
    for window in windows:
        for start in range(0, draws, CHUNK):
            rows = slice(start, start + CHUNK)
            runs = _runs(window.flipped(thrown[rows]))
            np.maximum(largest[rows], np.abs(runs).max(axis=(1, 2)), out=largest[rows])
    return tuple(_summary(one, window, residuals, frames, largest) for one, window in zip(events, windows, strict=True))


@dataclass(frozen=True)
class _Window:
    """Means about the events: one for each trajectory, then summed over units of exchange."""

    sums: Array  # (u, w, k), 0 where a unit has no such frame
    counts: Array  # (w, 1) units that have it
    squares: Array  # (w, k)
    trajectories: int

    def flipped(self, thrown: Array) -> Array:
        """Studentised means (draws, w, k)."""
        flat = thrown @ self.sums.reshape(len(self.sums), -1)
        return self._student(flat.reshape(len(thrown), *self.sums.shape[1:]))

    def observed(self) -> Array:
        return self._student(self.sums.sum(axis=0)[None])

    def _student(self, total: Array) -> Array:
        counts = np.maximum(self.counts, 2.0)
        variance = np.maximum(self.squares - total**2 / counts, 1e-300) * counts / (counts - 1.0)
        return np.where(self.counts >= 5, total / np.sqrt(variance), 0.0)


def _windows(residuals: Residuals, events: Events, frames: NDArray[np.int64]) -> _Window:
    rows = events.rows[:, None] + frames
    inside = (rows >= 0) & (rows < len(residuals.values))
    rows = np.clip(rows, 0, len(residuals.values) - 1)
    # only the stretches that the event parts: what lies behind another event is that event's affair
    number = stretch(residuals)
    inside &= number[rows] == np.where(frames < 0, number[events.rows - 1][:, None], number[events.rows][:, None])
    values = np.where(inside[:, :, None], residuals.values[rows], 0.0)
    is_before = inside & (frames < 0)
    values = values - (values * is_before[:, :, None]).sum(axis=1, keepdims=True) / np.maximum(
        is_before.sum(axis=1), 1
    ).reshape(-1, 1, 1)
    values = np.where(inside[:, :, None], values, 0.0)
    unit = residuals.unit_of_trajectory[residuals.trajectory[events.rows]]
    sums = np.zeros((residuals.unit_count, *values.shape[1:]))
    counts = np.zeros((residuals.unit_count, len(frames)))
    np.add.at(sums, unit, values)
    np.add.at(counts, unit, inside.astype(np.float64))
    sums /= np.maximum(counts, 1.0)[:, :, None]
    return _Window(sums, (counts > 0).sum(axis=0)[:, None].astype(float), (sums**2).sum(axis=0), len(np.unique(unit)))


def _runs(student: Array) -> Array:
    """Running sums (draws, w, k) of studentised means over frames above the threshold, of one sign."""
    runs = np.zeros_like(student)
    running = np.zeros((len(student), student.shape[2]))
    for frame in range(student.shape[1]):
        here = student[:, frame]
        stands_out = np.abs(here) > THRESHOLD
        running = np.where(stands_out, here + np.where(running * here > 0, running, 0.0), 0.0)
        runs[:, frame] = running
    return runs


def _summary(
    events: Events, window: _Window, residuals: Residuals, frames: NDArray[np.int64], largest: Array
) -> EventLocked:
    student = window.observed()
    runs = _runs(student)[0]
    has = np.maximum(window.counts, 1.0)
    mean = np.where(window.counts >= 5, window.sums.sum(axis=0) / has, np.nan)
    deviation = np.sqrt(np.maximum(window.squares / has - np.nan_to_num(mean) ** 2, 0.0) / np.maximum(has - 1, 1.0))
    clusters = []
    for column, component in enumerate(residuals.components):
        run = np.append(runs[:, column], 0.0)
        for stop in np.flatnonzero((run[:-1] != 0) & ((run[1:] == 0) | (run[1:] * run[:-1] < 0))) + 1:
            mass = float(run[stop - 1])
            start = stop - 1
            while start > 0 and run[start - 1] * mass > 0 and abs(run[start - 1]) < abs(run[start]):
                start -= 1
            p = float((1 + np.count_nonzero(largest >= abs(mass) - 1e-12)) / (1 + len(largest)))
            values = mean[start:stop, column]
            peak = float(values[np.abs(values).argmax()])
            clusters.append(Cluster(component, int(frames[start]), int(frames[stop - 1]) + 1, mass, p, peak))
    clusters.sort(key=lambda one: (one.p, -abs(one.mass)))
    deviation = np.where(window.counts >= 5, deviation, np.nan)
    words = _words(events.name, clusters, residuals.scale)
    return EventLocked(events.name, window.trajectories, frames, mean, deviation, tuple(clusters), words)


def _words(event: str, clusters: list[Cluster], scale: str) -> str:
    certain = [one for one in clusters if one.p <= 0.05]
    if not certain:
        return f"{event}: nothing that the event alone brings"
    first = certain[0]
    places = (
        f"frame {first.start:+d}"
        if first.stop == first.start + 1
        else f"frames {first.start:+d} to {first.stop - 1:+d}"
    )
    names = sorted({one.component for one in certain} - {first.component})
    also = f"; also in {', '.join(names)}" if names else ""
    size = f"{rounded(first.peak)} {scale}"
    return f"{event}: {first.component} departs by {size} at {places} ({p_words(first.p)}){also}"
