"""Why the zero of a force sensor differs from trajectory to trajectory: weight of the tool, drift, or cable drag."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tactiledata.arrays import Array
from tactiledata.contract.wording import counted
from tactiledata.diagnose.residuals.wording import p_words, percent
from tactiledata.diagnose.zeros.readings import ForceZeros

GRAVITY = 9.81
"""Acceleration of gravity in m/s^2."""
TIMES = (100.0, 300.0, 900.0, 2700.0)
"""Time constants of a drift that are tried, in s."""
DRAWS = 299
"""Permutations of trajectories in each test: the smallest p-value is 1 / 300."""
LEVEL = 0.01
"""Largest p-value at which a cause is reported."""
WORTH = 0.2
"""Least share of the held-out squares beyond the noise that a cause must explain to be reported."""
LEAST = 0.02
"""Least root mean square of the zeros' force in N; smaller differences are not analysed."""
WITHIN = 0.01
"""Change of the zero from the free air to the end of a trajectory, N, up to which a drift does not matter: a fit allows
every trajectory as much (`tactiledata.diagnose.touches.own_errors.OwnErrors`)."""
FEWEST = 8
"""Fewest trajectories with readings in free air; the cable, with its 18 columns, needs twice as many."""


@dataclass(frozen=True)
class ZeroCause:
    """A cause that the zero of the force sensor follows.

    Parameters
    ----------
    effect : str
        Name in the catalogue of effects: ``tool_weight``, ``sensor_drift`` or ``cable_drag``.
    p : float
        p-value by permutation of whole trajectories.
    explained : float
        Share of the squares of held-out trajectories, beyond the noise, that the cause explains; 0 to 1.
    before, after : float
        Root mean square of the zeros' force about their mean in N, without and with the cause. Both are nearly equal
        where the cause acts on torques alone.
    values : dict, name -> float
        Fitted numbers of the cause, in SI units.
    words : str
        The cause as sentences for the user.
    within : float, optional
        Root mean square of the change of the zero's force from the free air to the end of a trajectory, N, by a cause
        that acts while the arm rests; ``None`` for the others.
    """

    effect: str
    p: float
    explained: float
    before: float
    after: float
    values: dict[str, float]
    words: str
    within: float | None = None

    @property
    def matters(self) -> bool:
        """Whether contact forces are wrong by it: they are not where the zero hardly changes within a trajectory."""
        return self.within is None or self.within > WITHIN

    @property
    def document(self) -> dict[str, Any]:
        """The cause as it stands in ``diagnosis.json`` (schemas/diagnosis.json)."""
        return {**vars(self), "matters": self.matters}


@dataclass(frozen=True)
class _Model:
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
    """

    effect: str
    field: Array
    values: Callable[[Array], dict[str, float]]
    words: Callable[[dict[str, float]], str]
    within: Array | None = None


def zero_causes(zeros: ForceZeros, seed: int = 0, band: float = 0.0) -> list[ZeroCause]:
    """Return the causes that the zeros follow, the strongest first; empty where none is certain or data are few.

    The zero changes at each moment at which the sensor was tared; the mean of each stretch between two such moments is
    subtracted. Causes are added one after another. Each must predict trajectories that it was not fitted to, and must
    fit better than after a permutation of the trajectories.

    Parameters
    ----------
    zeros : ForceZeros
        Mean readings in free air, as `StoreReadings.zeros` returns them.
    seed : int
        Random seed of the permutations.
    band : float
        Half width, N, of the sensor's dead-band. What a cause changes by no more than that in any component of the
        force may as well be the band's doing, which follows weight and drift as the readings do, and is not reported.
    """
    if zeros.trajectories < FEWEST:
        return []
    scale = _scatter(zeros)
    spread = float(np.sqrt((_centred(zeros, zeros.load)[:, :3] ** 2).sum(axis=1).mean()))
    if spread < LEAST:
        return []
    models, taken = _models(zeros, scale), np.empty((6 * len(zeros), 0))
    causes: list[ZeroCause] = []
    target = (_centred(zeros, zeros.load) / scale).ravel()
    before, floor = spread, _noise(zeros, scale)
    hidden: set[str] = set()
    # forward selection: in each round the cause that predicts held-out trajectories best
    for _ in range(len(models)):
        rest = [model for model in models if model.effect not in hidden.union(cause.effect for cause in causes)]
        tried = [(_unseen(zeros, np.hstack([taken, model.field]), target), model) for model in rest]
        if not tried:
            break
        base = _unseen(zeros, taken, target)
        cost, best = min(tried, key=lambda attempt: attempt[0])
        explained = min(1.0, (base - cost) / max(base - floor, base - cost, 1e-300))
        p = _exchanged(zeros, taken, best.field, target, seed)
        if explained < WORTH or p > LEVEL:
            break
        # the cause is accepted: fit it together with those before
        design = np.hstack([taken, best.field])
        numbers: Array = np.linalg.lstsq(design, target, rcond=None)[0].astype(np.float64)
        own = ((best.field @ numbers[taken.shape[1] :]).reshape(-1, 6) * scale)[:, :3]
        if np.abs(own).max() <= band:
            hidden.add(best.effect)
            continue
        left = ((target - design @ numbers).reshape(-1, 6) * scale)[:, :3]
        after = float(np.sqrt((left**2).sum(axis=1).mean()))
        values = best.values(numbers[taken.shape[1] :])
        words = (
            f"In free air, {best.words(values)} ({p_words(p)}). This explains {percent(explained)} of the differences"
            " between the zeros of held-out trajectories. Each trajectory gets a zero of its own, so that contact"
            " forces contain only what changes within a trajectory"
        )
        within = None if best.within is None else _within(best.within, values)
        cause = ZeroCause(best.effect, p, explained, before, after, values, f"{words}.", within)
        if within is not None:
            weight = "forces are wrong by as much" if cause.matters else "too little to matter"
            cause = replace(cause, words=f"{words}: {within:.3f} N, {weight}.")
        causes.append(cause)
        taken, before = design, after
    return causes


def no_zeros(zeros: ForceZeros) -> str:
    """Return a sentence that says why the zeros cannot be analysed; empty where they can."""
    if zeros.trajectories >= FEWEST:
        return ""
    return (
        f"Only {counted(zeros.trajectories, 'trajectory')} with readings in free air: at least {FEWEST} are needed to"
        " see whether the tool's weight, the cable or a drift changes the zero of the force sensor. Begin recordings"
        " half a second before the touch."
    )


def _models(zeros: ForceZeros, scale: Array) -> list[_Model]:
    """Return the models that these data allow, without those whose columns never change."""
    listed = [_weight(zeros, scale)]
    listed += [_drift(zeros, scale, time) for time in TIMES]
    if zeros.joints is not None and zeros.trajectories >= 2 * FEWEST:
        listed.append(_cable(zeros, scale))
    return [model for model in listed if np.linalg.norm(model.field) > 1e-9 * np.sqrt(model.field.size)]


def _weight(zeros: ForceZeros, scale: Array) -> _Model:
    """Return the model of the tool's weight: linear in mass, kg, and first moment about the sensor's origin, kg m."""
    force = GRAVITY * zeros.down
    columns = np.zeros((len(zeros), 6, 4))
    columns[:, :3, 0] = force
    for axis in range(3):
        columns[:, 3:, 1 + axis] = np.cross(np.eye(3)[axis], force)
    return _Model(
        "tool_weight",
        _shaped(zeros, columns, scale),
        lambda numbers: {"mass": numbers[0], "moment_x": numbers[1], "moment_y": numbers[2], "moment_z": numbers[3]},
        lambda values: (
            f"the force follows the direction of gravity: the mass of the tool differs by {1e3 * values['mass']:+.0f} g"
            f" from robot.tool in log.yaml, with a moment of {_moment(values)} g mm about the force sensor"
        ),
    )


def _moment(values: dict[str, float]) -> str:
    """Return the first moment in g mm as text, such as ``"(+120, -30, +4)"``."""
    return f"({', '.join(f'{1e6 * values[name]:+.0f}' for name in ('moment_x', 'moment_y', 'moment_z'))})"


def _drift(zeros: ForceZeros, scale: Array, time: float) -> _Model:
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

    return _Model(
        "sensor_drift",
        _shaped(zeros, warm[:, None, None] * np.eye(6), scale),
        lambda numbers: {**dict(zip(names, numbers.tolist(), strict=True)), "time": time},
        words,
        np.exp(-zeros.seconds / time) * -np.expm1(-zeros.remaining / time),
    )


def _within(change: Array, values: Mapping[str, float]) -> float:
    """Return the root mean square, N, of changes (n,) for each newton of a drift's force in the end."""
    size = np.linalg.norm([values[name] for name in ("fx", "fy", "fz")])
    return float(size * np.sqrt((change**2).mean()))


def _cable(zeros: ForceZeros, scale: Array) -> _Model:
    """Return the model of the cable's drag: each component as sine and cosine of the last joint's angle, and linear in
    the one before.
    """
    assert zeros.joints is not None
    last, wrist = zeros.joints[:, 5], zeros.joints[:, 4]
    shapes = np.stack([np.sin(last), np.cos(last), wrist - wrist.mean()], axis=1)
    columns = np.concatenate([shapes[:, None, k, None] * np.eye(6) for k in range(3)], axis=2)

    def words(values: dict[str, float]) -> str:
        """A clause on the amplitude of the cable's force."""
        size = np.hypot(values["sine"], values["cosine"])
        return f"the force follows the angle of the last joint, by up to {size:.2f} N, as if a cable pulled on the tool"

    return _Model(
        "cable_drag",
        _shaped(zeros, columns, scale),
        lambda numbers: {
            "sine": float(np.linalg.norm(numbers[:3])),
            "cosine": float(np.linalg.norm(numbers[6:9])),
            "wrist": float(np.linalg.norm(numbers[12:15])),
        },
        words,
    )


def _shaped(zeros: ForceZeros, columns: Array, scale: Array) -> Array:
    """Return the design matrix (6 n, k) of columns (n, 6, k), centred between tares, over the scatter (6,)."""
    return (_centred(zeros, columns) / scale[:, None]).reshape(6 * len(zeros), -1)


def _centred(zeros: ForceZeros, rows: Array) -> Array:
    """Return rows (n, …) minus their mean over each stretch between two moments of taring."""
    centred = rows.copy()
    for stretch in np.unique(zeros.zeroed):
        members = zeros.zeroed == stretch
        centred[members] -= rows[members].mean(axis=0)
    return centred


def _scatter(zeros: ForceZeros) -> Array:
    """Return the scatter (6,) of centred loads, N and N m: one value for the forces, one for the torques."""
    deviations = _centred(zeros, zeros.load).std(axis=0).reshape(2, 3)
    sizes: Array = np.repeat(np.maximum(deviations.mean(axis=1), 1e-9), 3)
    return sizes


def _noise(zeros: ForceZeros, scale: Array) -> float:
    """Return the sum of scaled squares that noise alone would leave, from successive pieces of trajectories."""
    together = np.diff(zeros.trajectory) == 0
    steps = np.diff(zeros.load, axis=0)[together] / scale
    return float((steps**2).sum(axis=1).mean() / 2.0 * len(zeros)) if together.any() else 0.0


def _unseen(zeros: ForceZeros, design: Array, target: Array) -> float:
    """Return the sum of squared prediction errors over trajectories, each predicted by a fit to all others."""
    owner = np.repeat(zeros.trajectory, 6)
    total = 0.0
    for number in np.unique(zeros.trajectory):
        held_out = owner == number
        predicted = (
            design[held_out] @ np.linalg.lstsq(design[~held_out], target[~held_out], rcond=None)[0]
            if design.shape[1]
            else 0.0
        )
        total += float(((target[held_out] - predicted) ** 2).sum())
    return total


def _exchanged(zeros: ForceZeros, taken: Array, field: Array, target: Array, seed: int) -> float:
    """Return the p-value of a further model: the share of permutations that fit as well (Freedman and Lane 1983).

    Parameters
    ----------
    zeros : ForceZeros
        The n pieces and their trajectories.
    taken : (6 n, j)
        Design matrix of the causes that are already accepted.
    field : (6 n, k)
        Design matrix of the further cause.
    target : (6 n,)
        Centred loads over their scatter.
    seed : int
        Random seed of the permutations.
    """
    rest = target - taken @ np.linalg.lstsq(taken, target, rcond=None)[0] if taken.shape[1] else target
    basis, sizes, _ = np.linalg.svd(field - taken @ np.linalg.pinv(taken) @ field if taken.shape[1] else field, False)
    basis = basis[:, sizes > 1e-9 * sizes[0]]
    # means of trajectories are permuted; the scatter of pieces within a trajectory stays in place
    rng = np.random.default_rng(seed)
    fitted = float(((basis.T @ rest) ** 2).sum())
    means = _by_trajectory(zeros, rest)
    within = rest - np.concatenate([means[place] for place in _places(zeros)])
    count = 0
    for _ in range(DRAWS):
        order = rng.permutation(len(means))
        drawn = within + np.concatenate([means[order[place]] for place in _places(zeros)])
        count += float(((basis.T @ drawn) ** 2).sum()) >= fitted
    return (count + 1) / (DRAWS + 1)


def _places(zeros: ForceZeros) -> Sequence[int]:
    """Return the index of each piece's trajectory, counted from 0."""
    return np.unique(zeros.trajectory, return_inverse=True)[1].tolist()


def _by_trajectory(zeros: ForceZeros, rows: Array) -> Array:
    """Return means (t, 6) of rows (6 n,) over the pieces of each trajectory."""
    shaped = rows.reshape(-1, 6)
    return np.array([shaped[zeros.trajectory == number].mean(axis=0) for number in np.unique(zeros.trajectory)])
