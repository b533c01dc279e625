"""Linear models of what the zero of a force sensor may follow: weight of the tool, drift, drag of the cable."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.zeros.readings import ForceZeros
from tactiledata.effects.sensor.cable_drag import with_play

GRAVITY = 9.81
"""Acceleration of gravity in m/s^2."""
TIMES = (100.0, 300.0, 900.0, 2700.0)
"""Time constants of a drift that are tried, in s."""
FEWEST = 8
"""Fewest trajectories with readings in free air; the cable, with its 24 columns, needs twice as many."""
CABLE_PLAY = 0.1
"""Turn of the last joint, rad, over which the friction of a cable changes from one direction to the other: the play of
`tactiledata.effects.sensor.cable_drag.CableDrag` that is usual. Joints turn farther between two touches."""


@dataclass(frozen=True)
class ZeroModel:
    """A linear model of one cause of the zeros.

    Parameters
    ----------
    effect : str
        Name in the catalogue of effects.
    field : (6 n, k)
        Design matrix of the loads, which are divided by the scatter of their component.
    values : callable
        Makes named numbers of the k fitted coefficients.
    words : callable
        Makes a clause for the user of these numbers.
    within : (n,), optional
        Change of the zero from a piece of free air to the end of its trajectory, N, for each newton that the model's
        forces have in the end.
    alike : str
        Sentence on what else reads so in free air; empty where nothing is known.
    """

    effect: str
    field: Array
    values: Callable[[Array], dict[str, float]]
    words: Callable[[dict[str, float]], str]
    within: Array | None = None
    alike: str = ""

    def change_within(self, values: Mapping[str, float]) -> float | None:
        """Return the root mean square of the change of the zero's force from a piece of free air to the end of its
        trajectory, N; ``None`` where the model says nothing of it.

        Parameters
        ----------
        values : dict
            Fitted numbers, with ``fx``, ``fy`` and ``fz``, N.
        """
        if self.within is None:
            return None
        size = np.linalg.norm([values[name] for name in ("fx", "fy", "fz")])
        return float(size * np.sqrt((self.within**2).mean()))


def zero_models(zeros: ForceZeros, scale: Array) -> list[ZeroModel]:
    """Return the models that these data allow, without those whose columns never change."""
    listed = [_weight(zeros, scale)]
    listed += [_drift(zeros, scale, time) for time in TIMES]
    if zeros.joints is not None and zeros.trajectories >= 2 * FEWEST:
        listed.append(_cable(zeros, scale))
    return [model for model in listed if np.linalg.norm(model.field) > 1e-9 * np.sqrt(model.field.size)]


def _weight(zeros: ForceZeros, scale: Array) -> ZeroModel:
    """Return the model of the tool's weight: linear in mass, kg, and first moment about the sensor's origin, kg m."""
    force = GRAVITY * zeros.down
    columns = np.zeros((len(zeros), 6, 4))
    columns[:, :3, 0] = force
    for axis in range(3):
        columns[:, 3:, 1 + axis] = np.cross(np.eye(3)[axis], force)
    return ZeroModel(
        "tool_weight",
        _shaped(zeros, columns, scale),
        lambda numbers: {"mass": numbers[0], "moment_x": numbers[1], "moment_y": numbers[2], "moment_z": numbers[3]},
        lambda values: (
            f"the force follows the direction of gravity: the mass of the tool differs by {1e3 * values['mass']:+.0f} g"
            f" from robot.tool in log.yaml, with a moment of {_moment(values)} g mm about the force sensor"
        ),
        alike="A sensor with a wrong gain or with cross-talk reads so, too, of the weight that it carries.",
    )


def _moment(values: dict[str, float]) -> str:
    """Return the first moment in g mm as text, such as ``"(+120, -30, +4)"``."""
    return f"({', '.join(f'{1e6 * values[name]:+.0f}' for name in ('moment_x', 'moment_y', 'moment_z'))})"


def _drift(zeros: ForceZeros, scale: Array, time: float) -> ZeroModel:
    """Return the model of an exponential drift of each component since power-on, with one time constant in s."""
    warm = -np.expm1(-zeros.seconds / time)
    names = ("fx", "fy", "fz", "tx", "ty", "tz")

    def words(values: dict[str, float]) -> str:
        """A clause on the size of the drift over these recordings."""
        size = float(np.linalg.norm([values[name] for name in names[:3]]))
        span = float(np.ptp(warm))
        return (
            f"the force sensor's zero drifts with the time since power-on, by {size * span:.2f} N over these"
            f" recordings (time constant about {time:.0f} s)"
        )

    return ZeroModel(
        "sensor_drift",
        _shaped(zeros, warm[:, None, None] * np.eye(6), scale),
        lambda numbers: {**dict(zip(names, numbers.tolist(), strict=True)), "time": time},
        words,
        np.exp(-zeros.seconds / time) * -np.expm1(-zeros.remaining / time),
    )


def _cable(zeros: ForceZeros, scale: Array) -> ZeroModel:
    """Return the model of the cable's drag: each component as sine and cosine of the last joint's angle, linear in the
    one before, and with the friction of a cable that follows the last joint.
    """
    shapes = cable_shapes(zeros)
    columns = np.concatenate([shapes[:, None, k, None] * np.eye(6) for k in range(shapes.shape[1])], axis=2)

    def words(values: dict[str, float]) -> str:
        """A clause on the amplitude of the cable's force."""
        size = np.hypot(values["sine"], values["cosine"])
        return (
            f"the force follows the angle of the last joint, by up to {size:.2f} N, and differs by"
            f" {2.0 * values['friction']:.2f} N by the direction from which that joint came, as if a cable pulled on"
            " the tool"
        )

    return ZeroModel(
        "cable_drag",
        _shaped(zeros, columns, scale),
        lambda numbers: {
            name: float(np.linalg.norm(numbers[6 * k : 6 * k + 3]))
            for k, name in enumerate(("sine", "cosine", "wrist", "friction"))
        },
        words,
        alike="Cross-talk of the sensor can read so, too: the weight of the tool turns with the hand.",
    )


def cable_shapes(zeros: ForceZeros) -> Array:
    """Return what the pull of a cable may follow (n, 4): sine and cosine of the last joint, the wrist, and friction.

    Parameters
    ----------
    zeros : ForceZeros
        The n pieces, with joint angles.
    """
    assert zeros.joints is not None
    last, wrist = zeros.joints[:, 5], zeros.joints[:, 4]
    return np.stack([np.sin(last), np.cos(last), wrist - wrist.mean(), cable_friction(zeros)], axis=1)


def cable_friction(zeros: ForceZeros) -> Array:
    """Return the friction (n,) of a cable that follows the last joint, over its largest; 0 where a stretch between two
    tares begins.

    It grows until the cable slides, and keeps its sign until the joint comes back: the stop operator, the counterpart
    of `with_play`.

    Parameters
    ----------
    zeros : ForceZeros
        The n pieces, with joint angles.
    """
    assert zeros.joints is not None
    angle, friction = zeros.joints[:, 5], np.zeros(len(zeros))
    for stretch in np.unique(zeros.zeroed):
        members = np.flatnonzero(zeros.zeroed == stretch)
        members = members[np.argsort(zeros.seconds[members], kind="stable")]
        friction[members] = (angle[members] - with_play(angle[members], CABLE_PLAY)) / (0.5 * CABLE_PLAY)
    return friction


def _shaped(zeros: ForceZeros, columns: Array, scale: Array) -> Array:
    """Return the design matrix (6 n, k) of columns (n, 6, k), centred between tares, over the scatter (6,)."""
    return (centred(zeros, columns) / scale[:, None]).reshape(6 * len(zeros), -1)


def centred(zeros: ForceZeros, rows: Array) -> Array:
    """Return rows (n, …) minus their mean over each stretch between two moments of taring."""
    centred = rows.copy()
    for stretch in np.unique(zeros.zeroed):
        members = zeros.zeroed == stretch
        centred[members] -= rows[members].mean(axis=0)
    return centred


def scatter_of(zeros: ForceZeros) -> Array:
    """Return the scatter (6,) of centred loads, N and N m: one value for the forces, one for the torques."""
    deviations = centred(zeros, zeros.load).std(axis=0).reshape(2, 3)
    sizes: Array = np.repeat(np.maximum(deviations.mean(axis=1), 1e-9), 3)
    return sizes
