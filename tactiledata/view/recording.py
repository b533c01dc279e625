"""Trajectories of a store as one file for rerun's viewer: a recording each, side by side in the file."""

from __future__ import annotations

import fcntl
import glob
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from tactiledata.contract.atomic import sync_folder
from tactiledata.contract.progress import Progress
from tactiledata.contract.provenance import digest_of, provenance
from tactiledata.contract.simulated import SimulatedCount
from tactiledata.contract.wording import counted, listed
from tactiledata.errors import StoreError, UsageError
from tactiledata.store.read.flags import Flag
from tactiledata.store.read.meshes import StoredMesh
from tactiledata.store.read.reader import Store
from tactiledata.view.about import ABOUT, about
from tactiledata.view.chosen import chosen_trajectories
from tactiledata.view.curves import put_curves
from tactiledata.view.gel import put_gel, shown_mesh
from tactiledata.view.options import ViewOptions
from tactiledata.view.panes import panes, stacked_panes
from tactiledata.view.pictures import put_pictures
from tactiledata.view.rerun_package import load_rerun
from tactiledata.view.touch import TouchReader, ViewedTouch
from tactiledata.view.touch_log import TouchLog

COLOURS = re.compile("\x1b\\[[0-9;]*m")
"""What rerun writes into its messages to colour them on a terminal."""
SUFFIX = ".rrd"
MOST_MESHES = 3
"""Names of other meshes that a report prints."""
LOCK = "lock"
"""A file that is locked as long as its folder is written to; the system frees it when the process dies."""


@dataclass(frozen=True)
class ViewReport:
    """What was written for the viewer.

    Parameters
    ----------
    out : str
        The file.
    trajectories : tuple of str
        Full names of those that are shown.
    found : int
        How many trajectories the options describe.
    pictures, meshes : int
        How many are shown.
    mesh : str
        Name of the mesh; empty where there is none.
    other_meshes : tuple of str
        Names of the meshes of the store that are not shown.
    simulated : SimulatedCount
        Of the trajectories that are shown.
    flags : tuple of Flag
        Flags of the trajectories that are shown.
    missing : dict, sentence -> number of trajectories
        What is not there.
    """

    out: str
    trajectories: tuple[str, ...]
    found: int
    pictures: int
    meshes: int
    mesh: str
    other_meshes: tuple[str, ...]
    simulated: SimulatedCount
    flags: tuple[Flag, ...]
    missing: dict[str, int]

    def document(self) -> dict[str, Any]:
        """The report as JSON values."""
        return {
            **vars(self),
            "trajectories": list(self.trajectories),
            "other_meshes": list(self.other_meshes),
            "simulated": self.simulated.document(),
            "flags": [flag.document() for flag in self.flags],
        }

    def lines(self) -> list[str]:
        """The report for people."""
        shown = len(self.trajectories)
        what = f"{counted(shown, 'trajectory')} of {self.found}" if shown < self.found else counted(shown, "trajectory")
        named = f" ({self.mesh})" if self.mesh else ""
        pictures, meshes = counted(self.pictures, "picture"), counted(self.meshes, "frame")
        lines = [f"{self.out}: {what}, {pictures}, {meshes} with a mesh{named}"]
        if self.other_meshes:
            lines.append(f"other meshes, shown by --mesh NAME: {listed(self.other_meshes, MOST_MESHES)}")
        if shown < self.found:
            lines.append("others: name them, or give --most 0 for all")
        lines += [self.simulated.sentence] if self.simulated.sentence else []
        lines += [f"flagged: {flag.words}" for flag in self.flags]
        for sentence, count in self.missing.items():
            lines.append(sentence if count == shown else f"{sentence} ({counted(count, 'trajectory')})")
        return lines


@dataclass(frozen=True)
class _Shown:
    """What one trajectory's part of the file holds."""

    touch: ViewedTouch
    cameras: list[str]
    curves: set[str]
    pictures: int
    meshes: int
    missing: list[str]


def write_view(
    store: Store, out: Path, options: ViewOptions | None = None, progress: Progress | None = None
) -> ViewReport:
    """Write a file that rerun's viewer opens, and report what it holds.

    The file is written beside its place and renamed: killed at any moment, what was there before stays. Memory holds
    the tables of the store, a block of frames, the samples of one signal of one trajectory, and in the end rerun's
    index of the file, some 0.7 MB a trajectory.

    Parameters
    ----------
    store : Store
    out : Path
        A file that ends in ``.rrd``; one that is there is replaced.
    options : ViewOptions, optional
    progress : callable, optional
        Called with trajectories done, trajectories in all, and the name of the last one.

    Raises
    ------
    UnknownName, UsageError
        What is named is not there, or nothing is left to show; rerun is not installed; another suffix.
    StoreError
        The store is damaged, or the file cannot be written.
    """
    load_rerun()
    options = options or ViewOptions()
    if out.suffix != SUFFIX or out.is_dir():
        raise UsageError(f"the file {out}", f"a file name that ends in {SUFFIX}", "For example --out view.rrd.")
    rows, found = chosen_trajectories(store, options)
    mesh = shown_mesh(store, options.mesh)
    reader = TouchReader(store)
    shown: list[_Shown] = []
    out.parent.mkdir(parents=True, exist_ok=True)
    with _folder_beside(out) as folder:
        parts = []
        for done, row in enumerate(rows, start=1):
            touch = reader.touch(row)
            part = folder / f"{done:06d}{SUFFIX}"
            shown.append(_write_part(part, store, touch, mesh, options))
            parts.append(part)
            if progress is not None:
                progress(done, len(rows), touch.name)
        layout = folder / "panes.rbl"
        _write_layout(layout, store, shown, options.narrow)
        # the viewer shows what it read last
        _join([layout, *reversed(parts)], folder / "joined.rrd", out)
    return _report(out, shown, found, mesh, store.mesh_names)


@contextmanager
def _folder_beside(out: Path) -> Iterator[Path]:
    """A folder for parts of a file, beside it, taken away at the end; those that killed processes left go as well."""
    for left in out.parent.glob(f".{glob.escape(out.name)}.*.part"):
        try:
            with (left / LOCK).open("rb") as lock:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except FileNotFoundError:  # killed before it had its lock; a live process that loses it makes another
            with suppress(OSError):
                left.rmdir()
            continue
        except OSError:  # another process writes there
            continue
        shutil.rmtree(left, ignore_errors=True)
    folder, held = _locked_folder(out)
    with held:
        try:
            yield folder
        finally:
            shutil.rmtree(folder, ignore_errors=True)


def _locked_folder(out: Path) -> tuple[Path, BinaryIO]:
    """Make a folder beside a file, and its lock, held; another where a process that starts took it for a leftover."""
    while True:
        folder = Path(tempfile.mkdtemp(prefix=f".{out.name}.", suffix=".part", dir=out.parent))
        try:
            held = (folder / LOCK).open("wb")
        except FileNotFoundError:
            continue
        fcntl.flock(held, fcntl.LOCK_EX)
        if (folder / LOCK).exists():
            return folder, held
        held.close()


def _application(store: Store) -> str:
    """Name under which rerun keeps the layout: recordings of one store share it. It allows letters, digits, _ and -."""
    return re.sub(r"[^A-Za-z0-9_-]+", "-", f"tactiledata-{Path(store.location).stem}")[:60]


def _write_part(part: Path, store: Store, touch: ViewedTouch, mesh: StoredMesh | None, options: ViewOptions) -> _Shown:
    """Write the rerun recording of one trajectory into a file of its own."""
    rr = load_rerun()
    made = provenance("view", {"store": store.digest}, {**vars(options), "names": list(options.names)})
    identity = digest_of([touch.uid, made, None if mesh is None else mesh.facts["digest"]])
    stream = rr.RecordingStream(_application(store), recording_id=f"{touch.uid}-{identity[:16]}", send_properties=False)
    # times of writing would be a third time line
    stream.set_log_time_enabled(False)
    stream.set_log_tick_enabled(False)
    try:
        with part.open("wb") as file:
            log = TouchLog(stream, touch, file)
            stream.send_recording_name(touch.title)
            cameras, missing, pictures = put_pictures(log, store, options)
            gel = put_gel(log, store, mesh, options)
            without_curves, curves = put_curves(log, store, mesh)
            missing += [*gel.missing, *without_curves]
            words = about(touch, store.location, mesh, gel.largest_move, missing)
            log.put_static(ABOUT, rr.TextDocument(words, media_type="text/markdown"))
            stream.send_property("tactiledata", _properties(touch, store, made))
            log.flush()
    finally:
        stream.disconnect()
    return _Shown(touch, cameras, curves, pictures, gel.meshes, missing)


def _properties(touch: ViewedTouch, store: Store, made: dict[str, Any]) -> Any:
    """Facts of a trajectory that stay with its rerun recording, for programs."""
    return load_rerun().AnyValues(
        uid=touch.uid,
        trajectory=touch.name,
        sensor=touch.facts["sensor"],
        indenter=touch.facts["indenter"],
        recorded=touch.kind,
        flagged="no" if touch.flag is None else touch.flag.reason,
        start_ns=np.array([touch.start_ns], np.int64),
        log_start_ns=np.array([touch.log_ns], np.int64),
        store_digest=store.digest,
        version=made["version"],
    )


def _write_layout(path: Path, store: Store, shown: Sequence[_Shown], narrow: bool) -> None:
    """Write the layout of the screen, which serves all trajectories."""
    cameras = {camera for part in shown for camera in part.cameras}
    curves = {entity for part in shown for entity in part.curves}
    arrange = stacked_panes if narrow else panes
    arrange(cameras, curves, any(part.meshes for part in shown)).save(_application(store), str(path))


def _join(parts: Collection[Path], joined: Path, out: Path) -> None:
    """Join files of rerun into one and put it in its place; messages are copied as they are, one at a time."""
    command = [sys.executable, "-m", "rerun", "rrd", "route", *map(str, parts), "-o", str(joined)]
    # with CI set, rerun's program does not report its use
    done = subprocess.run(command, capture_output=True, text=True, check=False, env={**os.environ, "CI": "true"})
    if done.returncode or not joined.is_file():
        raise StoreError(
            f"{out} could not be written: {COLOURS.sub('', done.stderr).strip()[-300:]}",
            "a folder with free space that may be written",
            "Free some space, or name another place with --out.",
        )
    with joined.open("rb+") as stream:
        os.fsync(stream.fileno())
    joined.replace(out)
    sync_folder(out.parent)


def _report(
    out: Path, shown: Sequence[_Shown], found: int, mesh: StoredMesh | None, names: Sequence[str]
) -> ViewReport:
    meshes = sum(part.meshes for part in shown)
    return ViewReport(
        out=str(out),
        trajectories=tuple(part.touch.name for part in shown),
        found=found,
        pictures=sum(part.pictures for part in shown),
        meshes=meshes,
        mesh=mesh.name if mesh is not None and meshes else "",
        other_meshes=tuple(name for name in names if mesh is None or name != mesh.name),
        simulated=SimulatedCount.of((part.touch.kind for part in shown), "trajectory"),
        flags=tuple(part.touch.flag for part in shown if part.touch.flag is not None),
        missing=dict(Counter(sentence for part in shown for sentence in part.missing)),
    )
