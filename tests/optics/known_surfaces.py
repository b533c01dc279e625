"""Surfaces whose height is known in closed form."""

import numpy as np

from tactiledata.optics.surface import GelSurface
from tactiledata.optics.view import View


def flat_surface(columns=41, rows=53, width=0.0184, length=0.025, skew=0.0):
    """A flat pad as a grid of triangles, its middle at the origin; ``skew`` moves inner nodes about."""
    x, y = np.meshgrid(np.linspace(-width / 2, width / 2, columns), np.linspace(-length / 2, length / 2, rows))
    places = np.stack([x, y, np.zeros_like(x)], axis=-1)
    if skew:
        places[1:-1, 1:-1, :2] += np.random.default_rng(0).uniform(-skew, skew, (rows - 2, columns - 2, 2))
    number = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]
    triangles = np.concatenate([np.stack(part, axis=-1).reshape(-1, 3) for part in ((a, b, c), (a, c, d))])
    return GelSurface(places.reshape(-1, 3), triangles)


def pressed(surface, depth):
    """Displacements (k, 3) that lower each node by ``depth(x, y)``."""
    moved = np.zeros_like(surface.places)
    moved[:, 2] = -depth(surface.places[:, 0], surface.places[:, 1])
    return moved


def cap(radius, depth, centre=(0.0, 0.0)):
    """Depth of a ball of a radius pressed in, nothing around it."""

    def at(x, y):
        square = (x - centre[0]) ** 2 + (y - centre[1]) ** 2
        return np.maximum(depth - radius + np.sqrt(np.maximum(radius**2 - square, 0.0)), 0.0)

    return at


def view(shape=(160, 120), mirrored=True):
    """The nominal DIGIT view with small pictures."""
    from tactiledata.sensors.digit import DIGIT

    return View.nominal(DIGIT, shape, mirrored)
