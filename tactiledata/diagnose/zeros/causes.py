"""Why the zero of a force sensor differs from trajectory to trajectory: the tool's weight, a drift, the cable."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tactiledata.arrays import Array
from tactiledata.contract.wording import counted
from tactiledata.diagnose.residuals.wording import p_words, percent
from tactiledata.diagnose.zeros.readings import ForceZeros

GRAVITY = 9.81
"""m/s^2"""
TIMES = (100.0, 300.0, 900.0, 2700.0)
"""s: time constants of a drift that are tried."""
DRAWS = 299
LEVEL = 0.01
WORTH = 0.2
"""Share of the squares beyond the noise of trajectories that were not fitted, from which on a cause is named."""
LEAST = 0.02
"""N: zeros that differ by less are no news."""
FEWEST = 8
"""Trajectories."""


@dataclass(frozen=True)
class ZeroCause:
    """Something that the zero follows.

    Parameters
    ----------
    effect : name in the catalogue of effects
    p : float
        Trajectories exchanged.
    explained : float
        Share of the squares, beyond what the noise of pieces makes of them, of trajectories that were held out.
    before, after : N
        Root mean square of the zeros' force about their mean, without it and with it; a cause may be in torques alone.
    values : dict, name -> number
    words : str
    """

    effect: str
    p: float
    explained: float
    before: float
    after: float
    values: dict[str, float]
    words: str

    @property
    def document(self) -> dict[str, Any]:
        """For schemas/diagnosis.json."""
        return dict(vars(self))


@dataclass(frozen=True)
class _Model:
    """A linear cause: columns (6 n, k) on loads in units of their scatter."""

    effect: str
    field: Array
    values: Callable[[Array], dict[str, float]]
    words: Callable[[dict[str, float]], str]


def zero_causes(zeros: ForceZeros, seed: int = 0) -> list[ZeroCause]:
    """What the zeros follow, the strongest first; empty where nothing is certain, or there are too few of them.

    Each moment at which the sensor was set to zero begins a zero of its own, which is fitted. Causes are added one
    after another: each has to tell trajectories that it was not fitted to, and to do so better than with trajectories
    exchanged.
    """
    if zeros.trajectories < FEWEST:
        return []
    scale = _scatter(zeros)
    spread = float(np.sqrt((_centred(zeros, zeros.load)[:, :3] ** 2).sum(axis=1).mean()))
    if spread < LEAST:
        return []
    models, taken = _models(zeros, scale), np.empty((6 * len(zeros), 0))
    found: list[ZeroCause] = []
    target = (_centred(zeros, zeros.load) / scale).ravel()
    before, floor = spread, _noise(zeros, scale)
    for _ in range(len(models)):
        rest = [model for model in models if model.effect not in {cause.effect for cause in found}]
        tried = [(_unseen(zeros, np.hstack([taken, model.field]), target), model) for model in rest]
        if not tried:
            break
        base = _unseen(zeros, taken, target)
        cost, best = min(tried, key=lambda one: one[0])
        explained = min(1.0, (base - cost) / max(base - floor, base - cost, 1e-300))
        p = _exchanged(zeros, taken, best.field, target, seed)
        if explained < WORTH or p > LEVEL:
            break
        design = np.hstack([taken, best.field])
        numbers: Array = np.linalg.lstsq(design, target, rcond=None)[0].astype(np.float64)
        left = ((target - design @ numbers).reshape(-1, 6) * scale)[:, :3]
        after = float(np.sqrt((left**2).sum(axis=1).mean()))
        values = best.values(numbers[taken.shape[1] :])
        words = (
            f"In free air, {best.words(values)} ({p_words(p)}); that tells {percent(explained)} of how much zeros of"
            " other trajectories differ. Zeros are taken anew for each trajectory, so contact forces keep only what"
            " changes within one."
        )
        found.append(ZeroCause(best.effect, p, explained, before, after, values, words))
        taken, before = design, after
    return found


def no_zeros(zeros: ForceZeros) -> str:
    """Why nothing can be said of zeros; empty where something can."""
    if zeros.trajectories >= FEWEST:
        return ""
    return (
        f"Only {counted(zeros.trajectories, 'trajectory')} with readings in free air: whether the tool's weight, the"
        f" cable or a drift is in the force sensor's zero needs {FEWEST}. Begin recordings half a second before the"
        " touch."
    )


def _models(zeros: ForceZeros, scale: Array) -> list[_Model]:
    listed = [_weight(zeros, scale)]
    listed += [_drift(zeros, scale, time) for time in TIMES]
    if zeros.joints is not None and zeros.trajectories >= 2 * FEWEST:
        listed.append(_cable(zeros, scale))
    return [model for model in listed if np.linalg.norm(model.field) > 1e-9 * np.sqrt(model.field.size)]


def _weight(zeros: ForceZeros, scale: Array) -> _Model:
    """Mass, and its moment about the sensor's origin: linear in both."""
    force = GRAVITY * zeros.down
    columns = np.zeros((len(zeros), 6, 4))
    columns[:, :3, 0] = force
    for axis in range(3):
        columns[:, 3:, 1 + axis] = np.cross(np.eye(3)[axis], force)
    return _Model(
        "tool_weight",
        _shaped(zeros, columns, scale),
        lambda found: {"mass": found[0], "moment_x": found[1], "moment_y": found[2], "moment_z": found[3]},
        lambda found: (
            f"the force follows the direction of gravity: the tool weighs {1e3 * found['mass']:+.0f} g beside what"
            f" robot.tool in log.yaml states, with a moment of {_moment(found)} g mm about the force sensor"
        ),
    )


def _moment(found: dict[str, float]) -> str:
    return f"({', '.join(f'{1e6 * found[name]:+.0f}' for name in ('moment_x', 'moment_y', 'moment_z'))})"


def _drift(zeros: ForceZeros, scale: Array, time: float) -> _Model:
    warm = -np.expm1(-zeros.seconds / time)
    names = ("fx", "fy", "fz", "tx", "ty", "tz")

    def words(found: dict[str, float]) -> str:
        size = float(np.linalg.norm([found[name] for name in names[:3]]))
        span = float(np.ptp(warm))
        return (
            f"the force sensor's zero drifts with the time since power-on, by {size * span:.2f} N over these"
            f" recordings (time constant about {time:.0f} s)"
        )

    return _Model(
        "sensor_drift",
        _shaped(zeros, warm[:, None, None] * np.eye(6), scale),
        lambda found: {**dict(zip(names, found.tolist(), strict=True)), "time": time},
        words,
    )


def _cable(zeros: ForceZeros, scale: Array) -> _Model:
    assert zeros.joints is not None
    last, wrist = zeros.joints[:, 5], zeros.joints[:, 4]
    shapes = np.stack([np.sin(last), np.cos(last), wrist - wrist.mean()], axis=1)
    columns = np.concatenate([shapes[:, None, k, None] * np.eye(6) for k in range(3)], axis=2)

    def words(found: dict[str, float]) -> str:
        size = np.hypot(found["sine"], found["cosine"])
        return (
            f"the force follows the angle of the last joint, by up to {size:.2f} N, as a cable that drags would make it"
        )

    return _Model(
        "cable_drag",
        _shaped(zeros, columns, scale),
        lambda found: {
            "sine": float(np.linalg.norm(found[:3])),
            "cosine": float(np.linalg.norm(found[6:9])),
            "wrist": float(np.linalg.norm(found[12:15])),
        },
        words,
    )


def _shaped(zeros: ForceZeros, columns: Array, scale: Array) -> Array:
    """Columns (n, 6, k), about their mean between moments of zeroing, over the scatter: (6 n, k)."""
    return (_centred(zeros, columns) / scale[:, None]).reshape(6 * len(zeros), -1)


def _centred(zeros: ForceZeros, rows: Array) -> Array:
    out = rows.copy()
    for stretch in np.unique(zeros.zeroed):
        members = zeros.zeroed == stretch
        out[members] -= rows[members].mean(axis=0)
    return out


def _scatter(zeros: ForceZeros) -> Array:
    """Of each component (6,), over trajectories: forces alike, torques alike."""
    deviations = _centred(zeros, zeros.load).std(axis=0).reshape(2, 3)
    sizes: Array = np.repeat(np.maximum(deviations.mean(axis=1), 1e-9), 3)
    return sizes


def _noise(zeros: ForceZeros, scale: Array) -> float:
    """Squares that noise alone leaves, from pieces of one trajectory that follow one another."""
    together = np.diff(zeros.trajectory) == 0
    steps = np.diff(zeros.load, axis=0)[together] / scale
    return float((steps**2).sum(axis=1).mean() / 2.0 * len(zeros)) if together.any() else 0.0


def _unseen(zeros: ForceZeros, design: Array, target: Array) -> float:
    """Squares of trajectories, each told by a fit to the others."""
    owner = np.repeat(zeros.trajectory, 6)
    left = 0.0
    for number in np.unique(zeros.trajectory):
        out = owner == number
        told = design[out] @ np.linalg.lstsq(design[~out], target[~out], rcond=None)[0] if design.shape[1] else 0.0
        left += float(((target[out] - told) ** 2).sum())
    return left


def _exchanged(zeros: ForceZeros, taken: Array, field: Array, target: Array, seed: int) -> float:
    """Share of exchanges of whole trajectories that fit as well (Freedman and Lane 1983)."""
    rest = target - taken @ np.linalg.lstsq(taken, target, rcond=None)[0] if taken.shape[1] else target
    basis, sizes, _ = np.linalg.svd(field - taken @ np.linalg.pinv(taken) @ field if taken.shape[1] else field, False)
    basis = basis[:, sizes > 1e-9 * sizes[0]]
    chance = np.random.default_rng(seed)
    fitted = float(((basis.T @ rest) ** 2).sum())
    means = _by_trajectory(zeros, rest)
    within = rest - np.concatenate([means[place] for place in _places(zeros)])
    count = 0
    for _ in range(DRAWS):
        order = chance.permutation(len(means))
        drawn = within + np.concatenate([means[order[place]] for place in _places(zeros)])
        count += float(((basis.T @ drawn) ** 2).sum()) >= fitted
    return (count + 1) / (DRAWS + 1)


def _places(zeros: ForceZeros) -> Sequence[int]:
    return np.unique(zeros.trajectory, return_inverse=True)[1].tolist()


def _by_trajectory(zeros: ForceZeros, rows: Array) -> Array:
    """Means (t, 6) over the pieces of each trajectory."""
    shaped = rows.reshape(-1, 6)
    return np.array([shaped[zeros.trajectory == number].mean(axis=0) for number in np.unique(zeros.trajectory)])
