"""A store of given frames, written by the real writer."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pyarrow as pa
from contestants import Pixels
from digit_frames import COLUMNS, ROWS

from tactiledata.contract.records import Image, Source
from tactiledata.contract.take import FRAME_SCHEMA, TRAJECTORY_SCHEMA, AlignedSignal, Take, findings_table
from tactiledata.store.write.commit import commit, create
from tactiledata.store.write.spool import Spool
from tactiledata.store.write.writer import stage, staging_folder
from tactiledata.units import SIGNAL_COLUMNS, signal_units

PERIOD_NS = 33_000_000


def write_store(folder: Path, pictures: Iterator[tuple[bytes, Pixels]], encoding: str) -> None:
    """A store with these frames; ``encoding`` is ``"jpeg"``, ``"png"`` or ``"raw"``."""
    create(folder)
    sha256 = hashlib.sha256(encoding.encode()).hexdigest()
    with Spool(staging_folder(folder, sha256)) as spool:
        for row, (payload, pixels) in enumerate(pictures):
            content = pixels.tobytes() if encoding == "raw" else payload
            spool.add(Image("digit", content, encoding, ROWS, COLUMNS, row * PERIOD_NS))  # type: ignore[arg-type]
        commit(folder, [stage(folder, spool, _take(spool.columns(), sha256))])


def _take(images: pa.Table, sha256: str) -> Take:
    n = images.num_rows
    columns = {name: images[name] for name in images.column_names}
    columns |= {
        "trajectory": pa.array(np.zeros(n)),
        "source": pa.array(np.zeros(n)),
        "sensor": pa.array(["D20542"] * n).dictionary_encode(),
        "t_ns": pa.array(PERIOD_NS * np.arange(n)),
        "contact_force": pa.array(np.full(n, 5.0)),
        "flags": pa.array(np.zeros(n)),
        "parent_frame": pa.array(np.full(n, -1)),
    }
    frames = pa.table([columns[name].cast(FRAME_SCHEMA.field(name).type) for name in FRAME_SCHEMA.names], FRAME_SCHEMA)
    facts = {
        "uid": "0" * 16,
        "trajectory": "t0",
        "source": 0,
        "sensor": "D20542",
        "indenter": "ball",
        "start_ns": 0,
        "end_ns": PERIOD_NS * n,
        "frame_start": 0,
        "frame_stop": n,
        "signal_rows": "{}",
        "peak_force": 5.0,
        "segmented": "log",
        "parent": "",
        "extra": "{}",
    }
    wrench = SIGNAL_COLUMNS["wrench"]
    aligned = AlignedSignal(np.ones((n, 6)), np.full(n, 10**7), wrench, signal_units(wrench), "ft", "made")
    return Take(
        source=Source("made", "made", "made", ("made",)),
        sha256=sha256,
        status="ok",
        description={},
        provenance={},
        frames=frames,
        trajectories=pa.table({name: [value] for name, value in facts.items()}, TRAJECTORY_SCHEMA),
        findings=findings_table([]),
        aligned={"wrench": aligned},
    )
