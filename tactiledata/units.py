"""Fields and their units: the one table behind validation, docs and plot labels. The toolkit computes in SI units."""

from __future__ import annotations

from dataclasses import dataclass

from tactiledata.errors import SchemaError, UnknownName


@dataclass(frozen=True)
class Field:
    """The meaning of a column of numbers: its unit as stored, and a label for people."""

    unit: str
    label: str


FIELDS: dict[str, Field] = {
    "t_ns": Field("ns", "time on the host clock"),
    "fx": Field("N", "force along x"),
    "fy": Field("N", "force along y"),
    "fz": Field("N", "force along z"),
    "tx": Field("N m", "torque about x"),
    "ty": Field("N m", "torque about y"),
    "tz": Field("N m", "torque about z"),
    "x": Field("m", "position x"),
    "y": Field("m", "position y"),
    "z": Field("m", "position z"),
    "qx": Field("1", "quaternion x"),
    "qy": Field("1", "quaternion y"),
    "qz": Field("1", "quaternion z"),
    "qw": Field("1", "quaternion w"),
    **{f"q{joint}": Field("rad", f"joint {joint}") for joint in range(6)},
    "contact_force": Field("N", "norm of the contact force"),
    "gap_ns": Field("ns", "time to the farther of the two samples that an aligned value lies between"),
}

SIGNAL_COLUMNS: dict[str, tuple[str, ...]] = {
    "wrench": ("fx", "fy", "fz", "tx", "ty", "tz"),
    "tcp": ("x", "y", "z", "qx", "qy", "qz", "qw"),
    "joints": ("q0", "q1", "q2", "q3", "q4", "q5"),
    "contact_wrench": ("fx", "fy", "fz", "tx", "ty", "tz"),
}
"""Columns of the signals that the toolkit knows by name, in order."""

TO_METRES: dict[str, float] = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "cm": 1e-2, "in": 0.0254}
"""Factors for lengths in documents that say their unit."""

TO_SI = {
    **{(name, "m"): factor for name, factor in TO_METRES.items()},
    ("deg", "rad"): 0.017453292519943295,
    ("mN", "N"): 1e-3,
    ("kN", "N"): 1e3,
    ("gf", "N"): 9.80665e-3,
    ("kgf", "N"): 9.80665,
    ("lbf", "N"): 4.4482216152605,
    ("N mm", "N m"): 1e-3,
    ("Nmm", "N m"): 1e-3,
    ("Nm", "N m"): 1.0,
}
"""Factors from a unit that a document states to the unit of the column."""


def metres(value: float, unit: str) -> float:
    """Return a length in metres, from a value and the unit that a document states; refuse units not in the table."""
    if unit not in TO_METRES:
        raise UnknownName("length unit", unit, TO_METRES)
    return value * TO_METRES[unit]


def signal_units(columns: tuple[str, ...]) -> tuple[str, ...]:
    """Return the unit of each column, ``"?"`` where the table does not know the column."""
    return tuple(FIELDS[column].unit if column in FIELDS else "?" for column in columns)


def unit_factor(unit: str, wanted: str, column: str, place: str, path: str) -> float:
    """Return the factor from a stated unit to the unit in which a column is kept.

    Parameters
    ----------
    unit, wanted : str
        The unit that a document states, and that of the column.
    column, place, path : str
        What has the unit, who states it, and where in the document, for the message.

    Raises
    ------
    SchemaError
        A unit that cannot become the column's.
    """
    if unit == wanted:
        return 1.0
    if (unit, wanted) in TO_SI:
        return TO_SI[(unit, wanted)]
    others = [known for known, of_column in TO_SI if of_column == wanted]
    raise SchemaError(
        f"{place} states {unit!r} for {column}",
        f"{wanted!r}" + (f", or one of {', '.join(others)}, which is brought to it" if others else ""),
        path=path,
    )
