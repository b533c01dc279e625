"""ACROSS: simulated indentations of a DIGIT and a BioTac, gel meshes and net forces in HDF5."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactiledata.contract.lfs_pointer import refuse_lfs_pointer
from tactiledata.contract.records import Recording, Signal, Source, Stamps, Trajectory
from tactiledata.errors import BrokenLog, UnsafeContent
from tactiledata.formats.reading.corpus import (
    CorpusFormat,
    Timeline,
    describe,
    note_nominal_rate,
    raise_empty,
    sensor_for,
    subfolders,
)
from tactiledata.formats.reading.intake import Intake
from tactiledata.formats.reading.natural_order import natural_key, natural_paths

FILE_NAME = re.compile(r"results_(?P<sensor>[a-zA-Z0-9]+)_(?P<job>.+)\.(?:hdf5|h5)")
NODES = "nodal_coords_"
FORCE = "net_force_vecs_"
MODELS = {"digit": "digit", "biotac": "biotac"}
MAX_VERTICES = 200_000
HDF5_FAULTS = (OSError, RuntimeError, KeyError, TypeError, ValueError, OverflowError, MemoryError)
"""What h5py raises on damaged files; names of groups may come as bytes, sizes as nonsense."""


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
        import h5py

        path = Path(source.path)
        refuse_lfs_pointer(path)
        try:
            with h5py.File(path, "r") as file:
                sensor = _sensor(path, file)
                serial = sensor_for(sensor, f"across-{sensor}", mapping)
                touches, signal = _walk(file, sensor, serial, intake)
        except UnsafeContent:  # it is a ValueError, and no damage
            raise
        except HDF5_FAULTS as error:
            raise BrokenLog(
                f"{path} cannot be read as HDF5 ({str(error)[:150]})",
                "a whole HDF5 file of ACROSS results",
                "Fetch the file again.",
                file=str(path),
            ) from error
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
    import h5py

    try:
        with h5py.File(path, "r") as file:
            trial = file.get("trial_0")
            step = trial.get("step_0") if isinstance(trial, h5py.Group) else None
            return isinstance(step, h5py.Group) and any(name.startswith(NODES) for name in step)
    except HDF5_FAULTS:
        return False


def _sensor(path: Path, file: Any) -> str:
    """The sensor's name: what the meshes are called, else what the file is called."""
    for trial in _numbered(file, "trial_"):
        for step in _numbered(_child(file, trial), "step_"):
            for name in _child(_child(file, trial), step):
                if name.startswith(NODES):
                    return str(name.removeprefix(NODES))
    named = FILE_NAME.fullmatch(path.name)
    return named["sensor"] if named else "unknown"


def _numbered(group: Any, prefix: str) -> list[str]:
    if not hasattr(group, "keys"):
        return []
    return sorted((name for name in group if re.fullmatch(prefix + r"\d+", name)), key=natural_key)


def _walk(file: Any, sensor: str, serial: str, intake: Intake) -> tuple[list[Trajectory], Signal]:
    timeline, touches = Timeline(), []
    times: list[int] = []
    forces: list[NDArray[np.float64]] = []
    for trial in _numbered(file, "trial_"):
        held = {step: _child(_child(file, trial), step) for step in _numbered(_child(file, trial), "step_")}
        environments = _environments(held.values(), sensor, intake)
        if not environments:
            intake.note("trajectory-empty", "warning", f"{trial} holds no mesh", trajectory=trial)
        for environment in environments:
            name = f"{trial}-{environment}"
            start = timeline.begin()
            for index, (step, group) in enumerate(held.items()):
                moment = timeline.at(index)
                _push(group, sensor, serial, moment, f"{name}/{step}", intake)
                times.append(moment)
                forces.append(_force(group, sensor, environment, f"{name}/{step}", intake))
            extra = {"trial": trial, "environment": environment}
            touches.append(Trajectory(name, start, timeline.interval()[1], serial, f"across_{environment}", extra))
    columns, units = ("fx", "fy", "fz"), ("N", "N", "N")
    table = np.array(forces, dtype=np.float64).reshape(-1, 3)
    signal = Signal(f"net_force_{sensor}", Stamps(np.array(times, dtype=np.int64)), table, columns, "simulation", units)
    return touches, signal


def _environments(steps: Iterable[Any], sensor: str, intake: Intake) -> list[str]:
    """Environments with a mesh in any step, in natural order; what else steps hold is said."""
    found: set[str] = set()
    for step in steps:
        found.update(_numbered(_child(step, NODES + sensor), "env_"))
        for other in set(step) - {NODES + sensor, FORCE + sensor}:
            intake.note("not-read", "info", f"{other} is not read", other)
    return sorted(found, key=natural_key)


def _child(group: Any, name: str) -> Any:
    """A member of a group, an empty dict where there is none; links are refused, they may lead to other files."""
    import h5py

    link = group.get(name, getlink=True) if isinstance(group, h5py.Group) else None
    if link is None:
        return {}
    member = group[name] if isinstance(link, h5py.HardLink) else None
    if member is None or (isinstance(member, h5py.Dataset) and (member.external or member.is_virtual)):
        raise UnsafeContent(
            f"{name} in {group.file.filename} is a link, or lies in another file",
            "HDF5 files that hold their own data",
            "Copy the data into the file (h5repack) if you trust its origin.",
            name=name,
        )
    return member


def _read(step: Any, group: str, environment: str, where: str, intake: Intake) -> NDArray[np.float64] | None:
    """The numbers of one environment at one step; ``None``, with a finding, where they are not there."""
    dataset = _child(_child(step, group), environment)
    if not hasattr(dataset, "shape"):
        intake.note("value-missing", "damage", f"{where}: {group}/{environment} is not there", group)
        return None
    if dataset.size > 3 * MAX_VERTICES or dataset.dtype.kind not in "fiu":
        found = f"{where}: {group} of shape {dataset.shape} and type {dataset.dtype}"
        intake.note("value-missing", "damage", found, group)
        return None
    try:
        return np.asarray(dataset[()], dtype=np.float64)
    except HDF5_FAULTS as error:
        intake.note("value-missing", "damage", f"{where}: {group} cannot be read ({str(error)[:100]})", group)
        return None


def _push(step: Any, sensor: str, serial: str, moment: int, where: str, intake: Intake) -> None:
    """One step as a moment without an image, the mesh's vertices as its values."""
    name = where.rpartition("/")[0]
    vertices = _read(step, NODES + sensor, name.rpartition("-")[2], where, intake)
    values = {}
    if vertices is not None and (vertices.ndim != 2 or vertices.shape[1] != 3 or not vertices.size):
        intake.note("value-missing", "damage", f"{where}: vertices of shape {vertices.shape}", "vertices")
    elif vertices is not None:
        flat = vertices.reshape(-1)
        if not intake.width("vertices"):
            columns = tuple(f"{axis}{vertex}" for vertex in range(len(vertices)) for axis in "xyz")
            note = "vertices of the gel, metres, x y z of each in turn; meshes without images"
            intake.declare("vertices", columns, ("m",) * len(columns), note)
        if len(flat) == intake.width("vertices"):
            values["vertices"] = flat
        else:
            found = f"{where}: {len(vertices)} vertices where the first mesh has {intake.width('vertices') // 3}"
            intake.note("length-mismatch", "damage", found, "vertices")
    intake.image(sensor, None, moment, sensor=serial, trajectory=name, name=where, values=values)


def _force(step: Any, sensor: str, environment: str, where: str, intake: Intake) -> NDArray[np.float64]:
    force = _read(step, FORCE + sensor, environment, where, intake)
    if force is None or force.size != 3:
        if force is not None:
            intake.note("value-missing", "damage", f"{where}: a net force of shape {force.shape}", FORCE + sensor)
        return np.full(3, np.nan)
    return force.reshape(3)
