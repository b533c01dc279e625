"""Curves of a trajectory: measured and simulated force, what lies between them, pose, and all other signals."""

from __future__ import annotations

import numpy as np

from tactiledata.arrays import Array, Times
from tactiledata.store.read.meshes import StoredMesh
from tactiledata.store.read.reader import Store
from tactiledata.store.read.signal_rows import SignalRows
from tactiledata.transforms import pose_matrices
from tactiledata.units import SIGNAL_COLUMNS
from tactiledata.view.touch_log import TouchLog

FORCE, TORQUE, RESIDUAL, POSE, OTHERS = "force", "torque", "residual", "pose", "signals"
"""Entities above the curves."""
MEASURED, SIMULATED = "measured", "simulated"
"""Entities below force and torque."""
CONTACT_WRENCH, TCP = "contact_wrench", "tcp"
"""Names of the signals that have panes of their own."""
MOST_SAMPLES = 20_000
"""Samples of one signal that are shown; of more, every so manieth is."""
BLOCK = 65_536
"""Samples that are read at once."""
GEL = "gel"
"""Frame of simulated wrenches, in which measured ones can be compared with them."""


def put_curves(log: TouchLog, store: Store, mesh: StoredMesh | None) -> tuple[list[str], set[str]]:
    """Put the curves of a trajectory; return what is missing in words, and the entities that have curves.

    Parameters
    ----------
    log : TouchLog
    store : Store
    mesh : StoredMesh, optional
        ``None`` where the store was not replayed.
    """
    there: set[str] = set()
    missing = []
    touch = log.touch
    for name in touch.signals:
        t_ns, values, thinning = _samples(log, store, name)
        missing += thinning
        signal = store.signal(touch.signals[name][0])
        # what has other columns than its name promises is one of the other signals
        known = name if tuple(signal.columns) == SIGNAL_COLUMNS.get(name) else ""
        if known == CONTACT_WRENCH:
            frame = signal.frame
            note = MEASURED if frame == GEL else f"{MEASURED} ({frame or 'frame not stated'})"
            log.curves(f"{FORCE}/{MEASURED}", ("fx", "fy", "fz"), t_ns, values[:, :3], simulated=False, note=note)
            log.curves(f"{TORQUE}/{MEASURED}", ("tx", "ty", "tz"), t_ns, values[:, 3:6], simulated=False, note=note)
            there |= {FORCE, TORQUE}
        elif known == TCP:
            _put_pose(log, t_ns, values)
            there.add(POSE)
        else:
            units = [f"{column} [{unit}]" for column, unit in zip(signal.columns, signal.units, strict=True)]
            for column, label in enumerate(units):
                log.curves(f"{OTHERS}/{name}", (label,), t_ns, values[:, column : column + 1], simulated=False)
            there.add(OTHERS)
    if FORCE not in there:
        missing.append("No measured contact force: the store has none of this trajectory (`tactiledata info`).")
    if POSE not in there:
        missing.append("No pose: the recording has none of this trajectory.")
    return [*missing, *_put_simulated(log, store, mesh, there)], there


def _samples(log: TouchLog, store: Store, name: str) -> tuple[Times, Array, list[str]]:
    """Times (n,), ns, and values (n, k) of a signal, thinned where there are too many; and that in words."""
    stored, first, stop = log.touch.signals[name]
    t_ns, values, step = every_so_many(store.signal(stored), first, stop)
    said = [] if step == 1 else [f"Of the {stop - first} samples of {name}, every {_ordinal(step)} is shown."]
    return t_ns, values, said


def every_so_many(
    signal: SignalRows, first: int, stop: int, most: int = MOST_SAMPLES, block: int = BLOCK
) -> tuple[Times, Array, int]:
    """Times (n,), ns, and values (n, k) of every so manieth sample of a signal, and every how manieth that is.

    Parameters
    ----------
    signal : SignalRows
    first, stop : int
        First row, and the row after the last.
    most : int
        Largest number of samples that are taken.
    block : int
        Largest number of samples in memory at once beside those that are taken, where ``step`` is less.
    """
    step = max(1, -(-(stop - first) // most))
    # each block begins with a sample that is taken
    length = max(1, block // step) * step
    starts = range(first, stop, length)
    t_ns = [signal.t_ns(at, min(at + length, stop))[::step] for at in starts]
    values = [np.asarray(signal.values(at, min(at + length, stop)))[::step] for at in starts]
    return np.concatenate(t_ns), np.concatenate(values), step


def _ordinal(number: int) -> str:
    return {2: "second", 3: "third"}.get(number, f"{number}th")


def _put_pose(log: TouchLog, t_ns: Times, values: Array) -> None:
    """Put how the tool has moved, mm, and turned, degrees, since the first pose of the trajectory that is known."""
    known = np.isfinite(values).all(axis=1)
    if not known.any():
        return
    t_ns, poses = t_ns[known], pose_matrices(values[known])
    moved = 1e3 * (poses[:, :3, 3] - poses[0, :3, 3])
    log.curves(f"{POSE}/moved_mm", ("x", "y", "z"), t_ns, moved, simulated=False)
    # the angle of a rotation, from the trace of its matrix
    trace = np.einsum("nij,ij->n", poses[:, :3, :3], poses[0, :3, :3])
    turned = np.degrees(np.arccos(np.clip((trace - 1) / 2, -1, 1)))
    log.curves(f"{POSE}/turned_deg", ("angle",), t_ns, turned[:, None], simulated=False, note="[degrees]")


def _put_simulated(log: TouchLog, store: Store, mesh: StoredMesh | None, there: set[str]) -> list[str]:
    """Put simulated wrenches, and measured minus simulated forces, at the moments of all frames of the trajectory."""
    if mesh is None:
        return []
    facts, touch = log.touch.facts, log.touch
    rows = np.arange(facts["frame_start"], facts["frame_stop"])
    rows = rows[mesh.has_mesh(rows)]
    if not len(rows):
        return []
    t_ns = store.frames(["t_ns"])["t_ns"].to_numpy()[rows]
    wrench = mesh.wrench(rows)
    note = SIMULATED
    log.curves(f"{FORCE}/{SIMULATED}", ("fx", "fy", "fz"), t_ns, wrench[:, :3], simulated=True, note=note)
    log.curves(f"{TORQUE}/{SIMULATED}", ("tx", "ty", "tz"), t_ns, wrench[:, 3:6], simulated=True, note=note)
    there |= {FORCE, TORQUE}
    stored = touch.aligned.get(CONTACT_WRENCH)
    if stored is None:
        return ["No residual: no measured contact force belongs to the frames."]
    meaning = store.meaning("aligned", stored)
    if meaning.frame != GEL or tuple(meaning.columns) != SIGNAL_COLUMNS[CONTACT_WRENCH]:
        frame = meaning.frame or "(not stated)"
        return [f"No residual: the measured contact force is {', '.join(meaning.columns)} in the frame {frame}."]
    residual = store.aligned(stored, rows)[0][:, :3] - wrench[:, :3]
    log.curves(RESIDUAL, ("fx", "fy", "fz"), t_ns, residual, simulated=False)
    there.add(RESIDUAL)
    return []
