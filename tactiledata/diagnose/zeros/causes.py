"""Why the zero of a force sensor differs from trajectory to trajectory: weight, frame, cross-talk, drift, or cable."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tactiledata.arrays import Array
from tactiledata.contract.wording import counted
from tactiledata.diagnose.residuals.wording import p_words, percent
from tactiledata.diagnose.zeros.readings import ForceZeros
from tactiledata.diagnose.zeros.wander import wandering_zero
from tactiledata.diagnose.zeros.zero_models import FEWEST, centred, scatter_of, zero_models
from tactiledata.effects import EFFECTS

DRAWS = 299
"""Permutations of trajectories in each test: the smallest p-value is 1 / 300."""
LEVEL = 0.01
"""Largest p-value at which a cause is reported."""
WORTH = 0.2
"""Least share of the held-out squares beyond the noise that a cause must explain to be reported."""
LEAST = 0.02
"""Least root mean square of the zeros' force in N; smaller differences are not analysed."""
OWN_ZERO = "so that contact forces contain only what changes within a trajectory"
"""What a zero of its own does to a trajectory, for the user."""
READS = "but contact forces are read in the same wrong way, which no zero takes away"
"""What it does not do, where the cause changes how every force is read."""
CONTAINS = {"gain_crosstalk": ("tool_weight", "frame_rotation")}
"""Causes with those that are special cases of them: where the wider one explains more, these are not reported."""
WITHIN = 0.01
"""Change of the zero from the free air to the end of a trajectory, N, up to which a drift does not matter: a fit allows
every trajectory as much (`tactiledata.diagnose.touches.own_errors.OwnErrors`)."""


@dataclass(frozen=True)
class ZeroCause:
    """A cause that the zero of the force sensor follows.

    Parameters
    ----------
    effect : str
        Name in the catalogue of effects: ``tool_weight``, ``frame_rotation``, ``gain_crosstalk``, ``sensor_drift`` or
        ``cable_drag``.
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
    alike : tuple of str
        Effects of the catalogue that would read the same in free air.
    """

    effect: str
    p: float
    explained: float
    before: float
    after: float
    values: dict[str, float]
    words: str
    within: float | None = None
    alike: tuple[str, ...] = ()

    @property
    def matters(self) -> bool:
        """Whether contact forces are wrong by it: they are not where the zero hardly changes within a trajectory."""
        return self.within is None or self.within > WITHIN

    @property
    def document(self) -> dict[str, Any]:
        """The cause as it stands in ``diagnosis.json`` (schemas/diagnosis.json)."""
        return {**vars(self), "alike": list(self.alike), "matters": self.matters}


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
    scale = scatter_of(zeros)
    spread = float(np.sqrt((centred(zeros, zeros.load)[:, :3] ** 2).sum(axis=1).mean()))
    if spread < LEAST:
        return []
    models, taken = zero_models(zeros, scale), np.empty((6 * len(zeros), 0))
    causes: list[ZeroCause] = []
    target = (centred(zeros, zeros.load) / scale).ravel()
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
            " between the zeros of held-out trajectories. Each trajectory gets a zero of its own,"
            f" {READS if best.reads else OWN_ZERO}"
        )
        within = best.change_within(values)
        alike = best.alike(values)
        cause = ZeroCause(
            effect=best.effect,
            p=p,
            explained=explained,
            before=before,
            after=after,
            values=values,
            words=f"{words}.",
            within=within,
            alike=alike,
        )
        if within is not None:
            weight = "forces are wrong by as much" if cause.matters else "too little to matter"
            cause = replace(cause, words=f"{words}: {within:.3f} N, {weight}.")
        elif cause.alike:
            titles = " or ".join(EFFECTS[name]().title for name in cause.alike)
            cause = replace(cause, words=f"{cause.words} In free air, {titles} would read the same.")
        # cross-talk contains a weight and a turned frame that were taken for it
        contained = [one for one in causes if one.effect in CONTAINS.get(cause.effect, ())]
        if contained:
            cause = replace(cause, before=contained[0].before)
        causes = [*(one for one in causes if one not in contained), cause]
        taken, before = design, after
    drifts = [cause for cause in causes if cause.effect == "sensor_drift"]
    wander = _wander(zeros, drifts, band, seed)
    return causes if wander is None else [*(cause for cause in causes if cause not in drifts), wander]


def beside_claims(causes: Sequence[ZeroCause], claimed: Sequence[str]) -> tuple[list[str], list[str]]:
    """Return the effects that readings in free air show beside those that a fit claims, and what they may be as well.

    A cause is no second effect where a claimed one reads the same in free air.

    Parameters
    ----------
    causes : sequence of ZeroCause
        What the zeros follow; those that do not matter are left out.
    claimed : sequence of str
        Names of the effects that a fit claims.
    """
    shown = [cause for cause in causes if cause.matters and not set(cause.alike) & set(claimed)]
    alike = [name for cause in shown if cause.effect not in claimed for name in cause.alike]
    return [cause.effect for cause in shown], list(dict.fromkeys(alike))


def _wander(zeros: ForceZeros, drifts: Sequence[ZeroCause], band: float, seed: int) -> ZeroCause | None:
    """Return a walk that matters, and changes the zero more than drifts since power-on do; ``None`` without one."""
    found = wandering_zero(zeros, [drift.values["time"] for drift in drifts], seed)
    least = max(band, WITHIN, *(drift.within or 0.0 for drift in drifts))
    if found is None or found.explained < WORTH or found.within <= least:
        return None
    words = (
        f"In free air, the force sensor's zero wanders by chance ({p_words(found.p)}): trajectories that are close in"
        f" time have similar zeros. This explains {percent(found.explained)} of what a steady drift, weight and cable"
        f" leave of the differences. From the free air to the end of a trajectory the zero changes by"
        f" {found.within:.3f} N: forces are wrong by as much."
    )
    values = dict(zip(("walk_x", "walk_y", "walk_z"), found.walk.tolist(), strict=True))
    return ZeroCause("sensor_drift", found.p, found.explained, found.before, found.after, values, words, found.within)


def no_zeros(zeros: ForceZeros) -> str:
    """Return a sentence that says why the zeros cannot be analysed; empty where they can."""
    if zeros.trajectories >= FEWEST:
        return ""
    return (
        f"Only {counted(zeros.trajectories, 'trajectory')} with readings in free air: at least {FEWEST} are needed to"
        " see whether the tool's weight, the cable or a drift changes the zero of the force sensor. Begin recordings"
        " half a second before the touch."
    )


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
