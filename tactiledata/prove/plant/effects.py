"""Effects that can be planted: changes of the force sensor's readings, or of what a log states of the gel."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from tactiledata.arrays import Array, Times
from tactiledata.contract.description import LogDescription
from tactiledata.contract.take import StoredSignal
from tactiledata.errors import UnknownName, UsageError
from tactiledata.ingest.clocks.align import align
from tactiledata.transforms import pose_matrices

LEVER = 0.02
"""Length, m, that turns a force into a torque of the same importance: of bands and drifts."""
GRAVITY = 9.80665
"""Standard acceleration of gravity, m/s^2."""


@dataclass(frozen=True)
class PlantedReadings:
    """Readings into which an effect is planted.

    Parameters
    ----------
    t_ns : (n,), ns
        Times on the host clock.
    values : (n, 6), N and N m
        Readings in the sensor's frame.
    base_from_tcp : (n, 4, 4), optional
        Poses of the tool at these times; ``None`` where the store has none.
    description : LogDescription
        What the log states.
    """

    t_ns: Times
    values: Array
    base_from_tcp: Array | None
    description: LogDescription

    @property
    def seconds(self) -> Array:
        """Seconds (n,) since the first reading."""
        return np.asarray((self.t_ns - self.t_ns[0]) * 1e-9, dtype=float)

    @staticmethod
    def of(wrench: StoredSignal, tcp: StoredSignal | None, description: LogDescription) -> PlantedReadings:
        """Return the readings of a take's signals.

        Parameters
        ----------
        wrench : StoredSignal
            Readings of the force sensor.
        tcp : StoredSignal, optional
            Stream of poses.
        description : LogDescription
            What the log states.
        """
        poses = None
        if tcp is not None and len(tcp.t_ns):
            held = np.clip(wrench.t_ns, tcp.t_ns[0], tcp.t_ns[-1])
            poses = pose_matrices(align(tcp, held).values)
        return PlantedReadings(wrench.t_ns, np.asarray(wrench.values, dtype=float), poses, description)


@dataclass(frozen=True)
class Plant:
    """An effect that can be planted.

    Parameters
    ----------
    title : str
        What it is, in words.
    unit : str
        Unit of its size.
    low, high : float
        Sizes between which one is drawn, evenly in its logarithm.
    named : tuple of str
        Effects of the catalogue that name it.
    change : callable, optional
        Returns the readings (n, 6) with the effect, from readings, size and a generator of directions; ``None`` where
        the effect changes what a log states.
    """

    title: str
    unit: str
    low: float
    high: float
    named: tuple[str, ...]
    change: Callable[[PlantedReadings, float, np.random.Generator], Array] | None

    def drawn(self, chance: np.random.Generator) -> float:
        """Return a drawn size, rounded to three digits."""
        size = float(np.exp(chance.uniform(np.log(self.low), np.log(self.high))))
        return float(f"{size:.3g}")


def _late(readings: PlantedReadings, size: float, chance: np.random.Generator) -> Array:
    """Return what was read a delay earlier; readings keep their stamps."""
    earlier = readings.seconds - size
    known = np.isfinite(readings.values).all(axis=1)
    columns = readings.values[known].T
    late = np.stack([np.interp(earlier, readings.seconds[known], column) for column in columns], axis=1)
    late[~known] = np.nan
    return late


def _turned(readings: PlantedReadings, size: float, chance: np.random.Generator) -> Array:
    """Return readings of a sensor that is turned about a direction of its own frame."""
    axis = chance.normal(size=3)
    rotation = Rotation.from_rotvec(size * axis / np.linalg.norm(axis)).as_matrix()
    turned: Array = np.concatenate([readings.values[:, :3] @ rotation.T, readings.values[:, 3:] @ rotation.T], axis=1)
    return turned


def _drifted(readings: PlantedReadings, size: float, chance: np.random.Generator) -> Array:
    """Return readings whose zero drifts evenly, by the size in a minute, in a direction that stays."""
    way = chance.normal(size=6)
    way /= np.linalg.norm(way[:3])
    scale = np.array([1.0, 1.0, 1.0, LEVER, LEVER, LEVER])
    drifted: Array = readings.values + size / 60.0 * readings.seconds[:, None] * (way * scale)
    return drifted


def _banded(readings: PlantedReadings, size: float, chance: np.random.Generator) -> Array:
    """Return readings that show 0 below a band, and its full value above."""
    band = size * np.array([1.0, 1.0, 1.0, LEVER, LEVER, LEVER])
    return np.where(np.abs(readings.values) < band, 0.0, readings.values)


def _gained(readings: PlantedReadings, size: float, chance: np.random.Generator) -> Array:
    """Return readings of which one axis of force is too large by a share."""
    factors = np.ones(6)
    factors[int(chance.integers(3))] += size
    gained: Array = readings.values * factors
    return gained


def _weighed(readings: PlantedReadings, size: float, chance: np.random.Generator) -> Array:
    """Return readings with the weight of a mass at the tool, which nobody stated; since the first reading."""
    if readings.base_from_tcp is None:
        raise UsageError("a store without poses of the tool", "poses, to add a mass", "Plant another effect.")
    tcp_from_ft = readings.description.transform("tcp_from_ft")
    if tcp_from_ft is None:
        raise UsageError("logs that do not state tcp_from_ft", "it, to add a mass", "Plant another effect.")
    down = -GRAVITY * size * readings.base_from_tcp[:, 2, :3] @ tcp_from_ft.rotation
    lever = np.array([0.0, 0.0, 0.05])
    load = np.concatenate([down, np.cross(lever, down)], axis=1)
    sign = 1.0 if readings.description.wrench.get("sign", "load_on_sensor") == "load_on_sensor" else -1.0
    weighed: Array = readings.values + sign * (load - load[:1])
    return weighed


PLANTS: Mapping[str, Plant] = {
    "lag": Plant("late readings of the force sensor", "s", 0.01, 0.1, ("lag",), _late),
    "frame_rotation": Plant("a force sensor that is turned", "rad", 0.02, 0.15, ("frame_rotation",), _turned),
    "drift": Plant("a drifting zero", "N/min", 0.1, 3.0, ("sensor_drift",), _drifted),
    "dead_band": Plant("small forces that are not shown", "N", 0.1, 0.6, ("quantisation",), _banded),
    "gain": Plant("one axis that reads too much", "1", 0.03, 0.2, ("gain_crosstalk",), _gained),
    "added_mass": Plant("a mass at the tool that is not stated", "kg", 0.01, 0.1, ("tool_weight",), _weighed),
    "thickness": Plant("a gel that is stated too thick", "1", 0.05, 0.3, ("thickness",), None),
}
"""Effects that can be planted, by name."""
NOTHING = "nothing"
"""Name under which nothing is planted: a blind test needs copies like that."""
ANY = "any"
"""Name that leaves the choice, nothing included, to chance."""


def stated_thicker(document: Mapping[str, Any], size: float) -> dict[str, Any]:
    """Return a log's description, or facts of a sensor, that state the gel thicker by a share.

    Parameters
    ----------
    document : dict
        A description with ``sensors``, or the facts of one sensor with ``gel``.
    size : float
        Share by which the stated thickness is larger.
    """
    if "sensors" in document:
        sensors = {serial: stated_thicker(facts, size) for serial, facts in document["sensors"].items()}
        return {**document, "sensors": sensors}
    gel = dict(document.get("gel", {}))
    for name in ("thickness", "edge_thickness"):
        if name in gel:
            gel[name] = round(gel[name] * (1.0 + size), 9)
    return {**document, "gel": gel} if gel else dict(document)


def find_plant(name: str) -> Plant:
    """Return an effect that can be planted, by its name.

    Raises
    ------
    UnknownName
        No effect has this name.
    """
    if name not in PLANTS:
        raise UnknownName("planted effect", name, (*PLANTS, NOTHING, ANY))
    return PLANTS[name]
