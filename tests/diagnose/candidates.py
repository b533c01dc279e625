"""Scored candidates for tests of the decision, without any fit: everything by which they are judged is given."""

import dataclasses
from types import SimpleNamespace

import numpy as np

from tactiledata.diagnose.naming.decide import decide
from tactiledata.diagnose.naming.evidence import ScoredCandidate
from tactiledata.diagnose.naming.metric import RandomEffects
from tactiledata.diagnose.naming.remaining_structure import RemainingStructure
from tactiledata.diagnose.naming.thresholds import DEFAULT_THRESHOLDS

TRAJECTORIES = 25
EASY, OTHER_EASY = "lag", "rate_friction"
"""Effects that errors of a simulation do not resemble."""
HARD = max(DEFAULT_THRESHOLDS.claims, key=lambda name: DEFAULT_THRESHOLDS.claims[name])
"""The effect that needs most evidence, as errors of a simulation resemble it."""
EVERYTHING = np.ones((2, 6))
"""A change in every component."""


def along(column):
    """A change (2, 6) of one component: at right angles to that of another."""
    return np.eye(6)[[column, column]]


def candidate(names, times=2.0, change=EVERYTHING, numbers=1, **changed):
    """A candidate that can be claimed: `times` the evidence that it needs, from all trajectories alike.

    There is one indenter only, so that none can be held out. `changed` replaces fields of the candidate.
    """
    named = names if isinstance(names, tuple) else (names,)
    evidence = times * DEFAULT_THRESHOLDS.needed(named)
    each = np.full(TRAJECTORIES, evidence / TRAJECTORIES)
    fit = SimpleNamespace(
        names=named,
        effect_change=change,
        effect_fields=change[:, :, None],
        model=SimpleNamespace(coordinates=(None,) * numbers),
        metric=plain_metric(),
    )
    sound = ScoredCandidate(
        fit=fit,
        gains=each,
        indenter_gain=float("nan"),
        indenter_error=float("nan"),
        excess_share=1.0,
        signature_before=DEFAULT_THRESHOLDS.signature_threshold,
        signature_after=0.0,
        implausible=(),
        at_bounds=(),
        evidence=evidence,
        evidence_per_trajectory=each,
    )
    return dataclasses.replace(sound, **changed)


def with_evidence(names, evidence, **changed):
    """A candidate as `candidate` makes it, with so much evidence in all."""
    named = names if isinstance(names, tuple) else (names,)
    return candidate(names, evidence / DEFAULT_THRESHOLDS.needed(named), **changed)


def scattered(total, errors=0.9):
    """Gains (25,) that sum to a positive total of so many standard errors."""
    about = np.tile([1.0, -1.0], TRAJECTORIES)[:TRAJECTORIES]
    about = (about - about.mean()) / about.std(ddof=1)
    # standard error of the sum: 5 times the standard deviation of 25 gains
    deviation = total / (errors * np.sqrt(TRAJECTORIES))
    return total / TRAJECTORIES + deviation * about


def plain_metric(rows=2):
    """Noise alone: no refit imitates anything."""
    return RandomEffects(np.zeros((rows, 6)), np.zeros((rows, 6, 0)), np.zeros(0), np.zeros(1, dtype=int))


NOTHING_LEFT = RemainingStructure(1.0, 1.0)
MORE_THAN_NOISE = RemainingStructure(
    0.5 * (DEFAULT_THRESHOLDS.noise_dispersion + DEFAULT_THRESHOLDS.structure_dispersion),
    0.5 * (DEFAULT_THRESHOLDS.noise_dispersion + DEFAULT_THRESHOLDS.structure_dispersion),
)
"""More than noise in most trajectories, but no structure."""
STRUCTURE = RemainingStructure(
    DEFAULT_THRESHOLDS.structure_dispersion + 0.2, DEFAULT_THRESHOLDS.structure_dispersion + 0.1
)
"""Structure in most trajectories."""
IN_FEW = RemainingStructure(DEFAULT_THRESHOLDS.structure_dispersion + 0.2, 1.0)
"""Much in two trajectories, noise in the others."""
MUCH = 10.0 * (DEFAULT_THRESHOLDS.needed((EASY, HARD)) + DEFAULT_THRESHOLDS.tie_evidence / DEFAULT_THRESHOLDS.tie_share)
"""Evidence far beyond what two effects need, so that the margin of a tie is a share of it."""


def decided(singles, pairs=(), left=NOTHING_LEFT):
    """The answer to scored candidates."""
    gains = {one.label: one.gains for one in (*singles, *pairs)}
    return decide(singles, list(pairs), gains, plain_metric(), left, DEFAULT_THRESHOLDS)
