"""Small stores with known content, written by the real writer: presses of two sensors by three indenters."""

import hashlib
import json
from pathlib import Path

import cv2
import numpy as np
import pyarrow as pa

from tactiledata.contract.records import FrameValues, Image, Source, Stamps
from tactiledata.contract.take import (
    FRAME_SCHEMA,
    TRAJECTORY_SCHEMA,
    AlignedSignal,
    FrameFlag,
    Reference,
    StoredSignal,
    Take,
    findings_table,
)
from tactiledata.splits.make import make_split
from tactiledata.store.read.reader import Store
from tactiledata.store.write.commit import commit, create
from tactiledata.store.write.spool import Spool
from tactiledata.store.write.writer import stage

HEIGHT, WIDTH = 16, 12
FRAMES = 6
SAMPLES = 15
"""Wrench samples of a trajectory at their native rate."""

SENSORS = ("D1", "D2")
INDENTERS = ("ball", "cone", "edge")
COLUMNS = ("fx", "fy", "fz", "tx", "ty", "tz")
UNITS = ("N", "N", "N", "N m", "N m", "N m")
FORCES = (0.0, 2.0, 4.0, 6.0, 8.0, 0.5)
"""Contact force of a trajectory's frames: the first and the last lie outside the usual filter."""


def picture(number):
    """The picture of a frame, by its number over the store."""
    return np.random.default_rng(number).integers(0, 256, (HEIGHT, WIDTH, 3)).astype(np.uint8)


def reference(sensor):
    """A sensor's picture without contact."""
    return np.full((HEIGHT, WIDTH, 3), 40 * (1 + SENSORS.index(sensor)), np.uint8)


def force_at(number):
    """The aligned wrench of a frame, by its number over the store."""
    return np.array([0.1, -0.2, FORCES[number % FRAMES], 0.01, 0.02, 0.03]) + 1e-3 * number


def write_loader_store(folder, n_sources=4, n_trajectories=3, encoding="png", cameras=("digit",), damaged=()):
    """A store; frame numbers in ``damaged`` are alternately without an image and with a broken one."""
    create(folder)
    commit(
        folder,
        [_staged(Path(folder), number, n_trajectories, encoding, cameras, set(damaged)) for number in range(n_sources)],
    )
    return Store.open(folder)


def split_store(folder, **options):
    """A store with the split ``default``: 24 trajectories in train, val and test."""
    store = write_loader_store(folder, **{"n_sources": 8, **options})
    make_split(store, fractions=(0.5, 0.25, 0.25), hold_out="none")
    return Store.open(folder)


def _payload(number, encoding):
    pixels = picture(number)
    if encoding == "raw":
        return pixels.tobytes()
    return cv2.imencode({"png": ".png", "jpeg": ".jpg"}[encoding], pixels[..., ::-1])[1].tobytes()


def _staged(folder, number, n_trajectories, encoding, cameras, damaged):
    sha256 = hashlib.sha256(str(number).encode()).hexdigest()
    n_frames = n_trajectories * FRAMES
    first = number * n_frames
    with Spool(folder / ".staging" / sha256) as spool:
        for place in range(n_frames):
            kind = "missing" if first + place in damaged and place % 2 == 0 else encoding
            camera = cameras[place % len(cameras)]
            payload = b"" if kind == "missing" else _payload(first + place, kind)
            spool.add(Image(camera, payload, kind, HEIGHT, WIDTH, 1000 * place))
        sensor = SENSORS[number % len(SENSORS)]
        take = Take(
            source=Source(f"run{number}", f"run{number}", "test", (f"run{number}",)),
            sha256=sha256,
            status="ok",
            description={},
            provenance={},
            frames=_frames(spool.columns(), sensor, first, damaged),
            trajectories=_trajectories(number, n_trajectories, sensor),
            findings=findings_table([]),
            signals={"wrench": _signal(first, n_trajectories)},
            aligned={"wrench": _aligned(first, n_frames)},
            frame_values={
                "centre": FrameValues(
                    np.arange(first, first + n_frames)[:, None] * [1.0, 2.0], ("u", "v"), ("px", "px")
                )
            },
            references={sensor: Reference(reference(sensor), "made")},
            sensors={sensor: {"model": "digit"}},
        )
        return stage(folder, spool, take)


def _frames(images, sensor, first, damaged):
    n = images.num_rows
    flags = np.zeros(n, np.uint32)
    for place in range(n):
        if first + place in damaged:
            flags[place] = FrameFlag.MISSING if place % 2 == 0 else FrameFlag.BROKEN
    columns = {name: images[name] for name in images.column_names}
    columns |= {
        "trajectory": pa.array(np.arange(n) // FRAMES, pa.int32()),
        "source": pa.array(np.zeros(n), pa.int32()),
        "sensor": pa.array([sensor] * n).dictionary_encode(),
        "t_ns": pa.array(1000 * np.arange(n)),
        "contact_force": pa.array([FORCES[place % FRAMES] for place in range(n)], pa.float32()),
        "flags": pa.array(flags),
        "parent_frame": pa.array(np.full(n, -1)),
    }
    return pa.table([columns[name].cast(FRAME_SCHEMA.field(name).type) for name in FRAME_SCHEMA.names], FRAME_SCHEMA)


def _trajectories(number, n, sensor):
    places = np.arange(n)
    rows = {
        "uid": [hashlib.sha256(f"{number}/{place}".encode()).hexdigest()[:16] for place in places],
        "trajectory": [f"t{place}" for place in places],
        "source": [0] * n,
        "sensor": [sensor] * n,
        "indenter": [INDENTERS[place % len(INDENTERS)] for place in places],
        "start_ns": (places * FRAMES * 1000).tolist(),
        "end_ns": ((places + 1) * FRAMES * 1000).tolist(),
        "frame_start": (places * FRAMES).tolist(),
        "frame_stop": ((places + 1) * FRAMES).tolist(),
        # every trajectory has another number of samples, the last one of a source has none
        "signal_rows": [
            json.dumps({"wrench": [int(place) * SAMPLES, (int(place) + 1) * SAMPLES - int(place)]})
            if place < n - 1
            else "{}"
            for place in places
        ],
        "peak_force": [max(FORCES)] * n,
        "segmented": ["log"] * n,
        "parent": [""] * n,
        "extra": [json.dumps({"speed": number, "glue": "A" if place else 7}) for place in range(n)],
    }
    return pa.table(rows, TRAJECTORY_SCHEMA)


def _signal(first, n_trajectories):
    n = n_trajectories * SAMPLES
    times = np.arange(n) * 400
    values = np.random.default_rng(first).standard_normal((n, 6))
    return StoredSignal(times, values, COLUMNS, UNITS, "ft", Stamps(times))


def _aligned(first, n):
    values = np.array([force_at(number) for number in range(first, first + n)])
    return AlignedSignal(values, np.full(n, 400), COLUMNS, UNITS, "ft", "linear")
