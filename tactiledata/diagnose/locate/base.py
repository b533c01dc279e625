"""What a locator of the table in ``locate/__init__.py`` offers; a new one is one file and one line there."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from tactiledata.diagnose.locate.events import Events
from tactiledata.diagnose.residuals.projection import ProjectedResiduals
from tactiledata.diagnose.residuals.residuals import Residuals


class LocatorFinding(Protocol):
    """One finding: how certain it is, and what it says."""

    @property
    def p(self) -> float:
        """p-value of the finding, corrected for all findings of its locator."""

    @property
    def words(self) -> str:
        """The finding as a clause without a full stop, such as ``"E rises by 4 ± 1 % with depth"``."""


@dataclass(frozen=True)
class LocatorInput:
    """The residuals and settings that every locator of the table gets.

    Parameters
    ----------
    residuals : Residuals
        Whitened residuals (n, k) of n frames, with covariates, labels and parameters.
    projection : ProjectedResiduals
        The same after the parameters of trajectories and a refit of the shared ones have taken what they can.
    events : sequence of Events
        Kinds of event in the labels of the frames, with the rows at which they happen.
    order_by : str
        Covariate along which trajectories are ordered.
    is_fitted : bool
        Whether the shared parameters were fitted to these residuals.
    seed : int
        Random seed of the diagnosis; a locator adds a number of its own.
    draws : int
        Number of sign flips of a test.
    """

    residuals: Residuals
    projection: ProjectedResiduals
    events: Sequence[Events]
    order_by: str
    is_fitted: bool
    seed: int
    draws: int


@dataclass(frozen=True)
class Locator:
    """A statistical test of one form of difference between recordings and simulation.

    Parameters
    ----------
    title : str
        Its name in documents, tables and pages.
    find : callable
        Gives all findings of a `LocatorInput`, the most certain first. An empty sequence: it was tested, and nothing
        was found. ``None``: these data give nothing to test, so that the locator does not count among the tests.
    facts : callable
        Gives the fields of a finding in ``diagnosis.json``, beside its p-value and words.
    most_said : int
        Most findings that become sentences.
    """

    title: str
    find: Callable[[LocatorInput], Sequence[Any] | None]
    facts: Callable[[Any], Mapping[str, Any]]
    most_said: int = 1
