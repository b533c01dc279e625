"""Small stores in memory for the tests of splits."""

import cv2
import numpy as np
import pyarrow as pa

from tactiledata.contract.take import FRAME_SCHEMA, TRAJECTORY_SCHEMA
from tactiledata.errors import MissingFile


def trajectories(rows):
    """A trajectories table of rows as dicts; what a row does not say is made up."""
    full = []
    for number, row in enumerate(rows):
        start = row.get("start_ns", 10_000 * number)
        full.append(
            {
                "uid": f"{number:016x}",
                "trajectory": f"t{number}",
                "source": 0,
                "sensor": "A",
                "indenter": "ball",
                "start_ns": start,
                "end_ns": start + 5_000,
                "frame_start": 0,
                "frame_stop": 0,
                "signal_rows": "{}",
                "peak_force": 5.0,
                "segmented": "log",
                "parent": "",
                "extra": "{}",
                **row,
            }
        )
    return pa.Table.from_pylist(full, schema=TRAJECTORY_SCHEMA)


def frames(table, per_trajectory=3, **columns):
    """A frames table with some frames for each trajectory, all in contact; columns replace what is made up."""
    n = table.num_rows * per_trajectory
    trajectory = np.repeat(np.arange(table.num_rows), per_trajectory)
    words = {"camera": "digit", "encoding": "jpeg"}
    made = {
        "trajectory": trajectory,
        "source": np.zeros(n, int),
        **{name: pa.array([word] * n).dictionary_encode() for name, word in words.items()},
        "sensor": table["sensor"].combine_chunks().take(pa.array(trajectory)).dictionary_encode(),
        **{name: np.arange(n) for name in ("t_ns", "log_ns", "publish_ns", "header_ns", "offset")},
        "height": np.full(n, 320),
        "width": np.full(n, 240),
        "length": 1000 + np.arange(n),
        "crc32c": np.arange(n) * 7919,
        "contact_force": np.full(n, 5.0),
        "flags": np.zeros(n, int),
        "parent_frame": np.full(n, -1),
        **columns,
    }
    arrays = [pa.array(made[field.name]).cast(field.type) for field in FRAME_SCHEMA]
    return pa.table(arrays, schema=FRAME_SCHEMA)


class MemoryStore:
    """What splits need of a store: two tables, a folder and pictures."""

    def __init__(self, folder, table, frame_table=None, pictures=None):
        self.location = str(folder)
        self.digest = "0" * 64
        self.folder = folder
        self.table = table
        self.frame_table = frames(table) if frame_table is None else frame_table
        self.pictures = pictures

    @property
    def n_frames(self):
        return self.frame_table.num_rows

    def trajectories(self, columns=None):
        return self.table.select(columns or self.table.column_names)

    def sources(self, columns):
        assert columns == ["key"]
        count = max(self.table["source"].to_pylist(), default=-1) + 1
        return pa.table({"key": [f"log{number}" for number in range(count)]})

    def frames(self, columns=None):
        return self.frame_table.select(columns or self.frame_table.column_names)

    def images(self, rows):
        return [self.pictures[row] for row in rows]

    def split_names(self):
        return sorted(path.stem for path in (self.folder / "splits").glob("*.json"))

    def split_path(self, name, suffix=".parquet"):
        return self.folder / "splits" / f"{name}{suffix}"

    def read_file(self, path):
        if not (self.folder / path).is_file():
            raise MissingFile(f"{path} does not exist")
        return (self.folder / path).read_bytes()


def many(n=400, sensors="ABCDE", indenters=("ball", "star", "edge", "cross", "ring")):
    """Rows of recorded trajectories, each in a source of its own."""
    return [
        {"source": k, "sensor": sensors[k % len(sensors)], "indenter": indenters[(k // len(sensors)) % len(indenters)]}
        for k in range(n)
    ]


def parts(table):
    """Partition by uid."""
    return dict(zip(table["uid"].to_pylist(), table["partition"].to_pylist(), strict=True))


def background(rng):
    """A sensor's picture without contact: lights of three colours from three sides, and specks."""
    rows, columns = np.mgrid[0:320, 0:240] / 240
    lights = [np.exp(-((rows - r) ** 2 + (columns - c) ** 2) / 0.5) for r, c in ((0, 0.5), (1.3, 0.1), (1.3, 0.9))]
    specks = cv2.GaussianBlur(rng.normal(0, 12, (320, 240)), (0, 0), 1.2)
    return 60 + 110 * np.stack(lights, axis=-1) + specks[..., None]


def touch(base, place, rng, depth=2.0, radius=28.0, noise=1.0):
    """A picture (320, 240, 3) uint8 of a round press at (row, column), with the camera's noise."""
    rows, columns = np.mgrid[0:320, 0:240]
    square = (rows - place[0]) ** 2 + (columns - place[1]) ** 2
    height = 20 * depth * np.exp(-square / (2 * radius**2))
    height += 8 * depth * np.sqrt(np.maximum(1 - square / radius**2, 0))
    across, along = cv2.Sobel(height, cv2.CV_64F, 1, 0), cv2.Sobel(height, cv2.CV_64F, 0, 1)
    sides = ((1.0, 0.0), (-0.5, 0.87), (-0.5, -0.87))
    shading = np.stack([4 * (a * across + b * along) for a, b in sides], axis=-1)
    return levels(base + shading + rng.normal(0, noise, base.shape))


def levels(picture):
    """Rounded to grey levels."""
    return np.clip(np.rint(picture), 0, 255).astype(np.uint8)


def jpeg(picture, quality):
    """The picture after JPEG at a quality."""
    _, payload = cv2.imencode(".jpg", picture[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, quality])
    return cv2.imdecode(payload, cv2.IMREAD_COLOR_RGB)


def replaced(table, **columns):
    for name, values in columns.items():
        at = table.column_names.index(name)
        table = table.set_column(at, table.schema.field(name), pa.array(values, table.schema.field(name).type))
    return table
