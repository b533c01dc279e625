"""Parts that pages of a diagnosis share: what locators found, dependences, events and maps, ready to be drawn."""

from __future__ import annotations

import numpy as np

from tactiledata.diagnose.dependence import dependence
from tactiledata.diagnose.event_locked import EventLocked
from tactiledata.diagnose.findings import findings
from tactiledata.diagnose.instability import Drift
from tactiledata.diagnose.ladder import is_logarithmic
from tactiledata.diagnose.locate import LEVEL, Located
from tactiledata.diagnose.projection import Projection
from tactiledata.diagnose.region import RegionMap
from tactiledata.diagnose.wording import p_text
from tactiledata.report.diagnosis_plots import Dependence, EventPicture, MapPicture, draw_shares
from tactiledata.report.page import Picture, Section
from tactiledata.report.plots import png_bytes

MOST_BARS = 24


def locators_section(located: Located, most: int = 10) -> Section:
    """p-values of all locators, and at most so many findings of each."""
    rows = [(name, p_text(p), "yes" if p <= LEVEL else "no") for name, p in located.p.items()]
    said = [("", f"{one['locator']}: {one['words']}") for one in findings(located, most)]
    text = (
        "p-values of the table hold for all locators together: where nothing is missing, one page in twenty says yes "
        "anywhere. Those of single findings hold within their locator; a finding may be the echo of another, which the "
        "sentences at the top leave out."
    )
    return Section("Where they differ", [("info", text), *said], ("locator", "p", "certain"), rows)


def shares_section(located: Located) -> Section | None:
    """Where the squares of the residual sit; ``None`` where there is no excess."""
    cells = sorted(located.energy.cells, key=lambda cell: cell.of_values - cell.share)[:MOST_BARS]
    if not cells:
        return None
    drawn = draw_shares([c.words for c in cells], [min(c.share, 1.0) for c in cells], [c.of_values for c in cells])
    picture = Picture(png_bytes(drawn), "Shares of the squared residual; ticks show an even spread.")
    return Section("Where the squares sit", [("", located.energy.words)], pictures=[picture])


def dependence_panel(projection: Projection, after: Projection | None, drift: Drift) -> Dependence:
    """Bins of a drift's covariate before and, where it is known, after."""
    residuals = projection.residuals
    covariate = residuals.covariates[drift.covariate]
    scale, unit = 1.0, drift.change.parameter.unit
    if drift.change.is_relative:
        scale, unit = 100.0 / abs(drift.change.parameter.value), "%"
    one = dependence(projection, drift.parameter, drift.covariate)
    other = None if after is None else dependence(after, drift.parameter, drift.covariate)
    return Dependence(
        drift.parameter if unit in ("", "1") else f"{drift.parameter}, {unit}",
        drift.covariate if covariate.unit in ("", "1") else f"{drift.covariate}, {covariate.unit}",
        is_logarithmic(covariate.values),
        one.places,
        scale * one.departures,
        scale * one.errors,
        # its bins are its own: drawn where those before are
        None if other is None else scale * np.interp(one.places, other.places, other.departures),
        None if other is None else scale * np.interp(one.places, other.places, other.errors),
    )


def event_picture(
    one: EventLocked, components: tuple[str, ...], note: str = "", scale: str = "times the noise"
) -> EventPicture:
    """Means about an event."""
    return EventPicture(f"{one.event}{note}", one.frames, one.mean, one.deviation, components, scale)


def map_picture(one: RegionMap, note: str = "") -> MapPicture:
    """A map; departures in per cent where the parameter's value is known."""
    parameter, scale, unit = one.change.parameter, 1.0, one.change.parameter.unit
    if one.change.is_relative:
        scale, unit = 100.0 / abs(parameter.value), "%"
    return MapPicture(
        f"{one.parameter}{note}", f"x, {one.unit}", f"y, {one.unit}", unit, one.x, one.y, scale * one.departure,
        np.abs(one.statistic) > one.band,
    )  # fmt: skip
