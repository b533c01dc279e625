"""Linear models of what the zero of a force sensor may follow: weight, a turned frame, cross-talk, drift, a cable."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from tactiledata.arrays import Array
from tactiledata.diagnose.zeros.readings import ForceZeros
from tactiledata.effects.sensor.cable_drag import with_play

GRAVITY = 9.81
"""Acceleration of gravity in m/s^2."""
TIMES = (100.0, 300.0, 900.0, 2700.0)
"""Time constants of a drift that are tried, in s."""
FEWEST = 8
"""Fewest trajectories with readings in free air; cable and cross-talk, with their many columns, need twice as many."""
CABLE_PLAY = 0.1
"""Turn of the last joint, rad, over which the friction of a cable changes from one direction to the other: the play of
`tactiledata.effects.sensor.cable_drag.CableDrag` that is usual. Joints turn farther between two touches."""


GAIN, ARM = 0.1, 0.005
"""Largest share of a component that shows in itself or another, and torque by a force, m, of a sensor whose cross-talk
may pass for another weight or a turned frame: twice what is plausible of `effects.sensor.gain_crosstalk.GainCrosstalk`.
"""


LEAST_TURN = 0.01
"""Root mean square change of the direction of gravity along its second line, rad, from which on a turn is found."""


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
    alike : callable
        Makes the names of other effects that read the same in free air, of the fitted numbers.
    reads : bool
        Whether the cause changes how every force is read, contact forces too, and no zero takes it away.
    """

    effect: str
    field: Array
    values: Callable[[Array], dict[str, float]]
    words: Callable[[dict[str, float]], str]
    within: Array | None = None
    alike: Callable[[Mapping[str, float]], tuple[str, ...]] = lambda values: ()
    reads: bool = False

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
    # of a weight that is not stated nobody knows how it would be read
    if zeros.weight is not None:
        listed.append(_turned(zeros, zeros.weight, scale))
        if zeros.trajectories >= 2 * FEWEST:
            listed.append(_cross_talk(zeros, scale))
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
        alike=lambda values: ("gain_crosstalk",) if _is_small(values, zeros.weight) else (),
    )


def _is_small(values: Mapping[str, float], weight: Array | None) -> bool:
    """Return whether a gain or a cross-talk of usual size reads the stated weight (n, 6) as this mass and moment more.

    ``False`` where no weight is stated.
    """
    if weight is None:
        return False
    mass, moment = (float(_sizes(part).max()) / GRAVITY for part in (weight[:, :3], weight[:, 3:]))
    more = float(np.linalg.norm([values[f"moment_{axis}"] for axis in "xyz"]))
    return abs(values["mass"]) <= GAIN * mass and more <= GAIN * moment + ARM * mass


def _turned(zeros: ForceZeros, weight: Array, scale: Array) -> ZeroModel:
    """Return the model of a sensor whose frame is turned: it reads the weight (n, 6) of its tool turned.

    It is linear about the turn that fits all forces best, or about none where the weight changes along one line only.
    """
    met = centred(zeros, weight[:, :3])
    ways = np.linalg.svd(met / max(_sizes(weight[:, :3]).max(), 1e-9), compute_uv=False)
    near = Rotation.identity()
    if ways[1] > LEAST_TURN * np.sqrt(len(met)):
        near = Rotation.align_vectors(centred(zeros, zeros.load)[:, :3] + met, met)[0]
    parts = [near.apply(part) for part in (weight[:, :3], weight[:, 3:])]
    columns = np.zeros((len(zeros), 6, 4))
    columns[:, :, 0] = np.hstack(parts) - weight
    for axis in range(3):
        columns[:, :, 1 + axis] = np.hstack([np.cross(np.eye(3)[axis], part) for part in parts])

    def values(numbers: Array) -> dict[str, float]:
        """The turn about each axis, rad."""
        turn = Rotation.from_rotvec(numbers[1:]) * Rotation.from_rotvec(numbers[0] * near.as_rotvec())
        return dict(zip(("tilt_x", "tilt_y", "yaw"), turn.as_rotvec().tolist(), strict=True))

    def words(values: dict[str, float]) -> str:
        """A clause on the turn, in degrees."""
        turns = ", ".join(f"{np.degrees(turn):+.1f}" for turn in values.values())
        return (
            "the force follows the direction of gravity as a turned sensor reads the weight of its tool: its frame is"
            f" turned by ({turns}) degrees about x, y and z from robot.tcp_from_ft in log.yaml"
        )

    return ZeroModel(
        "frame_rotation",
        _shaped(zeros, columns, scale),
        values,
        words,
        alike=lambda values: ("gain_crosstalk",) if max(map(abs, values.values())) <= GAIN else (),
        reads=True,
    )


def _cross_talk(zeros: ForceZeros, scale: Array) -> ZeroModel:
    """Return the model of cross-talk: each component follows the direction of gravity by three numbers of its own.

    A weight and a turned frame are special cases of it.
    """
    columns = np.einsum("ij,nk->nijk", np.eye(6), zeros.down).reshape(len(zeros), 6, 18)
    about_mean = centred(zeros, columns)

    def values(numbers: Array) -> dict[str, float]:
        """Largest change of force, N, and of torque, N m, over the directions of gravity that were met."""
        change = about_mean @ numbers
        return {"force": float(_sizes(change[:, :3]).max()), "torque": float(_sizes(change[:, 3:]).max())}

    return ZeroModel(
        "gain_crosstalk",
        _shaped(zeros, columns, scale),
        values,
        lambda values: (
            f"the force follows the direction of gravity, by up to {values['force']:.2f} N and"
            f" {values['torque']:.3f} N m, as no weight and no turn of the sensor's frame would: as of a sensor with"
            " cross-talk"
        ),
        reads=True,
    )


def _sizes(rows: Array) -> Array:
    """Return the norm (n,) of each of the rows (n, 3)."""
    return np.asarray(np.linalg.norm(rows, axis=1))


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
