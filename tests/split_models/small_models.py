"""A mesh of some 200 vertices and pictures of 40 x 30 pixels, quick to learn."""

import numpy as np

from split_models.networks.image_vae import ImageVae
from split_models.networks.mesh_graph import Topology, build_hierarchy
from split_models.networks.mesh_vae import MeshVae

ROWS, COLUMNS = 17, 12


def grid_topology(rows=ROWS, columns=COLUMNS, pitch=0.001, dome=0.0):
    """A surface of rows x columns vertices."""
    x, y = np.meshgrid(np.arange(columns) * pitch, np.arange(rows) * pitch)
    x, y = x - x.mean(), y - y.mean()
    places = np.stack([x, y, -dome * (x**2 + y**2)], axis=-1).reshape(-1, 3)
    number = np.arange(rows * columns).reshape(rows, columns)
    corners = [number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]]
    a, b, c, d = (corner.ravel() for corner in corners)
    return Topology(places, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]))


def presses(topology, count, seed=0, depth=0.001):
    """Displacements (count, v, 3), m, of smooth dents at random places."""
    rng = np.random.default_rng(seed)
    middle = rng.uniform(-0.004, 0.004, (count, 1, 2))
    width = rng.uniform(0.0015, 0.003, (count, 1))
    distance = ((topology.places[None, :, :2] - middle) ** 2).sum(axis=-1)
    dent = -depth * rng.uniform(0.5, 1.0, (count, 1)) * np.exp(-distance / width**2)
    return np.stack([0.1 * dent, 0.05 * dent, dent], axis=-1).astype(np.float32)


def pictures(count, seed=0, size=(40, 30)):
    """Pictures (count, h, w, 3), uint8: a coloured gradient with a brighter spot."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[: size[0], : size[1]]
    plain = np.stack([60 + y, 80 + x, 120 - y / 2], axis=-1)
    middle = rng.uniform((8, 6), (size[0] - 8, size[1] - 6), (count, 2))
    spot = np.exp(-((y - middle[:, 0, None, None]) ** 2 + (x - middle[:, 1, None, None]) ** 2) / 20)
    return np.clip(plain + 90 * spot[..., None] * (1.0, 0.5, -0.3), 0, 255).astype(np.uint8)


def mesh_vae(topology=None, **changes):
    """Latent 8."""
    hierarchy = build_hierarchy(topology or grid_topology())
    return MeshVae(hierarchy, **{"filters": (8, 8, 8, 16), "order": 3, "latent": 8, **changes})


def image_vae(**changes):
    """Latent 16, at 40 x 30."""
    small = {"size": (40, 30), "blocks": (1, 1, 1), "down": (2, 5), "channels": (8, 8, 16), "latent": 16}
    return ImageVae(**{**small, **changes})
