"""Event-locked means: residuals aligned at an event and averaged over trajectories, minus their mean before the event.

A window ends at the previous and at the next event. Runs of neighbouring frames with a large studentised mean are
clusters. The p-value of a cluster compares it with the largest cluster after flipping the signs of whole trajectories,
over all kinds of events and all components together (Maris and Oostenveld 2007).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import Array
from tactiledata.diagnose.locate.events import Events, stretch_numbers
from tactiledata.diagnose.residuals.residuals import Residuals
from tactiledata.diagnose.residuals.sign_flips import DRAWS, signs
from tactiledata.diagnose.residuals.wording import p_words, rounded

BEFORE, AFTER = 4, 8
"""Number of frames of the window before and after the event."""
THRESHOLD = 2.0
"""Least absolute studentised mean of a frame that belongs to a cluster."""
CHUNK = 200
"""Sign flips that are computed at a time, to limit memory."""


@dataclass(frozen=True)
class Cluster:
    """A run of frames about an event in which the mean of one component is large.

    Parameters
    ----------
    component : str
        Name of the component.
    start, stop : int
        Frames relative to the event; ``stop`` is not included.
    mass : float
        Sum of the studentised means over the run.
    p : float
        Family-wise p-value over all events and components.
    peak : float
        Mean of largest absolute value in the run, in the unit that `Residuals.scale` names.
    """

    component: str
    start: int
    stop: int
    mass: float
    p: float
    peak: float


@dataclass(frozen=True)
class EventLocked:
    """Event-locked means of one kind of event, and their clusters.

    Parameters
    ----------
    event : str
        Name of the event.
    trajectories : int
        Number of units of exchange that have the event.
    frames : (w,)
        Frames of the window, relative to the event.
    mean, deviation : (w, k)
        Mean over units of exchange and its standard error, in the unit that `Residuals.scale` names; NaN
        where fewer than 5 have the frame.
    clusters : tuple of Cluster
        The clusters, the most certain first.
    words : str
        The result as a clause.
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
        """p-value of the most certain cluster; 1 where there is none."""
        return min([cluster.p for cluster in self.clusters], default=1.0)


def event_locked(
    residuals: Residuals,
    events: Sequence[Events],
    before: int = BEFORE,
    after: int = AFTER,
    seed: int = 0,
    draws: int = DRAWS,
) -> tuple[EventLocked, ...]:
    """Return the event-locked means and clusters of every kind of event, in the given order.

    Parameters
    ----------
    residuals : Residuals
        Residuals of n frames; pass the score of a projection to remove what the parameters absorb.
    events : sequence of Events
        The kinds of events.
    before, after : int
        Number of frames of the window before and after the event.
    seed : int
        Random seed of the sign flips.
    draws : int
        Number of sign flips.

    Raises
    ------
    TactileDataError
        There are too few units of exchange.
    """
    residuals.need_units("event-locked means")
    frames = np.arange(-before, after)
    windows = [_windows(residuals, kind, frames) for kind in events]
    # the largest cluster of any event and component after each sign flip
    flips = signs(residuals.unit_count, draws, seed)
    largest = np.zeros(draws)
    for window in windows:
        for start in range(0, draws, CHUNK):
            rows = slice(start, start + CHUNK)
            runs = _runs(window.flipped(flips[rows]))
            np.maximum(largest[rows], np.abs(runs).max(axis=(1, 2)), out=largest[rows])
    return tuple(
        _summary(kind, window, residuals, frames, largest) for kind, window in zip(events, windows, strict=True)
    )


@dataclass(frozen=True)
class _Window:
    """Means about the events of one kind, one for each unit of exchange, and their sums over units."""

    sums: Array  # (u, w, k), 0 where a unit has no such frame
    counts: Array  # (w, 1) units that have it
    squares: Array  # (w, k)
    trajectories: int

    def flipped(self, flips: Array) -> Array:
        """Return the studentised means (draws, w, k) after each unit is multiplied by its sign (draws, u)."""
        flat = flips @ self.sums.reshape(len(self.sums), -1)
        return self._student(flat.reshape(len(flips), *self.sums.shape[1:]))

    def observed(self) -> Array:
        """Return the studentised means (1, w, k) of the data."""
        return self._student(self.sums.sum(axis=0)[None])

    def _student(self, total: Array) -> Array:
        """Return the studentised means from sums (…, w, k); 0 where fewer than 5 units have the frame."""
        counts = np.maximum(self.counts, 2.0)
        variance = np.maximum(self.squares - total**2 / counts, 1e-300) * counts / (counts - 1.0)
        return np.where(self.counts >= 5, total / np.sqrt(variance), 0.0)


def _windows(residuals: Residuals, events: Events, frames: NDArray[np.int64]) -> _Window:
    """Return residuals about each event, less the mean before it, averaged over each unit's events."""
    rows = events.rows[:, None] + frames
    inside = (rows >= 0) & (rows < len(residuals.values))
    rows = np.clip(rows, 0, len(residuals.values) - 1)
    # only the stretches that end and begin at this event: frames beyond another event belong to that one
    number = stretch_numbers(residuals)
    inside &= number[rows] == np.where(frames < 0, number[events.rows - 1][:, None], number[events.rows][:, None])
    # subtract the mean before the event
    values = np.where(inside[:, :, None], residuals.values[rows], 0.0)
    is_before = inside & (frames < 0)
    values = values - (values * is_before[:, :, None]).sum(axis=1, keepdims=True) / np.maximum(
        is_before.sum(axis=1), 1
    ).reshape(-1, 1, 1)
    values = np.where(inside[:, :, None], values, 0.0)
    # mean over the events of each unit
    unit = residuals.unit_of_trajectory[residuals.trajectory[events.rows]]
    sums = np.zeros((residuals.unit_count, *values.shape[1:]))
    counts = np.zeros((residuals.unit_count, len(frames)))
    np.add.at(sums, unit, values)
    np.add.at(counts, unit, inside.astype(np.float64))
    sums /= np.maximum(counts, 1.0)[:, :, None]
    return _Window(sums, (counts > 0).sum(axis=0)[:, None].astype(float), (sums**2).sum(axis=0), len(np.unique(unit)))


def _runs(student: Array) -> Array:
    """Return running sums (draws, w, k) of studentised means over neighbouring large frames of one sign."""
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
    """Return the means, clusters and clause of one kind of event.

    Parameters
    ----------
    events : Events
        The kind of event.
    window : _Window
        Its means about the events.
    residuals : Residuals
        Names of components and the scale of values.
    frames : (w,)
        Frames of the window, relative to the event.
    largest : (draws,)
        Largest absolute mass of any cluster after each sign flip.
    """
    student = window.observed()
    runs = _runs(student)[0]
    count = np.maximum(window.counts, 1.0)
    mean = np.where(window.counts >= 5, window.sums.sum(axis=0) / count, np.nan)
    deviation = np.sqrt(np.maximum(window.squares / count - np.nan_to_num(mean) ** 2, 0.0) / np.maximum(count - 1, 1.0))
    # a run ends where the running sum returns to 0 or changes its sign; go back from there to its start
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
    clusters.sort(key=lambda cluster: (cluster.p, -abs(cluster.mass)))
    deviation = np.where(window.counts >= 5, deviation, np.nan)
    words = _words(events.name, clusters, residuals.scale)
    return EventLocked(events.name, window.trajectories, frames, mean, deviation, tuple(clusters), words)


def _words(event: str, clusters: list[Cluster], scale: str) -> str:
    """Return a clause on the most certain cluster of an event, and the other components with certain clusters."""
    certain = [cluster for cluster in clusters if cluster.p <= 0.05]
    if not certain:
        return f"{event}: no departure begins there"
    first = certain[0]
    places = (
        f"frame {first.start:+d}"
        if first.stop == first.start + 1
        else f"frames {first.start:+d} to {first.stop - 1:+d}"
    )
    names = sorted({cluster.component for cluster in certain} - {first.component})
    also = f"; also in {', '.join(names)}" if names else ""
    size = f"{rounded(first.peak)} {scale}"
    return f"{event}: {first.component} departs by {size} at {places} ({p_words(first.p)}){also}"
