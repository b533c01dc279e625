"""Where recordings and simulation differ: every locator, and one error rate over all of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tactiledata.diagnose.locate.common_offset import Offset, offsets
from tactiledata.diagnose.locate.contrasts import Contrast, contrasts
from tactiledata.diagnose.locate.drifts import Drift, parameter_drifts
from tactiledata.diagnose.locate.energy import EnergyShares, energy_shares
from tactiledata.diagnose.locate.event_effects import EventEffect, event_effects
from tactiledata.diagnose.locate.event_locked import EventLocked, event_locked
from tactiledata.diagnose.locate.events import find_events
from tactiledata.diagnose.locate.free_air import FreeAir, free_air
from tactiledata.diagnose.locate.gate import Gate, NoiseModel, gate
from tactiledata.diagnose.locate.leading_drifts import leading_drifts
from tactiledata.diagnose.locate.own_offsets import own_drifts
from tactiledata.diagnose.locate.region_map import RegionMap, region_maps
from tactiledata.diagnose.locate.simulator_errors import beyond_errors
from tactiledata.diagnose.locate.steps import ChangePoint, can_step, change_points
from tactiledata.diagnose.locate.tree import Leaf, honest_tree
from tactiledata.diagnose.residuals.projection import ProjectedResiduals, project
from tactiledata.diagnose.residuals.residuals import Residuals
from tactiledata.diagnose.residuals.sign_flips import DRAWS, holm

LEVEL = 0.05
MOST_SAID = 3
BESIDES = "that allowed for, "


@dataclass(frozen=True)
class LocateOptions:
    """What locators need to know.

    Parameters
    ----------
    order_by : covariate along which steps are sought
    plane : two covariates that span the gel
    noise : NoiseModel, optional
        ``None`` where the size of the noise is not known: the residual's size then proves nothing.
    seed, draws : int
        Of the signs that are thrown.
    is_fitted : bool
        Whether the residuals are those of a fit of the shared parameters: a common offset is no question then.
    errors : dict, name -> standard deviation, optional
        What the simulation's own errors leave of contrasts: other findings, too, have to be beyond that. ``None`` where
        it is not known: no contrasts are asked.
    """

    order_by: str = "index"
    plane: tuple[str, str] = ("x", "y")
    noise: NoiseModel | None = None
    seed: int = 0
    draws: int = DRAWS
    is_fitted: bool = False
    errors: Mapping[str, float] | None = None


@dataclass(frozen=True)
class LocatorResults:
    """What all locators say.

    Parameters
    ----------
    projection : ProjectedResiduals
        After the refit of the shared parameters.
    gate : Gate, optional
    free_air : FreeAir
    overall, drifts, events, departures, contrasts, steps, maps, leaves
        See the modules of these names.
    leading : tuple of Drift
        The certain drifts without their echoes.
    own : tuple of Drift
        What the trajectories' own parameters follow.
    energy : EnergyShares
    p : dict, locator -> p-value
        Holm's, over all locators that had something to test.
    """

    projection: ProjectedResiduals
    gate: Gate | None
    free_air: FreeAir
    overall: tuple[Offset, ...]
    drifts: tuple[Drift, ...]
    leading: tuple[Drift, ...]
    own: tuple[Drift, ...]
    events: tuple[EventLocked, ...]
    departures: tuple[EventEffect, ...]
    contrasts: tuple[Contrast, ...]
    steps: tuple[ChangePoint, ...]
    maps: tuple[RegionMap, ...]
    leaves: tuple[Leaf, ...]
    energy: EnergyShares
    p: dict[str, float]

    @property
    def is_structured(self) -> bool:
        """Whether any locator is certain, all of them taken together."""
        return any(value <= LEVEL for value in self.p.values())

    def is_certain(self, locator: str) -> bool:
        """Whether one of them is."""
        return self.p.get(locator, 1.0) <= LEVEL

    def _drifts_said(self) -> list[Drift]:
        """Of shared parameters those without echoes, of own ones the most certain."""
        shared = self.leading if self.is_certain("drifting parameters") else ()
        return [*shared, *(self.own[:1] if self.is_certain("trajectories' own parameters") else ())]

    def sentences(self) -> list[str]:
        """What is certain, the plainest first; where nothing is, that."""
        if not self.is_structured:
            return ["Nothing found: no locator finds structure that chance does not explain."]
        said, known = [], self._drifts_said()
        if self.is_certain("free air"):
            said.append(self.free_air.words)
        if self.gate is not None and self.is_certain("size of the residual"):
            said.append(self.gate.words)
        if self.is_certain("a common offset"):
            said += [_sentence(one.words) for one in self.overall if one.p <= LEVEL][:MOST_SAID]
        said += [_sentence(f"{BESIDES if one in self.leading[1:] else ''}{one.words}") for one in known]
        if self.is_certain("contrasts"):
            pairs = {(one.parameter, one.covariate) for one in known}
            certain = [one for one in self.contrasts if one.p <= LEVEL]
            said += [_sentence(one.words) for one in certain if (one.what, one.along) not in pairs]
        if self.is_certain("departures from events on"):
            said.append(_sentence(self.departures[0].words))
        elif self.is_certain("events"):
            said += [_sentence(one.words) for one in self.events if one.p <= LEVEL][:MOST_SAID]
        if self.is_certain("steps"):
            said += [_sentence(one.words) for one in self.steps][:MOST_SAID]
        if self.is_certain("the map"):
            said += [_sentence(one.words) for one in self.maps if one.p <= LEVEL][:1]
        if self.is_certain("the tree"):
            said += [_sentence(one.words) for one in self.leaves if one.p <= LEVEL][:1]
        if self.energy.is_uneven:
            said.append(_sentence(self.energy.words))
        return said


def locate(residuals: Residuals, options: LocateOptions | None = None) -> LocatorResults:
    """Every locator on the same residuals.

    Raises
    ------
    TactileDataError
        Too few units of exchange.
    """
    chosen = options or LocateOptions()
    seed, draws = chosen.seed, chosen.draws
    residuals.need_units("a diagnosis")
    projection = project(residuals)
    refitted = residuals.with_values(projection.score)
    opened = None if chosen.noise is None else gate(projection, chosen.noise, seed)
    air = free_air(residuals, seed, draws)
    common = () if chosen.is_fitted else offsets(residuals, seed + 1, draws)
    drifts = beyond_errors(parameter_drifts(projection, seed + 2, draws), chosen.errors)
    leading = leading_drifts(projection, drifts, seed + 8, draws, chosen.errors)
    own = beyond_errors(own_drifts(projection, seed + 10, draws), chosen.errors)
    found_events = find_events(residuals)
    events = event_locked(refitted, found_events, seed=seed + 3, draws=draws)
    departures = beyond_errors(event_effects(projection, found_events, seed + 9, draws), chosen.errors)
    differ = _contrasts(projection, chosen)
    steps = beyond_errors(change_points(projection, chosen.order_by, seed + 4), chosen.errors)
    maps = beyond_errors(region_maps(projection, *chosen.plane, seed=seed + 5, draws=draws), chosen.errors)
    leaves = beyond_errors(honest_tree(projection, seed + 6, draws), chosen.errors)
    variance = 1.0 if chosen.noise is not None else 0.0
    shares = energy_shares(projection, variance, seed + 7)
    tests = {
        "size of the residual": None if opened is None else opened.p,
        "free air": air.p if air.is_tested else None,
        "a common offset": min([one.p for one in common], default=None),
        "drifting parameters": min([one.p for one in drifts], default=None),
        "trajectories' own parameters": min([one.p for one in own], default=None),
        "events": min([one.p for one in events], default=None),
        "departures from events on": min([one.p for one in departures], default=None),
        "contrasts": None if differ is None else min([one.p for one in differ], default=1.0),
        "steps": min([one.p for one in steps], default=1.0) if can_step(residuals, chosen.order_by) else None,
        "the map": min([one.p for one in maps], default=None),
        "the tree": min([one.p for one in leaves], default=None),
    }
    asked = {name: value for name, value in tests.items() if value is not None}
    corrected = holm(np.array(list(asked.values())))
    together = {name: float(value) for name, value in zip(asked, corrected, strict=True)}
    return LocatorResults(
        projection, opened, air, common, drifts, leading, own, events, departures, differ or (), steps, maps, leaves,
        shares, together,
    )  # fmt: skip


def _contrasts(projection: ProjectedResiduals, options: LocateOptions) -> tuple[Contrast, ...] | None:
    """Nothing where noise, its memory, or the simulation's own errors are not known."""
    inflation = None if options.noise is None else options.noise.inflation
    if options.errors is None or inflation is None:
        return None
    return contrasts(projection, options.errors, inflation)


def _sentence(words: str) -> str:
    """With a capital, unless it begins with a symbol as fz or mu."""
    first = words.split()[0]
    return f"{words if len(first) <= 2 else words[0].upper() + words[1:]}."
