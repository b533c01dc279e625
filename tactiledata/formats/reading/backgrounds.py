"""Images without contact that a description names, as RGB arrays.

Shared by all formats, as `base` is: members of the family may import it.
"""

from __future__ import annotations

import stat
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tactiledata.contract.description import LogDescription
from tactiledata.contract.image_sizes import Size, share_words, stray_sizes
from tactiledata.contract.lfs_pointer import fault_words
from tactiledata.contract.picture_kinds import decode_said
from tactiledata.contract.records import Finding
from tactiledata.errors import BrokenLog
from tactiledata.formats.reading.intake import Intake

MAX_IMAGE_BYTES = 2**28
"""Bytes above which a file is no tactile image."""

MOST_SIZES = 3
"""Sizes that a sentence names."""


@dataclass(frozen=True)
class Backgrounds:
    """References (H, W, 3) uint8 RGB and their origin in words, by sensor, and findings."""

    references: dict[str, NDArray[np.uint8]] = field(default_factory=dict)
    origins: dict[str, str] = field(default_factory=dict)
    findings: tuple[Finding, ...] = ()


def read_image_file(path: Path) -> bytes:
    """The bytes of a regular file of a size that an image may have.

    Raises
    ------
    OSError
        Not there, not readable, not a regular file, or too large.
    """
    facts = path.stat()
    if not stat.S_ISREG(facts.st_mode):
        raise OSError(0, "not a file", str(path))
    if facts.st_size > MAX_IMAGE_BYTES:
        raise OSError(0, f"{facts.st_size} bytes, more than an image has", str(path))
    return path.read_bytes()


def load_backgrounds(description: LogDescription, locate: Callable[[str, str], Path]) -> Backgrounds:
    """The backgrounds that a description names for its sensors, from files.

    Parameters
    ----------
    description : LogDescription
    locate : callable
        The path of a name that a document gives: ``locate(name, where)``. Must refuse what leads out of the recording.

    Raises
    ------
    UnsafeContent
        From ``locate``.
    """
    return fetch_backgrounds(description, lambda name, where: (read_image_file(locate(name, where)), name))


def fetch_backgrounds(description: LogDescription, fetch: Callable[[str, str], tuple[bytes, str]]) -> Backgrounds:
    """The backgrounds that a description names for its sensors, wherever a recording keeps them.

    Parameters
    ----------
    description : LogDescription
    fetch : callable
        The bytes of a name that a document gives, and their origin in words: ``fetch(name, where)``. Raises
        ``FileNotFoundError`` where there is none of this name, another ``OSError`` or `BrokenLog` where it cannot be
        read, and must refuse what leads out of the recording.
    """
    loaded: dict[str, NDArray[np.uint8]] = {}
    origins: dict[str, str] = {}
    findings: list[Finding] = []
    for sensor, facts in description.sensors.items():
        name = facts.get("background")
        if not name:
            continue
        what = f"background {name} of sensor {sensor}"
        try:
            payload, origin = fetch(name, f"{description.where or 'the description'}: sensors.{sensor}")
            loaded[sensor], remarks = decode_said(payload)
            origins[sensor] = origin
            findings.extend(Finding(one.code, one.severity, f"the {what} {one.words}") for one in remarks)
        except FileNotFoundError:
            findings.append(Finding("background-missing", "damage", f"the {what} is not there"))
        except (OSError, BrokenLog) as error:
            findings.append(Finding("background-broken", "damage", _unusable(what, error)))
    return Backgrounds(loaded, origins, tuple(findings))


def noted_background(path: Path, intake: Intake, what: str) -> NDArray[np.uint8] | None:
    """The background (H, W, 3), uint8 RGB, in a file; ``None`` where it cannot be used. What is said is noted.

    Parameters
    ----------
    path : Path
    intake : Intake
        Takes the findings.
    what : str
        Names the picture in a sentence.
    """
    try:
        picture, remarks = decode_said(read_image_file(path))
    except (OSError, BrokenLog) as error:
        intake.note("background-broken", "damage", _unusable(what, error))
        return None
    for remark in remarks:
        intake.note(remark.code, remark.severity, f"the {what} {remark.words}")
    return picture


def _unusable(what: str, error: OSError | BrokenLog) -> str:
    return f"the {what} cannot be used: {fault_words(error) if isinstance(error, BrokenLog) else error.strerror}"


def size_findings(
    references: Mapping[str, NDArray[np.uint8]], sizes: Mapping[str, Mapping[Size, int]]
) -> tuple[Finding, ...]:
    """What is said about backgrounds whose size is not that of their sensor's images; strays of size are no matter.

    Parameters
    ----------
    references : dict, sensor -> (H, W, 3)
    sizes : dict, sensor -> (height, width) in pixels -> number of its images
    """
    findings = []
    for sensor, picture in references.items():
        size = picture.shape[:2]
        counts = sizes.get(sensor, {})
        others = sorted(set(counts) - stray_sizes(counts) - {size})
        if others:
            total = sum(counts.values())
            words = ", ".join(share_words(counts[other], total, other) for other in others[:MOST_SIZES])
            message = f"the background of sensor {sensor} is {size[0]} x {size[1]} (rows x columns); {words}"
            findings.append(Finding("background-size", "damage", message))
    return tuple(findings)
