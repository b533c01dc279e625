"""Every effect on a touch that is turned about the gel's normal: the same, turned. No axis is taken for another."""

import dataclasses

import numpy as np
import pytest

from tactiledata.effects import EFFECTS
from tactiledata.effects.closed_form.ball_on_layer import BallOnLayer
from tactiledata.effects.simulate.setting import EffectSetting
from tactiledata.effects.simulate.simulator import with_effects
from tactiledata.sensors.base import GelGeometry

SQUARE = GelGeometry(outline=(0.010, 0.010), thickness=0.004, edge_thickness=0.004)
"""A pad that a quarter of a turn maps onto itself; the reference touch comes near its border."""
VECTORS = {
    "soft_region": [("x", "y")],
    "tool_weight": [("moment_x", "moment_y")],
    "cable_drag": [("fx", "fy"), ("tx", "ty")],
    "frame_rotation": [("tilt_x", "tilt_y")],
    "sensor_drift": [("fx", "fy"), ("tx", "ty")],
}
"""Pairs of parameters that are a vector of the gel frame, x and y; those of ``pose`` turn with the indenter."""


def turned(touch, turn):
    """The touch on a square pad, with poses and gravity turned."""
    poses = touch.poses.copy()
    poses[:, :3] = turn @ touch.poses[:, :3]
    gravity = (touch.gravity + np.array([1.0, 2.0, 0.0])) @ turn.T
    return dataclasses.replace(touch, poses=poses, gravity=gravity, geometry=SQUARE)


def with_axes(name, values, turn):
    """Values whose vectors and matrix are turned; all strengths differ, so that no two can be exchanged unseen."""
    values = {key: value * (1.0 - 0.07 * number) for number, (key, value) in enumerate(values.items())}
    if name == "soft_region":
        values |= {"x": 1e-3, "y": -2e-3, "radius": 3e-3}
    for pair in VECTORS.get(name, []):
        values |= dict(zip(pair, turn[:2, :2] @ [values[key] for key in pair], strict=True))
    if name == "gain_crosstalk":
        gains = turn @ np.array([[values[row + column] for column in "xyz"] for row in "xyz"]) @ turn.T
        values |= {row + column: gains[r, c] for r, row in enumerate("xyz") for c, column in enumerate("xyz")}
        for kind in ("m{row}_{column}", "{row}_m{column}"):
            keys = [[kind.format(row=row, column=column) for column in "xyz"] for row in "xyz"]
            mixed = turn @ np.array([[values[key] for key in row] for row in keys]) @ turn.T
            values |= {keys[r][c]: mixed[r, c] for r in range(3) for c in range(3)}
        # a quarter of a turn exchanges the gains of the torques about x and y
        values |= dict(zip(("mx", "my", "mz"), np.abs(turn) @ [values[f"m{axis}"] for axis in "xyz"], strict=True))
    return values


@pytest.mark.parametrize("quarters", [1, 2])
@pytest.mark.parametrize("name", EFFECTS)
def test_a_turned_touch_has_a_turned_wrench(name, quarters, touch, medium):
    """After a quarter and half of a turn, force and torque turn with the touch."""
    turn = np.linalg.matrix_power(np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]), quarters)
    found = []
    for way in (np.eye(3), turn):
        setting = EffectSetting(name, with_axes(name, medium(name), way))
        found.append(with_effects(BallOnLayer, [setting]).play(turned(touch, way)).wrench)
    here, there = found
    assert np.abs(here[:, :2]).max() > 0.1
    np.testing.assert_allclose(there[:, :3], here[:, :3] @ turn.T, atol=1e-9)
    np.testing.assert_allclose(there[:, 3:], here[:, 3:] @ turn.T, atol=1e-11)
