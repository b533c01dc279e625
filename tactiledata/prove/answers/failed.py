"""The answer to a case whose diagnosis ended in an error: it names nothing, and says why."""

from __future__ import annotations

from typing import Any

from tactiledata.errors import TactileDataError
from tactiledata.prove.score.outcome import FAILED


def failed_answer(error: TactileDataError) -> dict[str, Any]:
    """Return the document of an answer where the diagnosis ended in an error, with the keys of `NamedWorld.document`.

    Parameters
    ----------
    error : TactileDataError
        What ended it. Other errors are faults of ours, and end the run.
    """
    return {
        "verdict": FAILED,
        "names": [],
        "set": [],
        "ties": [],
        "nearest": [],
        "objections": [f"the diagnosis ended in an error: {error}"],
        "probabilities": {},
        "dispersion": None,
        "at_large": None,
        "candidates": [],
        "screen": [],
        "undetectable": [],
        "not_tried": [],
        "before": [],
        "after": [],
        "values": {},
        "zeros": [],
        "full_plays": [],
    }
