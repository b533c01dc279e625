"""Which explanations are still in the running, and which of them are to be told apart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from tactiledata.diagnose.naming.joint_fit import JointFit, joint_fit
from tactiledata.diagnose.naming.name_effects import NamingResult
from tactiledata.diagnose.naming.parameters import joint_model
from tactiledata.diagnose.naming.signatures import strengths_of
from tactiledata.diagnose.naming.strength import Strength, set_at
from tactiledata.effects import EFFECTS
from tactiledata.effects.simulate.setting import EffectSetting

NOTHING = "nothing"
CLAIMED = ("named", "one of a set")
HALF = 0.5


@dataclass(frozen=True)
class Rival:
    """One explanation.

    Parameters
    ----------
    name : str
        Effects, joined by `` + ``; ``NOTHING`` for the plain simulation.
    fit : JointFit
        In the recorded data.
    """

    name: str
    fit: JointFit


@dataclass(frozen=True)
class Pair:
    """Two explanations, by their places among all.

    Parameters
    ----------
    first, second : int
    both_ways : bool
        Whether either may be true; only the first where the second hardly differs from nothing.
    known : float
        How far (in noise, squared) the recorded data really keep them apart, where that is less than they could.
    """

    first: int
    second: int
    both_ways: bool = True
    known: float = float("inf")

    @property
    def ways(self) -> tuple[tuple[int, int], ...]:
        """(what is true, what is refitted to it)."""
        there = (self.first, self.second)
        return (there, there[::-1]) if self.both_ways else (there,)


@dataclass(frozen=True)
class Rivals:
    """Explanations, and which of them are to be told apart.

    Parameters
    ----------
    members : tuple of Rival
    pairs : tuple of Pair
    """

    members: tuple[Rival, ...]
    pairs: tuple[Pair, ...]

    @staticmethod
    def around(members: Sequence[Rival], supports: Sequence[float]) -> Rivals:
        """The best supported against each of the others.

        Parameters
        ----------
        supports : descending
            What each has gained in log-likelihood: one with less than half of the first's is no truth beside it, only a
            wrong name for it. Nor is a part of the first.
        """
        whole = set(members[0].fit.names) if members else set()
        pairs = []
        for place in range(1, len(members)):
            may_be_true = supports[place] >= HALF * supports[0] and not set(members[place].fit.names) < whole
            pairs.append(Pair(0, place, may_be_true, 2.0 * abs(supports[0] - supports[place])))
        return Rivals(tuple(members), tuple(pairs))


def rivals_of(naming: NamingResult, most: int = 4) -> Rivals:
    """What an answer leaves open.

    Of a set, the named effect and its ties; of a name alone, it and what came nearest; of an abstention, the strongest
    few; where nothing is missing, what could be there and not show, each at the end of its plausible range, against
    nothing.
    """
    decision = naming.decision
    if decision.verdict == "nothing is missing":
        return _unseen(naming)
    ranked = sorted(naming.scored, key=lambda one: -one.gain)
    if decision.verdict in CLAIMED and decision.best is not None:
        tied = {tie.label for tie in decision.ties}
        others = [one for one in ranked if one.label in tied]
        if not others:
            others = [one for one in ranked if one is not decision.best and one.gain > 0][:1]
        ranked = [decision.best, *others]
    else:
        ranked = [one for one in ranked if len(one.names) == 1]
    found = [Rival(one.label, one.fit) for one in ranked]
    supports = [one.gain for one in ranked]
    if len(found) < 2 and decision.verdict not in CLAIMED:
        promising = [one for one in naming.screened if one.effect not in {rival.name for rival in found}][:most]
        found += [_screened(naming, one.starts[0]) for one in promising]
        supports += [one.evidence for one in promising]
    return Rivals.around(found[:most], supports[:most])


def _screened(naming: NamingResult, start: Sequence[EffectSetting]) -> Rival:
    """An effect that was not refitted, as its first-order score has it."""
    base = naming.base.model
    errors = len(base.errors)
    model = joint_model(base.material, start, len(base.offsets), errors, box=base.box)
    model = replace(model, offsets=base.offsets, errors=base.errors)
    return Rival(
        start[0].effect,
        joint_fit(
            naming.whitened, naming.whitened.simulation_error_fields(base.material, base.offsets), model, rounds=0
        ),
    )


def _unseen(naming: NamingResult) -> Rivals:
    plain = Rival(NOTHING, naming.base)
    known = naming.identifiable
    members = [plain]
    for effect in known.undetectable:
        reach = {one: known.reach[k] for k, one in enumerate(known.numbers) if one.effect == effect}
        strengths = [Strength(effect, one.name) for one in strengths_of(EFFECTS[effect]())]
        members.append(_at_its_strongest(naming, max(reach or strengths, key=lambda one: reach.get(one, 0.0))))
    return Rivals(tuple(members), tuple(Pair(place, 0, False) for place in range(1, len(members))))


def _at_its_strongest(naming: NamingResult, strength: Strength) -> Rival:
    base, cases = naming.base, naming.whitened
    setting = set_at(strength.effect, {strength.name: strength.end}, strength.place)
    model = replace(base.model, settings=(setting,), coordinates=())
    plays = [cases.touch_set.play(base.model.material, settings, base.model.offsets) for settings in ([setting], [])]
    change = cases.whiten(plays[0] - plays[1])
    return Rival(strength.effect, replace(base, model=model, residual=base.residual - change, effect_change=change))
