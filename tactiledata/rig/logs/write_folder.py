"""Writing of a recording as a folder log: tables, pictures and a description that people can open."""

from __future__ import annotations

import io
import secrets
import shutil
from collections.abc import Callable
from pathlib import Path

import pandas as pd
import yaml

from tactiledata.contract.atomic import sync_folder
from tactiledata.errors import UsageError
from tactiledata.rig.logs.encode import SUFFIX, encoded, turned
from tactiledata.rig.logs.tape import Samples, Tape
from tactiledata.units import SIGNAL_COLUMNS

FILES = {"wrench": "wrench.csv", "tcp": "tcp.csv", "joints": "joints.csv"}


def write_folder(tape: Tape, path: Path, progress: Callable[[int], None]) -> None:
    """Write a tape as a folder, whole or not at all; an existing folder is replaced.

    Parameters
    ----------
    tape : Tape
        The recording.
    path : Path
        The folder.
    progress : callable
        Called with the number of pictures written since the last call.

    Raises
    ------
    UsageError
        The scenario asks for a log without description, but a folder log needs its log.yaml.
    """
    if not tape.scenario.recordings.describe:
        raise UsageError(
            "the scenario says `describe: false`, but a folder log needs its description",
            "the MCAP form",
            "Record with --format mcap, or drop `describe: false`.",
        )
    beside = path.parent / f".{path.name[:60]}.{secrets.token_hex(4)}.part"
    gone = path.parent / f".{path.name[:60]}.{secrets.token_hex(4)}.old"
    try:
        beside.mkdir()
        _write(tape, beside, progress)
        if path.exists():
            path.rename(gone)
        beside.rename(path)
    finally:
        shutil.rmtree(beside, ignore_errors=True)
        shutil.rmtree(gone, ignore_errors=True)
    sync_folder(path.parent)


def _write(tape: Tape, folder: Path, progress: Callable[[int], None]) -> None:
    """Write all files of a folder log."""
    description = yaml.safe_dump(dict(tape.description), sort_keys=False, default_flow_style=None, allow_unicode=True)
    (folder / "log.yaml").write_text(description, encoding="utf-8")
    if tape.trajectories:
        _table(folder / "trajectories.csv", pd.DataFrame(list(tape.trajectories)))
    for purpose, (name, file) in enumerate(FILES.items()):
        if name in tape.signals:
            _signal(tape, folder / file, name, tape.signals[name], purpose)
    for name, background in tape.backgrounds.items():
        (folder / name).parent.mkdir(exist_ok=True, parents=True)
        (folder / name).write_bytes(encoded(background, "png", 0))
    for name, source in tape.files.items():
        (folder / name).parent.mkdir(exist_ok=True, parents=True)
        shutil.copyfile(source, folder / name)
    _pictures(tape, folder, progress)


def _signal(tape: Tape, path: Path, name: str, samples: Samples, purpose: int) -> None:
    """Write one stream of numbers as a CSV table, some rows out of order where the scenario asks for it."""
    table = pd.DataFrame(samples.values, columns=list(SIGNAL_COLUMNS[name]))
    table.insert(0, "t_ns", samples.stamp_ns)
    order = list(tape.disordered(range(len(table)), purpose=20 + purpose))
    _table(path, table.iloc[order])


def _table(path: Path, table: pd.DataFrame) -> None:
    """Write a table as CSV."""
    # repr-like digits: what is read back is what was written, bit for bit
    buffer = io.StringIO()
    table.to_csv(buffer, index=False, lineterminator="\n", na_rep="nan")
    path.write_text(buffer.getvalue(), encoding="utf-8")


def _pictures(tape: Tape, folder: Path, progress: Callable[[int], None]) -> None:
    """Write the pictures and their table; a lost picture keeps its row without a file."""
    setup = tape.scenario.images
    (folder / "frames").mkdir()
    rows = []
    for index, shot in enumerate(tape.shots):
        name = "" if shot.dropped else f"frames/{index:06d}.{SUFFIX[setup.encoding]}"
        rows.append({"t_ns": shot.stamp_ns, "trajectory": shot.trajectory, "file": name})
        if shot.dropped:
            continue
        encoding = "jpeg" if setup.encoding == "jpeg" else "png"
        (folder / name).write_bytes(encoded(turned(shot.picture(), setup), encoding, setup.quality))
        progress(1)
    _table(folder / "frames.csv", pd.DataFrame(rows, columns=["t_ns", "trajectory", "file"]))
