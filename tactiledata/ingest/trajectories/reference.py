"""A picture of each sensor without contact: the recording's own background, or a mean of its frames in free air."""

from __future__ import annotations

from collections.abc import Callable
from shlex import quote

import numpy as np
from numpy.typing import NDArray

from tactiledata.contract.records import Finding, Recording
from tactiledata.contract.take import Reference
from tactiledata.ingest.trajectories.identity import UNKNOWN

FREE_AIR = 0.2
"""N. Frames below this contact force show no contact; the paper sees no deformation below 1 N."""

MIN_FRAMES = 3
MAX_FRAMES = 32


def find_references(
    recording: Recording,
    sensors: list[str],
    order: NDArray[np.int64],
    contact_force: NDArray[np.float32],
    decode: Callable[[NDArray[np.int64]], list[NDArray[np.uint8] | None]],
    say: Callable[..., None],
) -> dict[str, Reference]:
    """References by sensor.

    Parameters
    ----------
    recording : Recording
    sensors : list of str, per frame in the store's order
    order : (n_frames,)
        Row in the sink of each frame.
    contact_force : (n_frames,) N
        NaN also where a frame has no image that can be used.
    decode : callable
        Images of rows of the sink.
    say : callable
        Takes findings.
    """
    description = recording.description
    references: dict[str, Reference] = {}
    names = np.array(sensors, dtype=object)
    for sensor in sorted(set(sensors)):
        facts = description.sensors.get(sensor, {})
        model, licence = facts.get("model", ""), description.document.get("licence", "")
        if sensor in recording.references:
            origin = recording.reference_sources.get(sensor, "the recording's background")
            references[sensor] = Reference(recording.references[sensor], origin, licence, model)
            continue
        free = np.flatnonzero((names == sensor) & (contact_force < FREE_AIR))
        found = _mean_image(decode, order, free)
        if found is None:
            text = (
                f"sensor {sensor!r} has no picture without contact: none is stated, and fewer than {MIN_FRAMES} frames "
                f"lie in free air. {_remedy(sensor)}"
            )
            say(Finding("no-background", "warning", text))
            continue
        mean, used = found
        references[sensor] = Reference(mean, f"mean of {used} frames below {FREE_AIR} N", licence, model)
    return references


def _remedy(sensor: str) -> str:
    """Say how the sensor gets its picture; one without a name of its own gets both at once."""
    if sensor.startswith(UNKNOWN):
        return (
            "State the sensor and its picture in log.yaml, or under `description` in a mapping: "
            "sensors: {SERIAL: {model: digit, background: FILE}}"
        )
    return f"Add one with `tactiledata sensors add {quote(sensor)} --background FILE --store S`"


def _mean_image(
    decode: Callable[[NDArray[np.int64]], list[NDArray[np.uint8] | None]], order: NDArray[np.int64], free: NDArray
) -> tuple[NDArray[np.uint8], int] | None:
    if len(free) < MIN_FRAMES:
        return None
    chosen = free[np.unique(np.linspace(0, len(free) - 1, MAX_FRAMES).astype(int))]
    images = [image for image in decode(order[chosen]) if image is not None]
    images = [image for image in images if image.shape == images[0].shape]
    if len(images) < MIN_FRAMES:
        return None
    return np.rint(np.mean(images, axis=0)).astype(np.uint8), len(images)
