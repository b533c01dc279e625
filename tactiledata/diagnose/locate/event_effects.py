"""Departures that begin at an event and that no parameter can imitate, with the event that explains each best.

After a calibration has absorbed part of an effect, the rest shows at every event. A departure that begins at one event
and stays, rises or fades is therefore fitted together with all parameters, and the events are compared.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.locate.base import Locator, LocatorInput
from tactiledata.diagnose.locate.events import Events
from tactiledata.diagnose.residuals.projection import ProjectedResiduals
from tactiledata.diagnose.residuals.residuals import Residuals
from tactiledata.diagnose.residuals.scores import along
from tactiledata.diagnose.residuals.sign_flips import DRAWS, family_wise, signs
from tactiledata.diagnose.residuals.wording import departs, p_words

SHAPES = ("stays", "rises", "fades")
"""Shapes of a departure after an event: constant, saturating, decaying."""
GOES_ON = {"stays": "this stays", "rises": "this grows", "fades": "this fades"}
"""Clause for each shape."""
FRAMES = 2.0
"""Time constant in frames with which a departure rises or fades."""


@dataclass(frozen=True)
class EventEffect:
    """A departure of one component that begins at one kind of event.

    Parameters
    ----------
    event, component : str
        Names of the event and of the component or direction (`Residuals.ways`).
    shape : "stays", "rises" or "fades"
        Shape of the departure with the largest statistic.
    size : float
        Size of the departure, in the unit that `Residuals.scale` names.
    statistic : float
        Size over standard error, as a standard normal value.
    p : float
        Family-wise p-value over all events, components and shapes.
    words : str
        The departure as a clause.
    """

    event: str
    component: str
    shape: str
    size: float
    statistic: float
    p: float
    words: str


def event_effects(
    projection: ProjectedResiduals, events: Sequence[Events], seed: int = 0, draws: int = DRAWS
) -> tuple[EventEffect, ...]:
    """Return the departure of every component after every kind of event, with its best shape; the most certain first.

    Parameters
    ----------
    projection : ProjectedResiduals
        Residuals after the refit.
    events : sequence of Events
        Kinds of events that are compared.
    seed : int
        Random seed of the sign flips.
    draws : int
        Number of sign flips.

    Raises
    ------
    TactileDataError
        There are too few units of exchange.
    """
    residuals = projection.residuals
    residuals.need_units("departures from events on")
    if not events:
        return ()
    # of three shapes of each event and component the largest statistic counts, in the data and after each flip
    instruments = np.concatenate([shapes_after(residuals, kind) for kind in events], axis=1)
    flips = signs(residuals.unit_count, draws, seed)
    pairs: list[tuple[str, str, str, float, float]] = []
    observed, drawn = [], []
    for component, direction in directions_of(residuals):
        scores = along(projection, direction, instruments)
        statistics, sizes = scores.statistic, scores.size
        flipped = np.abs(scores.flipped(flips)).reshape(draws, len(events), len(SHAPES)).max(axis=2)
        for number, event in enumerate(events):
            first = number * len(SHAPES)
            shape_index = int(np.abs(statistics[first : first + len(SHAPES)]).argmax())
            best = first + shape_index
            pairs.append((event.name, component, SHAPES[shape_index], float(sizes[best]), float(statistics[best])))
            observed.append(abs(float(statistics[best])))
            drawn.append(flipped[:, number])
    # family-wise p-values and clauses
    p_values = family_wise(np.array(observed), np.stack(drawn, axis=1))
    effects = []
    for (event_name, component, shape, size, statistic), p in zip(pairs, p_values, strict=True):
        departure = departs(component, size, 0.0, residuals.scale)
        words = f"{departure} from {event_name} on, and {GOES_ON[shape]} ({p_words(float(p))})"
        effects.append(EventEffect(event_name, component, shape, size, statistic, float(p), words))
    return tuple(sorted(effects, key=lambda effect: (effect.p, -abs(effect.statistic))))


def directions_of(residuals: Residuals) -> Iterator[tuple[str, Array]]:
    """Return names and directions (n, k), each of unit length or 0: the components, then `Residuals.ways`."""
    for column, component in enumerate(residuals.components):
        direction = np.zeros_like(residuals.values)
        direction[:, column] = 1.0
        yield component, direction
    yield from residuals.ways.items()


def shapes_after(residuals: Residuals, events: Events) -> Array:
    """Return instruments (n, 3) of the three `SHAPES` after the latest event of each trajectory; 0 before it."""
    last = np.full(len(residuals.values), -1)
    last[events.rows] = events.rows
    last = np.maximum.accumulate(last)
    frames = np.arange(len(last)) - last
    has_begun = last >= residuals.starts[residuals.trajectory]
    faded = np.exp(-frames / FRAMES)
    return np.where(has_begun[:, None], np.column_stack([np.ones(len(last)), 1.0 - faded, faded]), 0.0)


def _find(given: LocatorInput) -> tuple[EventEffect, ...] | None:
    """Return departures that begin at any kind of event; ``None`` where the labels show no event."""
    return event_effects(given.projection, given.events, given.seed + 9, given.draws) or None


LOCATOR = Locator(
    "departures from events on", _find, lambda effect: {"event": effect.event, "component": effect.component}
)
