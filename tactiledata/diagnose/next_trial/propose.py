"""Which trial to record next: what each would tell of the explanations that are left, before it is recorded."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.naming.name_effects import NamingResult
from tactiledata.diagnose.naming.rivals import Pair, Rivals, rivals_of
from tactiledata.diagnose.next_trial.bench import TrialBench
from tactiledata.diagnose.next_trial.cases import trial_cases
from tactiledata.diagnose.next_trial.distance import Recorded, TrialRows, error_probability, square_with
from tactiledata.diagnose.next_trial.kinds import TRIALS
from tactiledata.diagnose.next_trial.trial import Trial
from tactiledata.diagnose.touches.touch_case import BaseFamily
from tactiledata.diagnose.touches.whitened import WhitenedTouches
from tactiledata.errors import UsageError

Way = tuple[int, int]

SEPARATED = 0.05
"""Chance of a wrong name, below which two explanations count as told apart."""


@dataclass(frozen=True)
class Separation:
    """Two explanations before and after a trial.

    Parameters
    ----------
    first, second : str
    before, after : float
        How far they are apart, in standard deviations, when each is refitted to what the other would show.
    """

    first: str
    second: str
    before: float
    after: float

    @property
    def error_before(self) -> float:
        """Chance to take one for the other."""
        return error_probability(self.before**2)

    @property
    def error_after(self) -> float:
        """The same with the trial."""
        return error_probability(self.after**2)


@dataclass(frozen=True)
class Proposal:
    """A trial and what it is worth.

    Parameters
    ----------
    trial : Trial
    bench : TrialBench
    separations : tuple of Separation
        Of each pair of explanations that is left.
    """

    trial: Trial
    bench: TrialBench
    separations: tuple[Separation, ...]

    @property
    def gain(self) -> float:
        """By how much the chance to take one for the other falls, on average over pairs."""
        return float(np.mean([one.error_before - one.error_after for one in self.separations]))

    @property
    def separates(self) -> tuple[Separation, ...]:
        """Pairs that are not told apart yet, and would be."""
        return tuple(one for one in self.separations if one.error_after < SEPARATED <= one.error_before)

    @property
    def rank(self) -> tuple[float, float]:
        """For sorting: by the gain, then by how far apart the trial alone would bring the explanations."""
        grown = [one.after**2 - one.before**2 for one in self.separations]
        return -round(self.gain, 4), -float(np.mean(np.sqrt(np.maximum(grown, 0.0))))


def propose_trials(
    naming: NamingResult,
    base: BaseFamily | None = None,
    bench: TrialBench | None = None,
    trials: Sequence[Callable[[TrialBench], Trial]] = TRIALS,
    progress: Callable[[str], None] = lambda text: None,
) -> list[Proposal]:
    """All trials, the most telling first; empty where one explanation, or none, is left.

    T-optimal (Atkinson and Fedorov, Biometrika 62, 1975): the trial is played with one explanation, the other is
    refitted to it and to what was recorded, numbers of its own, E, nu, mu and nuisance included, to first order; of
    both directions the smaller distance counts.

    Parameters
    ----------
    base : BaseFamily, optional
        What plays touches that were not recorded, depths counted from the plane z = 0 of the gel frame; balls and
        punches in closed form where ``None``.
    bench : TrialBench, optional
        The rig; that of the recorded trajectories where ``None``.
    """
    rivals = rivals_of(naming)
    if not rivals.pairs:
        return []
    rig = bench or TrialBench.of(naming.whitened.touch_set, naming.base.model.material, base)
    return ranked_trials(rivals, naming.whitened, rig, max(naming.decision.left.dispersion, 1.0), trials, progress)


def ranked_trials(
    rivals: Rivals,
    recorded: WhitenedTouches,
    bench: TrialBench,
    dispersion: float = 1.0,
    trials: Sequence[Callable[[TrialBench], Trial]] = TRIALS,
    progress: Callable[[str], None] = lambda text: None,
) -> list[Proposal]:
    """The same for explanations that were fitted to recorded data by other means.

    Parameters
    ----------
    dispersion : float
        Mean square of what the best explanation leaves, over that of noise.
    """
    ways = {way: Recorded(*(rivals.members[place].fit for place in way)) for pair in rivals.pairs for way in pair.ways}
    before = {way: known.least for way, known in ways.items()}
    proposals = []
    for make in trials:
        trial = make(bench)
        progress(trial.title)
        try:
            after = _squares_with(TrialRows.of(trial_cases(trial, bench), recorded), ways)
        except UsageError:
            # gel and springs of a candidate find no balance there: nothing can be said of this trial
            continue
        parts = [
            _separation(
                rivals, pair, *(min(squares[way] for way in pair.ways) / dispersion for squares in (before, after))
            )
            for pair in rivals.pairs
        ]
        proposals.append(Proposal(trial, bench, tuple(parts)))
    return sorted(proposals, key=lambda one: one.rank)


def _separation(rivals: Rivals, pair: Pair, before: float, after: float) -> Separation:
    """What the recorded data have not kept of what they could, a trial does not bring back."""
    kept = min(before, pair.known)
    first, second = (rivals.members[place].name for place in (pair.first, pair.second))
    return Separation(first, second, float(np.sqrt(kept)), float(np.sqrt(kept + after - before)))


def _squares_with(trial: TrialRows, ways: dict[Way, Recorded]) -> dict[Way, float]:
    truths: dict[int, Array] = {}
    found = {}
    for (first, second), known in ways.items():
        if first not in truths:
            truths[first] = trial.residual(trial.model(known.truth, trial.vector(known.truth)))
        # more data cannot bring two nearer to one another: below stands what a step leaves undone
        found[first, second] = max(square_with(trial, known, truths[first]), known.least)
    return found
