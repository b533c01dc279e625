"""The zero of each component in free air: errors of the sensor, separate from errors of the contact."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tactiledata.diagnose.locate.common_offset import Offset, offsets
from tactiledata.diagnose.locate.drifts import Drift, parameter_drifts
from tactiledata.diagnose.residuals.projection import project
from tactiledata.diagnose.residuals.residuals import FEWEST_UNITS, ResidualParameter, Residuals
from tactiledata.diagnose.residuals.sign_flips import DRAWS


def with_zeros(residuals: Residuals) -> Residuals:
    """Return a copy with a zero of each component as a further shared parameter, in the component's unit."""
    width = len(residuals.components)
    deviations = np.ones(width) if residuals.deviations is None else residuals.deviations
    units = residuals.units or ("times the noise",) * width
    slopes = np.broadcast_to(np.diag(1.0 / deviations), (len(residuals.values), width, width))
    zeros = tuple(
        ResidualParameter(f"zero of {name}", unit) for name, unit in zip(residuals.components, units, strict=True)
    )
    return replace(
        residuals,
        parameters=(*residuals.parameters, *zeros),
        sensitivities=np.concatenate([residuals.slopes, slopes], axis=2),
    )


PHASE, FREE_AIR = "phase", "free air"
"""The label of phases, and its level before any contact."""
NOT_IN_CONTACT = (FREE_AIR, "approach")
"""Phases in which nothing touches."""


def in_contact(residuals: Residuals) -> NDArray[np.bool_]:
    """Return the mask (n,) of the frames in contact; all frames where the label ``phase`` is missing."""
    phases = residuals.labels.get(PHASE)
    if phases is None:
        return np.ones(len(residuals.values), dtype=bool)
    return np.asarray(~np.isin(phases, NOT_IN_CONTACT))


@dataclass(frozen=True)
class FreeAir:
    """Test results for the frames in free air, where only the sensor, its mount or its clock can err.

    Parameters
    ----------
    frames, trajectories : int
        Number of frames in free air, and of units of exchange that have some.
    p : float
        p-value of the hypothesis that they hold no structure; 1 where it cannot be tested.
    offsets : tuple of Offset
        Mean of each component, the most certain first.
    drifts : tuple of Drift
        Dependence of each component's mean on each covariate, the strongest first.
    words : str
        The result as sentences.
    """

    frames: int
    trajectories: int
    p: float
    offsets: tuple[Offset, ...]
    drifts: tuple[Drift, ...]
    words: str

    @property
    def is_tested(self) -> bool:
        """Whether at least `FEWEST_UNITS` units of exchange have frames in free air."""
        return self.trajectories >= FEWEST_UNITS


def free_air(residuals: Residuals, seed: int = 0, draws: int = DRAWS) -> FreeAir:
    """Test the means and drifts of each component in the frames whose ``phase`` is "free air".

    Parameters
    ----------
    residuals : Residuals
        All frames; those in free air are selected.
    seed : int
        Random seed of the sign flips.
    draws : int
        Number of sign flips.
    """
    rows: NDArray[np.bool_] = np.zeros(len(residuals.values), dtype=bool)
    if PHASE in residuals.labels:
        rows = residuals.labels[PHASE] == FREE_AIR
    if not rows.any():
        return FreeAir(
            0,
            0,
            1.0,
            (),
            (),
            "There are no frames in free air: errors of the sensor cannot be told apart from errors of the contact.",
        )
    alone = _with_zeros_only(residuals.part(rows))
    if alone.unit_count < FEWEST_UNITS:
        text = f"Only {alone.unit_count} trajectories have frames in free air: too few to test the sensor alone."
        return FreeAir(int(rows.sum()), alone.unit_count, 1.0, (), (), text)
    means = offsets(alone, seed, draws)
    drifts = parameter_drifts(project(alone), seed + 1, draws)
    # two families of tests, hence the factor 2 (Bonferroni)
    p = min([1.0, *(2 * mean.p for mean in means), *(2 * drift.p for drift in drifts)])
    return FreeAir(int(rows.sum()), alone.unit_count, p, means, drifts, _words(p, means, drifts))


def _with_zeros_only(alone: Residuals) -> Residuals:
    """Return the free-air frames with the zeros as their only parameters, without labels that describe contact."""
    labels = {name: texts for name, texts in alone.labels.items() if name not in (PHASE, "contact")}
    return with_zeros(replace(alone, labels=labels, parameters=(), sensitivities=None))


def _words(p: float, means: tuple[Offset, ...], drifts: tuple[Drift, ...]) -> str:
    """Return the result of the test as sentences; the most certain mean or drift stands for all."""
    if p > 0.05:
        return "There is no structure in free air: sensor, mount and clock do not explain differences in contact."
    p_of_clause = {mean.words: mean.p for mean in means} | {drift.words: drift.p for drift in drifts}
    strongest = min(p_of_clause, key=lambda clause: p_of_clause[clause])
    return (
        f"There is structure in free air, before anything touches: {strongest}. Its cause is the sensor, its mount or "
        "its clock. Check these before the contact."
    )
