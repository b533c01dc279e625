"""A mapped signal of an HDF5 file: from one array, from columns of it, or from several arrays of a group."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import Array, Times
from tactiledata.contract.records import Signal, Stamps
from tactiledata.contract.wording import listed
from tactiledata.errors import BrokenLog, SchemaError
from tactiledata.formats.reading.corpus import SECOND
from tactiledata.formats.reading.hdf5_members import Hdf5Members, UnreadableNumbers
from tactiledata.formats.reading.intake import Intake
from tactiledata.formats.reading.rotation_vectors import poses_from_rotation_vectors
from tactiledata.units import FIELDS, SIGNAL_COLUMNS, unit_factor

MOST = 10**8
"""Numbers of an array that is read."""
PER_SECOND = {"s": 1, "ms": 10**3, "us": 10**6, "ns": 10**9}
"""Units of times, each as its number in a second."""
COLUMN = re.compile(r"\[(\d+)\]")
"""A field that is a column of a matrix."""


@dataclass(frozen=True)
class ArrayFile:
    """An open HDF5 file whose arrays are read by their paths.

    Parameters
    ----------
    members : Hdf5Members
    name : str
        Of the file, for messages.
    """

    members: Hdf5Members
    name: str

    def parent(self, path: str) -> tuple[Any, str]:
        """Return the group that holds what a path names, ``None`` where there is none, and its name in the group."""
        *above, name = [part for part in path.split("/") if part] or [""]
        group = self.members.root
        for part in above:
            group = self.members.group(group, part)
        return group, name

    def has(self, path: str) -> bool:
        """Return whether there is something at a path; "/" is the file itself."""
        group, name = self.parent(path)
        return not name or self.members.member(group, name) is not None

    def values(self, path: str, place: str) -> NDArray[Any]:
        """Return the numbers at a path, in their own type and shape.

        Parameters
        ----------
        path : str
        place : str
            What names the path, for messages: ``"signals.wrench"``.

        Raises
        ------
        BrokenLog
            Nothing is there, or no numbers that can be read.
        """
        try:
            found = self.members.values(*self.parent(path), MOST)
        except UnreadableNumbers as error:
            raise BrokenLog(
                f"{self.name}: {path} is not read: it is {error}",
                f"an array of at most {MOST} numbers",
                f"The mapping names it under {place}.",
                file=self.name,
            ) from error
        if found is None:
            raise BrokenLog(
                f"{self.name} has no array {path}",
                f"the array that the mapping names under {place}",
                "Mend the path: tactiledata inspect lists the arrays of a file.",
                file=self.name,
            )
        return found

    def times(self, entry: Mapping[str, Any], place: str, rows: int) -> tuple[Times, NDArray[np.bool_]]:
        """Return times (rows,) ns, and which of them are times at all.

        Parameters
        ----------
        entry : dict
            What a mapping says of a stream: ``time`` and ``time_unit``.
        place : str
            Where in the mapping, for messages.
        rows : int
            Number of samples.

        Raises
        ------
        SchemaError
            The mapping names no times.
        BrokenLog
            There are more or fewer times than samples, or no numbers.
        """
        if "time" not in entry:
            raise SchemaError(
                f"the mapping's {place} names no times",
                "time: path of the array with the times of the samples",
                "`tactiledata inspect FILE --suggest-mapping` writes the likeliest.",
                path=f"$.{place}",
            )
        given = self.values(entry["time"], place)
        if given.shape != (rows,):
            raise BrokenLog(
                f"{self.name}: {entry['time']} holds times of shape {given.shape}, and {entry['topic']} {rows} samples",
                f"({rows},)",
                f"Name the times of {entry['topic']} under {place}.time.",
                file=self.name,
            )
        is_whole = given.dtype.kind in "iu"
        factor = SECOND // PER_SECOND[entry.get("time_unit", "ns" if is_whole else "s")]
        largest = 2**62 // factor
        is_time = np.isfinite(given) & (np.abs(given.astype(np.float64)) < largest)
        safe = np.where(is_time, given, 0)
        if is_whole:
            return safe.astype(np.int64) * factor, is_time
        # the whole part apart: a product of large seconds would lose nanoseconds twice
        whole = np.floor(safe)
        return whole.astype(np.int64) * factor + np.rint((safe - whole) * factor).astype(np.int64), is_time


def read_signal(file: ArrayFile, name: str, entry: Mapping[str, Any], intake: Intake) -> Signal | None:
    """Return a signal by what a mapping says of it; ``None`` where its array is not there, which is a finding.

    Parameters
    ----------
    file : ArrayFile
    name : str
        Of the signal: ``wrench``, ``tcp``, ``joints``, or another one with ``fields``.
    entry : dict
        ``topic``, ``time``, and as the schema of mappings has it: ``fields``, ``units``, ``rotation``, ``frame``.
    intake : Intake
        Takes findings.

    Raises
    ------
    BrokenLog
        Its arrays are there and cannot be read as this signal.
    SchemaError
        The mapping does not fit: no times, units for other fields, a unit that cannot become the column's.
    """
    place = f"signals.{name}"
    topic, fields = str(entry["topic"]), tuple(entry.get("fields", ()))
    if not file.has(topic):
        text = f"{file.name} has no {topic}, which the mapping names under {place}; {name} is not read"
        intake.note("missing-topic", "warning", text, name)
        return None
    turned = name == "tcp" and entry.get("rotation") == "rotation_vector"
    columns = SIGNAL_COLUMNS.get(name, tuple(_column_name(field) for field in fields))
    if not columns:
        raise SchemaError(
            f"the mapping's {place} has no fields",
            "fields: the columns of the array, as [0], or the names of arrays in the group",
            "wrench, tcp and joints alone need none.",
            path=f"$.{place}",
        )
    width = 6 if turned else len(columns)
    values = _fields(file, topic, fields, place) if fields else _matrix(file, topic, place)
    if values.shape[1] != width:
        raise BrokenLog(
            f"{file.name}: {name} from {topic} has {values.shape[1]} columns",
            f"{width}" + (": x, y, z and a rotation vector" if turned else f": {', '.join(columns)}"),
            f"Name them as fields under {place}, for example [0], [1]."
            + (" Six numbers of a pose need rotation: rotation_vector." if name == "tcp" and not turned else ""),
            file=file.name,
        )
    times, is_time = file.times(entry, place, len(values))
    if not is_time.all():
        lost = int((~is_time).sum())
        intake.note("bad-stamp", "damage", f"{lost} samples of {topic} have no time that is a number", name, count=lost)
    values, own_units = _in_si(values, name, columns if not turned else (), entry, place)
    is_finite = np.isfinite(values).all(axis=1)
    if not is_finite.all():
        count = int((~is_finite).sum())
        intake.note("non-finite", "warning", f"{count} samples of {topic} hold NaN or infinity", name, count=count)
    values = values[is_time]
    if turned:
        values = poses_from_rotation_vectors(values)
    return Signal(name, Stamps(times[is_time]), values, columns, str(entry.get("frame", "")), own_units)


def _matrix(file: ArrayFile, topic: str, place: str) -> Array:
    """Return an array (n, k) as float64; a single column for (n,)."""
    values = np.asarray(file.values(topic, place), dtype=np.float64)
    if values.ndim not in (1, 2):
        raise BrokenLog(f"{file.name}: {topic} has the shape {values.shape}", "samples by columns", file=file.name)
    return values.reshape(len(values), -1)


def _fields(file: ArrayFile, topic: str, fields: Sequence[str], place: str) -> Array:
    """Return the fields (n, k) of a topic: columns of a matrix, or arrays of a group."""
    places = [COLUMN.fullmatch(field) for field in fields]
    if all(places):
        whole = _matrix(file, topic, place)
        chosen = [int(one[1]) for one in places if one]
        if max(chosen) >= whole.shape[1]:
            raise BrokenLog(
                f"{file.name}: {topic} has {whole.shape[1]} columns, and {place} names [{max(chosen)}]",
                f"[0] to [{whole.shape[1] - 1}]",
                file=file.name,
            )
        return whole[:, chosen]
    columns = [_matrix(file, f"{topic}/{field}", place) for field in fields]
    if {column.shape for column in columns} != {(len(columns[0]), 1)}:
        shapes = listed([f"{field} {column.shape}" for field, column in zip(fields, columns, strict=True)], 6)
        raise BrokenLog(f"{file.name}: the fields of {topic} do not fit: {shapes}", "one length", file=file.name)
    return np.concatenate(columns, axis=1)


def _in_si(
    values: Array, name: str, columns: Sequence[str], entry: Mapping[str, Any], place: str
) -> tuple[Array, tuple[str, ...]]:
    """Return values with stated units brought to SI where the columns are known, and the units of other columns."""
    stated = tuple(str(unit) for unit in entry.get("units", ()))
    if stated and len(stated) != values.shape[1]:
        raise SchemaError(
            f"the mapping's {place} has {len(stated)} units", f"{values.shape[1]}", path=f"$.{place}.units"
        )
    if name not in SIGNAL_COLUMNS:
        return values, stated or ("?",) * values.shape[1]
    if not stated:
        return values, ()
    wanted = [FIELDS[column].unit for column in columns] or ["m"] * 3 + ["rad"] * 3
    named = list(columns) or ["x", "y", "z", "rx", "ry", "rz"]
    factors = [
        unit_factor(unit, into, column, f"the mapping's {place}", f"$.{place}.units")
        for unit, into, column in zip(stated, wanted, named, strict=True)
    ]
    return values * np.array(factors), ()


def _column_name(field: str) -> str:
    """Return the name of a column that the store keeps: of a field, without brackets and slashes."""
    return re.sub(r"[^A-Za-z0-9]+", "_", field).strip("_") or "value"
