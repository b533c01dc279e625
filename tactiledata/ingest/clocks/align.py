"""Values of a signal at the moments of the frames, with the distance between the samples that each lies between."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tactiledata.contract.records import Times, Values
from tactiledata.contract.take import AlignedSignal, StoredSignal
from tactiledata.transforms import interpolate_poses

POSE_COLUMNS = ("x", "y", "z", "qx", "qy", "qz", "qw")
LINEAR = "linear interpolation between the neighbouring samples"
SLERP = "linear in position, slerp in rotation, between the neighbouring samples"


def broken_rotations(poses: Values) -> NDArray[np.bool_]:
    """Return a mask (n,) of poses (n, 7) whose quaternion is no rotation: its norm is off 1 by more than a tenth."""
    with np.errstate(over="ignore", invalid="ignore"):
        return ~(np.abs(np.linalg.norm(poses[:, 3:], axis=1) - 1) < 0.1)


def fractions_between(sample_t_ns: Times, frame_t_ns: Times) -> NDArray[np.float64]:
    """Return where frames lie between the two samples that `align` interpolates, 0 at the earlier and 1 at the later.

    Frames before the first or after the last sample are left out, as `align` gives them no value.

    Parameters
    ----------
    sample_t_ns : (n,) int64, non-decreasing
    frame_t_ns : (n_frames,) int64
    """
    times = np.unique(sample_t_ns)
    inside = frame_t_ns[(frame_t_ns >= times[0]) & (frame_t_ns <= times[-1])] if len(times) else frame_t_ns[:0]
    if not len(inside):
        return np.empty(0)
    fractions = np.zeros(len(inside))
    after = np.searchsorted(times, inside, side="left")
    between = times[after] > inside
    later, earlier = times[after[between]], times[after[between] - 1]
    fractions[between] = (inside[between] - earlier) / (later - earlier)
    return fractions


def align(signal: StoredSignal, frame_t_ns: Times, is_off: NDArray[np.bool_] | None = None) -> AlignedSignal:
    """A signal's values at the frames' times.

    Samples that are not finite are left out; of samples with one time the first is taken. Nothing is extrapolated: a
    frame before the first or after the last sample has NaN and a gap of -1.

    Parameters
    ----------
    signal : StoredSignal
        ``t_ns`` non-decreasing.
    frame_t_ns : (n_frames,) int64
    is_off : (n_frames,) bool, optional
        Frames whose time is not the one at which they were taken: they have no value either.
    """
    is_pose = signal.columns == POSE_COLUMNS
    usable = np.isfinite(signal.values).all(axis=1)
    if is_pose:
        # no quaternion near zero turns anything; `timeline` says how many there are
        usable &= ~broken_rotations(signal.values)
    times, first = np.unique(signal.t_ns[usable], return_index=True)
    samples = signal.values[usable][first]
    values = np.full((len(frame_t_ns), len(signal.columns)), np.nan)
    gap = np.full(len(frame_t_ns), -1, dtype=np.int64)
    if len(times):
        after = np.clip(np.searchsorted(times, frame_t_ns, side="left"), 0, len(times) - 1)
        exact = times[after] == frame_t_ns
        between = (frame_t_ns > times[0]) & (frame_t_ns < times[-1]) & ~exact
        if is_off is not None:
            exact, between = exact & ~is_off, between & ~is_off
        gap[exact] = 0
        gap[between] = times[after[between]] - times[after[between] - 1]
        inside = exact | between
        # int64 nanoseconds since the epoch do not fit float64; distances from the first sample do
        knots = (times - times[0]).astype(np.float64)
        wanted = (frame_t_ns[inside] - times[0]).astype(np.float64)
        if is_pose and inside.any():
            values[inside] = interpolate_poses(knots, samples, wanted)
        elif inside.any():
            values[inside] = np.stack(
                [np.interp(wanted, knots, samples[:, column]) for column in range(samples.shape[1])], axis=1
            )
    return AlignedSignal(values, gap, signal.columns, signal.units, signal.frame, SLERP if is_pose else LINEAR)
