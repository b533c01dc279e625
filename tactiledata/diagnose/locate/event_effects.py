"""What begins at an event, beside all that the parameters can imitate: the event by which a departure is best told.

After a calibration has absorbed a part of an effect, its rest shows about every event. A departure that begins at one
event and stays, rises or fades is therefore fitted together with all parameters, and events compete.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.locate.events import Events
from tactiledata.diagnose.residuals.projection import ProjectedResiduals
from tactiledata.diagnose.residuals.residuals import Residuals
from tactiledata.diagnose.residuals.scores import along
from tactiledata.diagnose.residuals.sign_flips import DRAWS, family_wise, signs
from tactiledata.diagnose.residuals.wording import departs, p_words

SHAPES = ("stays", "rises", "fades")
GOES_ON = {"stays": "stays so", "rises": "more and more so", "fades": "fades"}
FRAMES = 2.0
"""Within which a departure rises or fades to 1/e."""


@dataclass(frozen=True)
class EventEffect:
    """A departure of one component from an event on.

    Parameters
    ----------
    event, component : str
        A way (`Residuals.ways`) counts as a component.
    shape : "stays", "rises" or "fades"
    size : float
        Times the noise.
    statistic : float
        As a standard normal value.
    p : float
        For all events, components and shapes together.
    words : str
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
    """Every event and component with its best shape, the most certain first.

    Raises
    ------
    TactileDataError
        Too few units of exchange.
    """
    residuals = projection.residuals
    residuals.need_units("departures from events on")
    if not events:
        return ()
    instruments = np.concatenate([shapes_after(residuals, one) for one in events], axis=1)
    thrown = signs(residuals.unit_count, draws, seed)
    pairs: list[tuple[str, str, str, float, float]] = []
    observed, drawn = [], []
    for component, direction in directions_of(residuals):
        found = along(projection, direction, instruments)
        statistics, sizes = found.statistic, found.size
        flipped = np.abs(found.flipped(thrown)).reshape(draws, len(events), len(SHAPES)).max(axis=2)
        for number, event in enumerate(events):
            first = number * len(SHAPES)
            sort = int(np.abs(statistics[first : first + len(SHAPES)]).argmax())
            best = first + sort
            pairs.append((event.name, component, SHAPES[sort], float(sizes[best]), float(statistics[best])))
            observed.append(abs(float(statistics[best])))
            drawn.append(flipped[:, number])
    p_values = family_wise(np.array(observed), np.stack(drawn, axis=1))
    effects = []
    for (event_name, component, shape, size, statistic), p in zip(pairs, p_values, strict=True):
        apart = departs(component, size, 0.0, residuals.scale)
        words = f"{apart} from {event_name} on, and {GOES_ON[shape]} ({p_words(float(p))})"
        effects.append(EventEffect(event_name, component, shape, size, statistic, float(p), words))
    return tuple(sorted(effects, key=lambda one: (one.p, -abs(one.statistic))))


def directions_of(residuals: Residuals) -> Iterator[tuple[str, Array]]:
    """Names and directions (n, k): each component, and the ways of trajectories."""
    for column, component in enumerate(residuals.components):
        direction = np.zeros_like(residuals.values)
        direction[:, column] = 1.0
        yield component, direction
    yield from residuals.ways.items()


def shapes_after(residuals: Residuals, events: Events) -> Array:
    """Instruments (n, 3) that begin at the last such event of the trajectory; 0 before it."""
    last = np.full(len(residuals.values), -1)
    last[events.rows] = events.rows
    last = np.maximum.accumulate(last)
    frames = np.arange(len(last)) - last
    has_begun = last >= residuals.starts[residuals.trajectory]
    faded = np.exp(-frames / FRAMES)
    return np.where(has_begun[:, None], np.column_stack([np.ones(len(last)), 1.0 - faded, faded]), 0.0)
