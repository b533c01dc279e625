"""Ranked proposals: how far each trial would separate the explanations that are left, before it is recorded."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.naming.name_effects import NamingResult
from tactiledata.diagnose.next_trial.bench import TrialBench
from tactiledata.diagnose.next_trial.cases import trial_cases
from tactiledata.diagnose.next_trial.distance import Recorded, TrialRows, error_probability, square_with
from tactiledata.diagnose.next_trial.kinds import TRIALS
from tactiledata.diagnose.next_trial.rivals import Pair, Rivals, rivals_of
from tactiledata.diagnose.next_trial.trial import Trial
from tactiledata.diagnose.touches.touch_case import BaseFamily
from tactiledata.diagnose.touches.whitened import WhitenedTouches
from tactiledata.errors import UsageError

Way = tuple[int, int]
"""Places of the true explanation and of the one that is refitted to it."""

SEPARATED = 0.05
"""Probability of a wrong name below which two explanations count as separated."""


@dataclass(frozen=True)
class Separation:
    """Distance of two explanations before and after a trial.

    Parameters
    ----------
    first, second : str
        Effects of each explanation, joined by `` + ``; "nothing" or "no effect" for the plain simulation.
    before, after : float
        Distance in standard deviations, where one explanation is refitted to what the other predicts.
    """

    first: str
    second: str
    before: float
    after: float

    @property
    def error_before(self) -> float:
        """Probability of taking one explanation for the other with the recorded data."""
        return error_probability(self.before**2)

    @property
    def error_after(self) -> float:
        """Probability of taking one explanation for the other with recorded data and trial."""
        return error_probability(self.after**2)


@dataclass(frozen=True)
class Proposal:
    """A trial, and how far it would separate the explanations that are left.

    Parameters
    ----------
    trial : Trial
    bench : TrialBench
        The rig on which it would be recorded.
    separations : tuple of Separation
        Separation of each pair of explanations that is left.
    """

    trial: Trial
    bench: TrialBench
    separations: tuple[Separation, ...]

    @property
    def gain(self) -> float:
        """Fall of the probability of taking one explanation for the other, averaged over pairs."""
        return float(np.mean([pair.error_before - pair.error_after for pair in self.separations]))

    @property
    def separates(self) -> tuple[Separation, ...]:
        """Pairs that the recorded data do not separate, and that the trial would."""
        return tuple(pair for pair in self.separations if pair.error_after < SEPARATED <= pair.error_before)

    @property
    def rank(self) -> tuple[float, float]:
        """Sort key: the gain, then the distance that the trial alone would bring; the best trial comes first."""
        grown = [pair.after**2 - pair.before**2 for pair in self.separations]
        return -round(self.gain, 4), -float(np.mean(np.sqrt(np.maximum(grown, 0.0))))


def propose_trials(
    naming: NamingResult,
    base: BaseFamily | None = None,
    bench: TrialBench | None = None,
    trials: Sequence[Callable[[TrialBench], Trial]] = TRIALS,
    progress: Callable[[str], None] = lambda text: None,
) -> list[Proposal]:
    """Return all trials, those that separate the explanations best first; empty where no two explanations are left.

    The design is T-optimal (Atkinson and Fedorov, Biometrika 62, 1975). The trial is played with one explanation. The
    other is refitted to it and to the recorded data: its own numbers, E, nu, mu and the errors of the simulation. Of
    both directions the smaller distance counts.

    Parameters
    ----------
    naming : NamingResult
        Gives the explanations that are left, and the recorded touches.
    base : BaseFamily, optional
        The simulation that plays touches that were not recorded, with depths counted from the plane z = 0 of the gel
        frame; by default balls and punches in closed form.
    bench : TrialBench, optional
        The rig; by default that of the recorded trajectories.
    trials : sequence of callables
        Each makes a trial for a bench.
    progress : callable
        Called with the title of each trial before it is played.
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
    """Return all trials for given explanations, those that separate them best first.

    Parameters
    ----------
    rivals : Rivals
        The explanations with their fits to the recorded data, and the pairs to be separated.
    recorded : WhitenedTouches
        The recorded data.
    bench : TrialBench
        The rig on which trials would be recorded.
    dispersion : float
        Mean square of what the best explanation leaves, over that of noise; squared distances are divided by it.
    trials : sequence of callables
        Each makes a trial for a bench.
    progress : callable
        Called with the title of each trial before it is played.
    """
    # squared distances in the recorded data
    ways = {way: Recorded(*(rivals.members[place].fit for place in way)) for pair in rivals.pairs for way in pair.ways}
    before = {way: known.least for way, known in ways.items()}
    # squared distances with each trial
    proposals = []
    for make in trials:
        trial = make(bench)
        progress(trial.title)
        try:
            after = _squares_with(TrialRows.of(trial_cases(trial, bench), recorded), ways)
        except UsageError:
            # the simulation finds no balance of gel and springs with a candidate: the trial cannot be judged
            continue
        parts = [
            _separation(
                rivals, pair, *(min(squares[way] for way in pair.ways) / dispersion for squares in (before, after))
            )
            for pair in rivals.pairs
        ]
        proposals.append(Proposal(trial, bench, tuple(parts)))
    return sorted(proposals, key=lambda proposal: proposal.rank)


def _separation(rivals: Rivals, pair: Pair, before: float, after: float) -> Separation:
    """Return the separation of a pair from squared distances before and after a trial.

    The recorded data may separate the pair by less than their information allows (``pair.known``). A trial adds to what
    they do separate; it does not recover the rest.
    """
    kept = min(before, pair.known)
    first, second = (rivals.members[place].name for place in (pair.first, pair.second))
    return Separation(first, second, float(np.sqrt(kept)), float(np.sqrt(kept + after - before)))


def _squares_with(trial: TrialRows, ways: dict[Way, Recorded]) -> dict[Way, float]:
    """Return the squared distance of each pair and direction in recorded data and trial together."""
    truths: dict[int, Array] = {}
    squares = {}
    for (first, second), known in ways.items():
        if first not in truths:
            truths[first] = trial.residual(trial.model(known.truth, trial.vector(known.truth)))
        # more data cannot make the distance smaller: a smaller value means an unfinished refit
        squares[first, second] = max(square_with(trial, known, truths[first]), known.least)
    return squares
