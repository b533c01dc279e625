"""What an answer to a case is worth, in one or two words."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tactiledata.prove.cases.kinds import LEAST_SIGNAL

CLAIMS = ("explained", "partly explained")
"""Verdicts that name an effect."""
QUIET = ("nothing found", "below detection")
"""Verdicts that say that nothing can be told from errors of the simulation."""
NAMED, IN_SET, ONE_OF_TWO = "named", "in the set", "one of two"
WRONG, MISSED, UNNAMED = "wrong", "missed", "unnamed"
NOTHING, STRUCTURE, FALSE_ALARM = "nothing found", "structure only", "false alarm"
FAILED = "failed"
"""Verdict and outcome where the diagnosis of a case ended in an error."""


def outcome(case: Mapping[str, Any]) -> str:
    """Return what the answer to a case is worth where something is hidden.

    ``named``, ``in the set``, ``one of two``, ``undetectable`` (in all its range, said so and true), ``too weak``
    (weaker than what the answer says it needs), ``missed``, ``unnamed`` (something is said to be missing, without a
    name), ``wrong``, or ``failed`` (the diagnosis ended in an error). What readings alone show is named, too.

    Parameters
    ----------
    case : dict
        ``truth``, ``names``, ``set`` and ``zeros``, the ``verdict``, the ``signal`` and what is ``undetectable``.
    """
    if case["verdict"] == FAILED:
        return FAILED
    truth = set(case["truth"])
    claimed = case["verdict"] in CLAIMS
    of_zeros = set(case["zeros"])
    if truth and truth <= set(case["names"]) | of_zeros:
        return NAMED
    if truth and truth <= set(case["set"]) | of_zeros:
        return IN_SET
    if truth & (set(case["set"]) | of_zeros):
        return ONE_OF_TWO
    if claimed or of_zeros:
        return WRONG
    if case["verdict"] not in QUIET:
        return UNNAMED
    if case["signal"] >= LEAST_SIGNAL:
        return MISSED
    return "undetectable" if truth <= set(case["undetectable"]) else "too weak"


def outcome_of_null(case: Mapping[str, Any]) -> str:
    """Return what the answer to a case is worth where nothing is hidden.

    It is nothing found, structure, a false alarm, or failed where the diagnosis ended in an error.

    Parameters
    ----------
    case : dict
        See `outcome`.
    """
    if case["verdict"] == FAILED:
        return FAILED
    if case["verdict"] in CLAIMS or case["zeros"]:
        return FALSE_ALARM
    return NOTHING if case["verdict"] in QUIET else STRUCTURE
