"""Zeros of a force sensor drawn by chance, with planted causes."""

import numpy as np

from tactiledata.diagnose.zeros.readings import ForceZeros
from tactiledata.diagnose.zeros.zero_models import GRAVITY

PIECES = 3
"""Pieces of free air of each trajectory."""
TOOL, LEVER = 0.8, (0.0, 0.0, 0.05)
"""Stated mass of the tool, kg, and its centre of gravity from the force sensor, m."""


def zeros(
    seed=0,
    trajectories=24,
    scatter=0.03,
    mass=0.0,
    centre=(0.01, 0.0, 0.03),
    drift=0.0,
    cable=0.0,
    rubs=0.0,
    walk=0.0,
    reads=None,
):
    """Trajectories at poses of chance, zeroed once halfway; each has a zero of its own beside what is planted.

    The friction of a cable, `rubs`, has the sign of the last joint's turn since the trajectory before. A sensor that
    `reads` by another matrix (6, 6) than it should reads the weight of its tool by it.
    """
    rng = np.random.default_rng(seed)
    down = np.array([0.0, 0.0, 1.0]) + rng.normal(0, 0.15, (trajectories, 3))
    down = (down / np.linalg.norm(down, axis=1)[:, None]).repeat(PIECES, axis=0)
    number = np.arange(trajectories).repeat(PIECES)
    seconds = 60.0 + 40.0 * number + np.tile([0.0, 1.0, 2.0], trajectories)
    joints = rng.uniform(-1, 1, (trajectories, 6)).repeat(PIECES, axis=0)
    units = np.array([1.0, 1.0, 1.0, 0.05, 0.05, 0.05])
    own = rng.normal(0, scatter, (trajectories, 6)) + np.cumsum(rng.normal(0, walk, (trajectories, 6)), axis=0)
    load = own.repeat(PIECES, axis=0) * units + rng.normal(0, 0.01, (len(number), 6)) * units
    force = mass * GRAVITY * down
    load += np.hstack([force, np.cross(centre, force)])
    stated = TOOL * GRAVITY * down
    weight = np.hstack([stated, np.cross(LEVER, stated)])
    load += weight @ ((np.eye(6) if reads is None else reads) - np.eye(6)).T
    load += drift * -np.expm1(-seconds / 300.0)[:, None] * np.array([0.5, 0.0, 1.0, 0.0, 0.02, 0.0])
    load += cable * np.sin(joints[:, 5:]) * np.array([1.0, 0.3, 0.0, 0.0, 0.0, 0.01])
    turn = np.diff(joints[::PIECES, 5], prepend=0.0).repeat(PIECES)
    load += rubs * np.sign(turn)[:, None] * np.array([1.0, 0.3, 0.0, 0.0, 0.0, 0.01])
    zeroed = (number >= trajectories // 2).astype(np.int64)
    load -= np.where(zeroed[:, None] == 0, load[0], load[PIECES * (trajectories // 2)])
    return ForceZeros(load, number, zeroed, down, seconds, np.full(len(number), 10.0), joints, weight)
