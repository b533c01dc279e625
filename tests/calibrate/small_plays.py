"""Touches of a ball that a coarse pad plays in a moment."""

import numpy as np

from tactiledata.calibrate.plan import Node
from tactiledata.calibrate.touches import MeasuredTouch
from tactiledata.gel.contact.history import GelTouch
from tactiledata.gel.mesh.structured_pad import GridPlan, structured_pad
from tactiledata.indenters.sphere import Sphere
from tactiledata.sensors.digit import DIGIT

PAD = structured_pad("coarse", DIGIT.gel, GridPlan(7, 9, 0.8e-3, (2.4e-3, 2.4e-3), (0.0, 0.5, 0.8, 1.0)))
NODES = [Node(0.47, friction, 0.0) for friction in (0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9)]


def press(number):
    """A ball that goes down, to another place for each number, and along."""
    poses = np.tile(np.eye(4), (8, 1, 1))
    poses[:, 2, 3] = np.array([5, -1, -2, -4, -5, -5, -5, -5]) * 1e-4
    poses[:, 0, 3] = 5e-4 * number + np.array([0, 0, 0, 0, 0, 1, 2, 3]) * 1e-4
    touch = GelTouch(Sphere(radius=4e-3), poses)
    return MeasuredTouch(f"{number}", "t", "s", "ball", touch, np.zeros((8, 6)), np.arange(8.0), 50.0)
