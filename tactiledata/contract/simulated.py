"""Which recordings are simulated, as their descriptions state it, and the words for it, the same everywhere."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Literal

from tactiledata.contract.wording import counted

Kind = Literal["simulated", "real", "not stated"]

TERM = "simulated recordings"


def recording_kind(description: Mapping[str, Any]) -> Kind:
    """What a log's description states of its contacts under ``recorded_by.contact``; any other text states nothing.

    Examples
    --------
    >>> recording_kind({"recorded_by": {"tool": "tactiledata rig", "contact": "simulated"}})
    'simulated'
    >>> recording_kind({"recorded_by": {"contact": "somebody@example.org"}})
    'not stated'
    """
    recorder = description.get("recorded_by")
    stated = recorder.get("contact") if isinstance(recorder, Mapping) else None
    kind = stated.strip().casefold() if isinstance(stated, str) else ""
    if kind == "simulated":
        return "simulated"
    return "real" if kind == "real" else "not stated"


@dataclass(frozen=True)
class SimulatedCount:
    """How many things, recordings or their trajectories, are simulated, real, or do not state it.

    Parameters
    ----------
    simulated, real, not_stated : int
    noun : str
        What is counted, in the singular.
    """

    simulated: int = 0
    real: int = 0
    not_stated: int = 0
    noun: str = "recording"

    @classmethod
    def of(cls, kinds: Iterable[Kind], noun: str = "recording") -> SimulatedCount:
        """The count of these kinds."""
        counts = Counter(kinds)
        return cls(counts["simulated"], counts["real"], counts["not stated"], noun)

    @property
    def total(self) -> int:
        """How many were counted."""
        return self.simulated + self.real + self.not_stated

    @property
    def label(self) -> str:
        """The words for titles and captions: empty where nothing is simulated, a share where not all is.

        Examples
        --------
        >>> SimulatedCount(2).label, SimulatedCount(2, 0, 1).label, SimulatedCount(0, 2, 1).label
        ('simulated recordings', 'simulated recordings: 2 of 3', '')
        """
        if not self.simulated:
            return ""
        return TERM if self.simulated == self.total else f"{TERM}: {self.simulated} of {self.total}"

    @property
    def heading(self) -> str:
        """The label as it stands above a picture; empty where nothing is simulated."""
        return _begun(self.label)

    @property
    def sentence(self) -> str:
        """A sentence for people, with how many are real and how many do not state it; empty where nothing is simulated.

        Examples
        --------
        >>> SimulatedCount(2).sentence
        'Simulated recordings: all 2 recordings.'
        >>> SimulatedCount(2, 1, 1, "trajectory").sentence
        'Simulated recordings: 2 of 4 trajectories; 1 is real; 1 does not state it.'
        """
        if not self.simulated:
            return ""
        if self.simulated == self.total:
            return f"{_begun(TERM)}: {'all ' if self.total > 1 else ''}{counted(self.total, self.noun)}."
        parts = [f"{_begun(TERM)}: {self.simulated} of {counted(self.total, self.noun)}"]
        if self.real:
            parts.append(f"{self.real} {'is' if self.real == 1 else 'are'} real")
        if self.not_stated:
            parts.append(f"{self.not_stated} {'does' if self.not_stated == 1 else 'do'} not state it")
        return "; ".join(parts) + "."

    def titled(self, title: str) -> str:
        """A title with the label behind it, in brackets; the title alone where nothing is simulated."""
        return f"{title} ({self.label})" if self.label else title

    def captioned(self, caption: str) -> str:
        """A caption with the label behind it, as a sentence; the caption alone where nothing is simulated."""
        return f"{caption} {self.heading}." if self.label else caption

    def document(self) -> dict[str, int]:
        """The counts as JSON values, stated whether or not anything is simulated."""
        return {"simulated": self.simulated, "real": self.real, "not_stated": self.not_stated}


NOTHING_STATED = SimulatedCount()
"""The count of things that nobody was asked about."""


def _begun(text: str) -> str:
    return text[:1].upper() + text[1:]
