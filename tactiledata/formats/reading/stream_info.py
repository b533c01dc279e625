"""Rows of `tactiledata inspect` for the cameras and signals of a recording that was read."""

from __future__ import annotations

from tactiledata.contract.records import Signal
from tactiledata.formats.base import TopicInfo
from tactiledata.formats.reading.stream_rate import has_times, rate_of


def camera_info(name: str, count: int, first: int, last: int, example: str) -> TopicInfo:
    """What is said of a camera.

    Parameters
    ----------
    name : str
        Of the camera.
    count : int
        Number of its images.
    first, last : int
        Times of the first and the last one, ns.
    example : str
        The first one, in words.
    """
    rate, timed = rate_of(count, first, last), has_times(count, first, last)
    role = f"image:{name}"
    return TopicInfo(name, "images", "", count, rate=rate, role=role, example=example, has_times=timed)


def signal_info(signal: Signal) -> TopicInfo:
    """What is said of a signal."""
    stamps = signal.stamps.log
    first, last = (int(stamps[0]), int(stamps[-1])) if len(stamps) else (0, 0)
    rate, timed = rate_of(len(stamps), first, last), has_times(len(stamps), first, last)
    kind = ", ".join(signal.columns)
    return TopicInfo(signal.name, kind, "", len(stamps), rate=rate, role=signal.name, has_times=timed)
