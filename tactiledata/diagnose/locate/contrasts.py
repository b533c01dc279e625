"""Contrasts: by how much components and parameters differ between parts of the data, beyond errors of the simulation.

Sign flips need no known noise, but an effect that differs from touch to touch inflates their standard errors. A
contrast is sharper where two things are known: the noise, and the standard deviation e of the contrast that errors of
the simulation cause where no physics is missing. A contrast of size s and noise variance v is then the standard normal
value s / sqrt(v + e^2), with the numerical discrepancy as a covariance of its own (Kennedy and O'Hagan, J. R. Statist.
Soc. B 63, 2001). It does not grow without bound with the number of touches, and is as sharp for one sensor, place or
indenter as for all data.
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
"""Largest p-value of a certain contrast."""
MOST = 3
"""Most contrasts that are listed."""
SHOWS = 0.25
"""Least share of a contrast's energy in a component for the sentence to name that component."""
DISTINCT = 1e-3
"""Least share of a contrast's information that must remain after the refit; with less it is not tested."""
MOST_CHANGE = 1.0
"""Largest relative change of a parameter: a larger decrease would change its sign, which is impossible."""
MOST_DEFICIT = 2.0 * np.log(20.0)
"""Largest deficit in squared z at which another covariate is still listed as an alternative (likelihood ratio 20)."""
IN_CONTACT = "in contact"
"""Name of the instrument that is 1 in all frames in contact."""
FROM = {"stays": "from {} on", "rises": "from {} on, more and more", "fades": "at {}, and it fades"}
"""Phrase of an event, by the shape of the departure."""


@dataclass(frozen=True)
class Contrast:
    """A component or parameter that differs along a covariate, between levels of a label, or from an event on.

    Parameters
    ----------
    what : str
        The component, direction (`Residuals.ways`) or parameter that differs.
    along : str
        The covariate, label or event; ``"in contact"`` where it differs in all frames in contact.
    size, half_width : float
        Size and half width of its 95 % interval: times the noise for components; for parameters a share of the value
        where it is known, else in the parameter's unit.
    value : float
        ``size`` over its standard deviation by noise and errors of the simulation, a standard normal value.
    p : float
        p-value over all contrasts, by Bonferroni.
    shares : dict, component -> float
        Share of the contrast's energy in each component after the refit; they sum to 1.
    words : str
        The contrast as a clause.
    alike : tuple of str
        Covariates and labels that are collinear with this one in these data.
    alternatives : tuple of str
        Further covariates, labels and events whose likelihood is at most 20 times smaller.
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
    alternatives: tuple[str, ...]


@dataclass(frozen=True)
class Instruments:
    """The c instruments along which components and parameters may differ; all are 0 outside contact.

    Parameters
    ----------
    columns : (n, c)
        Value of each instrument in each frame.
    names : tuple of c str
        Covariate, label or event of each instrument.
    places : tuple of c str
        Phrase of each instrument for sentences, such as ``"between depth 0.2 mm and 1.1 mm"``.
    """

    columns: Array
    names: tuple[str, ...]
    places: tuple[str, ...]


@dataclass(frozen=True)
class Sizes:
    """Sizes of all testable contrasts of one component or parameter.

    Parameters
    ----------
    what : str
        Name of the component, direction or parameter.
    direction : (n, k)
        Change of the whitened residual by a contrast of size 1.
    places : (c,)
        Index of each contrast's instrument in `Instruments`.
    size : (c,)
        Size of each contrast.
    variance : (c,)
        Variance of each size by noise alone.
    """

    what: str
    direction: Array
    places: NDArray[np.int64]
    size: Array
    variance: Array


def contrasts(
    projection: ProjectedResiduals, errors: Mapping[str, float], inflation: float = 1.0
) -> tuple[Contrast, ...]:
    """Return the strongest contrast, then those that are certain with all stronger ones fitted; at most three.

    Parameters
    ----------
    projection : ProjectedResiduals
        Residuals of n frames after the refit.
    errors : dict, name -> float
        Standard deviation that errors of the simulation cause in contrasts of each component, direction and parameter,
        in the unit of `Contrast.size`. What has no entry is not tested.
    inflation : float
        Factor on the variance of sums over neighbouring frames, because their noise is correlated.

    Raises
    ------
    TactileDataError
        There are too few units of exchange.
    """
    residuals = projection.residuals
    residuals.need_units("contrasts")
    instruments = instruments_of(residuals)
    alike = look_alikes(residuals)
    listed: list[Contrast] = []
    fields: dict[str, Array] = {}
    refitted = projection
    while len(listed) < MOST:
        strongest = _strongest(refitted, instruments, errors, inflation, alike)
        if strongest is None or (listed and strongest[0].p > LEVEL):
            break
        listed.append(strongest[0])
        if strongest[0].p > LEVEL:
            break
        fields[f"contrast {len(listed)}"] = strongest[1]
        refitted = project(residuals.with_fields(fields))
    return tuple(listed)


def sizes_of(
    projection: ProjectedResiduals, instruments: Instruments, tested: Mapping[str, float], inflation: float = 1.0
) -> Iterator[Sizes]:
    """Return sizes of all contrasts of the tested components and parameters, with their variance by noise alone.

    Parameters
    ----------
    projection : ProjectedResiduals
        Residuals of n frames after the refit.
    instruments : Instruments
        Along what components and parameters may differ.
    tested : dict
        Names of the components, directions and parameters that are tested; the values are not used.
    inflation : float
        Factor on the variance, because the noise of neighbouring frames is correlated.
    """
    for what, direction in _directions(projection.residuals):
        if what not in tested:
            continue
        scores = along(projection, direction, instruments.columns)
        alone = np.einsum("nk,nc->c", direction**2, instruments.columns**2)
        places = np.flatnonzero(scores.is_testable & (scores.information > DISTINCT * alone))
        yield Sizes(what, direction, places, scores.size[places], inflation / scores.information[places])


def instruments_of(residuals: Residuals) -> Instruments:
    """Return all instruments: contact, slopes over covariates, levels of labels, three shapes after each event."""
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
    """Return names and directions (n, k) of components, ways and tested parameters, in the unit of a contrast."""
    yield from directions_of(residuals)
    for place, parameter in enumerate(residuals.parameters):
        if parameter.is_tested:
            scale = parameter.value if np.isfinite(parameter.value) else 1.0
            yield parameter.name, residuals.slopes[:, :, place] * scale


def _strongest(
    projection: ProjectedResiduals,
    instruments: Instruments,
    errors: Mapping[str, float],
    inflation: float,
    alike: Mapping[str, tuple[str, ...]],
) -> tuple[Contrast, Array] | None:
    """Return the contrast with the largest standard normal value and its field (n, k); ``None`` where none is testable.

    Parameters
    ----------
    projection : ProjectedResiduals
        Residuals after the refit, with the contrasts found before as parameters.
    instruments : Instruments
        Along what components and parameters may differ.
    errors : dict, name -> float
        Standard deviation by errors of the simulation, as in `contrasts`.
    inflation : float
        Factor on the variance by noise.
    alike : dict, name -> names
        Collinear covariates and labels, as from `look_alikes`.
    """
    # the largest value over all directions and instruments
    best: tuple[float, Sizes, Array] | None = None
    tests = 0
    relative = {parameter.name for parameter in projection.residuals.parameters if np.isfinite(parameter.value)}
    for sizes in sizes_of(projection, instruments, errors, inflation):
        tests += len(sizes.places)
        values = np.abs(sizes.size) / np.sqrt(sizes.variance + errors[sizes.what] ** 2)
        if sizes.what in relative:
            values = np.where(np.abs(sizes.size) > MOST_CHANGE, 0.0, values)
        if len(values) and (best is None or values.max() > best[0]):
            best = float(values.max()), sizes, values
    if best is None:
        return None
    # its p-value, interval, shares and sentence
    value, sizes, values = best
    number = int(values.argmax())
    place = int(sizes.places[number])
    field = sizes.direction * instruments.columns[:, place, None]
    p = float(min(1.0, 2.0 * tests * norm.sf(value)))
    half_width = float(norm.ppf(0.975) * np.sqrt(sizes.variance[number] + errors[sizes.what] ** 2))
    name, size = instruments.names[place], float(sizes.size[number])
    shares, same = _shares(projection, field), alike.get(name, ())
    alternatives = _alternatives(instruments, sizes, values, {name, *same})
    words = f"{_clause(projection.residuals, sizes.what, size, half_width)} {instruments.places[place]} ({p_words(p)})"
    if sizes.what not in shares:
        words += f"; it shows in {joined_names([component for component, share in shares.items() if share > SHOWS])}"
    words += alike_words(name, same)
    if alternatives:
        words += f"; also explained by {joined_names(alternatives)}"
    signed = float(np.copysign(value, size))
    return Contrast(sizes.what, name, size, half_width, signed, p, shares, words, same, alternatives), field


def _alternatives(instruments: Instruments, sizes: Sizes, values: Array, known: set[str]) -> tuple[str, ...]:
    """Return names of instruments that fit the direction nearly as well as the known ones, the best first."""
    order = np.argsort(-values)
    close = order[values[order] ** 2 >= values.max() ** 2 - MOST_DEFICIT]
    names = dict.fromkeys(instruments.names[int(place)] for place in sizes.places[close])
    return tuple(name for name in names if name not in known)


def _shares(projection: ProjectedResiduals, field: Array) -> dict[str, float]:
    """Return the share of the energy of a field (n, k) in each component, after all parameters are refitted."""
    left = projection.orthogonal(field[:, :, None])
    energy = np.maximum((left * projection.weigh(left)).sum(axis=(0, 2)), 0.0)
    return {
        name: float(part / max(energy.sum(), 1e-300))
        for name, part in zip(projection.residuals.components, energy, strict=True)
    }


def _clause(residuals: Residuals, what: str, size: float, half_width: float) -> str:
    """Return a clause on the size of a contrast: a departure of a component, or a change of a parameter."""
    parameters = {parameter.name: parameter for parameter in residuals.parameters}
    if what not in parameters:
        return departs(what, size, half_width, residuals.scale)
    parameter = parameters[what]
    if np.isfinite(parameter.value):
        return signed_change(what, 100.0 * size, 100.0 * half_width, "%")
    return signed_change(what, size, half_width, parameter.unit)
