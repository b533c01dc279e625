"""Exports for tests, and what of the store each row of them must be."""

import numpy as np

from tactiledata.export.export import export_data
from tactiledata.export.plan import ExportPlan
from tactiledata.splits.manifest import load_split, partition_rows
from tactiledata.store.read.reader import Store


def export(store, to, out, **options):
    """An export into a folder; the folder and its document."""
    report = export_data(store, ExportPlan(to, **options), out)
    return out, report.document


def digests(folder):
    """Digest of every file of a finished export, by its path."""
    import hashlib

    files = (path for path in sorted(folder.rglob("*")) if path.is_file())
    return {path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


def expected_frames(store: Store, part):
    """Rows of the frames that a part must have, trajectory after trajectory: readable, of its trajectories; slowly."""
    partition = partition_rows(load_split(store, "default"), store.trajectories(["uid"])["uid"])
    frames = store.frames(["trajectory", "flags"]).to_pylist()
    return [
        row
        for trajectory in range(len(partition))
        if partition[trajectory] == part
        for row, frame in enumerate(frames)
        if frame["trajectory"] == trajectory and not frame["flags"] & (1 | 2 | 16 | 32)
    ]


def nan_equal(ours, theirs):
    """Whether two arrays hold the same numbers, NaN in the same places."""
    return np.array_equal(np.asarray(ours, float), np.asarray(theirs, float), equal_nan=True)
