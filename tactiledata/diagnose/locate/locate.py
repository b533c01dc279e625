"""Run every locator on the same residuals, correct their p-values for their number, and put the findings into words."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tactiledata.diagnose.locate import LOCATORS
from tactiledata.diagnose.locate.base import LocatorFinding, LocatorInput
from tactiledata.diagnose.locate.contrasts import Contrast, contrasts
from tactiledata.diagnose.locate.drifts import Drift, parameter_drifts
from tactiledata.diagnose.locate.energy import EnergyShares, energy_shares
from tactiledata.diagnose.locate.event_locked import EventLocked, event_locked
from tactiledata.diagnose.locate.events import find_events
from tactiledata.diagnose.locate.free_air import FreeAir, free_air
from tactiledata.diagnose.locate.gate import Gate, NoiseModel, gate
from tactiledata.diagnose.locate.leading_drifts import leading_drifts
from tactiledata.diagnose.locate.own_offsets import own_drifts
from tactiledata.diagnose.locate.region_map import RegionMap, region_maps
from tactiledata.diagnose.locate.simulator_errors import beyond_errors
from tactiledata.diagnose.residuals.projection import ProjectedResiduals, project
from tactiledata.diagnose.residuals.residuals import Residuals
from tactiledata.diagnose.residuals.sign_flips import DRAWS, holm

LEVEL = 0.05
"""Error rate over all locators: the largest corrected p-value of a certain locator."""
MOST_SAID = 3
"""Most findings of a locator that become sentences."""
SAID_BEFORE = ("a common offset", "departures from events on", "steps")
"""Locators of the table whose sentences stand among those of the others; all others come behind them."""
BESIDES = "that allowed for, "
"""Begin of a sentence on a drift that was found with a stronger one fitted."""


@dataclass(frozen=True)
class LocateOptions:
    """What the locators need to know beside the residuals.

    Parameters
    ----------
    order_by : str
        Covariate along which steps between trajectories are sought.
    plane : (str, str)
        The two covariates that span the map.
    noise : NoiseModel, optional
        Distribution of the noise; ``None`` where its size is not known, so that the residual's size is not tested.
    seed : int
        Random seed; each locator uses its own number after it.
    draws : int
        Number of sign flips or permutations of each test.
    is_fitted : bool
        Whether the shared parameters were fitted to these residuals; common offsets are then not tested.
    errors : dict, name -> float, optional
        Standard deviation that the simulation's own errors cause in contrasts of each component and parameter, in the
        units of `Contrast.size`; all findings must exceed it. ``None`` where it is not known: contrasts are then not
        tested.
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
    """The findings of all locators, and their corrected p-values.

    Parameters
    ----------
    projection : ProjectedResiduals
        Residuals after the refit of the shared parameters.
    gate : Gate, optional
        Size and slowness of the residual; ``None`` where the noise is not known.
    free_air : FreeAir
        Structure before contact.
    drifts : tuple of Drift
        All pairs of shared parameter and covariate or label.
    leading : tuple of Drift
        The certain drifts that remain with all stronger ones fitted.
    own : tuple of Drift
        What the trajectories' own parameters follow.
    events : tuple of EventLocked
        Means about each kind of event.
    contrasts : tuple of Contrast
        Differences beyond errors of the simulation; empty where those are not known.
    maps : tuple of RegionMap
        Parameters over the plane.
    energy : EnergyShares
        Which data hold the excess.
    p : dict, locator -> float
        Holm's p-value of each locator that had something to test.
    by_table : dict, locator -> tuple of LocatorFinding
        Findings of each locator in the table `LOCATORS`, by its title.
    """

    projection: ProjectedResiduals
    gate: Gate | None
    free_air: FreeAir
    drifts: tuple[Drift, ...]
    leading: tuple[Drift, ...]
    own: tuple[Drift, ...]
    events: tuple[EventLocked, ...]
    contrasts: tuple[Contrast, ...]
    maps: tuple[RegionMap, ...]
    energy: EnergyShares
    p: dict[str, float]
    by_table: dict[str, tuple[LocatorFinding, ...]]

    @property
    def is_structured(self) -> bool:
        """Whether any locator is certain at the error rate `LEVEL` over all locators."""
        return any(value <= LEVEL for value in self.p.values())

    def is_certain(self, locator: str) -> bool:
        """Return whether one locator, by its name in ``p``, is certain at the error rate over all locators."""
        return self.p.get(locator, 1.0) <= LEVEL

    def _reported_drifts(self) -> list[Drift]:
        """Return the drifts for sentences: all leading ones, and the most certain one of own parameters."""
        shared = self.leading if self.is_certain("drifting parameters") else ()
        return [*shared, *(self.own[:1] if self.is_certain("trajectories' own parameters") else ())]

    def _of_table(self, title: str) -> list[str]:
        """Return sentences on the certain findings of one locator of the table; none where it is not certain."""
        if not self.is_certain(title):
            return []
        most = next(LOCATORS[name].most_said for name in LOCATORS if LOCATORS[name].title == title)
        return [_sentence(finding.words) for finding in self.by_table[title] if finding.p <= LEVEL][:most]

    def sentences(self) -> list[str]:
        """Return the certain findings as sentences, simple causes first; one sentence says so where there are none."""
        if not self.is_structured:
            return ["Nothing found: no locator finds structure beyond chance."]
        sentences, drifts = [], self._reported_drifts()
        if self.is_certain("free air"):
            sentences.append(self.free_air.words)
        if self.gate is not None and self.is_certain("size of the residual"):
            sentences.append(self.gate.words)
        sentences += self._of_table("a common offset")
        sentences += [_sentence(f"{BESIDES if drift in self.leading[1:] else ''}{drift.words}") for drift in drifts]
        if self.is_certain("contrasts"):
            # a contrast that repeats a drift is left out
            pairs = {(drift.parameter, drift.covariate) for drift in drifts}
            certain = [contrast for contrast in self.contrasts if contrast.p <= LEVEL]
            sentences += [
                _sentence(contrast.words) for contrast in certain if (contrast.what, contrast.along) not in pairs
            ]
        departures = self._of_table("departures from events on")
        sentences += departures
        if not departures and self.is_certain("events"):
            sentences += [_sentence(event.words) for event in self.events if event.p <= LEVEL][:MOST_SAID]
        sentences += self._of_table("steps")
        if self.is_certain("the map"):
            sentences += [_sentence(region_map.words) for region_map in self.maps if region_map.p <= LEVEL][:1]
        for title in self.by_table:
            sentences += [] if title in SAID_BEFORE else self._of_table(title)
        if self.energy.is_uneven:
            sentences.append(_sentence(self.energy.words))
        return sentences


def locate(residuals: Residuals, options: LocateOptions | None = None) -> LocatorResults:
    """Return the findings of every locator on the same residuals, with p-values corrected over all locators.

    Parameters
    ----------
    residuals : Residuals
        Residuals with covariates, labels, parameters and sensitivities.
    options : LocateOptions, optional
        Settings of the locators; defaults where left out.

    Raises
    ------
    TactileDataError
        There are too few units of exchange, or scikit-learn is not installed.
    """
    chosen = options or LocateOptions()
    seed, draws = chosen.seed, chosen.draws
    residuals.need_units("a diagnosis")
    projection = project(residuals)
    refitted = residuals.with_values(projection.score)
    # each locator has a random seed of its own, so that its draws do not depend on the others
    gate_result = None if chosen.noise is None else gate(projection, chosen.noise, seed)
    in_air = free_air(residuals, seed, draws)
    drifts = beyond_errors(parameter_drifts(projection, seed + 2, draws), chosen.errors)
    leading = leading_drifts(projection, drifts, seed + 8, draws, chosen.errors)
    own = beyond_errors(own_drifts(projection, seed + 10, draws), chosen.errors)
    found_events = find_events(residuals)
    events = event_locked(refitted, found_events, seed=seed + 3, draws=draws)
    differences = _contrasts(projection, chosen)
    maps = beyond_errors(region_maps(projection, *chosen.plane, seed=seed + 5, draws=draws), chosen.errors)
    variance = 1.0 if chosen.noise is not None else 0.0
    energy = energy_shares(projection, variance, seed + 7)
    # the locators of the table; what errors of the simulation could explain loses its certainty
    given = LocatorInput(residuals, projection, found_events, chosen.order_by, chosen.is_fitted, seed, draws)
    asked = {locator.title: locator.find(given) for locator in (LOCATORS[name] for name in LOCATORS)}
    by_table = {title: beyond_errors(findings or (), chosen.errors) for title, findings in asked.items()}
    # the smallest p-value of each locator; None where it had nothing to test
    tests = {
        "size of the residual": None if gate_result is None else gate_result.p,
        "free air": in_air.p if in_air.is_tested else None,
        "drifting parameters": min([finding.p for finding in drifts], default=None),
        "trajectories' own parameters": min([finding.p for finding in own], default=None),
        "events": min([finding.p for finding in events], default=None),
        "contrasts": None if differences is None else min([finding.p for finding in differences], default=1.0),
        "the map": min([finding.p for finding in maps], default=None),
        **{
            title: None if findings is None else min([finding.p for finding in by_table[title]], default=1.0)
            for title, findings in asked.items()
        },
    }
    tested = {name: value for name, value in tests.items() if value is not None}
    holm_values = holm(np.array(list(tested.values())))
    corrected_p = {name: float(value) for name, value in zip(tested, holm_values, strict=True)}
    return LocatorResults(
        projection, gate_result, in_air, drifts, leading, own, events, differences or (), maps, energy, corrected_p,
        by_table,
    )  # fmt: skip


def _contrasts(projection: ProjectedResiduals, options: LocateOptions) -> tuple[Contrast, ...] | None:
    """Return the contrasts; ``None`` where the noise, its correlation or the simulation's own errors are not known."""
    inflation = None if options.noise is None else options.noise.inflation
    if options.errors is None or inflation is None:
        return None
    return contrasts(projection, options.errors, inflation)


def _sentence(words: str) -> str:
    """Return the words as a sentence, with a capital unless they begin with a symbol such as fz or mu."""
    first = words.split()[0]
    return f"{words if len(first) <= 2 else words[0].upper() + words[1:]}."
