"""A store with a planted mesh, and a view of it read back with rerun's own reader."""

from collections import defaultdict

import numpy as np
from rerun.chunk import RrdReader

from tactiledata.store.read.meshes import PadArrays
from tactiledata.store.read.reader import Store
from tactiledata.store.write.mesh_writer import append_mesh

COLUMNS, ROWS = 6, 5
UNSOLVED = 3
"""Row, over all frames of the store, of the frame that has no mesh."""


def planted_pad():
    """A flat surface of 6 x 5 nodes, 3 mm apart, numbered backwards below one node that no triangle has."""
    x, y = np.meshgrid(np.arange(COLUMNS), np.arange(ROWS))
    nodes = np.stack([3e-3 * x.ravel(), 3e-3 * y.ravel(), np.zeros(x.size)], axis=1)
    vertices = np.concatenate([[[0.0, 0.0, -0.004]], nodes[::-1]])
    number = len(nodes) - np.arange(len(nodes))
    corner = number.reshape(ROWS, COLUMNS)
    first, right = corner[:-1, :-1].ravel(), corner[:-1, 1:].ravel()
    below, across = corner[1:, :-1].ravel(), corner[1:, 1:].ravel()
    triangles = np.concatenate([np.stack([first, right, across], 1), np.stack([first, across, below], 1)])
    kept = np.arange(1, len(vertices))
    return PadArrays(
        vertices[None], np.zeros((1, 8), np.int64), triangles, kept, kept, kept[::2], np.zeros(1, np.int64)
    )


def attach_planted(place, name="planted"):
    """A planted mesh: frame n moves node k down by (n + 1)(k + 1) micrometres; frame 3 was not solved."""
    store = Store.open(place)
    pad, n = planted_pad(), store.n_frames
    kept, corners = len(pad.kept), len(pad.corners)
    solved = np.arange(n) != UNSOLVED
    down = -1e-6 * np.outer(np.arange(1, n + 1), np.arange(1, kept + 1))
    displacement = np.zeros((n, kept, 3), np.float32)
    displacement[:, :, 2] = down
    displacement[~solved] = np.nan
    wrench = np.arange(6.0) + np.arange(n)[:, None]
    wrench[~solved] = np.nan
    arrays = {
        "displacement": displacement,
        "force": np.zeros((n, kept, 3), np.float32),
        "contact": np.tile(np.arange(corners) % 3 == 0, (n, 1)).astype(np.uint8),
        "wrench": wrench,
        "residual": np.zeros(n),
        "status": np.where(solved, 0, 5).astype(np.int8),
        "pad": np.where(solved, 0, -1).astype(np.int16),
    }
    settings = {"fidelity": "linear", "material": {"youngs_modulus": 8e5, "poisson_ratio": 0.48, "friction": 0.9}}
    statuses = {"0": "solved", "5": "no equilibrium was found"}
    described = {"settings": settings, "statuses": statuses, "kind": "hexahedron8"}
    append_mesh(place, name, described, [{"sensor": "digit"}], pad, (0, n), arrays)


class Viewed:
    """One recording of a view: rows of each entity, by the time of its trajectory."""

    def __init__(self, chunks):
        self.chunks = defaultdict(list)
        for chunk in chunks:
            self.chunks[chunk.entity_path].append(chunk)

    @property
    def entities(self):
        return {path.removeprefix("/") for path in self.chunks}

    def rows(self, entity, component, line="trajectory"):
        """Pairs of time, ns, and value of a component, in order of time; those that are cleared are left out."""
        found = []
        for chunk in self.chunks[f"/{entity}"]:
            batch = chunk.to_record_batch()
            if chunk.is_static or component not in batch.schema.names:
                continue
            times = batch.column(line).cast("int64").to_pylist()
            values = batch.column(component)
            found += [(t, value.as_py()) for t, value in zip(times, values, strict=True) if value.is_valid]
        return sorted(found, key=lambda pair: pair[0])

    def static(self, entity, component):
        (value,) = [
            chunk.to_record_batch().column(component)[0].as_py()
            for chunk in self.chunks[f"/{entity}"]
            if chunk.is_static and component in chunk.to_record_batch().schema.names
        ]
        return value

    def curve(self, entity, line="trajectory"):
        """Times (n,), ns, and values (n,) of a curve."""
        rows = self.rows(entity, "Scalars:scalars", line)
        return np.array([t for t, _ in rows], np.int64), np.array([value[0] for _, value in rows])

    def property(self, name):
        return self.static("__properties/tactiledata", name)[0]


def read_view(path):
    """The recordings of a file, by the uid of their trajectory, and how many layouts it has."""
    reader = RrdReader(path)
    viewed = [Viewed(reader.stream(store=entry)) for entry in reader.recordings()]
    return {one.property("uid"): one for one in viewed}, len(reader.blueprints())
