"""Parts of a page: how much better the simulation is with an effect, and where."""

from __future__ import annotations

from collections.abc import Sequence

from tactiledata.diagnose.case_residuals import COMPONENTS
from tactiledata.diagnose.gap_words import gap_words
from tactiledata.diagnose.held_out_errors import FORCE, HeldOutErrors
from tactiledata.diagnose.instability import Drift
from tactiledata.diagnose.locate import LEVEL, Located
from tactiledata.diagnose.name_effects import Naming
from tactiledata.diagnose.page_parts import dependence_panel, event_picture, map_picture
from tactiledata.diagnose.show import Shown
from tactiledata.diagnose.shown_words import same_digits
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

MOST_PANELS = 6
MOST_EVENTS = 3
PLAIN, BLACK_BOX = "plain", "black box"


def better_section(shown: Shown) -> Section:
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


def comparison_sections(naming: Naming, located: Located, shown: Shown, heading: str = "") -> list[Section]:
    """Dependences, events, map and trajectories of a diagnosis, before and after.

    Parameters
    ----------
    naming : Naming
    located : Located
        Of the plain simulation.
    shown : Shown
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


def _after(shown: Shown) -> str:
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


def _panels(shown: Shown) -> list[ErrorPanel]:
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


def _dependences(located: Located, shown: Shown) -> Section | None:
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


def _events(located: Located, shown: Shown) -> Section | None:
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


def _map(located: Located, shown: Shown) -> Section | None:
    if not located.maps or located.maps[0].p > LEVEL:
        return None
    first = located.maps[0]
    pictures = [map_picture(first, f", {PLAIN}")]
    if shown.left_over is not None:
        same = [one for one in shown.left_over.maps if one.parameter == first.parameter]
        pictures += [map_picture(one, f", {_after(shown)}") for one in same]
    caption = "Departures over the gel; dots: outside the band of chance."
    return Section("Over the gel", [("", first.words)], pictures=[Picture(png_bytes(draw_map_pair(pictures)), caption)])


def _overlays(naming: Naming, shown: Shown, heading: str) -> Section:
    white, errors = naming.cases, shown.of_trajectories
    pictures = []
    for number in shown.worst():
        rows, case = white.trajectory == number, white.cases.cases[number]
        simulated = {PLAIN: errors.before[rows][:, FORCE]}
        if shown.names:
            simulated[_after(shown)] = errors.after[rows][:, FORCE]
        name = case.name or str(number)
        title = f"{name}, {white.cases.indenters[number]}: {errors.by_trajectory[number]:.2f} N"
        seconds = case.touch.seconds - case.touch.seconds[0]
        pictures.append(OverlayPicture(title, seconds, case.measured[:, FORCE], simulated))
    caption = "Gel frame; each trajectory predicted by numbers that were fitted to others."
    picture = Picture(png_bytes(draw_overlays(pictures), heading=heading), caption)
    return Section("Trajectories that the plain simulation tells worst", pictures=[picture])
