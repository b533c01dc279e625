"""A zero of each component as a parameter, so that a bias that drifts is told from a modulus that does."""

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
    """Residuals that know a zero of each component beside their parameters, in the component's unit."""
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
NOT_IN_CONTACT = (FREE_AIR, "approach")


def in_contact(residuals: Residuals) -> NDArray[np.bool_]:
    """Frames (n,) in which something touches; all of them where phases are not known."""
    phases = residuals.labels.get(PHASE)
    if phases is None:
        return np.ones(len(residuals.values), dtype=bool)
    return np.asarray(~np.isin(phases, NOT_IN_CONTACT))


@dataclass(frozen=True)
class FreeAir:
    """What free-air frames show.

    Parameters
    ----------
    frames, trajectories : int
    p : float
        That they hold no structure; 1 where it cannot be tested.
    offsets : tuple of Offset
        Components whose mean is not 0.
    drifts : tuple of Drift
        Components whose mean goes with a covariate.
    words : str
    """

    frames: int
    trajectories: int
    p: float
    offsets: tuple[Offset, ...]
    drifts: tuple[Drift, ...]
    words: str

    @property
    def is_tested(self) -> bool:
        """Whether there were frames enough."""
        return self.trajectories >= FEWEST_UNITS


def free_air(residuals: Residuals, seed: int = 0, draws: int = DRAWS) -> FreeAir:
    """Means and drifts of each component in the frames whose ``phase`` is "free air"."""
    rows: NDArray[np.bool_] = np.zeros(len(residuals.values), dtype=bool)
    if PHASE in residuals.labels:
        rows = residuals.labels[PHASE] == FREE_AIR
    if not rows.any():
        return FreeAir(
            0, 0, 1.0, (), (), "No frames in free air: an error of the sensor cannot be told from one of contact."
        )
    alone = _with_zeros_only(residuals.part(rows))
    if alone.unit_count < FEWEST_UNITS:
        text = f"Free air in {alone.unit_count} trajectories only: too few to say anything of the sensor alone."
        return FreeAir(int(rows.sum()), alone.unit_count, 1.0, (), (), text)
    means = offsets(alone, seed, draws)
    drifts = parameter_drifts(project(alone), seed + 1, draws)
    p = min([1.0, *(2 * mean.p for mean in means), *(2 * drift.p for drift in drifts)])
    return FreeAir(int(rows.sum()), alone.unit_count, p, means, drifts, _words(p, means, drifts))


def _with_zeros_only(alone: Residuals) -> Residuals:
    """Free-air frames know one parameter for each component: its zero. Labels of contact mean nothing there."""
    labels = {name: texts for name, texts in alone.labels.items() if name not in (PHASE, "contact")}
    return with_zeros(replace(alone, labels=labels, parameters=(), sensitivities=None))


def _words(p: float, means: tuple[Offset, ...], drifts: tuple[Drift, ...]) -> str:
    if p > 0.05:
        return "Free air holds no structure: sensor, mount and clock give no cause for the rest."
    said = {mean.words: mean.p for mean in means} | {drift.words: drift.p for drift in drifts}
    strongest = min(said, key=lambda words: said[words])
    return (
        f"Structure in free air, before anything touches: {strongest}. It comes from the sensor, its mount or "
        "its clock; look there before you speak of contact."
    )
