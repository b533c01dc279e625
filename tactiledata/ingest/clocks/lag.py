"""How late the camera is against the force sensor: estimated and reported, never applied.

The mean change of an image against the free-air background grows with the contact force. Where loading and unloading
are both recorded, only the right lag makes one a function of the other; a wrong one opens a loop. So the lag is where
the rank correlation of the two peaks. Source: our own.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from tactiledata.contract.records import Finding
from tactiledata.contract.take import Take

LAGS = np.arange(-300, 301, 10) * 1_000_000
"""ns. Lags that are tried; positive: the camera is late."""

MIN_RATE = 8.0
"""Hz. Slower capture cannot resolve the lags of real cameras (20 to 200 ms)."""

MIN_FRAMES = 15
MAX_TOUCHES = 6
MAX_FRAMES = 48
MIN_CORRELATION = 0.9
MIN_PEAK, BESIDE = 0.01, 10
"""Fall of the correlation so many lags (100 ms) beside its peak, below which the recording does not determine it."""


def camera_lag(take: Take, decode: Callable[[NDArray[np.int64]], list[NDArray[np.uint8] | None]]) -> list[Finding]:
    """Findings on the camera's lag.

    Parameters
    ----------
    take : Take
    decode : callable
        Images of rows of ``take.frames``.
    """
    contact = take.signals.get("contact_wrench")
    if contact is None:
        return []
    force = np.linalg.norm(contact.values[:, :3], axis=1)
    curves = []
    for rows in _moving_touches(take):
        activity = _activity(take, rows, decode)
        if activity is None:
            continue
        times, change = activity
        curves.append(_correlations(times, change, contact.t_ns, force))
    if not curves:
        return []
    best = clear_peak(np.nanmean(curves, axis=0))
    if best is None:
        return []
    each = [int(LAGS[int(np.nanargmax(curve))]) for curve in curves]
    text = lag_in_words(int(LAGS[best]), _frame_distance(take), each)
    return [Finding("camera-lag", "info", text, count=len(curves))]


def clear_peak(curve: NDArray[np.float64]) -> int | None:
    """Index of the peak of a correlation at each of `LAGS` (n,); ``None`` for a low peak, or one that hardly falls."""
    best = int(np.nanargmax(curve))
    beside = curve[[max(best - BESIDE, 0), min(best + BESIDE, len(curve) - 1)]]
    return None if curve[best] < MIN_CORRELATION or curve[best] - beside.max() < MIN_PEAK else best


def lag_in_words(lag_ns: int, frame_ns: float, each_ns: Sequence[int]) -> str:
    """The sentence about a camera's lag: a lag that may as well be nothing is not stated as one.

    Parameters
    ----------
    lag_ns : int
        The estimate; positive: images come late.
    frame_ns : float
        Time between two frames: a lag is not known any finer.
    each_ns : sequence of int
        Estimates of the touches one by one; half their spread is a doubt as well.
    """
    spread = max(each_ns) - min(each_ns)
    doubt = max(frame_ns, spread / 2)
    apart = f"; the {len(each_ns)} touches judged one by one spread over {spread / 1e6:.0f} ms" if each_ns[1:] else ""
    if abs(lag_ns) <= doubt:
        return (
            f"camera lag: none seen (less than {math.ceil((abs(lag_ns) + doubt) / 1e6)} ms; frames are "
            f"{frame_ns / 1e6:.0f} ms apart{apart})"
        )
    return (
        f"the camera is {lag_ns / 1e6:+.0f} ms against the force sensor, give or take {doubt / 1e6:.0f} ms; + means "
        f"that images come late{apart}. Reported, not applied"
    )


def _frame_distance(take: Take) -> float:
    """Median time between neighbouring frames of a trajectory, ns: a lag is not known any finer."""
    trajectory, t_ns = take.frames["trajectory"].to_numpy(), take.frames["t_ns"].to_numpy()
    return float(np.median(np.diff(t_ns)[np.diff(trajectory) == 0]))


def _moving_touches(take: Take) -> list[NDArray[np.int64]]:
    """Rows of frames of the touches that were filmed fast enough, the longest first."""
    trajectory = take.frames["trajectory"].to_numpy()
    t_ns = take.frames["t_ns"].to_numpy()
    force = take.frames["contact_force"].to_numpy()
    encoding = np.array(take.frames["encoding"].to_pylist(), dtype=object)
    touches = []
    for number in range(take.trajectories.num_rows):
        rows = np.flatnonzero((trajectory == number) & (encoding != "missing") & np.isfinite(force))
        if len(rows) < MIN_FRAMES or np.median(np.diff(t_ns[rows])) > 1e9 / MIN_RATE:
            continue
        touched = rows[force[rows] > 0.5]
        if len(touched) >= MIN_FRAMES:
            touches.append(touched)
    touches.sort(key=len, reverse=True)
    return [rows[np.unique(np.linspace(0, len(rows) - 1, MAX_FRAMES).astype(int))] for rows in touches[:MAX_TOUCHES]]


def _activity(
    take: Take, rows: NDArray[np.int64], decode: Callable[[NDArray[np.int64]], list[NDArray[np.uint8] | None]]
) -> tuple[NDArray[np.int64], NDArray[np.float64]] | None:
    """Times (n,) and mean absolute change (n,) of a touch's images against the sensor's reference."""
    sensor = take.frames["sensor"][int(rows[0])].as_py()
    reference = take.references.get(sensor)
    if reference is None:
        return None
    times, change = [], []
    t_ns = take.frames["t_ns"].to_numpy()
    # every fourth pixel is enough for a mean, and quarters the time
    background = reference.image[::2, ::2].astype(np.int16)
    for row, image in zip(rows, decode(rows), strict=True):
        if image is not None and image.shape == reference.image.shape:
            times.append(t_ns[row])
            change.append(float(np.abs(image[::2, ::2].astype(np.int16) - background).mean()))
    return (np.array(times), np.array(change)) if len(times) >= MIN_FRAMES else None


def _correlations(
    times: NDArray[np.int64], change: NDArray[np.float64], force_t_ns: NDArray[np.int64], force: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Rank correlation of image change and force at each of `LAGS`."""
    usable = np.isfinite(force)
    origin = force_t_ns[0]
    knots, values = (force_t_ns[usable] - origin).astype(float), force[usable]
    ranks = pd.Series(change).rank()
    result = []
    for lag in LAGS:
        shifted = np.interp((times - lag - origin).astype(float), knots, values)
        with np.errstate(invalid="ignore", divide="ignore"):
            result.append(np.corrcoef(ranks, pd.Series(shifted).rank())[0, 1])
    return np.array(result)
