"""Sentences, tables and pictures on how much better the simulation is on held-out data."""

from __future__ import annotations

import math
from collections.abc import Sequence

from tactiledata.diagnose.answer.locator_rows import (
    DEPENDENCE_CAPTION,
    MAP_CAPTION,
    dependence_panel,
    event_picture,
    map_picture,
)
from tactiledata.diagnose.locate.drifts import Drift
from tactiledata.diagnose.locate.locate import LEVEL, LocatorResults
from tactiledata.diagnose.naming.name_effects import NamingResult
from tactiledata.diagnose.naming.thresholds import DEFAULT_THRESHOLDS
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
from tactiledata.report.panels import panels_of

FEW = 3
"""Fewest groups whose rise of the error counts as it is: of two, each is predicted from one alone."""


def shown_sentences(shown: HeldOutComparison) -> list[str]:
    """Return sentences on how much better the simulation is on data that had no part in the fit.

    In this order: the errors of force and torque with and without the claimed effects (or that none is claimed), the
    strongest drift of a parameter before and after, what locators still find, how much a black box (boosted trees)
    could explain, and errors of the simulation that the plain fit makes unusually large.
    """
    sentences = _gained(shown) if shown.names else _unclaimed(shown)
    if shown.flattened is not None:
        sentences.append(_flattened(shown))
    if shown.left_over is not None:
        sentences.append(_left_over(shown))
    sentences.append(_ceiling(shown))
    if shown.stretched:
        listed = [f"{name} ({rounded(abs(size))} times the usual)" for name, size in shown.stretched.items()]
        sentences.append(
            f"The plain fit needs unusually large errors of the simulation itself: {joined_names(listed)}. A wrong "
            "radius, a wrong thickness or an effect may be the cause."
        )
    return sentences


def same_digits(*values: float, digits: int = 2) -> tuple[str, ...]:
    """Return numbers as texts, all with as many decimals as the smallest needs for ``digits`` significant ones."""
    least = min((abs(value) for value in values if value), default=1.0)
    places = min(max(0, digits - 1 - math.floor(math.log10(least))), 4)
    return tuple(f"{value:.{places}f}" for value in values)


def _gained(shown: HeldOutComparison) -> list[str]:
    """Return sentences on the errors that the claimed effects change."""
    # trajectories, beside the noise
    first = shown.of_trajectories
    noise = f"Noise alone leaves {same_digits(first.force.floor, digits=3)[0]} N"
    closes = f": {change_words(first.force)}" if first.has_gap else ", so there was hardly a gap to close"
    below = " The error is then below the noise that free air shows."
    is_below = first.has_gap and first.force.interval[0] > 1.0
    sentences = [
        f"On held-out {first.unseen} the force error {_changes(first)}. {noise}{closes}.{below if is_below else ''}"
    ]
    # the hardest of what was held out
    hardest = shown.hardest
    if hardest is not first:
        others = "in turn predicted from the others" if hardest.groups >= FEW else "predicted from the other alone"
        closes = f": {change_words(hardest.force)}" if hardest.has_gap else ""
        of_groups = f"On {hardest.groups} held-out {hardest.unseen}, each {others}"
        sentences.append(f"{of_groups}, the error {_changes(hardest)}{closes}.")
    if any(_rises(errors) for errors in (first, hardest)):
        sentences.append("An error that rises speaks against the claim.")
    return sentences


def doubts(shown: HeldOutComparison) -> list[str]:
    """Return a sentence on what speaks against a claim; nothing where nothing does, or nothing is claimed."""
    if not shown.names:
        return []
    against = [f"the error rises on held-out {errors.unseen}" for errors in shown.errors if _rises(errors)]
    if shown.left_over is not None and shown.left_over.is_structured:
        against.append("structure is left")
    return [f"Take this claim with care: {joined_names(against)}."] if against else []


def _rises(errors: HeldOutErrors) -> bool:
    """Return whether the force error rises; with few groups, only where its bootstrap interval excludes a fall."""
    return errors.change > 0 and (errors.groups >= FEW or (errors.has_gap and errors.force.interval[1] < 0))


def _changes(errors: HeldOutErrors) -> str:
    """Return the change of the force error, as ``"falls from 0.128 to 0.092 N"``."""
    before, after = same_digits(errors.force.before, errors.force.after, digits=3)
    return f"{'rises' if errors.change > 0 else 'falls'} from {before} to {after} N"


def _unclaimed(shown: HeldOutComparison) -> list[str]:
    """Return sentences on the error of the plain simulation, and on what the nearest candidate would change."""
    errors = shown.of_trajectories
    before, floor = same_digits(errors.force.before, errors.force.floor)
    sentences = [
        f"On held-out trajectories the force error of the plain simulation is {before} N. Noise alone leaves {floor} N."
    ]
    if shown.tried:
        titles = joined_names([EFFECTS[name]().title for name in shown.tried])
        changes = [f"{_signed_percent(errors.change)} on {errors.unseen}" for errors in shown.errors]
        sentences.append(f"The nearest candidate, {titles}, would change this error by {joined_names(changes)}.")
    return sentences


def _signed_percent(share: float) -> str:
    """Return a share in per cent with its sign, as ``"+1.2 %"``."""
    return f"{100 * share:+.1f} %".replace("-", "−")


def _flattened(shown: HeldOutComparison) -> str:
    """Return the strongest dependence of the plain simulation, and what the effect leaves of it."""
    assert shown.flattened is not None
    before, after = shown.flattened
    first = before.words.split(" (p ")[0]
    begin = "A dependence is gone" if after.p > LEVEL else "A dependence remains"
    return f"{begin}: in the plain simulation {first}; with the effect {after.change.words} ({p_words(after.p)})."


def _left_over(shown: HeldOutComparison) -> str:
    """Return whether locators still find structure with the effect, and the plainest finding."""
    assert shown.left_over is not None
    if not shown.left_over.is_structured:
        return "With the effect, no locator finds structure any more."
    return f"With the effect, structure is left. {shown.left_over.sentences()[0]}"


def _ceiling(shown: HeldOutComparison) -> str:
    """Return the force error that a black box reaches, beside that of the effect."""
    errors = shown.of_trajectories
    if shown.ceiling_force >= errors.force.before:
        return "A black box, boosted trees on all covariates, improves nothing on held-out trajectories."
    reached, after = same_digits(shown.ceiling_force, errors.force.after)
    box = f"A black box, boosted trees on all covariates, reaches {reached} N on held-out trajectories"
    return f"{box}; the effect reaches {after} N." if shown.names else f"{box}."


MOST_PANELS = 6
"""Most dependences that are drawn."""
MOST_EVENTS = 3
"""Most events that are drawn."""
PLAIN, WITH_EFFECT, BLACK_BOX = "plain", "with the effect", "black box"


def better_section(shown: HeldOutComparison) -> Section:
    """Return the section with the held-out errors beside noise and black box."""
    columns = ("unseen", "error", PLAIN, _after(shown), "noise alone", "gap closed")
    rows = [row for errors in shown.errors for row in _rows(errors, bool(shown.names))]
    text = (
        "Each group is predicted by numbers that were fitted to the others; contact offset and zero are the "
        "trajectory's own. Force and torque are root mean squares of a component, torque about the gel's origin. "
        "The paper's loss is the mean difference between the norms of measured and simulated force. Noise alone gives "
        "the noise floor: the error that noise leaves to a perfect simulation. The gap is the plain error less this."
    )
    picture = panels_of(draw_held_out(_panels(shown)), "Errors on what was held out.")
    return Section("How much better", [("info", text)], columns, rows, [picture])


def comparison_sections(naming: NamingResult, located: LocatorResults, shown: HeldOutComparison) -> list[Section]:
    """Return the sections with dependences, events, map and trajectories, before and after.

    Parameters
    ----------
    naming : NamingResult
    located : LocatorResults
        Results of the locators on the plain simulation.
    shown : HeldOutComparison
    """
    sections = [
        _dependences(located, shown),
        _events(located, shown),
        _map(located, shown),
        _overlays(naming, shown),
    ]
    return [section for section in sections if section is not None]


def _after(shown: HeldOutComparison) -> str:
    """Return what the simulation with effects is called in tables and pictures."""
    return WITH_EFFECT if shown.names else "nearest candidate"


def _rows(errors: HeldOutErrors, is_claimed: bool) -> list[tuple[str, ...]]:
    """Return the rows of force, torque and the paper's loss for one kind of held-out data."""
    unseen = f"{errors.groups} {errors.unseen}"
    force = same_digits(errors.force.before, errors.force.after, errors.force.floor)
    torque = same_digits(errors.torque.before, errors.torque.after, errors.torque.floor)
    return [
        (unseen, "force, N", *force, gap_words(errors.force, is_claimed and errors.has_gap)),
        ("", "torque, N mm", *torque, gap_words(errors.torque, is_claimed and errors.has_torque_gap)),
        ("", "paper's loss, N", *same_digits(*errors.paper), ""),
    ]


def _panels(shown: HeldOutComparison) -> list[ErrorPanel]:
    """Return the panels of force, torque and the paper's loss; a black box is shown on held-out trajectories only."""
    names = [errors.unseen for errors in shown.errors]
    nothing = [float("nan")] * len(names)
    after = _after(shown)

    def bars(before: list[float], with_it: list[float], box: list[float]) -> dict[str, Sequence[float]]:
        tried = {after: with_it} if shown.tried else {}
        return {PLAIN: before, **tried, BLACK_BOX: box}

    force, torque = [errors.force for errors in shown.errors], [errors.torque for errors in shown.errors]
    paper = [errors.paper for errors in shown.errors]
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
    """Return the section with the certain dependences on covariates, without those that repeat another."""
    covariates = located.projection.residuals.covariates
    drawn_drifts: list[Drift] = [shown.flattened[0]] if shown.flattened is not None else []
    for drift in located.drifts:
        drawn_pairs = {(drawn.parameter, name) for drawn in drawn_drifts for name in (drawn.covariate, *drawn.alike)}
        is_new = (drift.parameter, drift.covariate) not in drawn_pairs
        if drift.covariate in covariates and drift.p <= LEVEL and is_new:
            drawn_drifts.append(drift)
    if not drawn_drifts:
        return None
    after = None if shown.left_over is None else shown.left_over.projection
    panels = [dependence_panel(located.projection, after, drift) for drift in drawn_drifts[:MOST_PANELS]]
    drawn = draw_dependences(panels, (PLAIN, _after(shown)))
    return Section("On what the difference depends", pictures=[panels_of(drawn, DEPENDENCE_CAPTION)])


def _events(located: LocatorResults, shown: HeldOutComparison) -> Section | None:
    """Return the section with the mean residual about the most certain events."""
    certain = sorted((event for event in located.events if event.p <= LEVEL), key=lambda event: event.p)[:MOST_EVENTS]
    if not certain:
        return None
    left = {event.event: event for event in shown.left_over.events} if shown.left_over is not None else {}
    pairs = [
        (
            event_picture(event, COMPONENTS, f", {PLAIN}"),
            event_picture(left[event.event], COMPONENTS, f", {_after(shown)}") if event.event in left else None,
        )
        for event in certain
    ]
    caption = "Means over trajectories, less the mean before the event; bands are two standard errors."
    return Section("About events", pictures=[panels_of(draw_event_pairs(pairs), caption)])


def _map(located: LocatorResults, shown: HeldOutComparison) -> Section | None:
    """Return the section with the map of departures over the gel; ``None`` where it is not certain."""
    if not located.maps or located.maps[0].p > LEVEL:
        return None
    first = located.maps[0]
    pictures = [map_picture(first, f", {PLAIN}")]
    if shown.left_over is not None:
        same = [region for region in shown.left_over.maps if region.parameter == first.parameter]
        pictures += [map_picture(region, f", {_after(shown)}") for region in same]
    return Section("Over the gel", [("", first.words)], pictures=[panels_of(draw_map_pair(pictures), MAP_CAPTION)])


def worst_picture(naming: NamingResult, shown: HeldOutComparison) -> Picture:
    """Return the picture of the trajectory with the largest error: measured, and simulated without and with effects.

    Parameters
    ----------
    naming : NamingResult
    shown : HeldOutComparison
    """
    with_it = (
        f", and with {joined_names([EFFECTS[name]().title for name in shown.names])} (solid)" if shown.names else ""
    )
    caption = (
        "The trajectory with the largest error of the plain simulation. Dots are measured, lines are simulated: plain "
        f"(dashed){with_it}. It is predicted by numbers that were fitted to other trajectories."
    )
    drawn = draw_overlays([_overlay(naming, shown, shown.worst(1)[0])])
    return panels_of(drawn, caption)


def _overlays(naming: NamingResult, shown: HeldOutComparison) -> Section:
    """Return the section with the forces of the worst trajectories, and of those that keep what the best fit leaves."""
    left, worst = naming.decision.left, shown.worst()
    in_few = [name for name in left.worst_two if name] if left.is_in_few(DEFAULT_THRESHOLDS) else []
    named = [number for number, case in enumerate(naming.whitened.touch_set.touches) if case.name in in_few]
    pictures = [_overlay(naming, shown, number) for number in dict.fromkeys([*worst, *named])]
    caption = (
        "Contact force over time, gel frame, where the plain simulation errs most. Dots are measured, lines are "
        "simulated. Each trajectory is predicted by numbers that were fitted to others."
    )
    if in_few:
        caption += f" {joined_names(in_few)} hold nearly all that the best fit leaves."
    picture = panels_of(draw_overlays(pictures), caption)
    return Section("Measured and simulated forces of single trajectories", pictures=[picture])


def _overlay(naming: NamingResult, shown: HeldOutComparison, number: int) -> OverlayPicture:
    """Return the measured and simulated forces of a trajectory, predicted by numbers that were fitted to others."""
    white, errors = naming.whitened, shown.of_trajectories
    rows, case = white.trajectory == number, white.touch_set.touches[number]
    simulated = {PLAIN: errors.before[rows][:, FORCE]}
    if shown.names:
        simulated[_after(shown)] = errors.after[rows][:, FORCE]
    name = case.name or str(number)
    title = f"{name}, {white.touch_set.indenters[number]}: error {errors.by_trajectory[number]:.2f} N"
    seconds = case.touch.seconds - case.touch.seconds[0]
    return OverlayPicture(title, seconds, case.measured[:, FORCE], simulated)
