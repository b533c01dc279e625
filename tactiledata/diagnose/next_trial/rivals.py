"""Which explanations an answer leaves open, and which pairs of them a next trial should tell apart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from tactiledata.diagnose.naming.joint_fit import JointFit, joint_fit
from tactiledata.diagnose.naming.name_effects import NamingResult
from tactiledata.diagnose.naming.parameters import joint_model
from tactiledata.diagnose.naming.signatures import strengths_of
from tactiledata.diagnose.naming.strength import Strength, set_at
from tactiledata.diagnose.verdict import Verdict
from tactiledata.effects import EFFECTS
from tactiledata.effects.simulate.setting import EffectSetting
from tactiledata.errors import UsageError

NOTHING = "nothing"
NO_CLAIM = "no effect"
"""The plain simulation beside an effect that has the evidence that it needs, and that another rule keeps back."""
HALF = 0.5
"""An explanation with less than this share of the first one's support is not considered as possibly true itself."""


@dataclass(frozen=True)
class Rival:
    """One explanation of the recorded data.

    Parameters
    ----------
    name : str
        Names of its effects joined by " + "; ``NOTHING`` or ``NO_CLAIM`` for the plain simulation.
    fit : JointFit
        Its fit to the recorded data.
    """

    name: str
    fit: JointFit


@dataclass(frozen=True)
class Pair:
    """Two explanations that are to be told apart.

    Parameters
    ----------
    first, second : int
        Their indices among all explanations.
    both_ways : bool
        Whether either of them may be the true one; otherwise only the first may.
    known : float
        Upper limit of the squared distance, in noise, by which the recorded data separate the two: twice the
        difference of their supports; infinite where there is no such limit.
    """

    first: int
    second: int
    both_ways: bool = True
    known: float = float("inf")

    @property
    def ways(self) -> tuple[tuple[int, int], ...]:
        """Index pairs (explanation that is true, explanation that is refitted to it)."""
        there = (self.first, self.second)
        return (there, there[::-1]) if self.both_ways else (there,)


@dataclass(frozen=True)
class Rivals:
    """Explanations, and which pairs of them are to be told apart.

    Parameters
    ----------
    members : tuple of Rival
        The explanations; `Pair` refers to them by index.
    pairs : tuple of Pair
        Those that a next trial should separate.
    """

    members: tuple[Rival, ...]
    pairs: tuple[Pair, ...]

    @staticmethod
    def around(members: Sequence[Rival], supports: Sequence[float]) -> Rivals:
        """Return the best supported explanation paired with each of the others.

        Of a pair, the second may be the true one only if it has at least the share ``HALF`` of the first one's support,
        and is not a part of the first (one effect of a pair of effects).

        Parameters
        ----------
        members : sequence of Rival
            The best supported first.
        supports : sequence of float
            Rise of the log-likelihood by each, over the plain simulation.
        """
        whole = set(members[0].fit.names) if members else set()
        pairs = []
        for index in range(1, len(members)):
            may_be_true = supports[index] >= HALF * supports[0] and not set(members[index].fit.names) < whole
            pairs.append(Pair(0, index, may_be_true, 2.0 * abs(supports[0] - supports[index])))
        return Rivals(tuple(members), tuple(pairs))


def rivals_of(naming: NamingResult, most: int = 4) -> Rivals:
    """Return the explanations that an answer leaves open.

    - If the answer is a set of effects: the named effect and its ties.
    - If it is one effect: this effect, and the candidate that comes nearest in gain.
    - If no effect is named: the few strongest candidates.
    - If nothing is found: the effects that have the evidence that they need, and that another rule kept from being
      claimed, beside the plain simulation. Where there are none: each effect that these data cannot show, at the end
      of its plausible range, beside the plain simulation.

    Parameters
    ----------
    naming : NamingResult
        The answer, with all fits.
    most : int
        Largest number of explanations; it does not limit those of the answer that nothing is found.
    """
    decision = naming.decision
    if decision.verdict is Verdict.NOTHING_FOUND:
        return _nearly_found(naming, most) or _undetectable(naming)
    ranked = sorted(naming.scored, key=lambda candidate: -candidate.gain)
    if decision.claimed and decision.best is not None:
        tied = {tie.label for tie in decision.ties}
        others = [candidate for candidate in ranked if candidate.label in tied]
        if not others:
            others = [candidate for candidate in ranked if candidate is not decision.best and candidate.gain > 0][:1]
        ranked = [decision.best, *others]
    else:
        ranked = [candidate for candidate in ranked if len(candidate.names) == 1]
    rivals = [Rival(candidate.label, candidate.fit) for candidate in ranked]
    supports = [candidate.gain for candidate in ranked]
    # without a claim and with fewer than two refits, the screen adds effects by their first-order evidence
    if len(rivals) < 2 and not decision.claimed:
        promising = [effect for effect in naming.screened if effect.effect not in {rival.name for rival in rivals}][
            :most
        ]
        for effect in promising:
            if (rival := _screened(naming, effect.starts[0])) is not None:
                rivals.append(rival)
                supports.append(effect.evidence)
    return Rivals.around(rivals[:most], supports[:most])


def _screened(naming: NamingResult, start: Sequence[EffectSetting]) -> Rival | None:
    """An effect that was not refitted, with the strengths of its first-order score; ``None`` without any balance."""
    base = naming.base.model
    errors = len(base.errors)
    model = joint_model(base.material, start, len(base.offsets), errors, box=base.box)
    model = replace(model, offsets=base.offsets, errors=base.errors)
    try:
        return Rival(start[0].effect, joint_fit(naming.whitened, model, rounds=0))
    except UsageError:
        return None


def _nearly_found(naming: NamingResult, most: int) -> Rivals | None:
    """Return the effects with as much evidence as they need, against the plain simulation; None where there are none.

    The plain simulation is a part of each of them, so that only they may be the true explanation. What the recorded
    data say does not count, since it was not enough for a claim.
    """
    found = [
        one for one in naming.scored if len(one.names) == 1 and one.evidence >= one.needed(naming.thresholds)
    ]  # fmt: skip
    if not found:
        return None
    found = sorted(found, key=lambda one: -one.evidence)[:most]
    members = (Rival(NO_CLAIM, naming.base), *(Rival(one.label, one.fit) for one in found))
    return Rivals(members, tuple(Pair(place, 0, False, 0.0) for place in range(1, len(members))))


def _undetectable(naming: NamingResult) -> Rivals:
    """Each effect that these data cannot show, by its most visible strength, against the plain simulation.

    Effects with which gel and springs find no balance at that strength are left out.
    """
    known = naming.identifiable
    members = [Rival(NOTHING, naming.base)]
    for effect in known.undetectable:
        reach = {strength: known.reach[k] for k, strength in enumerate(known.numbers) if strength.effect == effect}
        strengths = [Strength(effect, parameter.name) for parameter in strengths_of(EFFECTS[effect]())]
        most_visible = max(reach or strengths, key=lambda strength: reach.get(strength, 0.0))
        if (rival := _at_its_strongest(naming, most_visible)) is not None:
            members.append(rival)
    return Rivals(tuple(members), tuple(Pair(index, 0, False) for index in range(1, len(members))))


def _at_its_strongest(naming: NamingResult, strength: Strength) -> Rival | None:
    """The plain fit with one strength at the far end of its plausible range; ``None`` without any balance."""
    base, whitened = naming.base, naming.whitened
    setting = set_at(strength.effect, {strength.name: strength.end}, strength.place)
    model = replace(base.model, settings=(setting,), coordinates=())
    play = whitened.touch_set.play
    try:
        plays = [play(base.model.material, settings, base.model.offsets) for settings in ([setting], [])]
    except UsageError:
        return None
    change = whitened.whiten(plays[0] - plays[1])
    return Rival(strength.effect, replace(base, model=model, residual=base.residual - change, effect_change=change))
