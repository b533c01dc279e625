"""HDF5 files as a laboratory's own recorder may write them, and the mapping by which they are read."""

import h5py
import numpy as np

STAMPS = 1_700_000_000_123_456_789 + 10_000_000 * np.arange(40)
MAPPING = {
    "format": "tactiledata-mapping/1",
    "signals": {
        "wrench": {"topic": "force/values", "time": "force/t_ns"},
        "tcp": {"topic": "robot/pose", "time": "force/t_ns", "rotation": "rotation_vector"},
    },
    "images": {"digit": {"topic": "camera/images", "time": "camera/time", "sensor": "D1"}},
    "description": {"sensors": {"D1": {"model": "digit"}}},
}


def some_arrays(seed=0):
    """A wrench and poses at 100 Hz, and four pictures, by their paths."""
    rng = np.random.default_rng(seed)
    return {
        "force/t_ns": STAMPS,
        "force/values": rng.normal(size=(40, 6)),
        "robot/pose": rng.normal(size=(40, 6)),
        "camera/time": STAMPS[::10] / 1e9,
        "camera/images": rng.integers(0, 256, (4, 6, 8, 3), dtype=np.uint8),
    }


def write(path, arrays, **more):
    """The file with these arrays; pictures in chunks of three."""
    with h5py.File(path, "w") as file:
        for name, values in {**arrays, **more}.items():
            is_pictures = getattr(values, "ndim", 0) == 4
            chunks = {"chunks": (3, *values.shape[1:]), "compression": "gzip"} if is_pictures else {}
            file.create_dataset(name, data=values, **chunks)
    return path
