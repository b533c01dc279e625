"""Readings of the force sensor in free air (its zero), over all trajectories of a store."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.ndimage import uniform_filter1d

from tactiledata.arrays import Array, Indices
from tactiledata.contract.description import LogDescription
from tactiledata.contract.records import Stamps
from tactiledata.contract.take import StoredSignal
from tactiledata.diagnose.touches.rest_means import position_jitter
from tactiledata.diagnose.zeros.inertia import FreeAirMoves
from tactiledata.effects.touch.felt_acceleration import felt_accelerations
from tactiledata.ingest.clocks.align import POSE_COLUMNS, broken_rotations
from tactiledata.ingest.forces.contact import zeros_at
from tactiledata.ingest.forces.gravity import tool_weight, without_pose
from tactiledata.ingest.forces.onset import SURELY_FREE, before_touch, component_noise, touch_threshold, touching
from tactiledata.ingest.forces.tare_events import locate_tares, without_steps
from tactiledata.replay.opened import OpenedStore
from tactiledata.store.read.signal_rows import SignalRows
from tactiledata.transforms import pose_matrices

PIECES = 8
"""Most pieces into which a stretch of free air is cut; each gives one mean reading."""
SHAKEN = 0.2
"""Seconds over which readings are averaged where a touch is sought: more than a period of an arm's vibration."""
RINGS_ON = 0.3
"""Seconds after the first pose for which an arm may still vibrate from what it did before."""
FEWEST_READINGS = 10
"""Fewest readings of a piece."""


@dataclass(frozen=True)
class ForceZeros:
    """Mean readings of n pieces of free air, in the order of trajectories.

    Parameters
    ----------
    load : (n, 6) N, N m
        Mean reading as a load on the sensor, minus the stated weight of the tool; force sensor's frame.
    trajectory : (n,)
        Number of the trajectory in the store.
    zeroed : (n,)
        Number of the stretch between two moments at which the sensor was tared (set to zero).
    down : (n, 3)
        Unit vector of gravity in the force sensor's frame.
    seconds : (n,)
        Time in s since the sensor was switched on, where the log states it; else since the start of the log.
    remaining : (n,) s
        Time from the piece to the end of its trajectory.
    joints : (n, 6) rad, optional
        Joint angles of the robot; ``None`` where any piece lacks them.
    weight : (n, 6) N, N m, optional
        Weight of the tool as ``log.yaml`` states it, as a load on the sensor in its frame; ``None`` where any piece
        lacks it.
    """

    load: Array
    trajectory: Indices
    zeroed: Indices
    down: Array
    seconds: Array
    remaining: Array
    joints: Array | None
    weight: Array | None = None

    def __len__(self) -> int:
        return len(self.load)

    @property
    def trajectories(self) -> int:
        """Number of trajectories that have at least one piece."""
        return len(np.unique(self.trajectory))


@dataclass(frozen=True)
class _FreeAir:
    """Readings of one trajectory before its first touch.

    Parameters
    ----------
    stretches : list of (int, (m, 6), (m,))
        As `free_air_between` returns them.
    starts_ns, ends_ns : int
        Times of the first and the last reading of the trajectory.
    tcp : StoredSignal
        Poses of the tool.
    ft_from_tcp : (3, 3)
        Rotation of the force sensor's frame.
    description : LogDescription
        What the log says of the tool.
    """

    stretches: list[tuple[int, Array, Indices]]
    starts_ns: int
    ends_ns: int
    tcp: StoredSignal
    ft_from_tcp: Array
    description: LogDescription


class StoreReadings:
    """Readings of the force sensor in all trajectories of a store; each trajectory is read once.

    Parameters
    ----------
    opened : OpenedStore
        The store.
    """

    def __init__(self, opened: OpenedStore) -> None:
        self._store, self._descriptions, self._rows = opened.store, opened.descriptions, opened.trajectories

    def zeros(self) -> ForceZeros:
        """Return the zeros of all trajectories that begin in free air and have poses; empty without any."""
        pieces = [
            piece for number, air in enumerate(self._free_air) if air is not None for piece in self._pieces(number, air)
        ]
        joints, weights = ([piece[name] for piece in pieces] for name in ("joints", "weight"))
        return ForceZeros(
            np.array([piece["load"] for piece in pieces]).reshape(-1, 6),
            np.array([piece["trajectory"] for piece in pieces], dtype=np.int64),
            np.unique([f"{piece['zeroed']}" for piece in pieces], return_inverse=True)[1].astype(np.int64),
            np.array([piece["down"] for piece in pieces]).reshape(-1, 3),
            np.array([piece["seconds"] for piece in pieces], dtype=np.float64),
            np.array([piece["remaining"] for piece in pieces], dtype=np.float64),
            np.array(joints) if joints and all(angles is not None for angles in joints) else None,
            np.array(weights) if weights and all(weight is not None for weight in weights) else None,
        )

    def logged(self) -> list[Array]:
        """Return the readings (m, 6), N and N m, of each trajectory that has forces, as they were logged."""
        return [wrench.values for wrench in self._wrenches if wrench is not None]

    def moves(self) -> list[FreeAirMoves]:
        """Return the free air of all trajectories, with the acceleration of a tool that swings on the arm."""
        return [move for number, air in enumerate(self._free_air) if air is not None for move in _moves_in(number, air)]

    @cached_property
    def _wrenches(self) -> list[StoredSignal | None]:
        """Readings of each trajectory, ``None`` where it has none."""
        return [self._signal("wrench", row["spans"]) for row in self._rows]

    @cached_property
    def _free_air(self) -> list[_FreeAir | None]:
        """Free air of each trajectory, ``None`` where forces or poses lack."""
        return [self._free_air_of(row, wrench) for row, wrench in zip(self._rows, self._wrenches, strict=True)]

    def _pieces(self, number: int, air: _FreeAir) -> list[dict[str, Any]]:
        """Return the pieces of one trajectory; keys as the fields of `ForceZeros`."""
        row = self._rows[number]
        joints = self._signal("joints", row["spans"])
        switched_on = self._descriptions[row["source"]].switched_on(row["sensor"], air.starts_ns)
        since = self._start(row["source"]) if switched_on is None else switched_on
        # one mean reading for each piece, with pose and joints at its middle
        listed = []
        parts = [(*stretch, part) for stretch in air.stretches for part in pieces_of(len(stretch[1]))]
        middles = [int(t_ns[part[len(part) // 2]]) for _, _, t_ns, part in parts]
        weights = tool_weight(air.description, air.tcp, np.array(middles, dtype=np.int64)) if middles else None
        for place, (middle, (zeroed, readings, _, part)) in enumerate(zip(middles, parts, strict=True)):
            pose = pose_matrices(_nearest(air.tcp, middle)[None])[0]
            angles = None if joints is None else _nearest(joints, middle)[:6]
            listed.append({
                "load": readings[part].mean(axis=0),
                "trajectory": number,
                "zeroed": (row["source"], zeroed),
                "down": -(air.ft_from_tcp @ pose[:3, :3].T)[:, 2],
                "seconds": (middle - since) / 1e9,
                "remaining": (air.ends_ns - middle) / 1e9,
                "joints": angles,
                "weight": None if weights is None else weights[place],
            })  # fmt: skip
        return [piece for piece in listed if np.isfinite(piece["load"]).all() and np.isfinite(piece["down"]).all()]

    def _free_air_of(self, row: Mapping[str, Any], wrench: StoredSignal | None) -> _FreeAir | None:
        """Return the free air of one trajectory, from its row of the table; ``None`` where forces or poses lack."""
        description = self._descriptions[row["source"]]
        tcp_from_ft = description.transform("tcp_from_ft")
        tcp = self._signal("tcp", row["spans"])
        if wrench is None or tcp is None or tcp_from_ft is None:
            return None
        # readings as loads on the sensor, without the weight that log.yaml states
        stated = description.wrench
        load = wrench.values if stated.get("sign", "load_on_sensor") == "load_on_sensor" else -wrench.values
        if (
            stated.get("gravity") != "compensated"
            and (weight := tool_weight(description, tcp, wrench.t_ns)) is not None
        ):
            load = np.where(without_pose(tcp, wrench.t_ns)[:, None], np.nan, load - weight)
        # stretches of free air between tares
        tare_ns = [int(moment) for moment in stated.get("tare_ns", [])]
        stretches = free_air_between(load, wrench.t_ns, tare_ns, zeros_at(description, tcp, tare_ns))
        turn = tcp_from_ft.inverse().rotation
        return _FreeAir(stretches, int(wrench.t_ns[0]), int(wrench.t_ns[-1]), tcp, turn, description)

    def _signal(self, stream: str, spans: Mapping[str, Any]) -> StoredSignal | None:
        """Return the finite rows of a stream, such as ``"wrench"``, in one trajectory; ``None`` where there are none.

        Poses whose quaternion is no rotation, such as zeros in place of a lost pose, are left out, too. ``spans``
        holds the first and last row of each signal of the trajectory.
        """
        name = next((name for name in spans if name.partition("@")[0] == stream), None)
        if name is None or spans[name][0] == spans[name][1]:
            return None
        signal: SignalRows = self._store.signal(name)
        values, t_ns = signal.values(*spans[name]), signal.t_ns(*spans[name])
        is_finite = np.isfinite(values).all(axis=1)
        if signal.columns == POSE_COLUMNS:
            is_finite &= ~broken_rotations(values)
        if not is_finite.any():
            return None
        return StoredSignal(
            t_ns[is_finite], values[is_finite], signal.columns, signal.units, signal.frame, Stamps(t_ns[is_finite])
        )

    def _start(self, source: int) -> int:
        """Return the time in ns at which the first trajectory of a source begins."""
        table = self._store.trajectories(["source", "start_ns"])
        starts = np.asarray(table["start_ns"])[np.asarray(table["source"]) == source]
        return int(starts.min())


def _moves_in(number: int, air: _FreeAir) -> list[FreeAirMoves]:
    """Return the stretches of free air of one trajectory with the tool's acceleration, force sensor's frame."""
    start, places = air.tcp.t_ns[0], air.tcp.values[:, :3]
    moments = (air.tcp.t_ns - start) * 1e-9
    unit = felt_accelerations(moments, moments, np.random.default_rng(0).normal(size=places.shape))
    blur = position_jitter(places) ** 2 * (unit**2).mean(axis=(0, 2))
    listed = []
    for _, readings, t_ns in air.stretches:
        # what the arm did before the poses begin rings on for a while
        known = np.isfinite(readings).all(axis=1) & (t_ns > start + RINGS_ON * 1e9)
        seconds = (t_ns[known] - start) * 1e-9
        felt = felt_accelerations(seconds, moments, places)
        turns = pose_matrices(air.tcp.values[_nearest_rows(air.tcp, t_ns[known])])[:, :3, :3]
        in_sensor = np.einsum("ij,nkj,nfk->nfi", air.ft_from_tcp, turns, felt)
        listed.append(FreeAirMoves(number, seconds, readings[known, :3], in_sensor, blur))
    return listed


def pieces_of(count: int) -> list[Indices]:
    """Return row indices of each piece of ``count`` readings; empty with fewer than `FEWEST_READINGS`."""
    pieces = min(PIECES, count // FEWEST_READINGS)
    return np.array_split(np.arange(count), pieces) if pieces else []


def free_air_readings(load: Array, t_ns: Indices) -> tuple[Array, Indices]:
    """Return the readings (n, 6) of a trajectory before its first touch, without repeated readings, and their times
    (n,) in ns.
    """
    air = free_air_between(load, t_ns, [], np.zeros((0, 6)))
    return (air[0][1], air[0][2]) if air else (load[:0], t_ns[:0])


def free_air_between(load: Array, t_ns: Indices, tare_ns: list[int], zeros: Array) -> list[tuple[int, Array, Indices]]:
    """Return the readings of a trajectory before its first touch, in the stretches between tare events.

    A jump of the zero at a tare is not taken for a touch.

    Parameters
    ----------
    load : (n, 6) N, N m
        Load on the sensor; repeated readings are dropped.
    t_ns : (n,) int64
        Time of each reading in ns.
    tare_ns : list of int
        Stated tare events of the whole recording, in ns.
    zeros : (len(tare_ns), 6) N, N m
        Load, without the tool's weight, that a reading of 0 means at each tare event.

    Returns
    -------
    list of (int, (m, 6), (m,))
        For each stretch: the number of tare events before it, its loads and its times in ns.
    """
    is_new = np.ones(len(load), dtype=bool)
    is_new[1:] = (np.diff(load, axis=0) != 0).any(axis=1)
    load, t_ns = load[is_new], t_ns[is_new]
    if len(load) < FEWEST_READINGS:
        return []
    # the first touch is sought in readings from which the jumps at tares are removed
    noise = component_noise(load)
    inside = [tare for tare in locate_tares(t_ns, load, tare_ns, zeros, noise)[0] if tare.row > 0]
    steady = without_steps(load, inside, 0, len(load))
    # a touch lasts: an arm that starts shakes the tool, by more than the threshold, to either side
    width = max(1, round(SHAKEN / max(float(np.median(np.diff(t_ns))) * 1e-9, 1e-9)))
    lasting = uniform_filter1d(steady[:, :3], min(width, len(steady)), axis=0, mode="nearest")
    from_start = lasting - np.median(steady[: max(FEWEST_READINGS, 2 * width), :3], axis=0)
    touched = np.flatnonzero(touching(np.linalg.norm(from_start, axis=1), touch_threshold(noise)))
    first = before_touch(int(touched[0]) if len(touched) else len(load), steady, t_ns)
    # each stretch ends safely before the first touch
    borders = [0, *(tare.row for tare in inside), len(load)]
    before = sum(moment < t_ns[0] for moment in tare_ns)
    stretches = []
    for number, (start, stop) in enumerate(itertools.pairwise(borders)):
        stop = min(stop, start + int(SURELY_FREE * (first - start)))
        if stop > start:
            stretches.append((before + number, load[start:stop], t_ns[start:stop]))
    return stretches


def _nearest(signal: StoredSignal, moment: int) -> Array:
    """Return the row of a signal whose time is nearest to a moment in ns."""
    return np.asarray(signal.values[_nearest_rows(signal, np.array([moment]))[0]])


def _nearest_rows(signal: StoredSignal, t_ns: Indices) -> Indices:
    """Return the rows (m,) of a signal whose times are nearest to times (m,) in ns."""
    after = np.clip(np.searchsorted(signal.t_ns, t_ns), 1, max(len(signal.t_ns) - 1, 1))
    is_before = t_ns - signal.t_ns[after - 1] <= signal.t_ns[np.minimum(after, len(signal.t_ns) - 1)] - t_ns
    return np.minimum(np.where(is_before, after - 1, after), len(signal.t_ns) - 1)
