"""A store with names that our reader cannot guess: cameras without a tactile word, a signal of its own."""

import hashlib

import cv2
import numpy as np
import pyarrow as pa

from tactiledata.contract.records import Image, Source, Stamps
from tactiledata.contract.take import FRAME_SCHEMA, TRAJECTORY_SCHEMA, StoredSignal, Take, findings_table
from tactiledata.store.read.reader import Store
from tactiledata.store.write.commit import commit, create
from tactiledata.store.write.spool import Spool
from tactiledata.store.write.writer import stage

START = 1_700_000_000_000_000_000
FRAMES = 12


def renamed_store(folder, encoding):
    """A store of one recording with two cameras and a temperature."""
    create(folder)
    sha256 = hashlib.sha256(b"renamed").hexdigest()
    rng = np.random.default_rng(4)
    with Spool(folder / ".staging" / sha256) as spool:
        for place in range(FRAMES):
            pixels = rng.integers(0, 256, (8, 6, 3)).astype(np.uint8)
            payload = pixels.tobytes() if encoding == "raw" else cv2.imencode(".png", pixels)[1].tobytes()
            camera = ("left_pad", "right_pad")[place % 2]
            spool.add(Image(camera, payload, encoding, 8, 6, START + place * 10_000_000))
        images = spool.columns()
        columns = {name: images[name] for name in images.column_names}
        columns |= {
            "trajectory": pa.array([-1] * FRAMES, pa.int32()),
            "source": pa.array([0] * FRAMES, pa.int32()),
            "sensor": pa.array(["P1"] * FRAMES).dictionary_encode(),
            "t_ns": images["log_ns"],
            "contact_force": pa.array([None] * FRAMES, pa.float32()),
            "flags": pa.array([8] * FRAMES, pa.uint32()),
            "parent_frame": pa.array([-1] * FRAMES, pa.int64()),
        }
        frames = [columns[name].cast(FRAME_SCHEMA.field(name).type) for name in FRAME_SCHEMA.names]
        times = START + np.arange(20) * 5_000_000
        values = rng.normal(300, 1, (20, 1))
        take = Take(
            source=Source("run", "run", "test", ("run",)),
            sha256=sha256,
            status="ok",
            description={"format": "tactiledata-log/1", "sensors": {"P1": {"model": "digit"}}},
            provenance={},
            frames=pa.table(frames, FRAME_SCHEMA),
            trajectories=TRAJECTORY_SCHEMA.empty_table(),
            findings=findings_table([]),
            signals={"temperature": StoredSignal(times, values, ("t0",), ("K",), "", Stamps(times))},
            aligned={},
            frame_values={},
            references={},
            sensors={"P1": {"model": "digit"}},
        )
        commit(folder, [stage(folder, spool, take)])
    return Store.open(folder)
