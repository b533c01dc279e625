"""What an answer to a case is worth, in one or two words."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tactiledata.prove.cases.kinds import LEAST_SIGNAL

CLAIMS = ("explained", "partly explained")
"""Verdicts that name an effect."""
QUIET = ("nothing found", "below detection")
"""Verdicts that say that nothing can be told from errors of the simulation."""
DRIFT = "sensor_drift"
"""A cause of zeros that every world has, 0.02 N a minute: told of nulls as well, it counts for nothing."""
NAMED, IN_SET, ONE_OF_TWO = "named", "in the set", "one of two"
WRONG, MISSED, UNNAMED = "wrong", "missed", "unnamed"
NOTHING, STRUCTURE, FALSE_ALARM = "nothing found", "structure only", "false alarm"


def told_by_readings(answer: Mapping[str, Any]) -> tuple[str, ...]:
    """Return what readings alone show by an answer, without the drift that every world has.

    Parameters
    ----------
    answer : dict
        With ``zeros``, the names that its readings show.
    """
    return tuple(name for name in answer["zeros"] if name != DRIFT)


def outcome(case: Mapping[str, Any]) -> str:
    """Return what the answer to a case is worth where something is hidden.

    ``named``, ``in the set``, ``one of two``, ``undetectable`` (in all its range, said so and true), ``too weak``
    (weaker than what the answer says it needs), ``missed``, ``unnamed`` (something is said to be missing, without a
    name) or ``wrong``. What readings alone show is named, too, but for a drift of the zero, which they show of nulls.

    Parameters
    ----------
    case : dict
        ``truth``, ``names``, ``set`` and ``zeros``, the ``verdict``, the ``signal`` and what is ``undetectable``.
    """
    truth = set(case["truth"])
    claimed = case["verdict"] in CLAIMS
    of_zeros = set(told_by_readings(case))
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
    """Return what the answer to a case is worth where nothing is hidden: nothing found, structure, or a false alarm.

    Parameters
    ----------
    case : dict
        See `outcome`.
    """
    if case["verdict"] in CLAIMS or told_by_readings(case):
        return FALSE_ALARM
    return NOTHING if case["verdict"] in QUIET else STRUCTURE
