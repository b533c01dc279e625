"""From a channel and its role to the function that takes its messages."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any

from tactiledata.formats.mcap.cdr import JOINT_LAYOUT, VECTOR_LAYOUTS, Take, joint_taker, vector_taker
from tactiledata.formats.mcap.collect import SignalBuffer
from tactiledata.formats.mcap.decode import FAULTS, Decoder
from tactiledata.formats.mcap.message_fields import (
    NoSuchField,
    frame_of,
    kind_in_words,
    path_of,
    stamp_of,
    steps_of,
    value_at,
)
from tactiledata.formats.mcap.roles import FIELDS_OF, SignalRole
from tactiledata.formats.mcap.undecoded import reason_of
from tactiledata.units import unit_factor

UR_JOINTS = (
    "shoulder_pan_joint",
    "shoulder_lift_joint",
    "elbow_joint",
    "wrist_1_joint",
    "wrist_2_joint",
    "wrist_3_joint",
)


def signal_taker(role: SignalRole, decoder: Decoder, sink: SignalBuffer) -> Take:
    """What reads the messages of a channel into a signal: fast where it can be, and the general way where it must.

    Parameters
    ----------
    role : SignalRole
        What the channel is, and which fields of its messages are read.
    decoder : Decoder
        Reads messages of the channel's type.
    sink : SignalBuffer
        Takes the samples.
    """
    order = JointOrder(role.joint_names, sink.absent)
    fast: Take | None = None
    if role.fields:
        general = _general(_field_reader(role), decoder, sink)
    elif role.name == "joints":
        general = _general(order.read, decoder, sink)
        if decoder.layout == JOINT_LAYOUT:
            fast = joint_taker(order, sink)
    else:
        general = _general(_paths_reader(FIELDS_OF[decoder.kind]), decoder, sink)
        if decoder.layout in VECTOR_LAYOUTS:
            fast = vector_taker(VECTOR_LAYOUTS[decoder.layout], sink)
    return general if fast is None else _with_fallback(fast, general)


def _with_fallback(fast: Take, general: Take) -> Take:
    def take(buffer: bytes, start: int, stop: int, log_ns: int, publish_ns: int) -> None:
        try:
            fast(buffer, start, stop, log_ns, publish_ns)
        except ValueError:
            general(buffer, start, stop, log_ns, publish_ns)

    return take


Reader = Callable[[Any], "Sequence[float] | None"]


def _general(read: Reader, decoder: Decoder, sink: SignalBuffer) -> Take:
    """The general way: decode the message, then read the values from its fields; a fault is counted, not raised."""
    decode = decoder.decode

    def take(buffer: bytes, start: int, stop: int, log_ns: int, publish_ns: int) -> None:
        try:
            message = decode(buffer[start:stop])
            values = read(message)
            stamp, frame = stamp_of(message), frame_of(message)
        except FAULTS as error:
            if isinstance(error, NoSuchField):
                sink.misnamed = sink.misnamed or error
            sink.faults.add(log_ns, reason_of(error))
            return
        if values is not None:
            sink.add(values, log_ns, publish_ns, stamp, frame)

    return take


def _paths_reader(paths: Sequence[str]) -> Reader:
    steps = [steps_of(path) for path in paths]

    def read(message: Any) -> list[float]:
        try:
            return [float(value_at(message, step)) for step in steps]
        except (TypeError, ValueError, OverflowError) as error:
            raise ValueError(_no_number(message, steps) or str(error)) from error

    return read


def _no_number(message: Any, paths: Sequence[tuple[str | int, ...]]) -> str:
    """What the first of the fields holds that is no number; empty where all of them are numbers."""
    for steps in paths:
        value = value_at(message, steps)
        try:
            float(value)
        except OverflowError:
            return f"{path_of(steps)!r} is beyond the largest number that is kept"
        except (TypeError, ValueError):
            return f"{path_of(steps)!r} is {kind_in_words(value)}, and no number"
    return ""


def _field_reader(role: SignalRole) -> Reader:
    read = _paths_reader(role.fields)
    factors = unit_factors(role)
    if role.is_rotation_vector:
        return lambda message: _with_quaternion([v * f for v, f in zip(read(message) or (), factors, strict=True)])
    if all(factor == 1.0 for factor in factors):
        return read
    return lambda message: [value * factor for value, factor in zip(read(message) or (), factors, strict=True)]


def _with_quaternion(pose: Sequence[float]) -> list[float]:
    """A pose with a quaternion x y z w, of one with a rotation vector in radians."""
    from scipy.spatial.transform import Rotation

    return [*pose[:3], *Rotation.from_rotvec(pose[3:]).as_quat().tolist()]


def unit_factors(role: SignalRole) -> list[float]:
    """Factors that take a mapping's stated units to those of the columns; 1 where the column is not a known one.

    Raises
    ------
    SchemaError
        A unit that cannot become the column's.
    """
    factors = []
    for field, wanted, unit in zip(role.fields, role.field_units, role.units or ("",) * len(role.fields), strict=True):
        if unit in ("", "?"):
            factors.append(1.0)
        else:
            place = f"the mapping's signals.{role.name}"
            factors.append(unit_factor(unit, wanted, field, place, f"$.signals.{role.name}.units"))
    return factors


class JointOrder:
    """The places of the six joints of the arm among the names of a message; never taken by position.

    Names may carry a prefix (``left_elbow_joint``, ``ur/elbow_joint``) as long as only one robot fits. -1 stands for a
    joint that a message lacks while it holds others of the robot.
    """

    def __init__(self, joint_names: Sequence[str], absent: Counter[str]) -> None:
        self._wanted = tuple(joint_names) or UR_JOINTS
        self._absent = absent

    def __call__(self, names: tuple[str, ...]) -> tuple[int, ...] | None:
        """Indexes (6,); ``None`` where the message holds none of our joints."""
        indexes = tuple(self._index(wanted, names) for wanted in self._wanted)
        return None if max(indexes) < 0 else indexes

    def _index(self, wanted: str, names: tuple[str, ...]) -> int:
        if wanted in names:
            return names.index(wanted)
        fits = [place for place, name in enumerate(names) if name.endswith((f"_{wanted}", f"/{wanted}"))]
        if len(fits) > 1:
            raise ValueError(
                f"{len(fits)} joints are called {wanted}: joint_names in a mapping must say which are meant"
            )
        return fits[0] if fits else -1

    def read(self, message: Any) -> list[float] | None:
        """Positions (6,) of a decoded message, NaN for a joint that it lacks."""
        names = tuple(value_at(message, ("name",)))
        indexes = self(names)
        if indexes is None:
            return None
        positions = value_at(message, ("position",))
        if len(positions) != len(names):
            raise ValueError(f"{len(positions)} positions for {len(names)} names")
        self._absent.update(name for name, place in zip(self._wanted, indexes, strict=True) if place < 0)
        return [float(positions[place]) if place >= 0 else float("nan") for place in indexes]
