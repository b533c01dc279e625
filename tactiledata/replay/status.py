"""Status of each frame of a replay: the engine's outcome, or why the frame was not given to the engine."""

from __future__ import annotations

from enum import IntEnum

from tactiledata.gel.contact.history import FrameStatus


class ReplayStatus(IntEnum):
    """Reason why a frame was not given to the gel engine; the numbers follow those of ``FrameStatus``."""

    OUTSIDE = 16
    NO_POSES = 17
    GEL_PLACE_UNKNOWN = 18
    INDENTER_UNKNOWN = 19
    INDENTER_PLACE_UNKNOWN = 20
    INDENTER_UNUSABLE = 21
    GEL_UNKNOWN = 22
    GEL_UNUSABLE = 23


_REASONS = {
    ReplayStatus.OUTSIDE: "the frame lies outside any trajectory",
    ReplayStatus.NO_POSES: "the recording has no stream of tcp poses",
    ReplayStatus.GEL_PLACE_UNKNOWN: "the recording does not state where the gel is (robot.tcp_from_gel)",
    ReplayStatus.INDENTER_UNKNOWN: "the recording does not describe the trajectory's indenter",
    ReplayStatus.INDENTER_PLACE_UNKNOWN: "the recording does not state where the indenter stands (base_from_indenter)",
    ReplayStatus.INDENTER_UNUSABLE: "the indenter's shape cannot be made or pressed",
    ReplayStatus.GEL_UNKNOWN: "neither the recording nor a sensor model states the gel's geometry",
    ReplayStatus.GEL_UNUSABLE: "no mesh can be made of the gel's geometry",
}

STATUSES: dict[int, str] = {
    **{int(status): status.reason for status in FrameStatus},
    **{int(status): words for status, words in _REASONS.items()},
}
"""Words of every status, of ``FrameStatus`` and of ``ReplayStatus``."""
