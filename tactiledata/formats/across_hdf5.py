"""ACROSS: simulated indentations of a DIGIT and a BioTac, gel meshes and net forces in HDF5."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactiledata.contract.records import Recording, Signal, Source, Stamps, Trajectory
from tactiledata.errors import UnsafeContent
from tactiledata.formats.reading.corpus import (
    CorpusFormat,
    Timeline,
    describe,
    note_nominal_rate,
    raise_empty,
    sensor_for,
    subfolders,
)
from tactiledata.formats.reading.hdf5_members import (
    HDF5_FAULTS,
    Hdf5Members,
    UnreadableNumbers,
    open_hdf5,
    reading_hdf5,
)
from tactiledata.formats.reading.intake import Intake
from tactiledata.formats.reading.natural_order import natural_key, natural_paths

FILE_NAME = re.compile(r"results_(?P<sensor>[a-zA-Z0-9]+)_(?P<job>.+)\.(?:hdf5|h5)")
NODES = "nodal_coords_"
FORCE = "net_force_vecs_"
MODELS = {"digit": "digit", "biotac": "biotac"}
MAX_VERTICES = 200_000
MOST_NAMED = 3
"""Members that are not read and are named before it is said how many more there are."""


class AcrossHdf5Format(CorpusFormat):
    """ACROSS: one source per HDF5 file, one trajectory per trial and environment.

    There are no images: every step is a captured moment whose image is missing, and the gel's vertices are its values.
    """

    name = "across_hdf5"
    title = "ACROSS simulation results (meshes and net forces)"
    layout = "results_<sensor>_<job>.hdf5: trial_<i>/step_<j>/{nodal_coords_<sensor>, net_force_vecs_<sensor>}/env_<k>"
    licence_note = "See the licence beside the data; the code of wzaielamri/across_framework has its own."

    def sniff(self, path: Path) -> bool:
        """Whether this is such a file, by name or content, or a folder with some."""
        if path.is_file():
            return path.suffix in (".hdf5", ".h5") and (bool(FILE_NAME.fullmatch(path.name)) or _holds_trials(path))
        return path.is_dir() and next(_results(path), None) is not None

    def sources(self, path: Path) -> Sequence[Source]:
        """One source per file."""
        self.require(path)
        if path.is_file():
            return [Source(str(path), path.name, self.name, (str(path),))]
        return [self.make_source(path, file, [file]) for file in _results(path)]

    def record(self, source: Source, intake: Intake, mapping: Mapping[str, Any] | None) -> Recording:
        """A file: trials and environments one after another, read step by step.

        Parameters
        ----------
        source : Source
            One HDF5 file, as `sources` found it.
        intake : Intake
            Takes moments without images; it is read afterwards for values and findings.
        mapping : dict, optional
            A mapping document; it may name the sensor and describe it.

        Raises
        ------
        BrokenLog
            The file cannot be read as HDF5, or holds no step.
        NotFetched
            The file is a Git LFS pointer.
        UnsafeContent
            It takes values from another file.
        """
        path = Path(source.path)
        with reading_hdf5(path, "a whole HDF5 file of ACROSS results", "Fetch the file again.") as members:
            sensor = _sensor(path, members)
            serial = sensor_for(sensor, f"across-{sensor}", mapping)
            touches, signal = _walk(members, sensor, serial, intake)
        if not touches:
            raise_empty(source, "trial_<i>/step_<j>/nodal_coords_<sensor>/env_<k>")
        note_nominal_rate(intake, "the simulation")
        found = "the file holds meshes and no images: its steps are moments without an image"
        intake.note("images-absent", "info", found, sensor)
        model = MODELS.get(sensor, sensor)
        description = describe(source, mapping, {serial: model}, f"ACROSS {path.stem}", self.licence_note, "simulated")
        return self.finish(source, intake, description, touches, {signal.name: signal})


def _results(path: Path) -> Iterator[Path]:
    for folder in subfolders(path, 3):
        yield from natural_paths(
            file
            for file in folder.iterdir()
            if FILE_NAME.fullmatch(file.name) and file.is_file() and not file.is_symlink()
        )


def _holds_trials(path: Path) -> bool:
    try:
        with open_hdf5(path) as members:
            step = members.group(members.group(members.root, "trial_0"), "step_0")
            return any(name.startswith(NODES) for name in members.names(step))
    except (*HDF5_FAULTS, UnsafeContent):
        return False


def _sensor(path: Path, members: Hdf5Members) -> str:
    """The sensor's name: what the meshes are called, else what the file is called."""
    for trial in _numbered(members, members.root, "trial_"):
        group = members.group(members.root, trial)
        for step in _numbered(members, group, "step_"):
            for name in members.names(members.group(group, step)):
                if name.startswith(NODES):
                    return name.removeprefix(NODES)
    named = FILE_NAME.fullmatch(path.name)
    return named["sensor"] if named else "unknown"


def _numbered(members: Hdf5Members, group: Any, prefix: str) -> list[str]:
    return sorted((name for name in members.names(group) if re.fullmatch(prefix + r"\d{1,9}", name)), key=natural_key)


@dataclass(frozen=True)
class _Step:
    """The groups of one step that hold a data set for each environment; ``None`` where one is not there."""

    name: str
    nodes: Any
    forces: Any


def _walk(members: Hdf5Members, sensor: str, serial: str, intake: Intake) -> tuple[list[Trajectory], Signal]:
    timeline, touches = Timeline(), []
    times: list[int] = []
    forces: list[NDArray[np.float64]] = []
    left: set[str] = set()
    for trial in _numbered(members, members.root, "trial_"):
        steps = _steps(members, trial, sensor, left)
        environments = {name for step in steps for name in _numbered(members, step.nodes, "env_")}
        if not environments:
            intake.note("trajectory-empty", "warning", f"{trial} holds no mesh", trajectory=trial)
        for environment in sorted(environments, key=natural_key):
            name = f"{trial}-{environment}"
            start = timeline.begin()
            for index, step in enumerate(steps):
                moment, where = timeline.at(index), f"{name}/{step.name}"
                vertices = _read(members, step.nodes, environment, f"{where}: {NODES}{sensor}", intake)
                values = _vertices(vertices, where, intake)
                intake.image(sensor, None, moment, sensor=serial, trajectory=name, name=where, values=values)
                times.append(moment)
                net = _read(members, step.forces, environment, f"{where}: {FORCE}{sensor}", intake)
                forces.append(_force(net, sensor, where, intake))
            extra = {"trial": trial, "environment": environment}
            touches.append(Trajectory(name, start, timeline.interval()[1], serial, f"across_{environment}", extra))
    if left:
        named = sorted(name[:60] for name in left)[:MOST_NAMED]
        more = f" and {len(left) - MOST_NAMED} more" if len(left) > MOST_NAMED else ""
        intake.note("not-read", "info", f"{', '.join(named)}{more} in steps: not read")
    columns, units = ("fx", "fy", "fz"), ("N", "N", "N")
    table = np.array(forces, dtype=np.float64).reshape(-1, 3)
    signal = Signal(f"net_force_{sensor}", Stamps(np.array(times, dtype=np.int64)), table, columns, "simulation", units)
    return touches, signal


def _steps(members: Hdf5Members, trial: str, sensor: str, left: set[str]) -> list[_Step]:
    """The steps of a trial in natural order; what else they hold is added to ``left``."""
    group = members.group(members.root, trial)
    steps = []
    for name in _numbered(members, group, "step_"):
        held = members.group(group, name)
        left.update(set(members.names(held)) - {NODES + sensor, FORCE + sensor})
        steps.append(_Step(name, members.group(held, NODES + sensor), members.group(held, FORCE + sensor)))
    return steps


def _read(members: Hdf5Members, group: Any, environment: str, what: str, intake: Intake) -> NDArray[np.float64] | None:
    """The numbers of one environment at one step; ``None``, with a finding, where they are not there."""
    stream = what.rpartition(" ")[2]
    try:
        values = members.numbers(group, environment, 3 * MAX_VERTICES)
    except UnreadableNumbers as error:
        intake.note("value-missing", "damage", f"{what} {error}", stream)
        return None
    if values is None:
        intake.note("value-missing", "damage", f"{what}/{environment} is not there", stream)
    elif not np.isfinite(values).all():
        count = int(np.count_nonzero(~np.isfinite(values)))
        intake.note(
            "value-missing", "damage", f"{what} holds {count} of {values.size} values that are not finite", stream
        )
        return np.where(np.isfinite(values), values, np.nan)
    return values


def _vertices(vertices: NDArray[np.float64] | None, where: str, intake: Intake) -> dict[str, NDArray[np.float64]]:
    """The vertices (V, 3) of one mesh as values of its moment; none, with a finding, where they fit no mesh before."""
    if vertices is None:
        return {}
    if vertices.ndim != 2 or vertices.shape[1] != 3 or not vertices.size:
        intake.note("value-missing", "damage", f"{where}: vertices of shape {vertices.shape}", "vertices")
        return {}
    if not intake.width("vertices"):
        columns = tuple(f"{axis}{vertex}" for vertex in range(len(vertices)) for axis in "xyz")
        note = "vertices of the gel, metres, x y z of each in turn; meshes without images"
        intake.declare("vertices", columns, ("m",) * len(columns), note)
    if vertices.size != intake.width("vertices"):
        found = f"{where}: {len(vertices)} vertices where the first mesh has {intake.width('vertices') // 3}"
        intake.note("length-mismatch", "damage", found, "vertices")
        return {}
    return {"vertices": vertices.reshape(-1)}


def _force(force: NDArray[np.float64] | None, sensor: str, where: str, intake: Intake) -> NDArray[np.float64]:
    if force is None or force.size != 3:
        if force is not None:
            intake.note("value-missing", "damage", f"{where}: a net force of shape {force.shape}", FORCE + sensor)
        return np.full(3, np.nan)
    return force.reshape(3)
