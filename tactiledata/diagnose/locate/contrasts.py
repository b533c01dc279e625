"""By how much components and parameters differ between parts of the data, beyond what a simulation may be off.

Signs of trajectories thrown anew need no size of the noise, but an effect that differs from touch to touch raises their
own standard errors. Where noise is known, and how much the simulation's own errors make contrasts scatter on worlds
that hide nothing, a contrast of size s and variance v of the noise is a normal value s / sqrt(v + e^2): the numerical
discrepancy as a covariance of its own (Kennedy and O'Hagan, J. R. Statist. Soc. B 63, 2001). It does not grow without
bound with the number of touches, and is as sharp for one sensor, place or indenter as for all data.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm

from tactiledata.arrays import Array
from tactiledata.diagnose.locate.drifts import alike_words, look_alikes
from tactiledata.diagnose.locate.event_effects import SHAPES, directions_of, shapes_after
from tactiledata.diagnose.locate.events import find_events
from tactiledata.diagnose.locate.free_air import in_contact
from tactiledata.diagnose.residuals.instruments import levels, slope
from tactiledata.diagnose.residuals.projection import ProjectedResiduals, project
from tactiledata.diagnose.residuals.residuals import Residuals, joined_names
from tactiledata.diagnose.residuals.scores import along
from tactiledata.diagnose.residuals.slopes import over
from tactiledata.diagnose.residuals.wording import departs, p_words, signed_change

LEVEL = 0.05
MOST = 3
SHOWS = 0.25
"""Share of a contrast's energy from which on it is said to show in a component."""
DISTINCT = 1e-3
"""Share of a contrast that must be left beside all that is refitted."""
MOST_CHANGE = 1.0
"""Share of itself by which a parameter may differ: one that falls by more has changed its sign, which none may."""
NEARLY = 2.0 * np.log(20.0)
"""What squared values may be behind: another covariate is then less than twenty times less likely."""
IN_CONTACT = "in contact"
FROM = {"stays": "from {} on", "rises": "from {} on, more and more", "fades": "at {}, and it fades"}


@dataclass(frozen=True)
class Contrast:
    """A component, or a parameter, that differs along a covariate, a label or from an event on.

    Parameters
    ----------
    what : str
        A component, a way of trajectories (`Residuals.ways`) or a parameter.
    along : str
        The covariate, label or event; ``"in contact"`` where it differs all along.
    size, half_width : float
        Times the noise for components; for parameters a share of the value where it has one, else in its unit.
    value : float
        ``size`` over its standard deviation by noise and simulation: as a standard normal value.
    p : float
        For all contrasts together, by Bonferroni.
    shares : dict, component -> float
        Where its energy is, beside all that is refitted; they sum to 1.
    words : str
    alike : names of covariates that cannot be told from this one in these data
    near : names of others along which it is told nearly as well
    """

    what: str
    along: str
    size: float
    half_width: float
    value: float
    p: float
    shares: Mapping[str, float]
    words: str
    alike: tuple[str, ...]
    near: tuple[str, ...]


@dataclass(frozen=True)
class Instruments:
    """Columns (n, c) along which something may differ, 0 before contact.

    Parameters
    ----------
    columns : (n, c)
    names : covariate, label or event of each
    places : what to say of each
    """

    columns: Array
    names: tuple[str, ...]
    places: tuple[str, ...]


@dataclass(frozen=True)
class Sizes:
    """Of all contrasts of one direction that can be told, by the place of their instrument.

    Parameters
    ----------
    what : str
    direction : (n, k)
        Change by a size of 1.
    places : (c,)
    size, variance : (c,)
        Of the noise alone.
    """

    what: str
    direction: Array
    places: NDArray[np.int64]
    size: Array
    variance: Array


def contrasts(
    projection: ProjectedResiduals, errors: Mapping[str, float], inflation: float = 1.0
) -> tuple[Contrast, ...]:
    """The strongest contrast, then the strongest that is certain with the first one fitted, and so on; at most three.

    Parameters
    ----------
    errors : dict, name -> standard deviation
        By how much the simulation's own errors let each component, way and parameter differ, in the unit of `Contrast`;
        what has none is not asked.
    inflation : float
        Of the variance of sums over neighbouring frames, by the noise's memory.

    Raises
    ------
    TactileDataError
        Too few units of exchange.
    """
    residuals = projection.residuals
    residuals.need_units("contrasts")
    instruments = instruments_of(residuals)
    alike = look_alikes(residuals)
    found: list[Contrast] = []
    fields: dict[str, Array] = {}
    now = projection
    while len(found) < MOST:
        strongest = _strongest(now, instruments, errors, inflation, alike)
        if strongest is None or (found and strongest[0].p > LEVEL):
            break
        found.append(strongest[0])
        if strongest[0].p > LEVEL:
            break
        fields[f"contrast {len(found)}"] = strongest[1]
        now = project(residuals.with_fields(fields))
    return tuple(found)


def sizes_of(
    projection: ProjectedResiduals, instruments: Instruments, asked: Mapping[str, float], inflation: float = 1.0
) -> Iterator[Sizes]:
    """Sizes of all contrasts of what is asked, and how noise lets them scatter."""
    for what, direction in _directions(projection.residuals):
        if what not in asked:
            continue
        found = along(projection, direction, instruments.columns)
        alone = np.einsum("nk,nc->c", direction**2, instruments.columns**2)
        places = np.flatnonzero(found.is_testable & (found.information > DISTINCT * alone))
        yield Sizes(what, direction, places, found.size[places], inflation / found.information[places])


def instruments_of(residuals: Residuals) -> Instruments:
    """All along, the slope over each covariate, each level of a label, three shapes from each event on."""
    touches = in_contact(residuals).astype(float)
    columns, names, places = [touches[:, None]], [IN_CONTACT], [IN_CONTACT]
    for name, covariate in residuals.covariates.items():
        instrument, low, high = slope(covariate.values, touches)
        columns.append(instrument)
        names.append(name)
        places.append(over(name, low, high, covariate.unit))
    for name, texts in residuals.labels.items():
        kept, instrument = levels(texts)
        columns.append(instrument)
        names += [name] * len(kept)
        places += [f"at {name} {level}, against all others" for level in kept]
    for event in find_events(residuals):
        columns.append(shapes_after(residuals, event))
        names += [event.name] * len(SHAPES)
        places += [FROM[shape].format(event.name) for shape in SHAPES]
    return Instruments(np.concatenate(columns, axis=1) * touches[:, None], tuple(names), tuple(places))


def _directions(residuals: Residuals) -> Iterator[tuple[str, Array]]:
    """Names and directions (n, k) of components, ways and parameters, in the unit of a contrast's size."""
    yield from directions_of(residuals)
    for place, one in enumerate(residuals.parameters):
        if one.is_tested:
            scale = one.value if np.isfinite(one.value) else 1.0
            yield one.name, residuals.slopes[:, :, place] * scale


def _strongest(
    projection: ProjectedResiduals,
    instruments: Instruments,
    errors: Mapping[str, float],
    inflation: float,
    alike: Mapping[str, tuple[str, ...]],
) -> tuple[Contrast, Array] | None:
    """It, and its field (n, k)."""
    best: tuple[float, Sizes, Array] | None = None
    asked = 0
    relative = {one.name for one in projection.residuals.parameters if np.isfinite(one.value)}
    for sizes in sizes_of(projection, instruments, errors, inflation):
        asked += len(sizes.places)
        values = np.abs(sizes.size) / np.sqrt(sizes.variance + errors[sizes.what] ** 2)
        if sizes.what in relative:
            values = np.where(np.abs(sizes.size) > MOST_CHANGE, 0.0, values)
        if len(values) and (best is None or values.max() > best[0]):
            best = float(values.max()), sizes, values
    if best is None:
        return None
    value, sizes, values = best
    number = int(values.argmax())
    place = int(sizes.places[number])
    field = sizes.direction * instruments.columns[:, place, None]
    p = float(min(1.0, 2.0 * asked * norm.sf(value)))
    half_width = float(norm.ppf(0.975) * np.sqrt(sizes.variance[number] + errors[sizes.what] ** 2))
    name, size = instruments.names[place], float(sizes.size[number])
    shares, same = _shares(projection, field), alike.get(name, ())
    near = _near(instruments, sizes, values, {name, *same})
    words = f"{_said(projection.residuals, sizes.what, size, half_width)} {instruments.places[place]} ({p_words(p)})"
    if sizes.what not in shares:
        words += f"; it shows in {joined_names([one for one, share in shares.items() if share > SHOWS])}"
    words += alike_words(name, same)
    if near:
        words += f"; it is told nearly as well by {joined_names(near)}"
    signed = float(np.copysign(value, size))
    return Contrast(sizes.what, name, size, half_width, signed, p, shares, words, same, near), field


def _near(instruments: Instruments, sizes: Sizes, values: Array, known: set[str]) -> tuple[str, ...]:
    """Names along which the same direction is told nearly as well, the best first."""
    order = np.argsort(-values)
    enough = order[values[order] ** 2 >= values.max() ** 2 - NEARLY]
    names = dict.fromkeys(instruments.names[int(place)] for place in sizes.places[enough])
    return tuple(name for name in names if name not in known)


def _shares(projection: ProjectedResiduals, field: Array) -> dict[str, float]:
    """Of the energy of a field (n, k) beside all that is refitted, in each component."""
    left = projection.orthogonal(field[:, :, None])
    energy = np.maximum((left * projection.weigh(left)).sum(axis=(0, 2)), 0.0)
    return {
        name: float(one / max(energy.sum(), 1e-300))
        for name, one in zip(projection.residuals.components, energy, strict=True)
    }


def _said(residuals: Residuals, what: str, size: float, half_width: float) -> str:
    of_parameter = {one.name: one for one in residuals.parameters}
    if what not in of_parameter:
        return departs(what, size, half_width, residuals.scale)
    one = of_parameter[what]
    if np.isfinite(one.value):
        return signed_change(what, 100.0 * size, 100.0 * half_width, "%")
    return signed_change(what, size, half_width, one.unit)
