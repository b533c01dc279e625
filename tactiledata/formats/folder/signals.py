"""wrench.csv, tcp.csv and joints.csv as signals: rows that do not read are left out and reported."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactiledata.contract.description import LogDescription
from tactiledata.contract.records import Finding, Signal, Stamps, Values
from tactiledata.errors import BrokenLog
from tactiledata.formats.folder.files import LogFolder
from tactiledata.formats.reading.csv_cells import CsvTable, Mask, listed
from tactiledata.formats.reading.csv_tables import read_csv_table
from tactiledata.units import SIGNAL_COLUMNS, signal_units, unit_factor

TIME = "t_ns"

SIGNALS = ("wrench", "tcp", "joints")

UNIT_TOLERANCE = 1e-3
"""Largest deviation of a quaternion's norm from 1 that is taken for printed decimals and normalised."""

UNIT_SILENT = 1e-6
"""Deviation below which normalising is not worth a word."""


@dataclass(frozen=True)
class ReadSignals:
    """Signals by name, and findings."""

    signals: dict[str, Signal]
    findings: tuple[Finding, ...]


def read_signals(folder: LogFolder, description: LogDescription) -> ReadSignals:
    """All signals of a folder log in SI units, in the frames that its description names.

    Raises
    ------
    BrokenLog
        A table lacks a column or is no table of ours.
    SchemaError
        A stated unit cannot become that of its column.
    """
    signals: dict[str, Signal] = {}
    findings: list[Finding] = []
    for name in SIGNALS:
        table, said = open_table(folder, f"{name}.csv", name)
        findings.extend(said)
        if table is None:
            findings.extend(_absence(name, description) if not said else ())
            continue
        signal, faults = _signal(name, table, _frame(name, description), _factors(name, description))
        findings.extend(faults)
        if signal is not None:
            signals[name] = signal
    return ReadSignals(signals, tuple(findings))


def open_table(folder: LogFolder, name: str, stream: str) -> tuple[CsvTable | None, tuple[Finding, ...]]:
    """A table of the log and the findings about its text; ``None`` where it is absent, or empty, which is a finding.

    Parameters
    ----------
    folder : LogFolder
        The log.
    name : str
        File name of the table.
    stream : str
        The stream that findings are about.

    Raises
    ------
    BrokenLog
        The table is there, is not empty, and cannot be read.
    """
    path = folder.table(name)
    if path is None:
        return None, ()
    try:
        table = read_csv_table(path, stream)
    except BrokenLog as error:
        if not error.facts.get("is_empty"):
            raise
        message = f"{name} is empty ({path.stat().st_size} bytes): the stream was lost or never written"
        return None, (Finding("csv-empty", "damage", message, stream),)
    return table, table.findings


def ignored_columns(table: CsvTable, known: tuple[str, ...], stream: str) -> list[Finding]:
    """What is said about columns that the layout does not know.

    Parameters
    ----------
    table : CsvTable
        The table that was read.
    known : tuple of str
        Names of the columns that the layout has.
    stream : str
        The stream that the finding is about.
    """
    others = [column for column in table.columns if column not in known]
    if not others:
        return []
    message = f"{table.name}: the columns {listed(others)} are not known and were not read"
    return [Finding("columns-ignored", "info", message, stream, count=len(others))]


def _frame(name: str, description: LogDescription) -> str:
    stated = {"wrench": str(description.wrench.get("frame", "ft")), "tcp": "base"}
    return stated.get(name, "")


def _absence(name: str, description: LogDescription) -> list[Finding]:
    """A stream that the description speaks of and that is not there is damage."""
    speaks = {"wrench": bool(description.wrench), "tcp": "tcp_from_gel" in description.robot}
    if name not in speaks:
        return []
    if speaks[name]:
        return [Finding("stream-missing", "damage", f"{name}.csv is not there, though log.yaml describes it", name)]
    return [Finding("stream-absent", "info", f"there is no {name}.csv", name)]


def _factors(name: str, description: LogDescription) -> Values | None:
    """Factors (k,) from the units that a description states for a table to SI; ``None`` where it states none."""
    columns = SIGNAL_COLUMNS[name]
    if name not in description.units:
        return None
    stated = [str(unit) for unit in description.units[name]]  # YAML reads a bare 1 as a number
    place, path = f"{description.where}: units.{name}", f"$.units.{name}"
    return np.array(
        [unit_factor(*each, place, path) for each in zip(stated, signal_units(columns), columns, strict=True)]
    )


def _signal(name: str, table: CsvTable, frame: str, factors: Values | None) -> tuple[Signal | None, list[Finding]]:
    columns = SIGNAL_COLUMNS[name]
    table.require((TIME, *columns))
    findings = ignored_columns(table, (TIME, *columns), name)
    t_ns, has_time = table.nanoseconds(TIME)
    values, is_finite = table.numbers(columns)
    if factors is not None:
        with np.errstate(over="ignore"):
            values = values * factors
        is_finite &= np.isfinite(values).all(axis=1)
    findings += table.row_finding(
        "csv-time", ~has_time, f"have no {TIME} that is a whole number below 2^63; left out", name
    )
    unread = has_time & ~is_finite
    findings += table.row_finding("csv-value", unread, "have a value that is no finite number; left out", name)
    is_good = has_time & is_finite
    if name == "tcp":
        values, is_unit, said = _unit_quaternions(table, values, is_good)
        is_good &= is_unit
        findings += said
    if factors is not None and (factors != 1.0).any():
        message = f"{table.name}: its columns were brought to SI units, as the description states theirs"
        findings.append(Finding("units-stated", "info", message, name))
    if not is_good.any():
        return None, findings
    return Signal(name, Stamps(t_ns[is_good]), values[is_good], columns, frame), findings


def _unit_quaternions(table: CsvTable, poses: Values, is_good: Mask) -> tuple[Values, Mask, list[Finding]]:
    """Poses (n, 7) with unit quaternions, a mask (n,) of those that were nearly so, and findings."""
    with np.errstate(invalid="ignore", over="ignore"):
        norms = np.linalg.norm(poses[:, 3:], axis=1)
        deviation = np.abs(norms - 1.0)
        is_unit: Mask = deviation <= UNIT_TOLERANCE
        normalised = poses.copy()
        normalised[is_unit, 3:] /= norms[is_unit, None]
    what = "have a quaternion that is not of length 1; left out"
    findings = table.row_finding("quaternion-not-unit", is_good & ~is_unit, what, "tcp")
    is_off = is_good & is_unit & (deviation > UNIT_SILENT)
    if is_off.any():
        most = f"{deviation[is_off].max():.1e}"
        message = f"{table.name}: {is_off.sum()} quaternions were up to {most} off length 1; normalised"
        findings.append(Finding("quaternion-normalised", "info", message, "tcp", count=int(is_off.sum())))
    return normalised, is_unit, findings
