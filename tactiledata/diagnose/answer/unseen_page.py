"""What an effect does for unseen data, in plain sentences."""

from __future__ import annotations

import math
from collections.abc import Sequence

from tactiledata.diagnose.answer.locator_rows import dependence_panel, event_picture, map_picture
from tactiledata.diagnose.locate.drifts import Drift
from tactiledata.diagnose.locate.locate import LEVEL, LocatorResults
from tactiledata.diagnose.naming.name_effects import NamingResult
from tactiledata.diagnose.residuals.residuals import joined_names
from tactiledata.diagnose.residuals.wording import change_words, gap_words, p_words, rounded
from tactiledata.diagnose.unseen.compare import HeldOutComparison
from tactiledata.diagnose.unseen.errors import FORCE, HeldOutErrors
from tactiledata.diagnose.unseen.touch_residuals import COMPONENTS
from tactiledata.effects import EFFECTS
from tactiledata.report.diagnosis_plots import draw_dependences
from tactiledata.report.naming_plots import (
    ErrorPanel,
    OverlayPicture,
    draw_event_pairs,
    draw_held_out,
    draw_map_pair,
    draw_overlays,
)
from tactiledata.report.page import Picture, Section
from tactiledata.report.plots import png_bytes

FEW = 3
"""Groups; of two, each is predicted by one alone."""


def shown_sentences(shown: HeldOutComparison) -> list[str]:
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


def _gained(shown: HeldOutComparison) -> list[str]:
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


def doubts(shown: HeldOutComparison) -> list[str]:
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


def _unclaimed(shown: HeldOutComparison) -> list[str]:
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


def _flattened(shown: HeldOutComparison) -> str:
    assert shown.flattened is not None
    before, after = shown.flattened
    first = before.words.split(" (p ")[0]
    now = after.change.words.removeprefix(f"{after.parameter} ")
    begin = "Once sloped, now flat" if after.p > LEVEL else "Sloped still"
    return f"{begin}: in the plain simulation {first}; with the effect it {now} ({p_words(after.p)})."


def _left_over(shown: HeldOutComparison) -> str:
    assert shown.left_over is not None
    if not shown.left_over.is_structured:
        return "With it no locator finds structure any more."
    return f"Structure is left with it. {shown.left_over.sentences()[0]}"


def _ceiling(shown: HeldOutComparison) -> str:
    errors = shown.of_trajectories
    if shown.ceiling_force >= errors.force.before:
        return "A black box, boosted trees on all covariates, finds nothing that helps on trajectories held out."
    reached, after = same_digits(shown.ceiling_force, errors.force.after)
    said = f"A black box, boosted trees on all covariates, reaches {reached} N on trajectories held out"
    return f"{said}, where the effect reaches {after} N." if shown.names else f"{said}."


MOST_PANELS = 6
MOST_EVENTS = 3
PLAIN, BLACK_BOX = "plain", "black box"


def better_section(shown: HeldOutComparison) -> Section:
    """Errors on what was held out, with noise and black box."""
    columns = ("unseen", "error", PLAIN, _after(shown), "noise alone", "gap closed")
    rows = [row for one in shown.errors for row in _rows(one, bool(shown.names))]
    text = (
        "Each is predicted by numbers fitted to the others; contact offset and zero are the trajectory's own. Force "
        "and torque: root mean square of a component, torque about the gel's origin. Paper's loss: the mean of the "
        "difference between the norms of measured and simulated force."
    )
    picture = Picture(png_bytes(draw_held_out(_panels(shown))), "Errors on what was held out.")
    return Section("How much better", [("info", text)], columns, rows, [picture])


def comparison_sections(
    naming: NamingResult, located: LocatorResults, shown: HeldOutComparison, heading: str = ""
) -> list[Section]:
    """Dependences, events, map and trajectories of a diagnosis, before and after.

    Parameters
    ----------
    naming : NamingResult
    located : LocatorResults
        Of the plain simulation.
    shown : HeldOutComparison
    heading : str
        Above the picture of trajectories: what kind of recordings they are.
    """
    found = [
        _dependences(located, shown),
        _events(located, shown),
        _map(located, shown),
        _overlays(naming, shown, heading),
    ]
    return [section for section in found if section is not None]


def _after(shown: HeldOutComparison) -> str:
    return "with it" if shown.names else "nearest candidate"


def _rows(one: HeldOutErrors, is_claimed: bool) -> list[tuple[str, ...]]:
    unseen = f"{one.groups} {one.unseen}"
    force = same_digits(one.force.before, one.force.after, one.force.floor)
    torque = same_digits(one.torque.before, one.torque.after, one.torque.floor)
    return [
        (unseen, "force, N", *force, gap_words(one.force, is_claimed and one.has_gap)),
        ("", "torque, N mm", *torque, gap_words(one.torque, is_claimed and one.has_torque_gap)),
        ("", "paper's loss, N", *same_digits(*one.paper), ""),
    ]


def _panels(shown: HeldOutComparison) -> list[ErrorPanel]:
    names = [one.unseen for one in shown.errors]
    nothing = [float("nan")] * len(names)
    after = _after(shown)

    def bars(before: list[float], with_it: list[float], box: list[float]) -> dict[str, Sequence[float]]:
        tried = {after: with_it} if shown.tried else {}
        return {PLAIN: before, **tried, BLACK_BOX: box}

    force, torque = [one.force for one in shown.errors], [one.torque for one in shown.errors]
    paper = [one.paper for one in shown.errors]
    box = [shown.ceiling_force, *nothing[1:]]
    return [
        ErrorPanel("force, N", names, bars([g.before for g in force], [g.after for g in force], box),
                   [g.floor for g in force]),
        ErrorPanel("torque, N mm", names, bars([g.before for g in torque], [g.after for g in torque], nothing),
                   [g.floor for g in torque]),
        ErrorPanel("paper's loss, N", names, bars([p[0] for p in paper], [p[1] for p in paper], nothing),
                   [p[2] for p in paper]),
    ]  # fmt: skip


def _dependences(located: LocatorResults, shown: HeldOutComparison) -> Section | None:
    covariates = located.projection.residuals.covariates
    drifts: list[Drift] = [shown.flattened[0]] if shown.flattened is not None else []
    for one in located.drifts:
        told = {(drift.parameter, name) for drift in drifts for name in (drift.covariate, *drift.alike)}
        if one.covariate in covariates and one.p <= LEVEL and (one.parameter, one.covariate) not in told:
            drifts.append(one)
    if not drifts:
        return None
    after = None if shown.left_over is None else shown.left_over.projection
    panels = [dependence_panel(located.projection, after, drift) for drift in drifts[:MOST_PANELS]]
    drawn = draw_dependences(panels, (PLAIN, _after(shown)))
    caption = "What each part of the data alone says of a parameter; bars are standard errors over trajectories."
    return Section("On what it depends", pictures=[Picture(png_bytes(drawn), caption)])


def _events(located: LocatorResults, shown: HeldOutComparison) -> Section | None:
    certain = sorted((one for one in located.events if one.p <= LEVEL), key=lambda one: one.p)[:MOST_EVENTS]
    if not certain:
        return None
    left = {one.event: one for one in shown.left_over.events} if shown.left_over is not None else {}
    pairs = [
        (
            event_picture(one, COMPONENTS, f", {PLAIN}"),
            event_picture(left[one.event], COMPONENTS, f", {_after(shown)}") if one.event in left else None,
        )
        for one in certain
    ]
    caption = "Means over trajectories, the mean before the event taken off; bands are two standard errors."
    return Section("About events", pictures=[Picture(png_bytes(draw_event_pairs(pairs)), caption)])


def _map(located: LocatorResults, shown: HeldOutComparison) -> Section | None:
    if not located.maps or located.maps[0].p > LEVEL:
        return None
    first = located.maps[0]
    pictures = [map_picture(first, f", {PLAIN}")]
    if shown.left_over is not None:
        same = [one for one in shown.left_over.maps if one.parameter == first.parameter]
        pictures += [map_picture(one, f", {_after(shown)}") for one in same]
    caption = "Departures over the gel; dots: outside the band of chance."
    return Section("Over the gel", [("", first.words)], pictures=[Picture(png_bytes(draw_map_pair(pictures)), caption)])


def _overlays(naming: NamingResult, shown: HeldOutComparison, heading: str) -> Section:
    white, errors = naming.whitened, shown.of_trajectories
    pictures = []
    for number in shown.worst():
        rows, case = white.trajectory == number, white.touch_set.touches[number]
        simulated = {PLAIN: errors.before[rows][:, FORCE]}
        if shown.names:
            simulated[_after(shown)] = errors.after[rows][:, FORCE]
        name = case.name or str(number)
        title = f"{name}, {white.touch_set.indenters[number]}: {errors.by_trajectory[number]:.2f} N"
        seconds = case.touch.seconds - case.touch.seconds[0]
        pictures.append(OverlayPicture(title, seconds, case.measured[:, FORCE], simulated))
    caption = "Gel frame; each trajectory predicted by numbers that were fitted to others."
    picture = Picture(png_bytes(draw_overlays(pictures), heading=heading), caption)
    return Section("Trajectories that the plain simulation tells worst", pictures=[picture])
