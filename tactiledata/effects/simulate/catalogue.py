"""All effects as plain values, for commands and pages."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict
from typing import Any

from tactiledata.effects.base import SLOT_TITLES, Effect


def catalogue(effects: Iterable[Effect]) -> list[dict[str, Any]]:
    """Return what each effect declares, as values for JSON."""
    return [
        {
            "name": effect.name,
            "title": effect.title,
            "slot": effect.slot,
            "slot_title": SLOT_TITLES[effect.slot],
            "parameters": [asdict(parameter) for parameter in effect.parameters],
            "look_alikes": list(effect.look_alikes),
            "distinguishing_trial": effect.distinguishing_trial,
            "detectability": effect.detectability,
            "needs": list(effect.needs),
            "played_by_gel_engine": sorted(effect.designs),
            "reference": effect.reference,
        }
        for effect in effects
    ]
