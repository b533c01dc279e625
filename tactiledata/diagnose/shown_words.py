"""What an effect does for unseen data, in plain sentences."""

from __future__ import annotations

import math

from tactiledata.diagnose.gap_words import change_words
from tactiledata.diagnose.held_out_errors import HeldOutErrors
from tactiledata.diagnose.locate import LEVEL
from tactiledata.diagnose.residuals import joined_names
from tactiledata.diagnose.show import Shown
from tactiledata.diagnose.wording import p_words, rounded
from tactiledata.effects import EFFECTS

FEW = 3
"""Groups; of two, each is predicted by one alone."""


def shown_sentences(shown: Shown) -> list[str]:
    """What is gained, where it is gained, and what is left; without a claim, that none would help."""
    said = _gained(shown) if shown.names else _unclaimed(shown)
    if shown.flattened is not None:
        said.append(_flattened(shown))
    if shown.left_over is not None:
        said.append(_left_over(shown))
    said.append(_ceiling(shown))
    if shown.stretched:
        listed = [f"{name} by {rounded(abs(size))}" for name, size in shown.stretched.items()]
        said.append(
            "The plain fit blames the simulation itself beyond what it is known to err, in standard deviations: "
            f"{joined_names(listed)}. A wrong radius, a wrong thickness or an effect may hide there."
        )
    return said


def same_digits(*values: float, digits: int = 2) -> tuple[str, ...]:
    """Numbers with as many decimals as the smallest needs."""
    least = min((abs(value) for value in values if value), default=1.0)
    places = min(max(0, digits - 1 - math.floor(math.log10(least))), 4)
    return tuple(f"{value:.{places}f}" for value in values)


def _gained(shown: Shown) -> list[str]:
    first = shown.of_trajectories
    said = [f"On {first.unseen} that it has not seen the force error {_changes(first)}"]
    noise = f"noise alone gives {same_digits(first.force.floor, digits=3)[0]} N"
    said[0] += f"; {noise}" + (
        f": {change_words(first.force)}." if first.has_gap else ", so that there was hardly a gap to close."
    )
    if first.has_gap and first.force.interval[0] > 1.0:
        said[0] += " Less is left than free air tells of the noise."
    hardest = shown.hardest
    if hardest is not first:
        by = "" if hardest.groups >= FEW else ", each told by the other alone,"
        closes = f": {change_words(hardest.force)}" if hardest.has_gap else ""
        said.append(f"On {hardest.groups} {hardest.unseen} that it has not seen{by} it {_changes(hardest)}{closes}.")
    if any(_rises(one) for one in (first, hardest)):
        said.append("That it rises speaks against the claim.")
    return said


def doubts(shown: Shown) -> list[str]:
    """What speaks against taking a claim as it is, in a sentence beside the claim; nothing where nothing does."""
    if not shown.names:
        return []
    against = [f"the error rises on {one.unseen} that were held out" for one in shown.errors if _rises(one)]
    if shown.left_over is not None and shown.left_over.is_structured:
        against.append("structure is left with it")
    return [f"Take it with care: {joined_names(against)}."] if against else []


def _rises(errors: HeldOutErrors) -> bool:
    """Of few groups only where trajectories drawn anew agree on it."""
    return errors.change > 0 and (errors.groups >= FEW or (errors.has_gap and errors.force.interval[1] < 0))


def _changes(errors: HeldOutErrors) -> str:
    before, after = same_digits(errors.force.before, errors.force.after, digits=3)
    return f"{'rises' if errors.change > 0 else 'falls'} from {before} to {after} N"


def _unclaimed(shown: Shown) -> list[str]:
    errors = shown.of_trajectories
    before, floor = same_digits(errors.force.before, errors.force.floor)
    said = [
        f"On trajectories that it has not seen the plain simulation errs by {before} N; noise alone gives {floor} N."
    ]
    if shown.tried:
        titles = joined_names([EFFECTS[name]().title for name in shown.tried])
        changes = [f"{_signed(one.change)} on {one.unseen}" for one in shown.errors]
        said.append(f"The nearest candidate, {titles}, would change that error by {joined_names(changes)}.")
    return said


def _signed(share: float) -> str:
    return f"{100 * share:+.1f} %".replace("-", "−")


def _flattened(shown: Shown) -> str:
    assert shown.flattened is not None
    before, after = shown.flattened
    first = before.words.split(" (p ")[0]
    now = after.change.words.removeprefix(f"{after.parameter} ")
    begin = "Once sloped, now flat" if after.p > LEVEL else "Sloped still"
    return f"{begin}: in the plain simulation {first}; with the effect it {now} ({p_words(after.p)})."


def _left_over(shown: Shown) -> str:
    assert shown.left_over is not None
    if not shown.left_over.is_structured:
        return "With it no locator finds structure any more."
    return f"Structure is left with it. {shown.left_over.sentences()[0]}"


def _ceiling(shown: Shown) -> str:
    errors = shown.of_trajectories
    if shown.ceiling_force >= errors.force.before:
        return "A black box, boosted trees on all covariates, finds nothing that helps on trajectories held out."
    reached, after = same_digits(shown.ceiling_force, errors.force.after)
    said = f"A black box, boosted trees on all covariates, reaches {reached} N on trajectories held out"
    return f"{said}, where the effect reaches {after} N." if shown.names else f"{said}."
