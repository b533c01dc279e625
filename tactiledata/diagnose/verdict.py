"""The verdicts of a diagnosis: the only words that an answer may be, each with one meaning."""

from __future__ import annotations

from enum import StrEnum


class Verdict(StrEnum):
    """One word or phrase for what a diagnosis concludes, the same for stores and tables.

    `diagnosis.json` uses it in ``answer`` and, for the known effects alone, in ``naming.verdict``.
    schemas/diagnosis.json and docs/diagnose.md repeat the words with their meanings; a test compares them.
    """

    NOTHING_FOUND = "nothing found"
    BELOW_DETECTION = "below detection"
    CALIBRATION = "calibration"
    STRUCTURED_NOT_NAMED = "structured, not named"
    NOT_EXPLAINED = "not explained"
    PARTLY_EXPLAINED = "partly explained"
    EXPLAINED = "explained"

    @property
    def meaning(self) -> str:
        """What the verdict says, as a sentence without its period."""
        return MEANINGS[self]


MEANINGS = {
    Verdict.NOTHING_FOUND: "noise and known errors of the simulation account for all differences",
    Verdict.BELOW_DETECTION: (
        "the differences look like a known effect, but they are too small, or rest on too few touches, to be told from"
        " an error of the simulation"
    ),
    Verdict.CALIBRATION: "a common offset (zero) or scale is off, and nothing else is found",
    Verdict.STRUCTURED_NOT_NAMED: (
        "a black box (boosted trees) predicts part of the differences on groups that it was not trained on, and no"
        " locator says where they are"
    ),
    Verdict.NOT_EXPLAINED: "the differences have structure that neither a known effect nor a formula explains",
    Verdict.PARTLY_EXPLAINED: "a known effect or a formula explains part of the differences, and structure is left",
    Verdict.EXPLAINED: "a known effect or a formula explains the differences, and no structure is left",
}
"""Meaning of each verdict: a clause that can follow the verdict and a colon."""
