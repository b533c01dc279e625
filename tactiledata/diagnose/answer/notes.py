"""Notes on what took no part in the diagnosis of a store: trajectories, frames and effects, and why."""

from __future__ import annotations

import math

from tactiledata.contract.wording import counted
from tactiledata.diagnose.answer.diagnosis import StoreDiagnosis
from tactiledata.diagnose.residuals.wording import percent
from tactiledata.effects import EFFECTS

_NEEDS = {
    "joints": "the joints' angles",
    "gravity": "how the sensor is turned",
    "powered": "when the sensor was switched on (power_on_ns in log.yaml)",
    "selection": "a range of forces to which they were cut",
    "earlier_depth": "what was done to the gel before",
    "earlier_contacts": "what was done to the gel before",
}
"""What recordings must state for an effect to be tried, in words."""


def notes_of(done: StoreDiagnosis) -> list[str]:
    """Return notes on trajectories, frames and effects that took no part, and why."""
    # trajectories and frames
    played = done.played
    notes = [
        f"{counted(count, 'trajectory')} took no part: {reason}" for reason, count in sorted(played.left_out.items())
    ]
    frames = played.frames
    if frames.lost:
        notes.append(
            f"{frames.lost} frames, with {percent(frames.force_lost)} of the squared force, take no part: without pose"
            " or wrench, or the gel could not be solved there"
        )
    if frames.estimated:
        notes.append(
            f"{frames.estimated} frames could not be solved at some parameters of the gel and are interpolated there"
        )
    # effects that were looked at closely
    for closer in done.full_plays:
        notes.append(
            f"{EFFECTS[closer.effect]().title} was first estimated and then played in full: the estimate was off by"
            f" {percent(closer.error)} of what the effect changes; the evidence was"
            f" {_number(closer.estimated_evidence)} and is {_number(closer.evidence)}"
        )
    # effects that were not tried, by reason
    by_reason: dict[str, list[str]] = {}
    chosen = done.options.effects
    for name, reason in played.not_played.items():
        if chosen and name not in chosen:
            continue
        by_reason.setdefault(reason, []).append(EFFECTS[name]().title)
    for name in done.naming.not_tried:
        needed = " and ".join(_NEEDS.get(need, need) for need in EFFECTS[name].needs)
        by_reason.setdefault(f"the recordings do not state {needed}", []).append(EFFECTS[name]().title)
    return notes + [f"not tried, because {reason}: {', '.join(names)}" for reason, names in by_reason.items()]


def _number(evidence: float) -> str:
    """Return evidence in words: a number, or that it is too small for a refit."""
    return f"{evidence:.1f}" if math.isfinite(evidence) else "too small for a refit"
