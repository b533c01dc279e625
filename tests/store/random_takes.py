"""Random but reproducible takes: small pictures, signals, tables, as ingest would hand them to the store."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import cv2
import numpy as np
import pyarrow as pa

from tactiledata.contract.records import Finding, FrameValues, Image, Source, Stamps
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
from tactiledata.ingest.checks.image_sizes import mark_strays
from tactiledata.store.layout.places import Settings
from tactiledata.store.write.spool import Spool
from tactiledata.store.write.writer import StagedTake, stage, staging_folder

SMALL = Settings(heap_chunk_bytes=4096, signal_chunk_rows=16, shard_frames=4)
"""Chunks so small that a few frames cross every border."""


def picture(rng: np.random.Generator, size: tuple[int, int]) -> np.ndarray:
    return rng.integers(0, 256, (*size, 3), dtype=np.uint8)


def random_images(rng: np.random.Generator, count: int, cameras: tuple[str, ...] = ("digit",)) -> list[Image]:
    images = []
    for index in range(count):
        camera = cameras[int(rng.integers(len(cameras)))]
        encoding = str(rng.choice(["jpeg", "png", "raw", "missing"], p=[0.4, 0.2, 0.3, 0.1]))
        size = (6, 8) if rng.random() < 0.8 else (5, 7)
        pixels = picture(rng, size)
        if encoding in ("jpeg", "png"):
            payload = cv2.imencode(".jpg" if encoding == "jpeg" else ".png", pixels)[1].tobytes()
        else:
            payload = pixels.tobytes() if encoding == "raw" else b""
        images.append(Image(camera, payload, encoding, *size, log_ns=1000 + 10 * index, sensor="D1"))
    return images


def frames_table(spool: Spool, n_trajectories: int) -> pa.Table:
    columns = spool.columns()
    count = len(columns)
    trajectory = (np.arange(count) * max(n_trajectories, 1) // max(count, 1)) if n_trajectories else np.full(count, -1)
    missing = np.array(columns["encoding"].to_pylist(), dtype=object) == "missing"
    values = {
        **{name: columns[name] for name in columns.column_names if name in FRAME_SCHEMA.names},
        "trajectory": trajectory,
        "source": np.zeros(count),
        "t_ns": columns["log_ns"],
        "contact_force": np.linspace(0, 5, count),
        "flags": np.where(missing, FrameFlag.MISSING, 0),
        "parent_frame": np.full(count, -1),
    }
    arrays = []
    for field in FRAME_SCHEMA:
        column = values[field.name]
        array = column if isinstance(column, pa.ChunkedArray) else pa.array(np.asarray(column))
        arrays.append(array.cast(field.type))
    # as ingest hands them over
    return mark_strays(pa.table(arrays, schema=FRAME_SCHEMA), [f"touch{number}" for number in range(n_trajectories)])[0]


def trajectories_table(
    sha256: str, n_trajectories: int, n_frames: int, n_rows: int, indenter: str = "ball4"
) -> pa.Table:
    rows = []
    index = np.arange(n_frames) * max(n_trajectories, 1) // max(n_frames, 1)
    for number in range(n_trajectories):
        mine = np.flatnonzero(index == number)
        start, stop = (int(mine[0]), int(mine[-1]) + 1) if len(mine) else (0, 0)
        span = [n_rows * number // n_trajectories, n_rows * (number + 1) // n_trajectories]
        rows.append(
            {
                "uid": hashlib.sha256(f"{sha256}{number}".encode()).hexdigest()[:16],
                "trajectory": f"touch{number}",
                "source": 0,
                "sensor": "D1",
                "indenter": indenter,
                "start_ns": 1000 * number,
                "end_ns": 1000 * number + 500,
                "frame_start": start,
                "frame_stop": stop,
                "signal_rows": json.dumps({"wrench": span}),
                "peak_force": float(number),
                "segmented": "log",
                "parent": "",
                "extra": "{}",
            }
        )
    return pa.Table.from_pylist(rows, schema=TRAJECTORY_SCHEMA)


def stored_signal(rng: np.random.Generator, n_rows: int, columns: tuple[str, ...], frame: str) -> StoredSignal:
    t_ns = np.cumsum(rng.integers(0, 5, n_rows)).astype(np.int64)
    return StoredSignal(
        t_ns,
        rng.normal(size=(n_rows, len(columns))),
        columns,
        ("N",) * len(columns),
        frame,
        Stamps(t_ns + 7),
        {"rate": 100.0},
    )


def random_take(
    seed: int,
    spool: Spool,
    n_frames: int | None = None,
    frame: str = "ft",
    sensors: dict | None = None,
    cameras: tuple[str, ...] = ("digit",),
    images: list[Image] | None = None,
) -> Take:
    """A take, decided by its seed and options; images go into the spool."""
    rng = np.random.default_rng(seed)
    images = (
        random_images(rng, int(rng.integers(0, 14)) if n_frames is None else n_frames, cameras)
        if images is None
        else images
    )
    for image in images:
        spool.add(image)
    sha256 = hashlib.sha256(f"source {seed}".encode()).hexdigest()
    n_trajectories = int(rng.integers(0, 4)) if images else 0
    n_rows = int(rng.integers(0, 60))
    count = len(images)
    aligned, frame_values = {}, {}
    if rng.random() < 0.7:
        gap = rng.integers(-1, 50, count).astype(np.int64)
        aligned["wrench"] = AlignedSignal(rng.normal(size=(count, 2)), gap, ("fx", "fz"), ("N", "N"), frame, "linear")
    if rng.random() < 0.4:
        frame_values["centre"] = FrameValues(rng.normal(size=(count, 2)), ("u", "v"), ("1", "1"), "annotated")
    findings = [Finding("gap", "info", f"gap {number}", stream="wrench") for number in range(int(rng.integers(0, 3)))]
    return Take(
        source=Source(f"run{seed}.mcap", f"run{seed}", "mcap", (f"run{seed}.mcap",)),
        sha256=sha256,
        status="ok",
        description={"format": "tactiledata-log/1"},
        provenance={"seed": seed},
        frames=frames_table(spool, n_trajectories),
        trajectories=trajectories_table(sha256, n_trajectories, count, n_rows),
        findings=findings_table(findings),
        signals={"wrench": stored_signal(rng, n_rows, ("fx", "fz"), frame)},
        aligned=aligned,
        references={"D1": Reference(np.full((6, 8, 3), 100, np.uint8), "planted")} if seed % 2 else {},
        sensors={"D1": {"model": "digit"}} if sensors is None else sensors,
        frame_values=frame_values,
    )


def staged_take(store_path: Path, seed: int, **options) -> tuple[StagedTake, Take]:
    """A random take, staged."""
    sha256 = hashlib.sha256(f"source {seed}".encode()).hexdigest()
    spool = Spool(staging_folder(store_path, sha256))
    take = random_take(seed, spool, **options)
    return stage(store_path, spool, take), take
